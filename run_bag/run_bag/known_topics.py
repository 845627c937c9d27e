"""The topics of a thruster and of the vehicle by name, and the type of each."""

from __future__ import annotations

import re

from .topics_table import KnownTopic, topics

_THRUSTER, _NUMBER = "thruster_<i>/", re.compile(r"thruster_\d+/")
KNOWN = {t.name.removeprefix(_THRUSTER): t.type for t in topics() if t.name.startswith(_THRUSTER)}
"""Last part of `thruster_<i>/...` -> type."""
KNOWN_VEHICLE = {t.name: t.type for t in topics() if t.name.startswith("rov/")}
_BY_NAME = {t.name.lstrip("/"): t for t in topics()}


def known_topic(topic: str) -> KnownTopic | None:
    """Return a topic of the table, None for others."""
    return _BY_NAME.get(_NUMBER.sub(_THRUSTER, topic.strip("/"), count=1))


def topic_type(topic: str) -> str | None:
    """Return the message type of a known topic, None for others."""
    found = known_topic(topic)
    return None if found is None else found.type


def known_topics() -> str:
    """Return the names of all of them, for a sentence."""
    return ", ".join(t.name for t in topics())


def topic_rows() -> str:
    """Return the rows of the README's table of topics."""
    return "".join(f"| `{t.name}` | `{t.type.replace('/msg/', '/')}` | {t.content} |\n" for t in topics())
