"""Which effects, and how sure: one after the other, until the next one is not worth its odds."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.descent import product_of
from gap_diagnosis.vehicle.filtering import Prepared, log_likelihood, whitened
from gap_diagnosis.vehicle.gram import solution
from gap_diagnosis.vehicle.hypotheses import WIRING, Hypothesis, hypotheses
from gap_diagnosis.vehicle.learning import learned_from, prepared
from gap_diagnosis.vehicle.log import VehicleLog, told_in
from gap_diagnosis.vehicle.model import Key, Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.refining import Fit, Problem, Refined
from gap_diagnosis.vehicle.screening import Screen, nameless_names
from gap_diagnosis.vehicle.settling import likelihood, log_evidence, settled
from gap_diagnosis.vehicle.side_by_side import side_by_side
from gap_diagnosis.vehicle.stage import Stage, log_prior, stage_at
from rov_sim.vehicle.innovations import CHANNELS

__all__ = ["Found", "search"]

Array = NDArray[np.float64]
_Rivals = tuple[tuple[float, Refined], ...]
_BETTER = float(np.log(rules.SUSPECTED))
"""Log odds from which on a rival takes the place of an accepted effect."""
_Start = tuple[Array, list[tuple[float, ...]]]


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
    rivals: tuple[_Rivals, ...]
    left: _Rivals
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
    retuned = settled(model, logs, free, prepared(model, logs, {}, start=None, rounds=0), (), {})
    (runs, fit), rivals, odds = _begun(model, logs, free, tried, retuned)
    if fit.effects:
        told(f"begins with {', '.join(a.hypothesis.words for a in fit.effects)}")
        (runs, fit), rivals = _exchanged(model, logs, runs, fit, free, tried, rivals, told)
    stages: list[Stage] = []
    left: _Rivals = ()
    for depth in range(rules.MOST_EFFECTS + 1):
        stage = stage_at(model, runs, fit, free, tried, nameless_names(model, there))
        stages.append(stage)
        best = stage.offered[0] if stage.offered else (-np.inf, None)
        told(f"{depth} effects: best {best[0]:.1f} {best[1].words if best[1] else ''}")
        left = ()
        if best[0] < 0.0 or depth == rules.MOST_EFFECTS:
            break
        candidates = _refined(stage, free, tried)
        left = tuple((odds, each.effects[-1]) for odds, each in candidates)
        told(f"{depth} effects: fitted {left[0][0]:.1f} {left[0][1].hypothesis.words} {left[0][1].sizes}")
        if candidates[0][0] < np.log(rules.CLAIM):
            break
        odds.append(left[0][0])
        rivals.append(tuple((o - odds[-1], each) for o, each in left[1:]))
        accepted, values = candidates[0][1].effects, candidates[0][1].values
        runs, fit = _settled_with(accepted, model, logs, free, runs, values)
        spare = _spare(model, runs, fit, free, tried)
        if spare is not None:
            told(f"not needed beside it: {accepted[spare].hypothesis.words}")
            rest = [a for j, a in enumerate(fit.effects) if j != spare]
            # where the search began with it, it is the first stage that is no longer what it was
            del stages[max(spare - (len(odds) - len(stages)), 0)], odds[spare], rivals[spare]
            runs, fit = _settled_with(rest, model, logs, free, runs, fit.values)
        (runs, fit), rivals = _exchanged(model, logs, runs, fit, free, tried, rivals, told)
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


def _settled_with(
    effects: Sequence[Refined], model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], runs: list[Prepared],
    values: Mapping[Key, float],
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return recordings and fit as `settled` does with these effects on, noises learned from those of the runs."""
    on = [a.active for a in effects]
    again = prepared(model, logs, values, on, start=learned_from(runs), rounds=rules.LEARNED)
    return settled(model, logs, free, again, effects, values)


def _spare(
    model: Model, runs: list[Prepared], fit: Fit, free: dict[Key, float], tried: Sequence[Hypothesis]
) -> int | None:  # fmt: skip
    """Return the place of an accepted effect that is no longer worth its odds beside the last one; None: all are.

    The last one may explain all that an earlier one stood for, as a weight at a place does the shift of the centre.
    """
    on, numbers = fit.effects, len(free)
    screen = Screen(model=model, runs=runs, values={})
    odds = {}
    for k, a in enumerate(on[:-1]):
        if a.hypothesis.switch:
            continue
        rest, columns = _all_but(fit, k, numbers)
        less = Problem(screen=screen, nuisances=free, effects=tuple(each.hypothesis for each in rest))
        again = less.fit(fit.moved, [each.sizes for each in rest], columns, product_of(columns))
        odds[k] = fit.log_evidence - again.log_evidence + log_prior(a.hypothesis, tried)
    least = min(odds, key=lambda k: odds[k], default=None)
    return least if least is not None and odds[least] < np.log(rules.CLAIM) else None


