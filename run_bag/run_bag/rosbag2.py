"""What stock rosbag2 (Jazzy, metadata version 9) expects around the messages. Shared by every writer."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml
from mcap.writer import Writer

from safe_files.errors import YamlError
from safe_files.yaml_io import parse_yaml

from .definitions import definitions
from .run_metadata import RUN_RECORD, run_text

LIBRARY = "run_bag"
BAG_RECORD = "rosbag2"
INFINITE = {"sec": 9223372036, "nsec": 854775807}
DEFAULT_QOS: dict[str, Any] = {
    "history": "keep_last",
    "depth": 10,
    "reliability": "reliable",
    "durability": "volatile",
    "deadline": INFINITE,
    "lifespan": INFINITE,
    "liveliness": "automatic",
    "liveliness_lease_duration": INFINITE,
    "avoid_ros_namespace_conventions": False,
}


LATCHED_QOS = {**DEFAULT_QOS, "depth": 1, "durability": "transient_local"}


_Fastest: Any = getattr(yaml, "CSafeDumper", yaml.SafeDumper)  # libyaml's, where PyYAML was built with it


class _Dumper(_Fastest):  # type: ignore[misc]
    """rosbag2's YAML reader is happier without anchors."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


def dump(data: object) -> str:
    """Return YAML without anchors, keys in the given order."""
    return yaml.dump(data, Dumper=_Dumper, sort_keys=False, allow_unicode=True)


@dataclass(frozen=True, kw_only=True)
class TopicRecord:
    """A topic as rosbag2 describes it; `qos` holds one profile per publisher, `type_hash` is looked up if None."""

    name: str
    type: str
    qos: tuple[Mapping[str, Any], ...] = (DEFAULT_QOS,)
    type_hash: str | None = None

    def metadata(self) -> dict[str, Any]:
        """Return the `topic_metadata` entry of metadata.yaml."""
        return {
            "name": self.name,
            "type": self.type,
            "serialization_format": "cdr",
            "offered_qos_profiles": [dict(q) for q in self.qos],
            "type_description_hash": self.hash(),
        }

    def hash(self) -> str:
        """Return the REP 2011 hash of the type."""
        return definitions().type_hash(self.type) if self.type_hash is None else self.type_hash

    def extra(self) -> dict[str, str]:
        """Return the metadata of the topic's MCAP channel."""
        return {
            "offered_qos_profiles": dump([dict(q) for q in self.qos]).strip(),
            "topic_type_hash": self.hash(),
        }


def type_hash(extra: Mapping[str, str]) -> str:
    """Return the hash of the type that a channel was recorded with, "" where it does not say."""
    return extra.get("topic_type_hash", "")


def offers(extra: Mapping[str, str]) -> tuple[Mapping[str, Any], ...]:
    """Return the QoS profiles that a channel was recorded with, or the default where it does not say."""
    try:
        loaded = parse_yaml(extra.get("offered_qos_profiles", ""), "offered_qos_profiles")
    except YamlError:
        loaded = None
    profiles = tuple(p for p in loaded if isinstance(p, dict)) if isinstance(loaded, list) else ()
    return profiles or (DEFAULT_QOS,)


class TopicRegistry:
    """Registers schemas and channels with an MCAP writer, each once."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._schemas: dict[str, int] = {}

    def add(self, topic: TopicRecord) -> int:
        """Register a topic and return the id of its channel."""
        if topic.type not in self._schemas:
            text = definitions().text(topic.type).encode()
            self._schemas[topic.type] = self._writer.register_schema(topic.type, "ros2msg", text)
        return self._writer.register_channel(topic.name, "cdr", self._schemas[topic.type], topic.extra())


def bag_metadata(
    file_name: str, start_ns: int, end_ns: int, counts: Iterable[tuple[TopicRecord, int]], told: str = ""
) -> dict[str, Any]:
    """Return the description of a bag of one file, as under `rosbag2_bagfile_information`; `told`: what was run."""
    listed = list(counts)
    topics = [{"topic_metadata": t.metadata(), "message_count": n} for t, n in listed]
    total = sum(n for _, n in listed)
    duration = {"nanoseconds": max(0, end_ns - start_ns)}
    start = {"nanoseconds_since_epoch": start_ns}
    file = {"path": file_name, "starting_time": start, "duration": duration, "message_count": total}
    return {
        "version": 9,
        "storage_identifier": "mcap",
        "duration": duration,
        "starting_time": start,
        "message_count": total,
        "topics_with_message_count": topics,
        "compression_format": "",
        "compression_mode": "",
        "relative_file_paths": [file_name],
        "files": [file],
        "custom_data": {RUN_RECORD: told} if told else None,
        "ros_distro": "jazzy",
    }


def write_run_record(writer: Writer, metadata: Mapping[str, Any]) -> None:
    """Store what was run (or reconstructed) as MCAP metadata; write it first, so that it survives a cut."""
    writer.add_metadata(RUN_RECORD, {"json": run_text(metadata)})


def write_bag_record(writer: Writer, bag: Mapping[str, Any]) -> None:
    """Store the description of the bag as MCAP metadata, as rosbag2 does on closing."""
    writer.add_metadata(BAG_RECORD, {"serialized_metadata": dump(dict(bag))})


def write_metadata_yaml(directory: Path, bag: Mapping[str, Any]) -> None:
    """Write metadata.yaml, complete or not at all; it is the sign that the bag is finished."""
    temporary = directory / "metadata.yaml.part"
    with temporary.open("w", encoding="utf-8") as file:
        file.write(dump({"rosbag2_bagfile_information": dict(bag)}))
        file.flush()
        os.fsync(file.fileno())
    temporary.replace(directory / "metadata.yaml")
