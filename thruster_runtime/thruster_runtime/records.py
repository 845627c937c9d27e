"""Messages as named tuples of plain numbers, read from their bytes and written to them: a tenth of rclpy's cost.

rclpy makes an object for a message, its header and its stamp, each with its defaults, and then sets every field of it;
a node that handles a few numbers of each of many messages spends most of its time there. A record has the same
fields, in the same order, those of messages inside it with their names joined:

    header.stamp, header.frame_id   stamp [ns, an integer], frame_id
    wrench.force.x                  wrench_force_x
    covariance                      a tuple of its nine numbers

The bytes are CDR as every middleware of ROS 2 sends it (OMG DDSI-RTPS 10.2, plain CDR): an encapsulation header of
four bytes that tells the byte order, then the fields, each aligned to its own size counted from the end of that header;
a text is its length with the final zero as uint32, its bytes, the zero. Padding is written as zeros. Sequences and
wide texts have no record.
"""

import re
import struct
from collections import namedtuple
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

from builtin_interfaces.msg import Time
from rclpy.node import Node
from rclpy.qos import QoSProfile
from rclpy.subscription import Subscription

from thruster_runtime.errors import ThrusterRuntimeError
from thruster_runtime.qos import RELIABLE
from thruster_runtime.stamps import NANOSECONDS

__all__ = [
    "Ends", "Format", "Listener", "RecordPublisher", "UnreadableBytes", "UnreadableType", "ends_of", "format_of",
    "listen",
]  # fmt: skip

_CODES = {
    "boolean": "?", "octet": "B", "char": "B", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i",
    "uint32": "I", "int64": "q", "uint64": "Q", "float": "f", "double": "d",
}  # fmt: skip
_ARRAY = re.compile(r"(\w+)\[(\d+)\]")
_BEGIN = 4  # bytes of the encapsulation header, from whose end alignment counts
_WIDEST = 8  # bytes: no field is aligned to more
_LENGTH = "I"  # before each text
_STAMP = "iI"  # s, ns
_LITTLE_ENDIAN = b"\0\1\0\0"


class UnreadableType(ThrusterRuntimeError):
    """A message type with a field that records cannot hold."""

    def __init__(self, kind: type, field: str, found: str) -> None:
        super().__init__(
            f"{kind.__module__}.{kind.__name__}: field '{field}': expected numbers or a text; found {found}"
        )
        self.kind, self.field, self.found = kind, field, found


class UnreadableBytes(ThrusterRuntimeError):
    """A payload that is not plain CDR."""

    def __init__(self, data: bytes) -> None:
        super().__init__(f"payload: expected plain CDR (00 00 or 00 01 at its beginning); found {data[:2].hex(' ')}")
        self.data = data


class Listener:
    """A subscription whose callback gets records.

    Attributes:
        subscription: to the topic.
        callback: gets each record.
    """

    def __init__(self, node: Node, kind: type, topic: str, callback: Callable[[Any], None], qos: QoSProfile) -> None:
        """Subscribe for `node`."""
        self._read = format_of(kind).read
        self.callback = callback
        self.subscription: Subscription = node.create_subscription(kind, topic, self._receive, qos, raw=True)

    def _receive(self, data: bytes) -> None:
        self.callback(self._read(data))


class RecordPublisher:
    """Publishes records on a topic.

    Attributes:
        publisher: rclpy's.
        heard_by: these get each record as it is, beside the topic.
    """

    def __init__(self, node: Node, kind: type, topic: str, qos: QoSProfile = RELIABLE) -> None:
        """Publish for `node`.

        Raises:
            UnreadableType: of a message type that records cannot hold.
        """
        self._write = format_of(kind).write
        self.publisher = node.create_publisher(kind, topic, qos)
        self.heard_by: list[Callable[[Any], None]] = []
        ends_of(node).publishers.append(self)

    def publish(self, record: Any) -> None:
        """Publish a record of the topic's type."""
        self.publisher.publish(self._write(record))
        for callback in self.heard_by:
            callback(record)

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
        names: list[str] = []
        runs: list[str] = [""]  # of the numbers before each text, and after the last one
        self._joined: list[tuple[int, int, bool]] = []  # place, number of values and whether they are a stamp
        _collect(kind, kind, "", names, runs, self._joined)
        self.record: Any = namedtuple(kind.__name__, names)  # type: ignore[misc]
        codes = [*(f"{run}{_LENGTH}" for run in runs[:-1]), runs[-1]]
        self._layouts = {order: [_layouts(order, each) for each in codes] for order in "<>"}
        self._sizes = [len(run) for run in runs]

    def read(self, data: bytes) -> Any:
        """Return the record of a message's bytes.

        Raises:
            UnreadableBytes: where they are not plain CDR.
        """
        if data[0] != 0 or data[1] > 1:
            raise UnreadableBytes(data)
        *texts, last = self._layouts["<" if data[1] else ">"]
        values: list[Any] = []
        at = _BEGIN
        for run in texts:
            layout = run[at % _WIDEST]
            values += layout.unpack_from(data, at)
            at += layout.size
            length = values.pop()
            values.append(data[at : at + length - 1].decode())
            at += length
        values += last[at % _WIDEST].unpack_from(data, at)
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
        data, begin = _LITTLE_ENDIAN, 0
        *texts, last = self._layouts["<"]
        for run, size in zip(texts, self._sizes, strict=False):
            text = values[begin + size].encode() + b"\0"
            data += run[len(data) % _WIDEST].pack(*values[begin : begin + size], len(text)) + text
            begin += size + 1
        return data + last[len(data) % _WIDEST].pack(*values[begin:])


@cache
def format_of(kind: type) -> Format:
    """Return the format of a message type, made once.

    Raises:
        UnreadableType: of a message type that records cannot hold.
    """
    return Format(kind)


def _collect(
    outer: type, kind: type, prefix: str, names: list[str], runs: list[str], joined: list[tuple[int, int, bool]]
) -> None:
    """Add the fields of `kind`, a message inside of `outer`, to what is known of it."""
    for field, idl in kind.get_fields_and_field_types().items():  # type: ignore[attr-defined]
        name = f"{prefix}{field}"
        place = sum(map(len, runs)) + len(runs) - 1  # texts are one value each as well
        array = _ARRAY.fullmatch(idl)
        if array and array[1] in _CODES:
            count = int(array[2])
            runs[-1] += _CODES[array[1]] * count
            joined.append((place, count, False))
        elif idl in _CODES:
            runs[-1] += _CODES[idl]
        elif idl == "string":
            runs.append("")
        elif "/" in idl and "[" not in idl and "<" not in idl:
            inside = type(getattr(kind(), field))
            if inside is not Time:
                _collect(outer, inside, "" if name == "header" else f"{name}_", names, runs, joined)
                continue
            runs[-1] += _STAMP
            joined.append((place, 2, True))
        else:
            raise UnreadableType(outer, name, idl)
        names.append(name)


def _layouts(order: str, codes: str) -> list[struct.Struct]:
    """Return how numbers lie that begin at each place modulo the widest field, with the padding before each."""
    found = []
    for begin in range(_WIDEST):
        at, form = begin, order
        for code in codes:
            size = struct.calcsize(order + code)
            padding = (_BEGIN - at) % size
            form += f"{padding}x{code}"
            at += padding + size
        found.append(struct.Struct(form))
    return found