def _exchanged(
    model: Model, logs: Sequence[VehicleLog], runs: list[Prepared], fit: Fit, free: dict[Key, float],
    tried: Sequence[Hypothesis], rivals: Sequence[_Rivals], told: Callable[[str], None],
) -> tuple[tuple[list[Prepared], Fit], list[_Rivals]]:  # fmt: skip
    """Return recordings and fit with the rival in place of an accepted effect that is likelier beside all that is on
    now, and rivals of each, weighed again; as they are where none is."""
    rivals = _weighed_again(model, runs, fit, free, tried, rivals)
    k = max(range(len(rivals)), key=lambda k: rivals[k][0][0] if rivals[k] else -np.inf)
    if not rivals[k] or rivals[k][0][0] < _BETTER:
        return (runs, fit), rivals
    (gain, better), *others = rivals[k]
    told(f"in place of {fit.effects[k].hypothesis.words}, by {gain:.1f}: {better.hypothesis.words}")
    rivals[k] = tuple((odds - gain, each) for odds, each in ((0.0, fit.effects[k]), *others))
    effects = [better if j == k else a for j, a in enumerate(fit.effects)]
    return _settled_with(effects, model, logs, free, runs, fit.values), rivals


def _weighed_again(
    model: Model, runs: list[Prepared], fit: Fit, free: dict[Key, float], tried: Sequence[Hypothesis],
    rivals: Sequence[_Rivals],
) -> list[_Rivals]:  # fmt: skip
    """Return the rivals of each accepted effect with their log odds against it beside all that is on now, best first.

    When one is accepted the next ones are still missing, and numbers and noises make up for them: a shift of the centre
    of mass was a payload, by 400, while the IMU's delay was not settled.
    """
    on, screen = fit.effects, Screen(model=model, runs=runs, values={})
    found = []
    for k, own in enumerate(on):
        rest, columns = _all_but(fit, k, len(free))
        product, again = product_of(columns), []
        for _, rival in rivals[k][: rules.REFINED_BACK]:
            if rival.hypothesis.place in {a.hypothesis.place for a in rest}:
                continue
            effects = (*(a.hypothesis for a in rest), rival.hypothesis)
            problem = Problem(screen=screen, nuisances=free, effects=effects)
            there = problem.fit(fit.moved, [*(a.sizes for a in rest), rival.sizes], columns, product)
            if there.log_evidence > fit.log_evidence - rules.FAR_BEHIND:
                there = problem.fit(there.moved, [a.sizes for a in there.effects])
            prior = log_prior(rival.hypothesis, tried) - log_prior(own.hypothesis, tried)
            again.append((there.log_evidence - fit.log_evidence + prior, there.effects[-1]))
        found.append(tuple(sorted(again, key=lambda each: -each[0])))
    return found


def _all_but(fit: Fit, k: int, numbers: int) -> tuple[list[Refined], tuple[NDArray[np.float32], ...]]:
    """Return the effects of a fit but the k-th, and the columns of so many uncertain numbers and of these effects."""
    ends = np.cumsum([numbers, *(len(a.sizes) for a in fit.effects)])
    kept = np.delete(np.arange(ends[-1]), np.arange(ends[k], ends[k + 1]))
    return [a for j, a in enumerate(fit.effects) if j != k], tuple(c[:, kept] for c in fit.columns)


