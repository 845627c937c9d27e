"""Which effects, and how sure: from screening over fits to a posterior over sets of effects, none and the nameless."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import Prepared, log_likelihood, whitened
from gap_diagnosis.vehicle.gram import Column, Gram, evidence, gathered, solution
from gap_diagnosis.vehicle.hypotheses import WIRING, Hypothesis, hypotheses
from gap_diagnosis.vehicle.learning import learned_from, prepared
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Key, Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.refining import Fit, Problem, Refined
from gap_diagnosis.vehicle.screening import Screen, nameless_names
from gap_diagnosis.vehicle.side_by_side import side_by_side
from rov_sim.vehicle.innovations import CHANNELS

__all__ = ["Found", "Stage", "search", "settled"]

Array = NDArray[np.float64]
_NAMELESS_PROBE = {"surge": 1.0, "sway": 1.0, "heave": 1.0, "roll": 0.1, "pitch": 0.1, "yaw": 0.1}


@dataclass(frozen=True, kw_only=True, eq=False)
class Stage:
    """What is known with a number of effects accepted.

    Attributes:
        fit: of what is on; screen, gram: at its point; moved: of the nuisances there, in deviations.
        accepted: effects that are on, in order.
        offered: hypotheses by their log posterior odds against nothing more, to first order, best first.
        nameless: nameless dependences by their gain in log evidence, as it counts (`tempered`), best first.
        odds: log posterior odds of each of them against nothing more, to first order, as those of `offered`.
    """

    fit: Fit
    screen: Screen
    gram: Gram
    moved: Array
    accepted: tuple[Refined, ...]
    offered: tuple[tuple[float, Hypothesis], ...]
    nameless: tuple[tuple[float, Key], ...]
    odds: dict[Key, float]

    @property
    def log_evidence(self) -> float:
        """Of the recordings with what is on, comparable over noises."""
        return self.fit.log_evidence - 0.5 * sum(p.gains.log_determinant for p in self.screen.runs)


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
    rivals: tuple[tuple[tuple[float, Refined], ...], ...]
    left: tuple[tuple[float, Refined], ...]
    nuisances: dict[Key, float]
    tried: tuple[Hypothesis, ...]


def log_prior(h: Hypothesis, tried: Sequence[Hypothesis]) -> float:
    """Return that of a hypothesis: shared evenly by effects, then by the places where each can be."""
    effects = {each.effect for each in tried}
    places = sum(each.effect == h.effect for each in tried)
    return float(np.log(rules.P_EFFECT / (1.0 - rules.P_EFFECT) * (1.0 - rules.P_NAMELESS) / len(effects) / places))


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
    there = {name: any(log.there[name] for log in logs) for name in logs[0].there}
    tried = [h for h in hypotheses(model, there) if only(h)]
    free = nuisances(model, logs)
    told(f"{len(free)} uncertain numbers, {len(tried)} hypotheses")
    retuned = settled(model, logs, free, prepared(model, logs, {}, start=None, rounds=0), (), {})
    runs, fit = _rewired(model, logs, free, tried, retuned)
    if fit.effects:
        told(f"begins with {', '.join(a.hypothesis.words for a in fit.effects)}")
    stages: list[Stage] = []
    rivals: list[tuple[tuple[float, Refined], ...]] = [() for _ in fit.effects]
    odds = [np.inf for _ in fit.effects]
    left: tuple[tuple[float, Refined], ...] = ()
    for depth in range(rules.MOST_EFFECTS + 1):
        stage = _stage(model, runs, fit, free, tried)
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
        runs = prepared(
            model, logs, values, [a.active for a in accepted], start=learned_from(runs), rounds=rules.LEARNED
        )
        runs, fit = settled(model, logs, free, runs, accepted, values)
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


def _rewired(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], tried: Sequence[Hypothesis],
    retuned: tuple[list[Prepared], Fit],
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return recordings and fit with the wrong wires without which they are far less likely; without any: `retuned`.

    Numbers that are fitted with a thruster the wrong way round are no place to look for it from. So the believed ones
    are asked, where a thruster's own numbers have moved far.
    """
    far = {
        k[2] for k, moved in zip(free, retuned[1].moved, strict=True) if k[0] == "own" and abs(moved) > rules.SHIFTED
    }
    wires = [h for h in tried if h.effect in WIRING and far & {h.thruster, h.other}]
    on: list[Hypothesis] = []
    best = _foreseen(model, logs, on) if wires else 0.0
    while wires and len(on) < rules.MOST_EFFECTS:
        others = [[*on, h] for h in wires if h not in on]
        scores = side_by_side(lambda each: _foreseen(model, logs, each), others)
        if not others or max(scores) < best + np.log(rules.CLAIM):
            break
        best = max(scores)
        on = others[scores.index(best)]
    if not on:
        return retuned
    first = prepared(model, logs, {}, [h.active(()) for h in on], start=None, rounds=0)
    found = settled(
        model, logs, free, first, [Refined(hypothesis=h, sizes=(), deviations=()) for h in on], {}, anew=True
    )
    return found if _likelihood(*found) > _likelihood(*retuned) + np.log(rules.CLAIM) else retuned


