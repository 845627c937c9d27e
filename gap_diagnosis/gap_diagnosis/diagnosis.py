"""The diagnosis of recordings against a parameter set: from arrays to a verdict and all that a report needs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.disturbances import block_evidence
from gap_diagnosis.how_far import Errors, Shrink, errors_of, held_out, shrink_of
from gap_diagnosis.investigation import Investigation, investigate
from gap_diagnosis.jitter import is_at_random, jitter_in, scales_beside
from gap_diagnosis.plausibility import checked, excitation_problems, unit_problems
from gap_diagnosis.posterior import Posterior, posterior_of
from gap_diagnosis.problem import Problem, deviations_of
from gap_diagnosis.recording import Recording
from gap_diagnosis.scatter import Scatter, found_in_logs, masks_of
from gap_diagnosis.stamps import gain_of_regular, jitter_of_stamps, on_regular_stamps, regular_fit_better
from gap_diagnosis.suspects import suspects
from gap_diagnosis.verdict import Verdict, verdict_of
from gap_diagnosis.where import BlockCheck, block_checks, block_shares, excess_by_regime, worst_regime
from thruster_model.effects.stages import LIBRARY
from thruster_model.identification.experiment import SIGNALS
from thruster_model.parameter_set import ParameterSet

__all__ = ["Diagnosis", "Unfit", "diagnose"]

Array = NDArray[np.float64]


_PLAIN = 3.0
"""Evidence for an effect up to which none is in sight."""
_MINOR = 0.01  # evidence for an effect over that for scattered stamps beside it, up to which none is in sight


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
        investigation, posterior: all hypotheses; None where there is not enough data.
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
    """

    verdict: Verdict
    parameter_set: ParameterSet
    warnings: tuple[str, ...] = ()
    reasons: tuple[str, ...] = ()
    investigation: Investigation | None = None
    posterior: Posterior | None = None
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


def diagnose(
    recordings: Sequence[Recording],
    parameter_set: ParameterSet,
    *,
    excluded: tuple[str, ...] = (),
    seed: int = 0,
    progress: Callable[[str], None] = lambda _: None,
) -> Diagnosis:
    """Return the diagnosis.

    Args:
        recordings: of one thruster.
        parameter_set: that the simulator uses.
        excluded: effects of the library that are not considered.
        seed: of the bootstrap.
        progress: is told of each stage.

    Raises:
        Unfit: readings look like another unit or sign.
    """
    progress("log")
    usable, warnings, reasons = checked(recordings)
    if not reasons:
        problem = Problem(
            recordings=tuple(usable),
            parameter_set=parameter_set,
            deviations=deviations_of(parameter_set),
            fixed=parameter_set.effects.sizes,
            masks=masks_of(usable),
        )
        if not problem.series:
            reasons = [f"model {parameter_set.model_name} predicts none of the channels in the recordings"]
        else:
            reasons = excitation_problems(problem)
    if reasons:
        nothing = Verdict(verdict="not_enough_data", claims=(), chosen=None, probabilities={}, none=0.0, unknown=0.0)
        return Diagnosis(verdict=nothing, parameter_set=parameter_set, warnings=tuple(warnings), reasons=tuple(reasons))
    in_logs = found_in_logs(usable)
    known = {s.effect for s in in_logs if s.effect not in excluded}
    # What a converter cuts off depends on the reading: so do the residuals that are left.
    opaque = tuple({s.signal for s in in_logs if s.effect in known and s.effect.startswith("tach_")})
    if "tach_quantization" in known:
        known.add("tach_dropout")  # a coarse converter reads zero at low speed too
    given = replace(problem, opaque=opaque)
    regular = on_regular_stamps(given, checked([r.regular or r for r in recordings]).recordings)
    gain = 0.0 if regular is None else gain_of_regular(given, regular)

    def investigated(problem: Problem) -> Investigation:
        wrong = unit_problems(problem)
        if wrong:
            raise Unfit(wrong)
        listed = suspects({each.signal for each in problem.series}, (*excluded, *known))
        return investigate(problem, listed, with_ventilation="ventilation" not in excluded, progress=progress)

    problem = regular if regular is not None and regular_fit_better(gain) else given
    found = investigated(problem)
    if regular is not None and found.leading is not None:
        gain = gain_of_regular(given, regular, found.leading.fitted)
        better = regular if regular_fit_better(gain) else given
        if better is not problem:
            problem, found = better, investigated(better)
    jitter = jitter_of_stamps(given, gain) if regular_fit_better(gain) else None
    if "timestamp_jitter" not in excluded and _has_instants(problem):
        found, seen = _beside_jitter(found, investigated)
        jitter = jitter or seen
    in_logs += [jitter] if jitter is not None else []
    scatters = [s for s in in_logs if s.effect not in excluded]
    foreign = [s for s in in_logs if s.effect in excluded]
    progress("verdict")
    posterior = posterior_of(found, scatters=bool(scatters))
    verdict = verdict_of(found, posterior, scatters, foreign)
    progress("held-out data")
    return _complete(found, posterior, verdict, problem, tuple(warnings), tuple(scatters), foreign, seed)


