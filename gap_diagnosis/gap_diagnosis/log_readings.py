"""What a log does not say: how commands act between samples, and whether its stamps are those of the samples.

All ways to read it are fitted. Which one is right is asked of a model that may lack an effect at first, so it is asked
again with each effect that is found: dry friction that is not known of looks like commands in straight lines.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

from gap_diagnosis.investigation import Investigation
from gap_diagnosis.plausibility import checked
from gap_diagnosis.problem import Problem
from gap_diagnosis.rules import LOG_RULES
from gap_diagnosis.scatter import Scatter
from gap_diagnosis.stamps import gain_of_regular, jitter_of_stamps, on_regular_stamps, regular_fit_better
from system_identification.fitting import fit
from system_identification.hypothesis import Hypothesis
from system_identification.noise import whitener

__all__ = ["LogReading", "read_as_suits"]

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
        """Return another way that suits a set of effects better by far; None: there is none."""
        if self.regular is not None and self.suits(found) is not self.on_regular:
            return replace(self, on_regular=not self.on_regular)
        if self.straight is not None:
            other = replace(self, straight=not self.straight)
            if _evidence(other.problem, found) > _evidence(self.problem, found) + LOG_RULES.straight:
                return other
        return None

    def suits(self, found: Hypothesis | None = None) -> bool:
        """Tell whether regular stamps suit a set of effects better, or re-tuned parameters."""
        return regular_fit_better(self._gain(found))

    def jitter(self, found: Hypothesis) -> Scatter | None:
        """Return what it says that regular stamps suit what was found better; None: they do not."""
        gain = self._gain(found if found.suspects else None)
        return jitter_of_stamps(self.as_stamped, gain) if regular_fit_better(gain) else None

    def _gain(self, found: Hypothesis | None) -> float:
        if self.regular is None:
            return 0.0
        return gain_of_regular(self.as_stamped, self.regular, None if found is None else found.fitted)


def read_as_suits(
    log: Problem, investigated: Callable[[Problem, Callable[[Hypothesis], None]], Investigation]
) -> tuple[LogReading, Investigation]:
    """Return the way to read the logs that suits what is found in them, and what is found.

    Args:
        log: with commands held, on the stamps in the log.
        investigated: finds sets of effects for a problem, and gives each one as it is found.
    """

    def ask(found: Hypothesis) -> None:
        better = reading.better_for(found) if found.suspects else None
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
    held = LogReading(log=log, straight=None if known else False)
    if not known:
        lines = replace(held, straight=True)
        evidence = []
        for problem in (held.problem, lines.problem):
            noise = whitener(problem, problem.start())
            evidence.append(fit(problem, noise, problem.start(), iterations=8).evidence)
        held = lines if evidence[1] > evidence[0] + LOG_RULES.straight else held
    return replace(held, on_regular=held.suits())


def _evidence(problem: Problem, found: Hypothesis) -> float:
    """Return the evidence of a set of effects under its noise, fitted from where it is."""
    system = found.system
    posed = problem.with_effects(system.slots, system.gates)
    own = posed.nuisances == system.nuisances
    start = found.fitted.x if own else posed.start(found.fitted.x[system.nuisances :])
    noise = whitener(posed, start, found.noise.levels)
    return fit(posed, noise, start, iterations=10).evidence