def _foreseen(model: Model, logs: Sequence[VehicleLog], on: Sequence[Hypothesis]) -> float:
    """Return the log likelihood of recordings under the believed numbers, with switches on."""
    found = prepared(model, logs, {}, [h.active(()) for h in on], start=None, rounds=0)
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
    return _stage(model, runs, problem.fit(last.fit.moved, sizes, exact=True), free, ())


def _likelihood(runs: Sequence[Prepared], fit: Fit) -> float:
    return sum(log_likelihood(p) for p in runs) - 0.5 * float(fit.moved @ fit.moved)


def settled(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], runs: list[Prepared],
    accepted: Sequence[Refined], values: Mapping[Key, float], *, anew: bool = False,
) -> tuple[list[Prepared], Fit]:  # fmt: skip
    """Return the recordings with gains for noises learned where nuisances and accepted effects fit best, and that fit.

    Noises and numbers are found in turn: numbers fitted with noises that had to explain what the numbers do not are
    too near to what was believed, and noises learned there too large. anew: also with effects on, learn noises from the
    beginning, not from those of the recordings.
    """
    effects = tuple(a.hypothesis for a in accepted)
    moved = np.array([values.get(k, 0.0) / d for k, d in free.items()])
    sizes = [a.sizes for a in accepted]
    for turn in range(rules.TURNS):
        problem = Problem(screen=Screen(model=model, runs=runs, values={}), nuisances=free, effects=effects)
        before = problem.score(moved, sizes)
        fit = problem.fit(moved, sizes)
        after = problem.score(fit.moved, [e.sizes for e in fit.effects])
        moved, sizes = fit.moved, [e.sizes for e in fit.effects]
        if turn > 0 and after - before < rules.SETTLED:
            break
        afresh = turn == 0 and (anew or not accepted)
        start = None if afresh else learned_from(runs)
        runs = prepared(
            model, logs, fit.values, [e.active for e in fit.effects], start=start, rounds=4 if afresh else rules.LEARNED
        )
    # screening compares columns: those of the numbers must be as good as those of what is tried
    return runs, Problem(screen=Screen(model=model, runs=runs, values={}), nuisances=free, effects=effects).fit(
        moved, sizes, exact=True
    )


def _stage(model: Model, runs: list[Prepared], fit: Fit, free: dict[Key, float], tried: Sequence[Hypothesis]) -> Stage:
    screen = Screen(model=model, runs=runs, values=fit.values, effects=tuple(a.active for a in fit.effects))
    m, known = len(free), fit.columns[0].shape[1]
    names: list[object] = [
        *free,
        *(("accepted", a.hypothesis, p) for a in fit.effects for p in a.hypothesis.parameters),
    ]
    columns = [Column(name, 1.0, _known(screen, fit, j)) for j, name in enumerate(names)]
    places: dict[Hypothesis, list[int]] = {}
    used = {a.hypothesis.place for a in fit.effects}
    for h in tried:
        if h.place in used:
            continue
        new = screen.of_hypothesis(h)
        places[h] = list(range(len(columns), len(columns) + len(new)))
        columns += new
    nameless_of = nameless_names(model)
    first = len(columns)
    columns += [screen.of_nameless(name, _NAMELESS_PROBE[name[1]]) for name in nameless_of]
    width = round(rules.BLOCK / runs[0].log.period) * screen.residual(0).shape[1]
    gram = gathered(screen.residuals(), columns, base=known, block=width)
    sizes = [s / d for a in fit.effects for s, d in zip(a.sizes, a.hypothesis.scale, strict=True)]
    gram = _centred(gram, np.concatenate((fit.moved, sizes)))
    base = list(range(known))
    nothing = evidence(gram, base)
    offered = []
    for h, at in places.items():
        gain = (evidence(gram, base, on=at) if h.switch else evidence(gram, [*base, *at])) - nothing
        if len(at) == 1 and not h.switch and h.lower[0] >= 0.0 and solution(gram, [*base, *at])[0][-1] < 0.0:
            continue
        offered.append((gain + log_prior(h, tried), h))
    gains = [evidence(gram, [*base, first + j]) - nothing for j in range(len(nameless_of))]
    prior = np.log(rules.P_EFFECT / (1.0 - rules.P_EFFECT) * rules.P_NAMELESS / len(nameless_of))
    odds = {name: float(gain + prior) for gain, name in zip(gains, nameless_of, strict=True)}
    nameless = [
        (tempered(g, gram, [first + j]), name) for j, (g, name) in enumerate(zip(gains, nameless_of, strict=True))
    ]
    offered.sort(key=lambda each: -each[0])
    nameless.sort(key=lambda each: -each[0])
    return Stage(
        fit=fit, screen=screen, gram=gram, moved=fit.moved[:m], accepted=fit.effects, offered=tuple(offered),
        nameless=tuple(nameless), odds=odds,
    )  # fmt: skip


