"""Which effects, and how sure: one after the other, until the next one is not worth its odds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.beginning import begun
from gap_diagnosis.vehicle.candidates import may_stand_for_more, refined_ones
from gap_diagnosis.vehicle.hypotheses import Hypothesis, hypotheses
from gap_diagnosis.vehicle.learning import learned_from, unlearned
from gap_diagnosis.vehicle.log import VehicleLog, told_in
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.refining import Problem
from gap_diagnosis.vehicle.rivals import Rivals, exchanged, spare_of
from gap_diagnosis.vehicle.screening import Screen, nameless_names
from gap_diagnosis.vehicle.settling import log_evidence, settled, settled_with
from gap_diagnosis.vehicle.stage import Stage, stage_at
from gap_diagnosis.vehicle.unknowns import Key

__all__ = ["Found", "search"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """What was found.

    Attributes:
        stages: all, the last one to be believed; calm: the last one in calm water, None where it is calm.
        retuned: numbers without any effect.
        odds: log posterior odds with which each effect was accepted.
        rivals: of each accepted effect, with log odds against it.
        left: what was fitted in the last stage and not accepted, with log odds against nothing more, best first.
        nuisances: deviations by key; tried: all hypotheses.
    """

    stages: tuple[Stage, ...]
    calm: Stage | None
    retuned: Mapping[Key, float]
    odds: tuple[float, ...]
    rivals: tuple[Rivals, ...]
    left: Rivals
    nuisances: dict[Key, float]
    tried: tuple[Hypothesis, ...]


def search(
    model: Model, logs: Sequence[VehicleLog], told: Callable[[str], None] = lambda text: None,
    only: Callable[[Hypothesis], bool] = lambda h: True,
) -> Found:  # fmt: skip
    """Return what explains these recordings beyond the model's parameters.

    Args:
        model: the vehicle as it is believed to be.
        logs: its recordings.
        told: is told of the progress.
        only: which hypotheses are tried.
    """
    there = told_in(logs)
    tried = [h for h in hypotheses(model, there) if only(h)]
    free = nuisances(model, logs)
    told(f"{len(free)} uncertain numbers, {len(tried)} hypotheses")
    retuned, (runs, first), rivals, odds = begun(model, logs, free, tried, told)
    fit = first
    if fit.effects:
        told(f"begins with {', '.join(a.hypothesis.words for a in fit.effects)}")
        (runs, fit), rivals = exchanged(model, logs, runs, fit, free, tried, rivals, told)
    stages: list[Stage] = []
    left: Rivals = ()
    for depth in range(rules.MOST_EFFECTS + 1):
        stage = stage_at(model, runs, fit, free, tried, nameless_names(model, there))
        if fit.effects and fit is not first and stage.leaves_more:
            # numbers and noises that had to do without the last effect may have led its fit to where it does not belong
            again = settled(model, logs, free, fit.effects)
            if log_evidence(*again) > stage.log_evidence + rules.SETTLED:
                told(f"fitted from the believed numbers: {again[1].effects[-1].sizes}")
                runs, fit = again
                stage = stage_at(model, runs, fit, free, tried, nameless_names(model, there))
        stages.append(stage)
        best = stage.offered[0] if stage.offered else (-np.inf, None)
        told(f"{depth} effects: best {best[0]:.1f} {best[1].words if best[1] else ''}")
        worth = depth < rules.MOST_EFFECTS and (best[0] >= 0.0 or may_stand_for_more(stage, free))
        candidates = refined_ones(stage, free, tried) if worth else []
        left = tuple((odds, each.effects[-1]) for odds, each in candidates)
        if not left:
            break
        told(f"{depth} effects: fitted {left[0][0]:.1f} {left[0][1].hypothesis.words} {left[0][1].sizes}")
        if candidates[0][0] < np.log(rules.CLAIM):
            break
        odds.append(left[0][0])
        rivals.append(tuple((o - odds[-1], each) for o, each in left[1:]))
        accepted, values = candidates[0][1].effects, candidates[0][1].values
        runs, fit = settled_with(accepted, model, logs, free, runs, values)
        spare = spare_of(model, runs, fit, free, tried)
        if spare is not None:
            told(f"not needed beside it: {accepted[spare].hypothesis.words}")
            rest = [a for j, a in enumerate(fit.effects) if j != spare]
            # where the search began with it, it is the first stage that is no longer what it was
            del stages[max(spare - (len(odds) - len(stages)), 0)], odds[spare], rivals[spare]
            runs, fit = settled_with(rest, model, logs, free, runs, fit.values)
        (runs, fit), rivals = exchanged(model, logs, runs, fit, free, tried, rivals, told)
    calm = _calmed(model, logs, stages[-1], free)
    return Found(
        stages=tuple(stages),
        calm=calm,
        retuned=retuned[1].values,
        odds=tuple(odds),
        rivals=tuple(rivals),
        left=left,
        nuisances=free,
        tried=tuple(tried),
    )


def _calmed(model: Model, logs: Sequence[VehicleLog], last: Stage, free: dict[Key, float]) -> Stage | None:
    """Return the last stage as it is if the water is calm: a wrench that was learned hides what would explain it."""
    noises = learned_from(last.screen.runs)
    calm = np.minimum(noises.wrench, model.wrench_of_water(rules.CALM_WRENCH))
    if np.array_equal(calm, noises.wrench):
        return None
    on, sizes = last.screen.effects, [a.sizes for a in last.fit.effects]
    runs = unlearned(model, logs, last.fit.values, on, noises._replace(wrench=calm), last.screen.runs)
    effects = tuple(a.hypothesis for a in last.fit.effects)
    problem = Problem(screen=Screen(model=model, runs=runs, values={}), nuisances=free, effects=effects)
    return stage_at(
        model, runs, problem.fit(last.fit.moved, sizes, exact=True), free, (), nameless_names(model, told_in(logs))
    )
