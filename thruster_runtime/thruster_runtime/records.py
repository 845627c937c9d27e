"""Messages as named tuples of plain numbers, read from their bytes and written to them: a tenth of rclpy's cost.

rclpy makes an object for a message, its header and its stamp, each with its defaults, and then sets every field of it;
a node that handles a few numbers of each of many messages spends most of its time there. A record has the same
fields, in the same order, those of messages inside it with their names joined:

    header.stamp, header.frame_id   stamp [ns, an integer], frame_id
    wrench.force.x                  wrench_force_x
    covariance                      a tuple of its nine numbers

The bytes are CDR as every middleware of ROS 2 sends it; where each field lies `safe_files.cdr` says. Messages whose
texts have the same lengths lie alike, and all values of one are taken out or put in at once. Sequences and wide texts
have no record.
"""

import re
import struct
from collections import namedtuple
from collections.abc import Callable
from functools import cache
from typing import Any, Literal, NamedTuple
from weakref import WeakKeyDictionary

from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from safe_files.cdr import (
    ARRAY,
    BASE,
    HEADER_BYTES,
    NAME,
    PRIMITIVES,
    FieldsOf,
    Layout,
    Text,
    layout,
    payload_layout,
)
from safe_files.errors import CdrError
from thruster_runtime.errors import ThrusterRuntimeError
from thruster_runtime.qos import RELIABLE
from thruster_runtime.stamps import NANOSECONDS

__all__ = [
    "Ends", "Format", "Listener", "RecordPublisher", "UnreadableBytes", "UnreadableType", "ends_of", "format_of",
    "listen",
]  # fmt: skip

_IDL = {"boolean": "bool", "octet": "byte", "float": "float32", "double": "float64", "string": "string"}
_IDL |= {kind: kind for kind in PRIMITIVES if kind not in ("bool", "byte", "float32", "float64")}
_CODES = {
    "bool": "?", "byte": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i",
    "uint32": "I", "int64": "q", "uint64": "Q", "float32": "f", "float64": "d",
}  # fmt: skip
_ARRAY = re.compile(r"(\w+)\[(\d+)\]")
_TIME = ".sec", ".nanosec"
_WORD = 4  # bytes of a text's length
_LITTLE_ENDIAN = b"\0\1\0\0"
_BETWEEN_WORDS = 5.0
"""[s] Between two warnings of bytes that are no message, at least."""
_MOST_FORMS = 256
"""Of a type, for as many lengths of its texts; then all are learnt anew."""


class UnreadableType(ThrusterRuntimeError):
    """A message type with a field that records cannot hold."""

    def __init__(self, kind: type, field: str, found: str) -> None:
        super().__init__(
            f"{kind.__module__}.{kind.__name__}: field '{field}': expected numbers or a text; found {found}"
        )
        self.kind, self.field, self.found = kind, field, found


class UnreadableBytes(ThrusterRuntimeError):
    """A payload that is not plain CDR of its type."""

    def __init__(self, data: bytes, told: str) -> None:
        super().__init__(f"payload: {told}")
        self.data = data


class Listener:
    """A subscription whose callback gets records.

    Bytes that are no such message are passed over, as by rclpy's own subscriptions: what anyone on the network sends
    does not end a node. To a join they are as a message that was lost.

    Attributes:
        subscription: to the topic.
        callback: gets each record.
        passed_over: how many messages were none of the topic's type.
    """

    def __init__(self, node: Node, kind: type, topic: str, callback: Callable[[Any], None], qos: QoSProfile) -> None:
        """Subscribe for `node`."""
        self._read = format_of(kind).read
        self._say = node.get_logger().warning
        self.callback = callback
        self.passed_over = 0
        self.subscription: Subscription = node.create_subscription(kind, topic, self._receive, qos, raw=True)

    def _receive(self, data: bytes) -> None:
        try:
            record = self._read(data)
        except UnreadableBytes as error:
            self.passed_over += 1
            told = f"{self.subscription.topic_name}: {error}; passed over, as {self.passed_over} in all"
            self._say(told, throttle_duration_sec=_BETWEEN_WORDS)
            return
        self.callback(record)


