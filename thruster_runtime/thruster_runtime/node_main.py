"""The main function of every node: start, spin, stop cleanly on SIGINT or SIGTERM, exit status.

rclpy's own handlers end the graph at the signal, after which no node can publish its last command. Ours
only ask the loop to end; the graph is closed after the node's `on_stop`.
"""

import gc
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from types import FrameType

import rclpy
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.context import Context
from rclpy.duration import Duration
from rclpy.exceptions import ParameterException
from rclpy.executors import Executor
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future

from thruster_runtime.errors import StartRefused
from thruster_runtime.executors import (
    EXECUTOR_KINDS,
    LONGEST_WAIT,
    UnknownExecutor,
    make_executor,
    unsuitable_callbacks,
)
from thruster_runtime.hand_over import hand_over
from thruster_runtime.simulated_time import share_clock

STOPPED, REFUSED = 0, 2
LAST_WORDS = 2.0
"""How long a process that ends waits at most for reliable topics to arrive [s]."""

_REFUSALS: tuple[type[Exception], ...] = (
    StartRefused,
    UnknownExecutor,
    ParameterException,
    rclpy_implementation.RCLInvalidROSArgsError,
    rclpy_implementation.UnknownROSArgsError,
)


def run_node(
    build: Callable[[], Node],
    *,
    args: Sequence[str] | None = None,
    context: Context | None = None,
    refusals: tuple[type[Exception], ...] = (),
    stop: threading.Event | None = None,
) -> int:
    """Build a node, spin it until it is told to stop, and return the exit status of the process.

    A node may have a method `on_stop()`, which is called however the spinning ends, while it can still
    publish. An error in a callback ends the node too, and is raised after that.

    Args:
        build: Makes the node, usually its class.
        args: Command line with --ros-args; None is that of the process.
        context: None is the default one.
        refusals: Errors of `build` that are bad input rather than bugs: said as a sentence, no traceback.
        stop: Ends the spinning when set; SIGINT and SIGTERM set it.

    Returns:
        0 after a clean stop, 2 when the node refused to start.
    """
    return run_nodes([build], args=args, context=context, refusals=refusals, stop=stop)


def run_nodes(
    builds: Sequence[Callable[[], Node]],
    *,
    args: Sequence[str] | None = None,
    context: Context | None = None,
    refusals: tuple[type[Exception], ...] = (),
    stop: threading.Event | None = None,
    handing_over: bool = False,
) -> int:
    """Run several nodes in one executor as `run_node` does one; they stop in the opposite order.

    `handing_over`: they hand their messages to each other (`hand_over`).
    """
    stop = threading.Event() if stop is None else stop
    context = rclpy.get_default_context() if context is None else context
    with _signals_set(stop):
        try:
            rclpy.init(
                args=None if args is None else list(args),
                context=context,
                signal_handler_options=SignalHandlerOptions.NO,
            )
            return _run_in(context, builds, stop, handing_over)
        except (*_REFUSALS, *refusals) as error:
            sys.stderr.write(f"{error}\n")
            return REFUSED
        finally:
            rclpy.try_shutdown(context=context)


def _run_in(context: Context, builds: Sequence[Callable[[], Node]], stop: threading.Event, handing_over: bool) -> int:
    with ExitStack() as destroyed:
        nodes = []
        for build in builds:
            nodes.append(build())
            destroyed.callback(nodes[-1].destroy_node)
        share_clock(nodes)
        if handing_over:
            hand_over(nodes)
        kinds = {_executor_kind(node) for node in nodes}
        if len(kinds) != 1:
            raise StartRefused(f"executor: expected one kind for all nodes of a process; found {', '.join(kinds)}")
        executor = make_executor(kinds.pop(), context=context)
        with ExitStack() as leaving:  # runs backwards, and to its end whatever fails
            leaving.callback(executor.shutdown)
            for node in nodes:
                executor.add_node(node)
                # First out of the executor, then destroyed: the other way round may crash it.
                leaving.callback(executor.remove_node, node)
            leaving.callback(_be_heard, nodes)
            for node in nodes:
                leaving.callback(getattr(node, "on_stop", _nothing))
            gc.freeze()  # what has been built stays: no callback waits while the collector looks through it
            leaving.callback(gc.unfreeze)
            _spin(executor, context, stop)
    return STOPPED


def _be_heard(nodes: Sequence[Node]) -> None:
    """Wait until what nodes said at last has arrived: what a process publishes just before it ends may not."""
    end = time.monotonic() + LAST_WORDS
    for publisher in (publisher for node in nodes for publisher in node.publishers):
        publisher.wait_for_all_acked(Duration(seconds=max(end - time.monotonic(), 0.0)))


def _nothing() -> None:
    """What a node without `on_stop` does."""


def _executor_kind(node: Node) -> str:
    description = f"how callbacks are run: one of {', '.join(EXECUTOR_KINDS)}"
    descriptor = ParameterDescriptor(description=description, read_only=True)
    kind = str(node.declare_parameter("executor", "events", descriptor).value)
    trouble = unsuitable_callbacks(node) if kind == "events" else []
    if trouble:
        raise StartRefused(
            f"{node.get_fully_qualified_name()}: the executor 'events' cannot run every callback "
            f"({'; '.join(trouble)}); start it with --ros-args -p executor:=single"
        )
    return kind


def _spin(executor: Executor, context: Context, stop: threading.Event) -> None:
    # Runs as long as the node lives; each wait in it is bounded. Going back to Python after each callback, as
    # `spin_once` does, would double what a message costs in the events executor: nothing ever completes `never`.
    never: Future = Future()
    while context.ok() and not stop.is_set():
        executor.spin_until_future_complete(never, timeout_sec=LONGEST_WAIT)


@contextmanager
def _signals_set(stop: threading.Event) -> Iterator[None]:
    """Let SIGINT and SIGTERM set `stop`; a second one has its usual effect, for a node that hangs."""
    if threading.current_thread() is not threading.main_thread():
        yield  # only the main thread may handle signals
        return
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def ask_to_stop(number: int, _frame: FrameType | None) -> None:
        stop.set()
        signal.signal(number, before[signal.Signals(number)])

    for number in before:
        signal.signal(number, ask_to_stop)
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
