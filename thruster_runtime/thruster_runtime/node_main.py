"""The main function of every node: start, spin, stop cleanly on SIGINT or SIGTERM, exit status.

rclpy's own handlers end the graph at the signal, after which no node can publish its last command. Ours
only ask the loop to end; the graph is closed after the node's `on_stop`.

A script that starts a graph names itself in the variable THRUSTER_ENDS_WITH, as a process id: its nodes end when it is
gone, however it went and whatever stands between them (a `ros2 run` that hands no signal on).
"""

import gc
import os
import select
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
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

from safe_files.errors import YamlError
from thruster_runtime.command_line import asks_for_help, help_text, passed_over, stray_arguments, unknown_parameters
from thruster_runtime.errors import StartRefused
from thruster_runtime.executors import (
    EXECUTOR_KINDS,
    LONGEST_WAIT,
    UnknownExecutor,
    make_executor,
    unsuitable_callbacks,
)
from thruster_runtime.hand_over import hand_over
from thruster_runtime.parameters import Parameter
from thruster_runtime.simulated_time import share_clock

ENDS_WITH = "THRUSTER_ENDS_WITH"
"""Variable with the id of the process without which this one is to end."""
STOPPED, REFUSED = 0, 2
LAST_WORDS = 2.0
"""How long a process that ends waits at most for reliable topics to arrive [s]."""

_REFUSALS: tuple[type[Exception], ...] = (
    StartRefused,
    UnknownExecutor,
    YamlError,
    ParameterException,
    rclpy_implementation.RCLInvalidROSArgsError,
    rclpy_implementation.UnknownROSArgsError,
)


def node_main(
    build: Callable[[], Node],
    doc: str | None,
    parameters: Iterable[Parameter],
    *,
    stop: threading.Event | None = None,
    argv: Sequence[str] | None = None,
) -> int:
    """Do what a node's executable does: help, refuse what it does not understand, else `run_node`.

    Args:
        build: makes the node.
        doc: docstring of the node's module: purpose and topics.
        parameters: table of its parameters.
        stop: as of `run_node`.
        argv: command line with the program's name; None is that of the process.

    Returns:
        0 after help or a clean stop, 2 when it refused to start.
    """
    program, *args = sys.argv if argv is None else argv
    program = program.rpartition("/")[2]
    parameters = tuple(parameters)
    if asks_for_help(args):
        sys.stdout.write(help_text(program, doc or "", parameters))
        return STOPPED
    if wrong := stray_arguments(program, args, [each.name for each in parameters]):
        sys.stderr.write("".join(f"{sentence}\n" for sentence in wrong))
        return REFUSED
    return run_node(build, args=None if argv is None else args, stop=stop)


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
            return _run_in(context, builds, stop, handing_over, args)
        except (*_REFUSALS, *refusals) as error:
            sys.stderr.write(f"{error}\n")
            return REFUSED
        except rclpy_implementation.RCLError as error:
            if os.environ.get("ROS_SECURITY_ENABLE", "").lower() != "true":
                raise
            found = str(error).partition("\n")[0].removesuffix(": error not set")
            sys.stderr.write(
                "ROS_SECURITY_ENABLE=true: expected ROS_SECURITY_KEYSTORE with this node's enclave, and a Fast DDS "
                f"built with security; found: {found}; nothing was started\n"
            )
            return REFUSED
        finally:
            rclpy.try_shutdown(context=context)


def _run_in(
    context: Context,
    builds: Sequence[Callable[[], Node]],
    stop: threading.Event,
    handing_over: bool,
    args: Sequence[str] | None,
) -> int:
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
        if wrong := unknown_parameters(nodes, args) + passed_over(nodes, args):
            raise StartRefused("\n".join(wrong))
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
            leaving.callback(_close, keeper := _keeper())
            _spin(executor, context, stop, keeper)
    return STOPPED


def _keeper() -> int | None:
    """Return a descriptor that can be read once the process is gone without which this one is to end; None: nobody."""
    number = os.environ.get(ENDS_WITH, "")
    if not number.isdecimal():
        return None
    try:
        return os.pidfd_open(int(number))
    except ProcessLookupError:
        return os.open(os.devnull, os.O_RDONLY)  # gone already: always readable
    except OSError:
        return None  # a kernel without such descriptors


def _close(descriptor: int | None) -> None:
    if descriptor is not None:
        os.close(descriptor)


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


def _spin(executor: Executor, context: Context, stop: threading.Event, keeper: int | None) -> None:
    # Runs as long as the node lives; each wait in it is bounded. Going back to Python after each callback, as
    # `spin_once` does, would double what a message costs in the events executor: nothing ever completes `never`.
    never: Future = Future()
    kept = [] if keeper is None else [keeper]
    while context.ok() and not stop.is_set() and not (kept and select.select(kept, [], [], 0.0)[0]):
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