def _begun(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], tried: Sequence[Hypothesis],
    retuned: tuple[list[Prepared], Fit],
) -> tuple[tuple[list[Prepared], Fit], list[_Rivals], list[float]]:  # fmt: skip
    """Return recordings and fit with the wrong wires, or the delay, without which they are far less likely, rivals of
    each, and log odds for each; without any: `retuned`.

    Numbers that are fitted with a thruster the wrong way round, or to an IMU that is late, are no place to look for it
    from. So the believed ones are asked.
    """
    far = {
        k[2] for k, moved in zip(free, retuned[1].moved, strict=True) if k[0] == "own" and abs(moved) > rules.SHIFTED
    }
    switches = [h for h in tried if h.switch and far & {h.thruster, h.other}]
    delays = [h for h in tried if h.thruster is None and h.further and not h.carrier]
    nothing = _foreseen(model, logs, ()) if switches or delays else 0.0
    wires = _wired_wrongly(model, logs, switches, nothing)
    if wires:
        found = _settled_from_believed(model, logs, free, wires)
        if likelihood(*found) > likelihood(*retuned) + np.log(rules.CLAIM):
            return found, [() for _ in wires], [np.inf for _ in wires]
    if late_ones := _delayed(model, logs, delays, nothing):
        late, *others = late_ones
        found = _settled_from_believed(model, logs, free, [late])
        odds = log_evidence(*found) - log_evidence(*retuned) + log_prior(late.hypothesis, tried)
        if odds > np.log(rules.CLAIM):
            return found, [tuple((0.0, each) for each in others)], [odds]
    return retuned, [], []


