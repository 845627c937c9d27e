"""Steady states against a simulator: a table of throttles with what was read at each, and no time.

The table is taken for a staircase of the throttle that is read at the end of each stair. All nuisances are re-tuned
within their stated deviations beside every effect, as for recordings; what only moves or delays does not show.
Deviations of the readings are the user's: a table does not show its own noise.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import chi2

from gap_diagnosis.preparing import DT
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.recording import Recording
from gap_diagnosis.sizes import sizes_of
from gap_diagnosis.suspects import suspects
from gap_diagnosis.unit_check import unit_problems
from system_identification.fitting import fit
from system_identification.noise import white_noise
from system_identification.rating import rated, tried
from thruster_model.effects.stages import LIBRARY
from thruster_model.errors import UnfitDataError
from thruster_model.identification.experiment import SIGNALS, Experiment, Measurement
from thruster_model.parameter_set import ParameterSet

__all__ = ["Explanation", "SteadyDiagnosis", "diagnose_steady_states"]

Array = NDArray[np.float64]
STAIR = 20.0
"""Length of a stair [s]."""
_EQUAL = 5.0  # difference of evidence (logarithm) below which explanations are equals: deviations are guesses
_SURE = 0.99  # of the chi-squared distribution: costs beyond it are no chance
FEWEST = 10
"""Readings below which no effect is claimed: re-tuning and a size bend any curve through a handful."""
_TRIED = 8


@dataclass(frozen=True, kw_only=True)
class Explanation:
    """One effect: sizes with their standard deviations, evidence above that of none (logarithm), remaining cost."""

    effect: str
    sizes: Mapping[str, tuple[float, float]]
    evidence: float
    cost: float


@dataclass(frozen=True, kw_only=True)
class SteadyDiagnosis:
    """What a table of steady states says of a simulator.

    Attributes:
        throttle: of each stair [V], shape (K,).
        measured, stated, retuned: by signal, each (K,), SI units, NaN = not measured.
        costs: sums of squared deviations over their standard deviations, as stated and re-tuned (priors included).
        count: readings.
        explanations: effects, most evidence first.
    """

    throttle: Array
    measured: Mapping[str, Array]
    stated: Mapping[str, Array]
    retuned: Mapping[str, Array]
    costs: tuple[float, float]
    count: int
    explanations: tuple[Explanation, ...]

    @property
    def equals(self) -> tuple[Explanation, ...]:
        """The most likely explanations, which the table cannot tell apart."""
        if not self.explanations:
            return ()
        return tuple(e for e in self.explanations if e.evidence > self.explanations[0].evidence - _EQUAL)

    @property
    def verdict(self) -> str:
        """In the words of a diagnosis of recordings: no_gap, parameters, effect, cannot_tell or unknown."""
        limit = float(chi2.ppf(_SURE, self.count))
        best = self.explanations[0] if self.explanations else None
        if best is None or best.evidence < _EQUAL:
            if self.costs[1] > limit:
                return "unknown"
            return "no_gap" if self.costs[0] <= limit else "parameters"
        if best.cost > limit:
            return "unknown"
        return "effect" if len(self.equals) == 1 and self.count >= FEWEST else "cannot_tell"


def diagnose_steady_states(
    throttle: ArrayLike,
    readings: Mapping[str, ArrayLike],
    deviations: Mapping[str, float],
    parameter_set: ParameterSet,
    progress: Callable[[str], None] = lambda _: None,
) -> SteadyDiagnosis:
    """Return what steady states say of a simulator.

    Args:
        throttle: of each state [V], shape (K,).
        readings: speed [rad/s], axial, ambient [m/s], thrust [N], torque [N m], each (K,); NaN = not measured.
        deviations: standard deviation of the readings by signal, in the same units.
        parameter_set: that the simulator uses.
        progress: is told of each stage.

    Raises:
        UnfitDataError: with a sentence for each thing that is wrong with the table.
    """
    u = np.asarray(throttle, dtype=np.float64)
    measured = {name: np.asarray(values, dtype=np.float64) for name, values in readings.items()}
    _check(u, measured, deviations)
    problem = Problem(
        recordings=(_staircase(u, measured, deviations),),
        parameter_set=parameter_set,
        deviations=deviations_of(parameter_set),
        fixed=parameter_set.effects.sizes,
    )
    if not problem.series:
        raise UnfitDataError([f"model {parameter_set.model_name} predicts none of {', '.join(measured)}"])
    wrong = unit_problems(problem, least=5)
    if wrong:
        raise UnfitDataError(wrong)
    noise = white_noise(problem, dict(deviations))
    progress("re-tuning")
    base = fit(problem, noise, problem.start(), iterations=25)
    listed = [s for s in suspects(set(measured)) if LIBRARY[s.effect].block != "log" and LIBRARY[s.effect].steady]
    progress(f"{len(listed)} suspects")
    explanations = []
    for each in rated(base, noise, tried(base, listed, lambda s: problem.tried(base.x, s)))[:_TRIED]:
        start = np.concatenate((base.x, each.sizes))
        fitted = fit(problem.with_effects(each.suspect.slots), noise, start, iterations=25)
        sizes = {name: (size.value, size.std) for name, size in sizes_of(fitted, noise, each.suspect).items()}
        explanations.append(
            Explanation(
                effect=each.suspect.effect, sizes=sizes, evidence=fitted.evidence - base.evidence, cost=fitted.cost
            )
        )
    stated = problem.start()
    white = noise.whiten(problem.residuals(stated))
    return SteadyDiagnosis(
        throttle=u,
        measured=measured,
        stated=_by_signal(problem, problem.predicted(stated)),
        retuned=_by_signal(problem, problem.predicted(base.x)),
        costs=(float(white @ white), base.cost),
        count=int(np.sum(problem.known)),
        explanations=tuple(sorted(explanations, key=lambda e: -e.evidence)),
    )


def _check(u: Array, measured: Mapping[str, Array], deviations: Mapping[str, float]) -> None:
    problems = []
    if u.ndim != 1 or u.size < 3 or not np.all(np.isfinite(u)):
        problems.append(f"throttle: expected at least three finite values [V]; found {u.tolist()}")
    problems += [
        f"{name}: expected one of {', '.join(SIGNALS)}; found another name" for name in measured if name not in SIGNALS
    ]
    problems += [
        f"{name}: expected {u.size} readings, one for each throttle; found {values.shape}"
        for name, values in measured.items()
        if values.shape != u.shape
    ]
    problems += [
        f"deviation of {name}: expected a number above zero; found {deviations.get(name, 'none given')}"
        for name in measured
        if not float(deviations.get(name) or 0.0) > 0.0
    ]
    problems += [
        f"deviation of {name}: expected one of {', '.join(SIGNALS)}; found another name"
        for name in deviations
        if name not in SIGNALS
    ]
    if not measured:
        problems.append("expected readings of at least one signal; found none")
    if problems:
        raise UnfitDataError(problems)


def _staircase(u: Array, measured: Mapping[str, Array], deviations: Mapping[str, float]) -> Recording:
    ends: Array = STAIR * np.arange(1.0, u.size + 1.0) - DT
    measurements = {
        name: Measurement(signal=name, time=ends, values=values, width=0.0, noise=deviations[name])
        for name, values in measured.items()
    }
    commands = np.repeat(u, round(STAIR / DT))
    return Recording(experiment=Experiment(name="steady states", dt=DT, throttle=commands, measurements=measurements))


def _by_signal(problem: Problem, rows: Array) -> dict[str, Array]:
    return {each.signal: rows[each.rows] for each in problem.series}
