"""Readings as they come in, cut into pieces of a vehicle's log that follow each other without a gap.

Topics are stamped as they please. What is known is known up to the least of the throttles' latest stamps: a throttle is
held until the next one comes. One that does not come for `silence` is waited for no longer, and counts as zero from
then on, as drivers take it.
"""

from collections import defaultdict
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.log_io import log_of
from gap_diagnosis.vehicle.rules import PERIOD
from gap_diagnosis.vehicle.turns import Stated
from run_bag import Channel, Run

__all__ = ["Feed"]

_KEPT = 3.5  # s of readings before a piece: what three readings of a battery or a held throttle need
_NANO = 1_000_000_000


class Feed:
    """Collects readings by channel; `piece` gives what has become complete."""

    def __init__(
        self, thrusters: int, period: float = PERIOD, piece: float = 1.0, late: float = 0.15, silence: float = 1.0,
        *, stated: Stated | None = None,
    ) -> None:  # fmt: skip
        """Pieces of about so many seconds, in whole periods; one is complete when all is known up to `late` [s] after.

        A throttle is silent after `silence` [s], by the stamps of all readings: far longer than any loop's period.
        stated: see `log_of`.
        """
        self._stated = stated
        self._thrusters, self._late = thrusters, round(late * _NANO)
        self._period, self._count = period, max(round(piece / period), 1)
        self._piece, self._silence = round(self._count * period * _NANO), round(silence * _NANO)
        self._stamps: dict[str, list[int]] = defaultdict(list)
        self._values: dict[str, list[float]] = defaultdict(list)
        self._throttles: dict[int, int] = {}
        self._first = self._newest = 0
        self._next: int | None = None

    def add(self, stamp: int, readings: Mapping[str, float]) -> None:
        """Take readings by channel, stamped [ns]; one that is older than the one before it is left out."""
        self._first, self._newest = self._first or stamp, max(self._newest, stamp)
        for channel, value in readings.items():
            stamps = self._stamps[channel]
            if not stamps or stamp >= stamps[-1]:
                stamps.append(stamp)
                self._values[channel].append(value)

    def add_throttle(self, thruster: int, stamp: int, commanded: float) -> None:
        """Take a thruster's throttle [V], as `add` does."""
        self._throttles[thruster] = stamp
        self.add(stamp, {f"thruster_{thruster}/throttle.commanded": commanded})

    @property
    def known(self) -> int | None:
        """Instant [ns] up to which all throttles are known; None while one has not come that may still come."""
        patient = self._newest - self._silence
        if len(self._throttles) == self._thrusters:
            return max(min(self._throttles.values()), patient)
        return patient if self._throttles and patient >= self._first else None

    @property
    def silent(self) -> list[int]:
        """Thrusters whose throttles are waited for no longer."""
        oldest = self._newest - self._silence
        return [i for i in range(self._thrusters) if self._throttles.get(i, self._first) < oldest]

    def piece(self) -> VehicleLog | None:
        """Return the next piece, or None while it is not complete.

        Raises:
            RunError: nothing in it tells the vehicle's motion; the next one follows after it.
        """
        known = self.known
        if known is None:
            return None
        if self._next is None:
            self._next = known
        end = self._next + self._piece
        if known < end + self._late:
            return None
        begin, self._next = self._next, end
        run = Run(name="watched", channels=self._channels(begin - round(_KEPT * _NANO)))
        first = (begin - run.start) / _NANO
        grid = np.asarray(first + self._period * np.arange(self._count), dtype=np.float64)
        return log_of(run, self._thrusters, self._period, grid, stated=self._stated)

    def _channels(self, oldest: int) -> dict[str, Channel]:
        """Return all readings from the oldest instant [ns] on, and forget what came before."""
        channels = {}
        for name, stamps in self._stamps.items():
            keep = next((k for k, s in enumerate(stamps) if s >= oldest), len(stamps))
            held = "throttle" in name
            if held:  # it acts on after it was told
                keep = max(keep - 1, 0)
            del stamps[:keep], self._values[name][:keep]
            if stamps:
                at, values = np.array(stamps, dtype=np.int64), np.array(self._values[name])
                channels[name] = Channel(name=name, stamps=at, values=values)
                if held:
                    channels[name] = self._zero_where_silent(channels[name])
        return channels

    def _zero_where_silent(self, held: Channel) -> Channel:
        stamps: NDArray[np.int64] = np.asarray(held.stamps, dtype=np.int64)
        gone = np.flatnonzero(np.diff(np.append(stamps, self._newest)) > self._silence)
        return Channel(
            name=held.name,
            stamps=np.insert(stamps, gone + 1, stamps[gone] + self._silence),
            values=np.insert(held.values, gone + 1, 0.0),
        )
