"""The executor switch: `events` costs a fifth of `single`, which does everything that rclpy promises.

rclpy's EventsExecutor (7.1) has known failures, which this module and `node_main` keep away from:
`spin()` never returns after SIGINT, so that we only use `spin_once` with a time-out; `async` callbacks
never run and callbacks that take (message, information) raise, so that `unsuitable_callbacks` finds them
before they matter; publishers destroyed while it spins may crash it, so that a node leaves the executor
before it is destroyed.
"""

import inspect
import time
from collections.abc import Callable, Iterator
from typing import Any, Literal, get_args

from rclpy.context import Context
from rclpy.executors import Executor, SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.subscription import Subscription

from thruster_runtime.errors import ThrusterRuntimeError

ExecutorKind = Literal["events", "single"]
EXECUTOR_KINDS: tuple[str, ...] = get_args(ExecutorKind)

LONGEST_WAIT = 0.1
"""[s] Longest single wait for work; a signal or a deadline is noticed at most this much later."""


class UnknownExecutor(ThrusterRuntimeError):
    """An executor kind that does not exist."""

    def __init__(self, kind: str) -> None:
        super().__init__(f"executor: expected one of {', '.join(EXECUTOR_KINDS)}, got {kind!r}")
        self.kind = kind


def make_executor(kind: str, *, context: Context) -> Executor:
    """Return an executor of `kind` ("events" or "single") for the nodes of `context`."""
    if kind == "events":
        return EventsExecutor(context=context)
    if kind == "single":
        return SingleThreadedExecutor(context=context)
    raise UnknownExecutor(kind)


def unsuitable_callbacks(node: Node) -> list[str]:
    """Return one phrase for each callback of `node` that the events executor would not run properly."""
    phrases = []
    for what, callback in _callbacks(node):
        if inspect.iscoroutinefunction(callback):
            phrases.append(f"the callback of {what} is async")
    for subscription in node.subscriptions:
        if subscription._callback_type is Subscription.CallbackType.WithMessageInfo:
            phrases.append(f"the callback of topic {subscription.topic_name} takes message information")
    return phrases


def _callbacks(node: Node) -> Iterator[tuple[str, Callable[..., Any] | None]]:
    for subscription in node.subscriptions:
        yield f"topic {subscription.topic_name}", subscription.callback
    for service in node.services:
        yield f"service {service.srv_name}", service.callback
    for timer in node.timers:
        yield f"a timer of {timer.timer_period_ns / 1e9:g} s", timer.callback


def spin_until(
    executor: Executor,
    predicate: Callable[[], bool],
    timeout: float,
    *,
    monotonic: Callable[[], float] = time.monotonic,
) -> bool:
    """Spin `executor` until `predicate()` holds or `timeout` [s] has passed.

    Returns:
        Whether the predicate holds.
    """
    deadline = monotonic() + timeout
    while not predicate():
        left = deadline - monotonic()
        if left <= 0.0:
            return False
        executor.spin_once(timeout_sec=min(left, LONGEST_WAIT))
    return True