class RecordPublisher:
    """Publishes records on a topic.

    Attributes:
        publisher: rclpy's.
        heard_by: these get each record as it is, beside the topic.
        stamp: of the last record [ns]; 0 before the first, and of types without a stamp.
    """

    def __init__(self, node: Node, kind: type, topic: str, qos: QoSProfile = RELIABLE) -> None:
        """Publish for `node`.

        Raises:
            UnreadableType: of a message type that records cannot hold.
        """
        self._write = format_of(kind).write
        self.publisher = node.create_publisher(kind, topic, qos)
        self.heard_by: list[Callable[[Any], None]] = []
        self.stamp = 0
        ends_of(node).publishers.append(self)

    def publish(self, record: Any) -> None:
        """Publish a record of the topic's type."""
        self.publisher.publish(self._write(record))
        self.stamp = getattr(record, "stamp", 0)
        for callback in self.heard_by:
            callback(record)

    def last_word(self, node: Node) -> int:
        """Return the stamp [ns] of what a node says as it stops: now, but not before its last record.

        In simulated time the clock may come after the message that a record answers.
        """
        return max(int(node.get_clock().now().nanoseconds), self.stamp)

    def get_subscription_count(self) -> int:
        """Return how many subscriptions are matched, as rclpy's publisher does."""
        return int(self.publisher.get_subscription_count())


class Ends(NamedTuple):
    """What a node publishes and listens to as records."""

    publishers: list[RecordPublisher]
    listeners: list[Listener]


_ENDS: WeakKeyDictionary[Node, Ends] = WeakKeyDictionary()


def ends_of(node: Node) -> Ends:
    """Return what a node publishes and listens to as records, so far."""
    return _ENDS.setdefault(node, Ends([], []))


def listen(
    node: Node, kind: type, topic: str, callback: Callable[[Any], None], qos: QoSProfile = RELIABLE
) -> Subscription:
    """Subscribe to a topic for `node`; `callback` gets each message as a record.

    Raises:
        UnreadableType: of a message type that records cannot hold.
    """
    listener = Listener(node, kind, topic, callback, qos)
    ends_of(node).listeners.append(listener)
    return listener.subscription


class Format:
    """How records of a message type are read and written.

    Attributes:
        record: class of its records, a named tuple.
    """

    def __init__(self, kind: type) -> None:
        """Learn the fields of `kind`.

        Raises:
            UnreadableType: of a message type that records cannot hold.
        """
        known: dict[str, list[tuple[str, Any]]] = {}
        self._fields_of: FieldsOf = known
        self._name = _learn(kind, kind, "", known)
        empty = layout(self._fields_of, self._name, _Lengths([]))
        names: list[str] = []
        self._joined: list[tuple[int, int, bool]] = []  # place, number of values and whether they are a stamp
        self._texts: list[int] = []  # places among the values, a text being one
        place = 0
        for item in _in_order(empty):
            path, count = item.path, 1
            if isinstance(item, Text):
                self._texts.append(place)
            elif item.count is not None:
                count = item.count
                self._joined.append((place, count, False))
            elif path.endswith(_TIME[1]) and names[-1:] == [_named(path.removesuffix(_TIME[1]) + _TIME[0])]:
                self._joined.append((place - 1, 2, True))
                names.pop()
                path = path.removesuffix(_TIME[1])
            names.append(_named(path))
            place += count
        self.record: Any = namedtuple(kind.__name__, names)  # type: ignore[misc]
        self._read: dict[tuple[bytes, int], list[_Form]] = {}  # by encapsulation and size
        self._written: dict[tuple[int, ...], _Form] = {}  # by lengths of texts

    def read(self, data: bytes) -> Any:
        """Return the record of a message's bytes.

        Raises:
            UnreadableBytes: where they are not plain CDR of this type.
        """
        for numbers, texts in self._read.get((data[:2], len(data)), ()):
            values = list(numbers.unpack_from(data, HEADER_BYTES))
            for place, length in texts:
                if values[place][:_WORD] != length:
                    break
                values[place] = values[place][_WORD:].decode(errors="replace")  # as rclpy does
            else:
                break
        else:
            numbers, texts = self._form(data)
            values = list(numbers.unpack_from(data, HEADER_BYTES))
            for place, _ in texts:
                values[place] = values[place][_WORD:].decode(errors="replace")
        for place, count, stamp in reversed(self._joined):  # from the last on, so that places stay
            found = values[place : place + count]
            values[place : place + count] = [found[0] * NANOSECONDS + found[1] if stamp else tuple(found)]
        return self.record._make(values)

    def write(self, record: Any) -> bytes:
        """Return the bytes of a message, little-endian.

        Raises:
            struct.error: a number that its field cannot hold.
        """
        values = list(record)
        for place, _, stamp in self._joined:  # from the first on: those before have their places already
            values[place : place + 1] = divmod(values[place], NANOSECONDS) if stamp else values[place]
        texts = [values[place].encode() for place in self._texts]
        lengths = tuple(map(len, texts))
        form = self._written.get(lengths)
        if form is None:
            if len(self._written) >= _MOST_FORMS:
                self._written.clear()
            form = self._written[lengths] = _form_of(layout(self._fields_of, self._name, _Lengths(texts)))
        for (place, length), text in zip(form.texts, texts, strict=True):
            values[place] = length + text
        return _LITTLE_ENDIAN + form.numbers.pack(*values)

    def _form(self, data: bytes) -> "_Form":
        try:
            form = _form_of(payload_layout(self._fields_of, self._name, bytes(data)))
        except CdrError as error:
            raise UnreadableBytes(data, str(error)) from error
        if sum(map(len, self._read.values())) >= _MOST_FORMS:
            self._read.clear()
        self._read.setdefault((data[:2], len(data)), []).append(form)
        return form


