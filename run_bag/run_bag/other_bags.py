"""Bags that are no plain MCAP, as if they were: ROS 1, sqlite3, compressed as files or message by message.

What rosbags reads of them becomes the same raw topics that a scan of an MCAP file finds, so that everything behind it
is one path. A compressed file is unpacked into a temporary folder, within the budget.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterable, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import zstandard
from rosbags.interfaces import Connection
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag2.storage_sqlite3 import Sqlite3Reader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from .budget import Budget
from .errors import NotARunError, RunError
from .mcap_content import RawTopic, Scan, Schema
from .run_metadata import TOPIC, TYPES

Wanted = Callable[[str], bool]
ROS1_MAGIC = b"#ROSBAG V2.0"
SQLITE_MAGIC = b"SQLite format 3\0"


def convert_command(path: Path, storage: str = "sqlite3") -> str:
    """Return the shell command that makes a plain MCAP bag of another bag."""
    new = f"{path.resolve().name}_mcap"
    options = f"output_bags: [{{uri: {new}, storage_id: mcap, all_topics: true}}]"
    return f"echo '{options}' > convert.yaml && ros2 bag convert -i {path} {storage} -o convert.yaml"


def magic(path: Path) -> bytes:
    """Return the first bytes of a file."""
    with path.open("rb") as file:
        return file.read(16)


def other_files(path: Path, description: Mapping[str, Any]) -> list[Path] | None:
    """Return the files of a bag that the scan of MCAP does not read; None for those that it does."""
    if path.is_file():
        return [path] if path.suffix in (".db3", ".bag", ".zstd") or magic(path).startswith(ROS1_MAGIC) else None
    if not path.is_dir():
        return None
    found = sorted(p for p in path.iterdir() if p.suffix == ".db3" or p.name.endswith((".mcap.zstd", ".db3.zstd")))
    listed = [path / Path(str(name)).name for name in description.get("relative_file_paths") or []]
    files = [f for f in listed if f.is_file() and f in found]
    files += [f for f in found if f not in files]
    return files or None


def scan_others(files: Iterable[Path], wanted: Wanted, budget: Budget, scan_mcap: Callable[..., Scan]) -> list[Scan]:
    """Read such files.

    Raises:
        NotARunError: rosbags cannot read one of them; with the command that may.
        TooLargeError: more than the budget.
    """
    scans = []
    with ExitStack() as stack:
        for file in files:
            inner = file
            if file.suffix == ".zstd":
                folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="run_bag_")))
                inner = _unpacked(file, folder / file.stem, budget)
            try:
                if magic(inner).startswith(ROS1_MAGIC):
                    found = _ros1(inner, wanted, budget)
                elif magic(inner) == SQLITE_MAGIC:
                    found = _sqlite(inner, wanted, budget)
                else:
                    found = scan_mcap(inner, wanted, budget=budget)
            except RunError:
                raise
            except Exception as error:  # the readers raise all kinds on broken files
                why = " ".join(str(error).split())[:200] or type(error).__name__
                raise NotARunError(f"{file}: cannot be read: {why}; {_otherwise(file)}", path=file) from error
            found.path = file
            scans.append(found)
    return scans


def _otherwise(file: Path) -> str:
    if file.suffix == ".bag":
        return "`rosbag reindex` of ROS 1 mends a bag that was cut off"
    return f"try `{convert_command(file.parent, 'sqlite3' if '.db3' in file.name else 'mcap')}`"


def _unpacked(file: Path, target: Path, budget: Budget) -> Path:
    try:
        with file.open("rb") as source, target.open("wb") as sink:
            for block in zstandard.ZstdDecompressor().read_to_iter(source, write_size=1 << 20):
                budget.content(len(block), file)
                sink.write(block)
    except (zstandard.ZstdError, OSError) as error:
        raise NotARunError(f"{file}: cannot be unpacked: {error}", path=file) from error
    return target


def unpack_messages(scan: Scan, budget: Budget) -> None:
    """Unpack the messages of a bag that was compressed message by message, in place."""
    unpack = zstandard.ZstdDecompressor()
    for raw in scan.topics.values():
        for i, payload in enumerate(raw.payloads):
            try:
                with unpack.stream_reader(payload) as reader:
                    raw.payloads[i] = reader.read(budget.left_content() + 1)
            except zstandard.ZstdError as error:
                text = f"{scan.path}: topic {raw.topic}, message {i}: cannot be unpacked: {error}"
                raise NotARunError(text, path=scan.path, topic=raw.topic, position=i) from error
            budget.content(len(raw.payloads[i]), scan.path)


def _sqlite(file: Path, wanted: Wanted, budget: Budget) -> Scan:
    result = Scan(file, file.stat().st_size, complete=True)
    store = get_typestore(Stores.ROS2_JAZZY)
    reader = Sqlite3Reader(file)
    reader.open()
    try:
        for c in reader.connections:
            encoding = "ros2idl" if c.msgdef.format.name == "IDL" else "ros2msg"
            text = c.msgdef.data
            if not text and c.msgtype in store.fielddefs:
                text = store.generate_msgdef(c.msgtype, ros_version=2)[0]
            _topic(result, c, Schema(c.msgtype, encoding, text.encode()))
        _messages(result, reader, reader.connections, wanted, budget, lambda _, data: bytes(memoryview(data)))
    finally:
        reader.close()
    return result


def _ros1(file: Path, wanted: Wanted, budget: Budget) -> Scan:
    result = Scan(file, file.stat().st_size, complete=True)
    store = get_typestore(Stores.EMPTY)
    common = get_typestore(Stores.ROS2_JAZZY)
    with Ros1Reader(file) as reader:
        for c in reader.connections:
            types = get_types_from_msg(c.msgdef.data, c.msgtype)
            types.update({k: common.fielddefs[k] for k in types if k == "std_msgs/msg/Header"})  # type: ignore[misc]
            store.register({k: v for k, v in types.items() if k not in store.fielddefs})
        for c in reader.connections:
            text = store.generate_msgdef(c.msgtype, ros_version=2)[0]
            _topic(result, c, Schema(c.msgtype, "ros2msg", text.encode()))
        _messages(
            result,
            reader,
            reader.connections,
            wanted,
            budget,
            lambda c, data: bytes(store.ros1_to_cdr(data, c.msgtype)),
        )
    return result


def _topic(result: Scan, c: Connection, schema: Schema) -> None:
    if not (isinstance(c.topic, str) and isinstance(c.msgtype, str)):  # SQLite keeps any type in any column
        raise ValueError(f"expected names of a topic and its type, found {c.topic!r} and {c.msgtype!r}")
    if c.topic == TOPIC and schema.name in TYPES:
        return  # its messages are told, no topic's
    result.topics[c.id] = RawTopic(c.topic, "cdr", schema, {}, count=c.msgcount)


def _messages(
    result: Scan,
    reader: Any,
    connections: list[Connection],
    wanted: Wanted,
    budget: Budget,
    convert: Callable[[Connection, bytes], bytes],
) -> None:
    kept = [c for c in connections if wanted(c.topic) or c.id not in result.topics]
    if not kept:
        return
    for c, time, data in reader.messages(connections=kept):
        payload = convert(c, data)
        budget.message(len(payload), result.path)
        topic = result.topics.get(c.id)
        if topic is None:
            result.told.append(payload)
            continue
        if not (isinstance(time, int) and 0 <= time < 2**63):
            raise ValueError(f"topic {topic.topic}: expected a time in ns, found {time!r}")
        topic.log_times.append(time)
        topic.payloads.append(payload)
        result.last_log_time = max(time, result.last_log_time or 0)
