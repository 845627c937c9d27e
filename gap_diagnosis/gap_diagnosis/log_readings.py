"""What a log does not say: how commands act between samples, and whether its stamps are those of the samples.

All ways to read it are fitted. Which one is right is asked of a model that may lack an effect at first, so it is asked
again with each effect that is found: dry friction that is not known of looks like commands in straight lines.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.investigation import Investigation
from gap_diagnosis.plausibility import checked
from gap_diagnosis.problem import Problem
from gap_diagnosis.rules import LOG_RULES
from gap_diagnosis.scatter import Scatter
from gap_diagnosis.stamps import jitter_of_stamps, on_regular_stamps
from system_identification.hypothesis import Hypothesis, weighed
from system_identification.noise import whitener

__all__ = ["LogReading", "read_as_suits"]

Array = NDArray[np.float64]
_TURNS = 3
"""Times that logs may be read in another way."""


class _Misread(Exception):
    """Another way to read the logs suits what was found in them better."""

    def __init__(self, better: "LogReading") -> None:
        super().__init__()
        self.better = better


@dataclass(frozen=True, kw_only=True)
class LogReading:
    """One way to read the logs.

    Attributes:
        log: the problem with commands held, on the stamps in the log.
        straight: whether commands act as straight lines between their samples; None: that was stated.
        on_regular: whether stamps are replaced by regular ones.
    """

    log: Problem
    straight: bool | None
    on_regular: bool = False
    _gains: dict[tuple[str, ...], float] = field(init=False, default_factory=dict, compare=False, repr=False)

    @cached_property
    def as_stamped(self) -> Problem:
        """The problem on the stamps in the log."""
        if not self.straight:
            return self.log
        lines = tuple(recording.straight or recording for recording in self.log.recordings)
        return replace(self.log, recordings=lines)

    @cached_property
    def regular(self) -> Problem | None:
        """The problem on regular stamps; None: none scatter."""
        return on_regular_stamps(
            self.as_stamped, checked([each.regular or each for each in self.as_stamped.recordings]).recordings
        )

    @property
    def problem(self) -> Problem:
        """What is diagnosed."""
        return self.regular if self.on_regular and self.regular is not None else self.as_stamped

    def better_for(self, found: Hypothesis) -> "LogReading | None":
        """Return another way that suits a set of effects, found in this one, better by far; None: there is none."""
        if (self._for_regular(found) >= LOG_RULES.jitter) is not self.on_regular:
            return replace(self, on_regular=not self.on_regular)
        if self.straight is not None:
            other = replace(self, straight=not self.straight)
            if other.problem.known.size != self.problem.known.size:
                return None  # what is not the same data cannot be compared
            if self._gain(other.problem, found, "straight") > LOG_RULES.straight:
                return other
        return None

    def jitter(self, found: Hypothesis) -> Scatter | None:
        """Return what it says that regular stamps suit what was found better; None: they do not."""
        gain = self._for_regular(found)
        return jitter_of_stamps(self.as_stamped, gain) if gain >= LOG_RULES.jitter else None

    def _for_regular(self, found: Hypothesis) -> float:
        """Return by how much regular stamps suit a set found in this reading better, nats; 0: none scatter."""
        if self.regular is None:
            return 0.0
        if self.on_regular:
            return -self._gain(self.as_stamped, found, "stamps")
        return self._gain(self.regular, found, "stamps")

    def _gain(self, other: Problem, found: Hypothesis, way: str) -> float:
        """Return by how much a set suits another way better; of a set that was asked before it is known."""
        key = (way, *sorted(found.keys))
        if key not in self._gains:
            self._gains[key] = _ahead(other, found)
        return self._gains[key]


def read_as_suits(
    log: Problem, investigated: Callable[[Problem, Callable[[Hypothesis], None]], Investigation]
) -> tuple[LogReading, Investigation]:
    """Return the way to read the logs that suits what is found in them, and what is found.

    Args:
        log: with commands held, on the stamps in the log.
        investigated: finds sets of effects for a problem, and gives each one as it is found.
    """

    def ask(found: Hypothesis) -> None:
        better = reading.better_for(found)
        if better is not None:
            raise _Misread(better)

    reading = _first(log)
    for _ in range(_TURNS):
        try:
            return reading, investigated(reading.problem, ask)
        except _Misread as misread:
            reading = misread.better
    return reading, investigated(reading.problem, lambda _: None)


def _first(log: Problem) -> LogReading:
    """Return the way that suits re-tuned parameters best; commands are held where both do about alike."""
    known = all(recording.straight is None for recording in log.recordings)
    best = LogReading(log=log, straight=None if known else False)
    if known and best.regular is None:
        return best  # there is no other way: no fit is made to ask
    for _ in range(_TURNS):
        start = best.problem.start()
        better = best.better_for(weighed(best.problem, (), start, whitener(best.problem, start)))
        if better is None:
            break
        best = better
    return best


def _ahead(problem: Problem, found: Hypothesis) -> float:
    """Return by how much a set of effects suits another reading better than its own, nats.

    By samples that count in both. One is an outlier where neither way explains it: stamps that are wrong make many that
    the right ones do not, and those that stand out either way decide nothing. Noises of both are learned anew, from
    those of the set: one that was learned once more than the other was ahead by 700 nats, whichever it was.
    """
    pair = _read_in(found.system, found), _read_in(problem, found)
    count = pair[0].system.known & pair[1].system.known
    wild = np.minimum(*(np.ones(count.size) if each.noise.wild is None else each.noise.wild for each in pair))
    own, other = (_weighed_by(each, count, wild) for each in pair)
    return other.evidence - own.evidence


def _weighed_by(found: Hypothesis, count: NDArray[np.bool_], wild: Array) -> Hypothesis:
    """Return a hypothesis weighed anew by the samples that count, with outliers as they are known."""
    system = replace(found.system, observed=np.where(count, found.system.measured, np.nan))
    return weighed(system, found.suspects, found.fitted.x, found.noise, near=found.fitted, wild=wild)


def _read_in(problem: Problem, found: Hypothesis) -> Hypothesis:
    """Return a set of effects fitted to readings, its noise learned anew."""
    system = found.system
    posed = problem.with_effects(system.slots, system.gates)
    own = posed.nuisances == system.nuisances
    start = found.fitted.x if own else posed.start(found.fitted.x[system.nuisances :])
    return weighed(posed, found.suspects, start, whitener(posed, start, found.noise.levels))