class _Form(NamedTuple):
    """Messages of one layout: all their values, a text with its length being one, and places and lengths of texts."""

    numbers: struct.Struct
    texts: list[tuple[int, bytes]]


class _Lengths:
    """Tells a layout the texts of a message."""

    def __init__(self, texts: list[bytes]) -> None:
        self._texts = iter(texts)

    def string(self, path: str, offset: int) -> bytes:
        return next(self._texts, b"")

    def length(self, path: str, offset: int) -> int:
        raise CdrError(f"field {path!r}: a sequence")  # none is learnt


def _in_order(shape: Layout) -> list[Any]:
    return sorted([*shape.fields, *shape.texts], key=lambda item: item.offset)


def _form_of(shape: Layout) -> _Form:
    codes, at, place, texts = shape.order, HEADER_BYTES, 0, []
    order: Literal["little", "big"] = "little" if shape.order == "<" else "big"
    for item in _in_order(shape):
        count = 1
        codes += f"{item.offset - at}x"
        if isinstance(item, Text):
            codes += f"{_WORD + len(item.data)}sx"
            texts.append((place, (len(item.data) + 1).to_bytes(_WORD, order)))
        else:
            count = 1 if item.count is None else item.count
            codes += f"{count}{_CODES[item.kind]}"
        place += count
        at = HEADER_BYTES + struct.calcsize(codes)
    return _Form(struct.Struct(codes), texts)


def _named(path: str) -> str:
    return path.removeprefix("header.").replace(".", "_")


@cache
def format_of(kind: type) -> Format:
    """Return the format of a message type, made once.

    Raises:
        UnreadableType: of a message type that records cannot hold.
    """
    return Format(kind)


def _learn(outer: type, kind: type, prefix: str, known: dict[str, list[tuple[str, Any]]]) -> str:
    """Add the definitions of `kind`, a message inside of `outer`, and of all inside it; return its full name."""
    name = f"{kind.__module__}.{kind.__name__}"
    known[name] = []
    for field, idl in kind.get_fields_and_field_types().items():  # type: ignore[attr-defined]
        array = _ARRAY.fullmatch(idl)
        if idl in _IDL:
            found: Any = BASE, (_IDL[idl], 0)
        elif array and array[1] in _IDL and array[1] != "string":
            found = ARRAY, ((BASE, (_IDL[array[1]], 0)), int(array[2]))
        elif "/" in idl and "[" not in idl and "<" not in idl:
            found = NAME, _learn(outer, type(getattr(kind(), field)), f"{prefix}{field}.", known)
        else:
            raise UnreadableType(outer, _named(f"{prefix}{field}"), idl)
        known[name].append((field, found))
    return name
