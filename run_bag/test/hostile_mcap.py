"""MCAP files that mean ill: small, and large, wrong or endless when they are read. Each maker returns bytes."""

import struct
import zlib
from collections.abc import Callable

import zstandard

MAGIC = b"\x89MCAP0\r\n"
STRING = "std_msgs/msg/String"


def record(opcode: int, body: bytes) -> bytes:
    return struct.pack("<BQ", opcode, len(body)) + body


def text(value: str | bytes) -> bytes:
    data = value.encode() if isinstance(value, str) else value
    return struct.pack("<I", len(data)) + data


def pairs(content: dict[str, str]) -> bytes:
    return text(b"".join(text(k) + text(v) for k, v in content.items()))


def schema(number: int, name: str, data: str | bytes, encoding: str = "ros2msg") -> bytes:
    return record(3, struct.pack("<H", number) + text(name) + text(encoding) + text(data))


def channel(number: int, schema_number: int, topic: str, encoding: str = "cdr") -> bytes:
    return record(4, struct.pack("<HH", number, schema_number) + text(topic) + text(encoding) + pairs({}))


def message(number: int, payload: bytes = b"", time: int = 10**9) -> bytes:
    return record(5, struct.pack("<HIQQ", number, 0, time, time) + payload)


def chunk(data: bytes, compression: str = "zstd", size: int | None = None, crc: bool = True) -> bytes:
    packed = zstandard.ZstdCompressor(level=3).compress(data) if compression == "zstd" else data
    head = struct.pack("<QQQI", 0, 1, len(data) if size is None else size, zlib.crc32(data) if crc else 0)
    return record(6, head + text(compression) + struct.pack("<Q", len(packed)) + packed)


def metadata(name: str, content: dict[str, str]) -> bytes:
    return record(12, text(name) + pairs(content))


def file(*records: bytes) -> bytes:
    return MAGIC + record(1, text("ros2") + text("x")) + b"".join(records) + record(15, bytes(4))


def floats(value: float = 1.0) -> bytes:
    return b"\0\1\0\0" + struct.pack("<d", value)


GOOD = schema(1, "a/msg/A", "float64 x") + channel(1, 1, "/good") + message(1, floats())


def typed(definition: str, payload: bytes, encoding: str = "ros2msg", name: str = "a/msg/B") -> bytes:
    return file(GOOD, schema(2, name, definition, encoding), channel(2, 2, "/bad"), message(2, payload))


def many_layouts() -> bytes:
    """Strings of every length: no two messages alike, each of many fields."""
    definition = "string s\n" + "".join(f"float64 f{i}\n" for i in range(200))
    sent = []
    for k in range(5_000):
        body = struct.pack("<I", k % 4000 + 1) + b"a" * (k % 4000) + b"\0"
        body += b"\0" * (-len(body) % 8) + b"\0" * 1600
        sent.append(message(2, b"\0\1\0\0" + body, k))
    inside = schema(2, "a/msg/B", definition) + channel(2, 2, "/bad") + b"".join(sent)
    return file(GOOD, chunk(inside))


def sequences() -> bytes:
    """A few bytes a message, sequences of sequences in thousands of messages."""
    definition = "P[] p\n" + "=" * 80 + "\nMSG: a/P\nQ[] q\n" + "=" * 80 + "\nMSG: a/Q\nuint8[] r\n"
    inner = struct.pack("<I", 60) + (struct.pack("<I", 60) + struct.pack("<I", 0) * 60) * 60
    sent = b"".join(message(2, b"\0\1\0\0" + inner, k) for k in range(3000))
    return file(GOOD, chunk(schema(2, "a/msg/B", definition) + channel(2, 2, "/bad") + sent))


def bytes_as_numbers() -> bytes:
    """One byte of content becomes eight in a channel, in 60 arrays of 64."""
    definition = "".join(f"uint8[64] f{i}\n" for i in range(60))
    sent = b"".join(message(2, b"\0\1\0\0" + bytes(3840), k) for k in range(40_000))
    return file(GOOD, chunk(schema(2, "a/msg/B", definition) + channel(2, 2, "/bad") + sent))


