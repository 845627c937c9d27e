"""A copy of a run with other stamps, as another clock or another recorder would have put them on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .bag_folder import bag_files
from .definitions import definitions
from .finishing import Finished, recover
from .mcap_content import RawMessage, RawTopic
from .mcap_scan import scan
from .stamps import has_header, header_stamp, restamped

__all__ = ["Change", "restamp"]

Ticks = NDArray[np.int64]
Change = Callable[[Mapping[str, Ticks]], Mapping[str, tuple[Ticks, Ticks]]]
"""Makes of the stamps of all topics [ns], (N,) each, the new stamps and the number of the message, not a later one,
whose content goes with each; topics that it does not name stay as they are."""


def restamp(path: Path, target: Path, change: Change, about: Mapping[str, Any] | None = None) -> Finished:
    """Copy a run to a new one with other stamps in the headers; the time at which messages were logged stays.

    Args:
        path: the run; it is not touched.
        target: the new one.
        change: of the stamps.
        about: what is added to the run's metadata.

    Raises:
        RunExistsError, NotARunError, TooLargeError, CannotWriteError: as `recover`.
    """
    changed = change(_stamps(path))
    places = dict.fromkeys(changed, 0)
    held: dict[str, bytes] = {}

    def alter(topic: str, payload: bytes) -> bytes:
        if topic not in changed:
            return payload
        stamps, sources = changed[topic]
        place = places[topic]
        places[topic] += 1
        if sources[place] == place:
            held[topic] = payload
        return restamped(held[topic], int(stamps[place]))

    return recover(path, target, alter, about)


def _stamps(path: Path) -> dict[str, Ticks]:
    """Return the stamps [ns] of all messages that have a header, by topic as in the file."""
    found: dict[str, list[int]] = {}
    known: dict[str, bool] = {}

    def receive(message: RawMessage, raw: RawTopic) -> None:
        kind = raw.schema.name if raw.schema else ""
        if kind not in known:
            known[kind] = bool(kind) and has_header(definitions().fields(kind), kind)
        if known[kind]:
            found.setdefault(raw.topic, []).append(header_stamp(message.payload))

    for file in bag_files(path)[0]:
        scan(file, receive=receive)
    return {topic: np.array(stamps, dtype=np.int64) for topic, stamps in found.items()}
