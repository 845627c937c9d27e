"""Effects that begin in the middle of a recording: a failure."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from rov_sim.vehicle.effects.active import ActiveVehicleEffect

__all__ = ["Begun", "Onset", "on_in", "pieces"]

_SHARP = 0.5
"""[s] An interval that is no longer is told as one time."""


class Onset(NamedTuple):
    """When an effect begins: number of the recording and its name, instant since its clock's start, period between
    these [s], number of the last recording in which it is still there, among how many onsets it was found, and the
    first and last instant of those that are about as likely."""

    run: int
    name: str
    instant: int
    period: float
    last: int
    among: int
    earliest: int = 0
    latest: int = 0

    @property
    def time(self) -> float:
        """[s] since the recording's start."""
        return self.instant * self.period

    @property
    def interval(self) -> tuple[float, float]:
        """Earliest and latest time [s] that is about as likely."""
        return self.earliest * self.period, self.latest * self.period

    @property
    def lasts(self) -> bool:
        """Whether it is there in later recordings too."""
        return self.last > self.run

    @property
    def words(self) -> str:
        """It in a sentence."""
        first, last = self.interval
        when = f"{self.time:.1f} s" if last - first < _SHARP else f"somewhere between {first:.1f} and {last:.1f} s"
        return f"from {when} of {self.name} on{', later recordings included' if self.lasts else ''}"


@dataclass(frozen=True, kw_only=True)
class Begun(ActiveVehicleEffect):
    """An effect that is off before its onset."""

    onset: Onset


def on_in(effects: Sequence[ActiveVehicleEffect], run: int) -> list[ActiveVehicleEffect]:
    """Return the effects that are on at the end of a recording; those of one that is not there yet (-1): all."""
    return [
        e for e in effects if run < 0 or not isinstance(e, Begun) or e.onset.run <= run <= e.onset.last
    ]  # fmt: skip


def pieces(
    effects: Sequence[ActiveVehicleEffect], run: int, cut: int, count: int
) -> list[tuple[int, Sequence[ActiveVehicleEffect]]]:  # fmt: skip
    """Return the instants of a log from which on other effects are on, the first of them 0, with these effects.

    cut, count: of the log.
    """
    there = on_in(effects, run)
    begins = {id(e): e.onset.instant - cut for e in there if isinstance(e, Begun) and e.onset.run == run}
    firsts = sorted({0, *(k for k in begins.values() if 0 < k < count)})
    return [(first, [e for e in there if begins.get(id(e), 0) <= first]) for first in firsts]