HOSTILE: dict[str, Callable[[], bytes]] = {
    "many chunks of 255 MiB": lambda: file(GOOD, *[chunk(bytes(0), size=255 << 20, crc=False)] * 24),
    "many real chunks": lambda: file(GOOD, *[chunk(record(200, bytes(20 << 20)))] * 40),
    "millions of tiny messages": lambda: file(GOOD, chunk(message(1, floats()) * 2_500_000)),
    "millions of empty messages": lambda: file(GOOD, chunk(message(1) * 2_500_000)),
    "messages of unknown channels": lambda: file(GOOD, chunk(message(7) * 2_500_000)),
    "many layouts": many_layouts,
    "sequences of sequences": sequences,
    "bytes as numbers": bytes_as_numbers,
    "a hundred thousand metadata records": lambda: file(GOOD, chunk(metadata("x", {"a": "b"}) * 200_000)),
    "metadata with a million keys": lambda: file(GOOD, metadata("x", {f"{i}": "" for i in range(200_000)})),
    "ten thousand channels": lambda: file(GOOD, *(channel(i, 1, f"/t{i}") + message(i, floats()) for i in range(3000))),
    "ten thousand channels and metadata": lambda: file(
        GOOD, *(channel(i, 1, f"/t{i}") for i in range(2, 3000)), metadata("x", {}) * 50_000
    ),
    "schemas of 60 MiB": lambda: file(
        GOOD, *(chunk(schema(i, "a/msg/B", b"#" * (60 << 20))) for i in range(2, 8)), channel(2, 2, "/bad")
    ),
    "large schemas, many": lambda: file(
        GOOD,
        *(
            schema(i, "a/msg/B", "".join(f"float64 f{k}\n" for k in range(4000))) + channel(i, i, f"/bad{i}")
            + message(i, floats())
            for i in range(2, 60)
        ),
    ),
    "nested IDL": lambda: typed("module a { " * 2000 + "}; " * 2000, b"\0\1\0\0", "ros2idl"),
    "annotated IDL": lambda: typed(
        "module a { module msg { @verbatim(language=\"c\", text=\"x\") @unknown(3) struct B { @key double x; }; }; };",
        floats(), "ros2idl"),
    "computed IDL": lambda: typed(
        "module a { module msg { const long N = 3 + 4 << 70; struct B { double x[N * N]; }; }; };",
        floats(), "ros2idl"),
    "divided IDL": lambda: typed(
        "module a { module msg { const long N = 1 / 0; struct B { double x[N]; }; }; };", floats(), "ros2idl"),
    "IDL of brackets": lambda: typed("(" * 100_000, floats(), "ros2idl"),
    "a field twice": lambda: typed("float64 x\nfloat64 x\n", floats() + bytes(8)),
    "a type within itself": lambda: typed("B b\n", floats()),
    "arrays of arrays of a huge size": lambda: typed("float64[4000000000] x\n", floats()),
    "an array of negative size": lambda: typed("float64[-1] x\n", floats()),
    "a bounded string beyond": lambda: typed("string<=3 x\n", b"\0\1\0\0" + struct.pack("<I", 5) + b"abcd\0"),
    "a definition of commas": lambda: typed("," * 50_000, floats()),
    "a definition that is no text": lambda: file(
        GOOD, schema(2, "a/msg/B", b"\xff\xfe"), channel(2, 2, "/bad"), message(2, floats())),
    "a name that is no type": lambda: typed("float64 x", floats(), name="/////"),
    "an empty name": lambda: typed("float64 x", floats(), name=""),
    "names with control characters": lambda: file(
        schema(1, "a/msg/A", "float64 x"), channel(1, 1, "/\x1b[31m\n\0"), message(1, floats())),
    "metadata too deep": lambda: file(GOOD, metadata("run", {"json": "[" * 200_000})),
    "metadata deep": lambda: file(GOOD, metadata("run", {"json": '{"a":' * 400 + "1" + "}" * 400})),
    "metadata with half a pair": lambda: file(GOOD, metadata("run", {"json": '{"a": "\\ud800"}'})),
    "metadata with a huge number": lambda: file(GOOD, metadata("run", {"json": '{"a": ' + "9" * 5000 + "}"})),
    "an import that is null": lambda: file(GOOD, metadata("run", {"json": '{"import": null}'})),
    "an import that is a list": lambda: file(GOOD, metadata("run", {"json": '{"import": {"decisions": [1, null]}}'})),
    "stamps of the far future": lambda: file(
        schema(1, "a/msg/A", "float64 x"), channel(1, 1, "/good"), message(1, floats(), (1 << 64) - 1)),
    "a chunk in a chunk": lambda: file(GOOD, chunk(chunk(chunk(message(1, floats()))))),
    "a chunk that unpacks to more": lambda: file(GOOD, chunk(bytes(10 << 20), size=10)),
    "an attachment of all": lambda: file(GOOD, record(9, bytes(1000))),
}  # fmt: skip