def _settled_from_believed(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], on: Sequence[Refined]
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return recordings and fit as `settled` does with effects on, from the believed numbers."""
    first = prepared(model, logs, {}, [a.active for a in on], start=None, rounds=0)
    return settled(model, logs, free, first, on, {}, anew=True)


def _wired_wrongly(
    model: Model, logs: Sequence[VehicleLog], switches: list[Hypothesis], nothing: float
) -> list[Refined]:  # fmt: skip
    """Return the wrong wires with which believed numbers foresee recordings far better; nothing: without any.

    A thruster that they would rather have stopped is not wired wrongly; whether it has stopped is told from among all
    effects, most of which would do as well here.
    """
    on: list[Refined] = []
    best = nothing
    while switches and len(on) < rules.MOST_EFFECTS:
        scores = side_by_side(lambda h: _foreseen(model, logs, [*on, _of_size(h)]), switches)
        likeliest = switches[scores.index(max(scores))]
        if max(scores) < best + np.log(rules.CLAIM):
            break
        switches.remove(likeliest)
        if likeliest.effect in WIRING:
            best = max(scores)
            on.append(_of_size(likeliest))
        else:
            switches = [h for h in switches if likeliest.thruster not in (h.thruster, h.other)]
    return on


def _delayed(
    model: Model, logs: Sequence[VehicleLog], delays: Sequence[Hypothesis], nothing: float
) -> list[Refined]:  # fmt: skip
    """Return the delays of all alike with which believed numbers foresee recordings far better, each at its best size,
    the likeliest first."""
    tried = [_of_size(h, size) for h in delays for size in h.further]
    scores = side_by_side(lambda each: _foreseen(model, logs, [each]), tried)
    if max(scores, default=-np.inf) < nothing + np.log(rules.CLAIM):
        return []
    order = sorted(range(len(tried)), key=lambda j: -scores[j])
    found = []
    for h in list(dict.fromkeys(tried[j].hypothesis for j in order))[: rules.REFINED_LATE]:

        def of(size: float, h: Hypothesis = h) -> float:
            return -_foreseen(model, logs, [_of_size(h, (float(size),))])

        longest = h.further[-1][0]
        best = minimize_scalar(of, bounds=(0.0, longest), method="bounded", options={"xatol": rules.TIMING})
        found.append((float(best.fun), _of_size(h, (float(best.x),))))
    return [each for _, each in sorted(found, key=lambda each: each[0])]


def _of_size(h: Hypothesis, sizes: tuple[float, ...] = ()) -> Refined:
    return Refined(hypothesis=h, sizes=sizes, deviations=())


def _foreseen(model: Model, logs: Sequence[VehicleLog], on: Sequence[Refined]) -> float:
    """Return the log likelihood of recordings under the believed numbers, with effects on."""
    found = prepared(model, logs, {}, [a.active for a in on], start=None, rounds=0)
    rotors = slice(CHANNELS, CHANNELS + model.thrusters)
    return sum(log_likelihood(p) - 0.5 * float(np.sum(whitened(p, p.base)[:, rotors] ** 2)) for p in found)


def _calmed(model: Model, logs: Sequence[VehicleLog], last: Stage, free: dict[Key, float]) -> Stage | None:
    """Return the last stage as it is if the water is calm: a wrench that was learned hides what would explain it."""
    noises = learned_from(last.screen.runs)
    calm = np.minimum(noises.wrench, np.repeat(rules.CALM_WRENCH, 3))
    if np.array_equal(calm, noises.wrench):
        return None
    on, sizes = last.screen.effects, [a.sizes for a in last.fit.effects]
    runs = prepared(model, logs, last.fit.values, on, start=noises._replace(wrench=calm), rounds=0)
    effects = tuple(a.hypothesis for a in last.fit.effects)
    problem = Problem(screen=Screen(model=model, runs=runs, values={}), nuisances=free, effects=effects)
    return stage_at(
        model, runs, problem.fit(last.fit.moved, sizes, exact=True), free, (), nameless_names(model, told_in(logs))
    )


def _refined(stage: Stage, free: dict[Key, float], tried: Sequence[Hypothesis]) -> list[tuple[float, Fit]]:
    """Return the best hypotheses, fitted with all that is on, with log odds against nothing more, best first."""
    quick = [_quickly(stage, h, free) for _, h in stage.offered[: rules.REFINED]]
    quick += _from_believed(stage, free, tried)
    quick.sort(key=lambda each: -each[0].log_evidence)
    fits: list[Fit] = []
    for fit, problem in quick:
        if any(fit.effects[-1].hypothesis == each.effects[-1].hypothesis for each in fits):
            continue
        if len(fits) < rules.FITTED_ANEW and fit.log_evidence > quick[0][0].log_evidence - rules.FAR_BEHIND:
            fit = problem.fit(fit.moved, [e.sizes for e in fit.effects])
        fits.append(fit)
    nothing = _without_them(stage, free, fits)
    found = []
    for fit in fits:
        gain, prior = fit.log_evidence - nothing, log_prior(fit.effects[-1].hypothesis, tried)
        found.append((max(gain, 0.0) / fit.scatter + min(gain, 0.0) + prior, fit))
    return sorted(found, key=lambda each: -each[0])


def _quickly(stage: Stage, h: Hypothesis, free: dict[Key, float]) -> tuple[Fit, Problem]:
    """Return the best fit of a hypothesis along the columns of a stage, with all that is on, and its problem."""
    names, on = stage.gram.names, stage.fit.effects
    known = range(stage.fit.columns[0].shape[1])
    product = stage.gram.A[: len(known), : len(known)]
    problem = Problem(screen=stage.screen, nuisances=free, effects=(*(a.hypothesis for a in on), h))
    at = [j for j, name in enumerate(names) if isinstance(name, tuple) and name[0] == h]
    x, _ = solution(stage.gram, known, on=at) if h.switch else solution(stage.gram, [*known, *at])
    starts = [_start(stage, h, problem, share * x) for share in (1.0, 0.5, 0.0)]
    starts = [max(starts, key=lambda there: problem.score(*there))]
    starts += _handed_over(stage, h, problem, free, x)
    if h.carrier:  # no start tells by itself where it leads
        starts += [_start(stage, h, problem, _beside(stage, known, at, size[0] / h.scale[0])) for size in h.further]
    found_from = [problem.fit(*start, stage.fit.columns, product) for start in starts]
    return max(found_from, key=lambda fit: fit.log_evidence), problem


def _from_believed(stage: Stage, free: dict[Key, float], tried: Sequence[Hypothesis]) -> list[tuple[Fit, Problem]]:
    """Return quick fits of the effects of the thruster whose own numbers are furthest off, from these as believed.

    Such numbers may have taken over all that an effect does, and what both do is bent: where the numbers have it all no
    column of the effect leads to it. Which effects are worth a fit is told by that at their best size there.
    """
    own = [np.array([key[0] == "own" and key[2] == i for key in free]) for i in range(stage.screen.model.thrusters)]
    far = [float(np.max(np.abs(stage.moved[mine]), initial=0.0)) for mine in own]
    i = int(np.argmax(far))
    if far[i] < rules.SHIFTED:
        return []
    on, sizes = tuple(a.hypothesis for a in stage.fit.effects), [a.sizes for a in stage.fit.effects]
    moved = np.where(own[i], 0.0, stage.moved)
    starts = []
    for h in tried:
        if i in (h.thruster, h.other) and h.place not in {each.place for each in on}:
            problem = Problem(screen=stage.screen, nuisances=free, effects=(*on, h))
            start = _sized(problem, h, moved, sizes)
            starts.append((problem.score(*start), start, problem))
    starts.sort(key=lambda each: -each[0])
    columns = Problem(screen=stage.screen, nuisances=free, effects=on).columns(moved, sizes)
    product = product_of(columns)
    return [(problem.fit(*start, columns, product), problem) for _, start, problem in starts[: rules.REFINED_BACK]]


def _sized(problem: Problem, h: Hypothesis, moved: Array, sizes: Sequence[tuple[float, ...]]) -> _Start:
    """Return the point with a further effect at its most likely size, up to twice the expected one, all else as is."""
    if h.switch or h.grid:
        return moved, [*sizes, problem.grid_start(moved, sizes)]
    ways = (1.0, -1.0) if h.lower[0] < 0.0 else (1.0,)
    found = [problem.resized(moved, [*sizes, (way * h.scale[0], *h.scale[1:])]) for way in ways]
    return max(found, key=lambda there: problem.score(*there))


def _handed_over(
    stage: Stage, h: Hypothesis, problem: Problem, free: dict[Key, float], x: Array
) -> list[_Start]:  # fmt: skip
    """Return where to fit from if a thruster's numbers give back what they took over before the effect was there.

    They are those which move by a deviation or more to first order, x in deviations; the effect takes as much as that
    is. Number and effect are multiplied: no step along columns that were made where one had it all leads there.
    """
    m, count = len(stage.moved), len(h.scale)
    own = np.array([key[0] == "own" and key[2] in (h.thruster, h.other) for key in free])
    back = own & (np.abs(x[:m]) > 1.0) & (x[:m] * stage.moved < 0.0)
    if not back.any():
        return []
    on = [a.sizes for a in stage.fit.effects]
    moved = np.where(back, 0.0, stage.moved)
    if h.switch:
        return [(moved, [*on, ()])]
    if h.grid or not np.any(x[-count:]):
        return []
    expected = x[-count:] / np.max(np.abs(x[-count:])) * np.array(h.scale)
    return [problem.resized(moved, [*on, tuple(map(float, expected))])]


def _beside(stage: Stage, known: Sequence[int], at: Sequence[int], size: float) -> Array:
    """Return what moves, in deviations, where the first parameter of a hypothesis, a mass or a length, is of that size.

    What it makes at its place is known far better than itself: to first order one stands for the other's error.
    """
    gram = replace(stage.gram, b=stage.gram.b - size * stage.gram.A[:, at[0]])
    x, _ = solution(gram, [*known, *at[1:]])
    return np.insert(x, len(known), size)


def _without_them(stage: Stage, free: dict[Key, float], fits: Sequence[Fit]) -> float:
    """Return the log evidence for nothing more, wherever one of the fits has led its uncertain numbers.

    What a hypothesis gains because its fit went on where the one before had stopped is no evidence for it.
    """
    on = stage.fit.effects
    alone = Problem(screen=stage.screen, nuisances=free, effects=tuple(a.hypothesis for a in on))
    best = stage.fit
    reached = alone.score(best.moved, [a.sizes for a in on])
    for fit in fits:
        there = fit.moved, [a.sizes for a in fit.effects[:-1]]
        if alone.score(*there) > reached:
            again = alone.fit(*there)
            if again.log_evidence > best.log_evidence:
                best, reached = again, alone.score(again.moved, [a.sizes for a in again.effects])
    return best.log_evidence


def _start(stage: Stage, h: Hypothesis, problem: Problem, x: Array) -> _Start:
    """Return (nuisances, sizes) to fit from: the stage's point, moved by x in deviations."""
    m = len(stage.moved)
    moved, at, sizes = stage.moved + x[:m], m, []
    for a in stage.fit.effects:
        own = zip(a.sizes, x[at:], a.hypothesis.scale, strict=False)
        sizes.append(tuple(s + float(v) * d for s, v, d in own))
        at += len(a.sizes)
    if h.switch:
        return moved, [*sizes, ()]
    if h.grid:
        return stage.moved, [*sizes, problem.grid_start(stage.moved, sizes)]
    own_sizes = x[at:] * np.array(h.scale)
    if h.carrier and abs(own_sizes[0]) > 1e-9:
        own_sizes[1:] = own_sizes[1:] * h.scale[0] / own_sizes[0]
    return moved, [*sizes, tuple(map(float, own_sizes))]
