"""Readings as they come in, cut into pieces of a vehicle's log that follow each other without a gap."""

from collections import defaultdict

import numpy as np

from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.log_io import log_of
from gap_diagnosis.vehicle.rules import PERIOD
from run_bag import Channel, Run, RunError

__all__ = ["Feed"]

_KEPT = 1.5  # s of readings before a piece: what a parabola or a held throttle needs
_NANO = 1_000_000_000


class Feed:
    """Collects readings by channel; `piece` gives what has become complete."""

    def __init__(self, thrusters: int, piece: float = 1.0, late: float = 0.15) -> None:
        """Pieces of so many seconds; a piece is complete `late` [s] after its end."""
        self._thrusters, self._piece, self._late = thrusters, piece, late
        self._stamps: dict[str, list[int]] = defaultdict(list)
        self._values: dict[str, list[float]] = defaultdict(list)
        self._next: int | None = None

    def add(self, channel: str, stamp: int, value: float) -> None:
        """Take one reading, stamped [ns]; one that is older than the one before it is left out."""
        stamps = self._stamps[channel]
        if not stamps or stamp >= stamps[-1]:
            stamps.append(stamp)
            self._values[channel].append(value)

    def piece(self) -> VehicleLog | None:
        """Return the next piece, or None while it is not complete."""
        newest = max((s[-1] for name, s in self._stamps.items() if s and "throttle" in name), default=None)
        if newest is None:
            return None
        if self._next is None:
            self._next = newest
        end = self._next + round(self._piece * _NANO)
        if newest < end + round(self._late * _NANO):
            return None
        oldest = self._next - round(_KEPT * _NANO)
        channels = {}
        for name, stamps in self._stamps.items():
            keep = next((k for k, s in enumerate(stamps) if s >= oldest), len(stamps))
            if "throttle" in name:  # held ones act on after they were told
                keep = max(keep - 1, 0)
            del stamps[:keep], self._values[name][:keep]
            if stamps:
                values = np.array(self._values[name])
                channels[name] = Channel(name=name, stamps=np.array(stamps, dtype=np.int64), values=values)
        run = Run(name="watched", channels=channels)
        first = (self._next - run.start) / _NANO
        grid = np.asarray(first + PERIOD * np.arange(round(self._piece / PERIOD)), dtype=np.float64)
        self._next = end
        try:
            return log_of(run, self._thrusters, grid=grid)
        except RunError:
            return None