def _known(screen: Screen, fit: Fit, j: int) -> Callable[[int], Array]:
    return lambda k: fit.columns[k][:, j].astype(np.float64)


def tempered(gain: float, gram: Gram, at: Sequence[int]) -> float:
    """Return a gain in log evidence as it counts where scores scatter more than they should, see `Gram.scatter`."""
    return gain / float(np.mean(gram.scatter[list(at)])) if gain > 0.0 else gain


def _centred(gram: Gram, moved: Array) -> Gram:
    """Return products whose first columns have priors about the model's own numbers, not about the screen's point."""
    b = gram.b.copy()
    b[: moved.size] -= moved
    return replace(gram, b=b)


def _refined(stage: Stage, free: dict[Key, float], tried: Sequence[Hypothesis]) -> list[tuple[float, Fit]]:
    """Return the best hypotheses, fitted with all that is on, with log odds against nothing more, best first."""
    names, on = stage.gram.names, stage.fit.effects
    known = range(stage.fit.columns[0].shape[1])
    product = stage.gram.A[: len(known), : len(known)]
    quick = []
    for _, h in stage.offered[: rules.REFINED]:
        problem = Problem(screen=stage.screen, nuisances=free, effects=(*(a.hypothesis for a in on), h))
        at = [j for j, name in enumerate(names) if isinstance(name, tuple) and name[0] == h]
        x, _ = solution(stage.gram, known, on=at) if h.switch else solution(stage.gram, [*known, *at])
        starts = [_start(stage, h, problem, share * x) for share in (1.0, 0.5, 0.0)]
        # what a thruster's numbers took over before the effect was there, they give back at once
        own = np.array([key[0] == "own" and key[2] in (h.thruster, h.other) for key in free])
        starts += [(np.where(own, 0.0, moved), sizes) for moved, sizes in starts if own.any()]
        start = max(starts, key=lambda there: problem.score(*there))
        quick.append((problem.fit(*start, stage.fit.columns, product), problem))
    quick.sort(key=lambda each: -each[0].log_evidence)
    fits = []
    for place, (fit, problem) in enumerate(quick):
        if place < rules.FITTED_ANEW and fit.log_evidence > quick[0][0].log_evidence - rules.FAR_BEHIND:
            fit = problem.fit(fit.moved, [e.sizes for e in fit.effects])
        fits.append(fit)
    nothing = _without_them(stage, free, fits)
    found = []
    for fit in fits:
        gain, prior = fit.log_evidence - nothing, log_prior(fit.effects[-1].hypothesis, tried)
        found.append((max(gain, 0.0) / fit.scatter + min(gain, 0.0) + prior, fit))
    return sorted(found, key=lambda each: -each[0])


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


def _start(stage: Stage, h: Hypothesis, problem: Problem, x: Array) -> tuple[Array, list[tuple[float, ...]]]:
    """Return (nuisances, sizes) to fit from: the stage's point, moved by x in deviations."""
    m = len(stage.moved)
    moved, at, sizes = stage.moved + x[:m], m, []
    for a in stage.fit.effects:
        own = zip(a.sizes, x[at:], a.hypothesis.scale, strict=False)
        sizes.append(tuple(s + float(v) * d for s, v, d in own))
        at += len(a.sizes)
    if h.switch:
        return moved, [*sizes, ()]
    if h.effect in ("throttle_rate_limit", "throttle_saturation"):
        return stage.moved, [*sizes, problem.grid_start(stage.moved, sizes)]
    own_sizes = x[at:] * np.array(h.scale)
    if h.carrier and abs(own_sizes[0]) > 1e-9:
        own_sizes[1:] = own_sizes[1:] * h.scale[0] / own_sizes[0]
    return moved, [*sizes, tuple(map(float, own_sizes))]
