"""A run: named channels, each with its own stamps, unit and frame. Maths only, no I/O.

A channel is one scalar of one topic: "thruster_0/state.n" is field `n` of topic `thruster_0/state`,
"thruster_0/gauges.voltage[0]" the first element of an array. Stamps are integer nanoseconds, because
floating-point seconds lose ticks; seconds are counted from the start of the run. NaN means "not measured".
"""

from __future__ import annotations

import copy
import difflib
import json
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .alignment import ALIGNMENTS, HOLDS, Method
from .errors import InvalidRunError, MissingChannelError, RunError

NANOSECONDS = 1_000_000_000


def _by_number(name: str) -> list[str | int]:
    """Return a key by which data[2] comes before data[10]."""
    return [int(part) if part.isdigit() else part for part in re.split(r"(\d+)", name)]


@dataclass(frozen=True, kw_only=True, eq=False)
class Channel:
    """One scalar signal.

    Attributes:
        name: topic without leading slash, a dot, and the path of the field.
        stamps: instants of measurement [ns], int64, non-decreasing, shape (N,), N >= 1, read-only.
        values: float64, shape (N,), read-only; NaN = not measured. Integers beyond 2**53 are rounded.
        unit: SI unit such as "rad/s"; "1" for a pure number, "" if unknown.
        frame: frame id of the measurement, "" if it has none.

    Raises:
        InvalidRunError: with everything that is wrong at once.
    """

    name: str
    stamps: NDArray[np.int64]
    values: NDArray[np.float64]
    unit: str = ""
    frame: str = ""

    def __post_init__(self) -> None:
        problems = []
        stamps, values = np.asarray(self.stamps), np.asarray(self.values)
        if not self.name or self.name.startswith("/"):
            problems.append(f"expected a name without leading slash, found {self.name!r}")
        if stamps.dtype.kind not in "iu":
            problems.append(f"expected integer stamps in nanoseconds, found {stamps.dtype}")
        if values.dtype.kind not in "fiub":
            problems.append(f"expected numbers as values, found {values.dtype}")
        if stamps.ndim != 1 or stamps.shape != values.shape:
            problems.append(f"expected stamps and values of one length, found {stamps.shape} and {values.shape}")
        elif not stamps.size:
            problems.append("expected at least one sample, found none")
        elif stamps.dtype.kind in "iu" and (falls := np.flatnonzero(stamps[1:] < stamps[:-1])).size:
            i = int(falls[0])
            problems.append(f"stamps run backwards at sample {i + 1}: {stamps[i]} ns, then {stamps[i + 1]} ns")
        if problems:
            raise InvalidRunError(f"channel {self.name!r}", problems)
        for key, array in (("stamps", stamps.astype(np.int64)), ("values", values.astype(np.float64))):
            array.flags.writeable = False
            object.__setattr__(self, key, array)

    def __len__(self) -> int:
        return len(self.stamps)

    def __reduce__(self) -> tuple[Any, ...]:
        return (_build_channel, (self.name, self.stamps, self.values, self.unit, self.frame))

    def slice(self, start_ns: int, end_ns: int) -> Channel | None:
        """Return the samples with start_ns <= stamp < end_ns, or None if there is none."""
        first, last = np.searchsorted(self.stamps, [start_ns, end_ns], side="left")
        if last <= first:
            return None
        return replace(self, stamps=self.stamps[first:last], values=self.values[first:last])


def _build_channel(name: str, stamps: Any, values: Any, unit: str, frame: str) -> Channel:
    return Channel(name=name, stamps=stamps, values=values, unit=unit, frame=frame)


@dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """A recording in memory.

    Attributes:
        name: name of the recording.
        channels: by name; sorted by name, at least one.
        metadata: what was run or what was reconstructed; JSON values.
        warnings: what the reader had to leave out or could not trust, one sentence each.

    Raises:
        InvalidRunError: with everything that is wrong at once.
    """

    name: str
    channels: Mapping[str, Channel]
    metadata: Mapping[str, Any] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        problems = [f"channel {c.name!r} is filed under {k!r}" for k, c in self.channels.items() if k != c.name]
        if not self.channels:
            problems.append("expected at least one channel, found none")
        try:
            json.dumps(self.metadata, allow_nan=False)
        except (TypeError, ValueError) as error:
            problems.append(f"metadata is no JSON: {error}")
        if problems:
            raise InvalidRunError(f"run {self.name!r}", problems)
        object.__setattr__(self, "channels", {k: self.channels[k] for k in sorted(self.channels, key=_by_number)})
        object.__setattr__(self, "metadata", copy.deepcopy(dict(self.metadata)))
        object.__setattr__(self, "warnings", tuple(self.warnings))

    def __getitem__(self, name: str) -> Channel:
        try:
            return self.channels[name]
        except KeyError:
            near = difflib.get_close_matches(name, self.channels, n=1, cutoff=0.6)
            hint = f", nearest is {near[0]!r}" if near else ""
            listed = ", ".join(self.channels)
            text = f"run {self.name!r} has no channel {name!r}{hint}; it has: {listed}"
            raise MissingChannelError(text, name=name, available=list(self.channels)) from None

    def __contains__(self, name: object) -> bool:
        return name in self.channels

    def __iter__(self) -> Iterator[str]:
        return iter(self.channels)

    @property
    def start(self) -> int:
        """First stamp of any channel [ns]."""
        return int(min(c.stamps[0] for c in self.channels.values()))

    @property
    def end(self) -> int:
        """Last stamp of any channel [ns]."""
        return int(max(c.stamps[-1] for c in self.channels.values()))

    @property
    def duration(self) -> float:
        """Time from the first to the last stamp [s]."""
        return (self.end - self.start) / NANOSECONDS

    def time(self, name: str) -> NDArray[np.float64]:
        """Return the stamps of a channel as seconds since the start of the run, shape (N,)."""
        return np.asarray((self[name].stamps - self.start) * 1e-9, dtype=np.float64)

    def hold(self, signal: str) -> str | None:
        """Return how a signal acts between its samples, as `hold` in the metadata states: "previous" or "linear".

        None: nothing is stated of it.

        Raises:
            RunError: something else is.
        """
        stated = self.metadata.get("hold")
        told = stated.get(signal) if isinstance(stated, Mapping) else None
        if told not in (None, *HOLDS):
            expected = f"expected metadata hold.{signal} {' or '.join(HOLDS)}"
            raise RunError(f"{self.name}: {expected}; found {told!r}", expected=HOLDS, found=told)
        return told

    def slice(self, start_s: float, end_s: float | None = None) -> Run:
        """Return the part with start_s <= time < end_s [s since start]; None: up to and including the end.

        Channels without a sample in it are left out. Times of the result count from its own first stamp.

        Raises:
            InvalidRunError: when no channel has a sample in it.
        """
        first = self.start + round(start_s * NANOSECONDS)
        last = self.end + 1 if end_s is None else self.start + round(end_s * NANOSECONDS)
        parts = {k: part for k, c in self.channels.items() if (part := c.slice(first, last)) is not None}
        return replace(self, channels=parts)

    def align(
        self, names: Iterable[str], grid_s: ArrayLike, method: Method = "previous"
    ) -> dict[str, NDArray[np.float64]]:
        """Return channels on one time grid.

        Args:
            names: channels.
            grid_s: strictly increasing seconds since the start of the run, shape (M,).
            method: "previous" (zero-order hold), "linear", or "mean" over the cell centred on the grid point
                (from the middle to the previous point up to the middle to the next; NaN where it is empty).

        Returns:
            name -> values of shape (M,); NaN outside the channel's own first and last stamp.

        Raises:
            MissingChannelError: a name is not in the run.
            RunError: the grid or the method is not usable.
        """
        if method not in ALIGNMENTS:
            raise RunError(f"expected one of {', '.join(ALIGNMENTS)}, found {method!r}", found=method)
        grid = np.asarray(grid_s, dtype=np.float64)
        least = 2 if method == "mean" else 1
        if grid.ndim != 1 or len(grid) < least or not np.all(np.isfinite(grid)) or np.any(np.diff(grid) <= 0):
            text = f"expected a grid of at least {least} strictly increasing times in seconds"
            raise RunError(f"{text}, found {grid.ndim} dimensions and {grid.size} values", expected=least)
        ticks = self.start + np.round(grid * NANOSECONDS).astype(np.int64)
        channels = {name: self[name] for name in names}
        return {name: ALIGNMENTS[method](c.stamps, c.values, ticks) for name, c in channels.items()}

    def drop(self, names: Iterable[str]) -> Run:
        """Return the run without these channels; each must be there."""
        gone = {self[name].name for name in names}
        return replace(self, channels={k: c for k, c in self.channels.items() if k not in gone})
