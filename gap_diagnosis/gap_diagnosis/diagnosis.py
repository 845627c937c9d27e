"""The diagnosis of recordings against a parameter set: from arrays to a verdict and all that a report needs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.disturbances import block_evidence
from gap_diagnosis.how_far import Errors, Shrink, Step, budget_of_steps, errors_of, shrink_of, step_of
from gap_diagnosis.investigation import Investigation, investigate
from gap_diagnosis.jitter import jitter_in, scales_beside
from gap_diagnosis.log_readings import read_as_suits
from gap_diagnosis.plausibility import checked, problem_of, unit_problems
from gap_diagnosis.problem import Problem
from gap_diagnosis.recording import Recording
from gap_diagnosis.rules import RULES
from gap_diagnosis.scatter import Scatter, found_in_logs, unlike_stated
from gap_diagnosis.stretches import stretches_of
from gap_diagnosis.suspects import ROUNDED, betrayed_by
from gap_diagnosis.verdict import Verdict, verdict_of
from gap_diagnosis.where import BlockCheck, block_checks, block_shares, excess_by_regime, worst_regime
from system_identification.budget import Budget, budget_of
from system_identification.earning import Earned
from system_identification.fitting import Fitted
from system_identification.hypothesis import Hypothesis
from thruster_model.effects.stages import LIBRARY
from thruster_model.identification.experiment import SIGNALS
from thruster_model.parameter_set import ParameterSet

__all__ = ["Diagnosis", "Unfit", "diagnose"]

Array = NDArray[np.float64]
_OPAQUE = ("zeros", "lattice")
"""Traces of a sensor whose residuals have a structure of their own."""


class Unfit(ValueError):
    """Recordings that contradict the parameter set in a way that no effect explains; one sentence each."""

    def __init__(self, problems: Sequence[str]) -> None:
        """Keep the sentences."""
        self.problems = list(problems)
        super().__init__(self.problems)  # as given: what comes back from another process is made of it

    def __str__(self) -> str:
        """Return the sentences, one a line."""
        return "\n".join(self.problems)


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """Everything that was found.

    Attributes:
        verdict: and its claims.
        parameter_set: of the simulator.
        warnings: what was left out of the recordings and why.
        reasons: why there is not enough data, where that is the verdict.
        investigation: all sets that were weighed; None where there is not enough data.
        problem: recordings and parameters, without effects.
        errors: the four numbers; None where there is not enough data.
        shrink: of the claimed effects together; None where nothing with a trace in the predictions is claimed, or
            something that parameters would do by themselves.
        shrinks: of each claimed effect, in the order of the claims.
        where: blocks and their shares of the gap.
        regime: in which the re-tuned model is worst.
        by_regime: excess over the noise by regime and signal.
        checks: single blocks fed with measurements.
        predictions: as stated, re-tuned (held out), with effects (held out, None where none is claimed), (R,) each.
        scatters: what the logs show.
        budget: where the gap goes; None where there is not enough data.
        waterfall: errors on runs left out, one cause after the other.
        nearest: where nothing is claimed: re-tuned parameters, then sets that bring runs left out nearer and nearer.
        straight: whether commands were found to act as straight lines between their samples; None: that was stated.
    """

    verdict: Verdict
    parameter_set: ParameterSet
    warnings: tuple[str, ...] = ()
    reasons: tuple[str, ...] = ()
    investigation: Investigation | None = None
    problem: Problem | None = None
    errors: Errors | None = None
    shrink: Shrink | None = None
    shrinks: tuple[Shrink, ...] = ()
    where: tuple[tuple[str, float], ...] = ()
    regime: str = ""
    by_regime: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    checks: tuple[BlockCheck, ...] = ()
    predictions: Mapping[str, Array] = field(default_factory=dict)
    scatters: tuple[Scatter, ...] = ()
    budget: Budget | None = None
    waterfall: tuple[Step, ...] = ()
    nearest: tuple[Earned, ...] = ()
    straight: bool | None = None

    @cached_property
    def retuned(self) -> Fitted | None:
        """What comes out: the claimed set, or parameters alone; if the model is wrong, as they predict free runs best.

        Where it is right, what pushed the plant is no business of its parameters.
        """
        if self.investigation is None:
            return None
        if self.verdict.verdict == "unknown":
            return self.investigation.free[0]
        return (self.verdict.chosen or self.investigation.none).fitted

    @property
    def improves(self) -> bool:
        """Whether a set that comes out of it is better on new runs: effects are claimed, or re-tuning helps."""
        found = self.investigation
        return bool(self.verdict.claims) or (found is not None and found.retuning_helps >= RULES.helps)


def diagnose(
    recordings: Sequence[Recording],
    parameter_set: ParameterSet,
    *,
    excluded: tuple[str, ...] = (),
    seed: int = 0,
    longest: float | None = None,
    progress: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Return the diagnosis.

    Args:
        recordings: of one thruster.
        parameter_set: that the simulator uses.
        excluded: effects of the library that are not considered.
        seed: of the bootstrap.
        longest: of all recordings together [s]; longer ones are thinned, see `stretches`; None: as that says.
        progress: is told of each stage.

    Raises:
        Unfit: readings look like another unit or sign.
    """
    progress("log")
    usable, warnings, reasons = checked(stretches_of(recordings, longest))
    if not reasons:
        problem, reasons = problem_of(usable, parameter_set)
    if reasons:
        nothing = Verdict(verdict="not_enough_data", claims=(), chosen=None, probabilities={}, none=0.0, unknown=0.0)
        return Diagnosis(verdict=nothing, parameter_set=parameter_set, warnings=tuple(warnings), reasons=tuple(reasons))
    in_logs, stated = found_in_logs(usable), parameter_set.effects.sizes
    known = {s.effect for s in in_logs if s.effect not in excluded}
    # What a converter cuts off depends on the reading: so do the residuals that are left.
    opaque = tuple({s.signal for s in in_logs if s.effect in known and LIBRARY[s.effect].trace in _OPAQUE})
    known |= {other for effect in known for other in LIBRARY[effect].entails} | ({ROUNDED} & set(stated))
    given = replace(problem, opaque=opaque)

    def investigated(problem: Problem, grew: Callable[[Hypothesis], None] = lambda _: None) -> Investigation:
        wrong = unit_problems(problem)
        if wrong:
            raise Unfit(wrong)
        signals = {each.signal for each in problem.series}
        return investigate(problem, signals, (*excluded, *known), grew=grew, progress=progress)

    reading, found = read_as_suits(given, investigated)
    jitter = reading.jitter(found.best)
    if betrayed_by("stamps") not in excluded and _has_instants(reading.problem):
        found, seen = _beside_jitter(found, investigated)
        jitter = jitter or seen
    in_logs = unlike_stated([*in_logs, *([jitter] if jitter is not None else [])], stated)
    scatters = [s for s in in_logs if s.effect not in excluded]
    foreign = [s for s in in_logs if s.effect in excluded]
    progress("verdict")
    verdict = verdict_of(found, scatters, foreign)
    progress("runs left out")
    return _complete(found, verdict, tuple(warnings), tuple(scatters), foreign, reading.straight, seed)