def _beside_jitter(
    found: Investigation, investigated: Callable[[Problem], Investigation]
) -> tuple[Investigation, Scatter | None]:
    """Return the hypotheses, and the scatter of the stamps that residuals show: None where something else is wrong.

    Where it is so large that it looks like something else, hypotheses are weighed by what it leaves of the readings.
    """
    fitted = found.none.fitted
    jitter = jitter_in(fitted)
    if jitter is None or _is_plain(found):
        return found, jitter
    if is_at_random(fitted, jitter.size):
        beside = investigated(replace(fitted.problem, scales=scales_beside(fitted, jitter.size)))
        if _is_plain(beside, _MINOR * jitter.log_odds):
            return beside, jitter
    return found, None


def _is_plain(found: Investigation, least: float = 0.0) -> bool:
    """Tell whether no effect and nothing unknown is in sight: what is wrong with a model grows with a slope as well."""
    unexplained = found.none.unexplained
    return (
        all(candidate.evidence <= max(_PLAIN, least) for candidate in found.candidates)
        and unexplained is not None
        and unexplained.evidence <= 1.0
    )


def _has_instants(problem: Problem) -> bool:
    """Tell whether readings are those of an instant: means over cells have no stamps that could scatter."""
    return all(m.width == 0.0 for r in problem.recordings for m in r.experiment.measurements.values())


def _complete(
    found: Investigation,
    posterior: Posterior,
    verdict: Verdict,
    problem: Problem,
    warnings: tuple[str, ...],
    scatters: tuple[Scatter, ...],
    foreign: Sequence[Scatter],
    seed: int,
) -> Diagnosis:
    none = found.none.fitted
    stated = none.x.copy()
    stated[: len(problem.names)] = 0.0
    predictions = {"as_is": problem.predicted(stated), "retuned": held_out(none, found.noise)}
    shrinks: list[Shrink] = []
    whole: Shrink | None = None
    if verdict.chosen is not None and verdict.verdict == "effect":
        predictions["with_effect"] = held_out(verdict.chosen.fitted, found.noise)
        physical = [c for c in verdict.claims if not c.scatters]
        if all(claim.kind != "parametric" for claim in physical):  # parameters would do that by themselves
            whole = shrink_of(problem, found.noise, predictions["retuned"], predictions["with_effect"], seed)
        for claim in verdict.claims:
            if claim.scatters or claim.kind == "parametric":
                shrinks.append(Shrink(value=None, interval=None))
            elif len(physical) == 1 and whole is not None:
                shrinks.append(whole)
            else:
                shrinks.append(_of_one(found, claim.key, problem, predictions, seed))
    else:
        shrinks = [Shrink(value=None, interval=None) for _ in verdict.claims]
    units = {name: signal.unit for name, signal in SIGNALS.items()}
    errors = errors_of(
        problem, found.noise, predictions["as_is"], predictions["retuned"], predictions.get("with_effect"), units
    )
    by_regime = excess_by_regime(problem, found.noise, none)
    disturbed = block_evidence(none, found.noise) if verdict.verdict == "unknown" else {}
    if disturbed and found.stretches is not None and not found.stretches.nameless:
        disturbed["thrust"] = max(disturbed["thrust"], found.stretches.evidence)
    marginal = dict(posterior.marginal) if verdict.verdict in ("effect", "cannot_tell", "unknown") else {}
    for claim in verdict.claims:
        if claim.scatters:
            marginal[claim.effect] = max(marginal.get(claim.effect, 0.0), claim.probability)
    shares = block_shares(
        marginal, posterior.unknown if disturbed else 0.0, disturbed, [LIBRARY[s.effect].block for s in foreign]
    )
    return Diagnosis(
        verdict=verdict,
        parameter_set=problem.parameter_set,
        warnings=warnings,
        investigation=found,
        posterior=posterior,
        problem=problem,
        errors=errors,
        shrink=whole,
        shrinks=tuple(shrinks),
        where=tuple(shares),
        regime=worst_regime(by_regime),
        by_regime=by_regime,
        checks=tuple(block_checks(none, found.noise)),
        predictions=predictions,
        scatters=scatters,
    )


def _of_one(found: Investigation, key: str, problem: Problem, predictions: Mapping[str, Array], seed: int) -> Shrink:
    """Return how far one of two effects alone shrinks the gap."""
    alone = next((c for c in found.candidates if c.keys == (key,)), None)
    if alone is None:
        return Shrink(value=None, interval=None)
    return shrink_of(problem, found.noise, predictions["retuned"], held_out(alone.fitted, found.noise), seed)
