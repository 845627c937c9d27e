"""Serialised messages of any installed type, with the stamps and numbers that the middleware gives them."""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from ..errors import SchemaError


class Arrival(NamedTuple):
    """A message as it came: payload, when it was published and received [ns, system clock], its publisher's number."""

    payload: bytes
    published: int
    received: int
    number: int


def message_class(name: str) -> Any:
    """Return the class of a message type such as "std_msgs/msg/Float64".

    Raises:
        SchemaError: it is not installed, or no message.
    """
    package, _, kind = name.partition("/")
    folder, _, kind = kind.partition("/")
    try:
        if folder != "msg":
            raise ImportError(f"expected package/msg/Type, found {name}")
        return getattr(importlib.import_module(f"{package}.msg"), kind)
    except (ImportError, AttributeError) as error:
        raise SchemaError(f"message type {name!r} is not installed here: {error}", found=name) from error


class RawTopic:
    """A subscription that gives messages undecoded, with their information, in either executor.

    rclpy calls back with information only where the executor supports it, and 7.1's events executor hands over both as
    one tuple. This takes either form.
    """

    def __init__(
        self, node: Node, name: str, kind: str, profile: QoSProfile, receive: Callable[[Arrival], None]
    ) -> None:
        """Subscribe; `receive` is called with each message.

        Raises:
            SchemaError: the type is not installed.
        """
        self._type = message_class(kind)
        self._receive = receive
        quiet = SubscriptionEventCallbacks(use_default_callbacks=False)
        self._subscription = node.create_subscription(
            self._type, name, self._called, profile, raw=True, event_callbacks=quiet
        )
        self._subscription._callback_type = Subscription.CallbackType.WithMessageInfo

    def _called(self, message: Any, information: dict[str, int] | None = None) -> None:
        payload, given = message if information is None else (message, information)
        self._receive(_arrival(payload, given))

    @property
    def publishers(self) -> int:
        """How many publishers it is connected to."""
        return int(self._subscription.get_publisher_count())

    def waiting(self) -> Iterator[Arrival]:
        """Take what has arrived and was not handed over yet; only while no executor spins."""
        while (taken := self._subscription.handle.take_message(self._type, True)) is not None:
            yield _arrival(*taken)


def _arrival(payload: bytes, information: dict[str, int]) -> Arrival:
    number = information.get("publication_sequence_number") or 0
    return Arrival(payload, information["source_timestamp"], information["received_timestamp"], number)