def _beside_jitter(
    found: Investigation, investigated: Callable[[Problem], Investigation]
) -> tuple[Investigation, Scatter | None]:
    """Return the sets, and the scatter of the stamps that residuals show: None where something else is wrong.

    Where it is so large that it looks like something else, sets are weighed by what it leaves of the readings.
    """
    fitted = found.none.fitted
    jitter = jitter_in(fitted)
    if jitter is None or _is_plain(found):
        return found, jitter
    beside = investigated(replace(fitted.problem, scales=scales_beside(fitted, jitter.size)))
    return (beside, jitter) if _is_plain(beside) else (found, None)


def _is_plain(found: Investigation) -> bool:
    """Tell whether nothing is in sight, named or nameless: what is wrong with a model grows with a slope as well."""
    return not found.best.suspects and not found.nameless


def _has_instants(problem: Problem) -> bool:
    """Tell whether readings are those of an instant: means over cells have no stamps that could scatter."""
    return all(m.width == 0.0 for r in problem.recordings for m in r.experiment.measurements.values())


def _complete(
    found: Investigation,
    verdict: Verdict,
    warnings: tuple[str, ...],
    scatters: tuple[Scatter, ...],
    foreign: Sequence[Scatter],
    straight: bool | None,
    seed: int,
) -> Diagnosis:
    problem: Problem = found.none.system
    noise = found.noise
    as_is = found.as_stated
    predictions = {"as_is": as_is}
    floor = found.left.noise
    waterfall = [step_of("as_is", problem, floor, noise, as_is, None, seed)]
    nearest = tuple(found.earned) if verdict.verdict == "unknown" else ()
    for each in nearest or [Earned(found=h, out=found.held_out(h)) for h in _chain(found)]:
        name = each.found.keys[-1] if each.found.keys else "retuned"
        step = step_of(name, problem, floor, noise, each.out.predicted, waterfall[-1], seed)
        waterfall.append(step if each.helps is None else replace(step, helps=each.helps))
        predictions.setdefault("retuned", each.out.predicted)
        last = each.out.predicted
    whole: Shrink | None = None
    shrinks = [Shrink(value=None, interval=None) for _ in verdict.claims]
    if verdict.chosen is not None:
        predictions["with_effect"] = last
        physical = [c for c in verdict.claims if not c.scatters]
        if all(claim.kind != "parametric" for claim in physical):  # parameters would do that by themselves
            whole = shrink_of(problem, floor, predictions["retuned"], predictions["with_effect"], seed)
            if len(physical) == 1:
                shrinks[verdict.claims.index(physical[0])] = whole
    units = {name: signal.unit for name, signal in SIGNALS.items()}
    errors = errors_of(problem, floor, as_is, predictions["retuned"], predictions.get("with_effect"), units)
    none = found.none.fitted
    by_regime = excess_by_regime(problem, noise, none)
    lost = found.left_by_none
    disturbed = block_evidence(lost.fitted, lost.noise) if verdict.verdict == "unknown" else {}
    marginal = dict(found.inclusion) if verdict.verdict in ("effect", "cannot_tell", "unknown") else {}
    for claim in verdict.claims:
        if claim.scatters:
            marginal[claim.effect] = max(marginal.get(claim.effect, 0.0), claim.probability)
    shares = block_shares(
        marginal, verdict.unknown if disturbed else 0.0, disturbed, [LIBRARY[s.effect].block for s in foreign]
    )
    nameless = found.unexplained.explained if found.nameless else np.zeros(problem.known.size)
    return Diagnosis(
        verdict=verdict,
        parameter_set=problem.parameter_set,
        warnings=warnings,
        investigation=found,
        problem=problem,
        errors=errors,
        shrink=whole,
        shrinks=tuple(shrinks),
        where=tuple(shares),
        regime=worst_regime(by_regime),
        by_regime=by_regime,
        checks=tuple(block_checks(none, noise)),
        predictions=predictions,
        scatters=scatters,
        budget=(
            budget_of_steps(waterfall, seed)
            if nearest
            else budget_of(found.likely_sets, nameless, seed, RULES.tempered)
        ),
        waterfall=tuple(waterfall),
        nearest=nearest,
        straight=straight,
    )


def _chain(found: Investigation) -> list[Hypothesis]:
    """Return re-tuned parameters alone and, one after the other, the sets that lead to the best one."""
    best, chain = found.best, [found.none]
    for count in range(1, len(best.suspects) + 1):
        keys = frozenset(best.keys[:count])
        if keys in found.search.weighed and found.search.weighed[keys].keys == best.keys[:count]:
            chain.append(found.search.weighed[keys])
    if chain[-1] is not best:
        chain.append(best)
    return chain
