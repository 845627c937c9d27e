"""Which effects, and how sure: from screening over fits to a posterior over sets of effects, none and the nameless."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import Prepared, learned_from, prepared, whitened
from gap_diagnosis.vehicle.gram import Column, Gram, evidence, gathered, solution
from gap_diagnosis.vehicle.hypotheses import Hypothesis, hypotheses
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Key, Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.refining import Refined, refined
from gap_diagnosis.vehicle.screening import Screen, nameless_names

__all__ = ["Found", "Stage", "search", "started"]

Array = NDArray[np.float64]
_NAMELESS_PROBE = {"surge": 1.0, "sway": 1.0, "heave": 1.0, "roll": 0.1, "pitch": 0.1, "yaw": 0.1}


@dataclass(frozen=True, kw_only=True, eq=False)
class Stage:
    """What is known with a number of effects accepted.

    Attributes:
        screen, gram: at their point; moved: of its nuisances, in deviations.
        accepted: effects that are on, in order.
        offered: hypotheses by their log posterior odds against nothing more, best first.
        nameless: nameless dependences by their gain in log evidence, best first.
        log_evidence: of the recordings with what is on, comparable between stages.
    """

    screen: Screen
    gram: Gram
    moved: Array
    accepted: tuple[Refined, ...]
    offered: tuple[tuple[float, Hypothesis], ...]
    nameless: tuple[tuple[float, Key], ...]
    log_evidence: float


@dataclass(frozen=True, kw_only=True, eq=False)
class Found:
    """All stages, the last one first to be believed; rivals of each accepted effect with log odds against it."""

    stages: tuple[Stage, ...]
    rivals: tuple[tuple[tuple[float, Refined], ...], ...]
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
    runs, values = started(model, logs, free)
    accepted: tuple[Refined, ...] = ()
    stages: list[Stage] = []
    rivals: list[tuple[tuple[float, Refined], ...]] = []
    for depth in range(rules.MOST_EFFECTS + 1):
        stage = _stage(model, runs, values, accepted, free, tried)
        stages.append(stage)
        best = stage.offered[0] if stage.offered else (-np.inf, None)
        told(f"{depth} effects: best {best[0]:.1f} {best[1].words if best[1] else ''}")
        if best[0] < np.log(rules.CLAIM) - 3.0 or depth == rules.MOST_EFFECTS:
            break
        candidates = _refined(stage, free, tried)
        if candidates[0][0] < np.log(rules.CLAIM):
            break
        first = candidates[0][1]
        rivals.append(tuple((odds - candidates[0][0], each) for odds, each in candidates[1:]))
        accepted = (*accepted, first)
        values = {k: values.get(k, 0.0) + float(s) * d for (k, d), s in zip(free.items(), first.shifts, strict=True)}
        runs = prepared(model, logs, values, [a.active for a in accepted], start=learned_from(runs), rounds=3)
    return Found(stages=tuple(stages), rivals=tuple(rivals), nuisances=free, tried=tuple(tried))


def started(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float]
) -> tuple[list[Prepared], dict[Key, float]]:
    """Return the recordings with gains whose noises were learned once parameters and biases had been fitted."""
    runs = prepared(model, logs, {}, start=None, rounds=0)
    values: dict[Key, float] = {}
    for turn in range(2):
        screen = Screen(model=model, runs=runs, values=values)
        gram = gathered(screen.residuals(), [screen.of_nuisance(k, d) for k, d in free.items()])
        centre = {j: -values.get(k, 0.0) / d for j, (k, d) in enumerate(free.items())}
        shifts, _ = solution(gram, range(len(free)), centre=centre)
        tried = {k: values.get(k, 0.0) + float(s) * d for (k, d), s in zip(free.items(), shifts, strict=True)}
        before, after = (_size(Screen(model=model, runs=runs, values=v)) for v in (values, tried))
        values = tried if after < before else values
        runs = prepared(model, logs, values, rounds=4 if turn == 0 else 2)
    return runs, values


def _size(screen: Screen) -> float:
    r = [np.clip(np.nan_to_num(x), -50.0, 50.0) for x in screen.residuals()]
    return sum(float(x @ x) for x in r)


def _log_det(runs: Sequence[Prepared]) -> float:
    """Return the sum of log deviations of all readings, by which likelihoods under different noises compare."""
    total = 0.0
    for p in runs:
        total += 0.5 * p.gains.log_determinant
        total += float(np.sum(np.log(p.spread)[np.isfinite(p.log.speeds)]))
        total += float(np.sum(np.isfinite(p.log.battery) * np.log(p.noises.battery)))
    return total


def _stage(
    model: Model, runs: list[Prepared], values: dict[Key, float], accepted: tuple[Refined, ...], free: dict[Key, float],
    tried: Sequence[Hypothesis],
) -> Stage:  # fmt: skip
    screen = Screen(model=model, runs=runs, values=values, effects=tuple(a.active for a in accepted))
    columns = [screen.of_nuisance(k, d) for k, d in free.items()]
    m = len(columns)
    own: list[int] = []
    places: dict[Hypothesis, list[int]] = {}
    for each in accepted:
        for j, name in enumerate(each.hypothesis.parameters):
            own.append(len(columns))
            columns.append(_derivative(screen, accepted, each, j, name))
    used = {a.hypothesis.place for a in accepted}
    for h in tried:
        if h.place in used:
            continue
        new = screen.of_hypothesis(h)
        places[h] = list(range(len(columns), len(columns) + len(new)))
        columns += new
    names = nameless_names(model)
    first = len(columns)
    columns += [screen.of_nameless(name, _NAMELESS_PROBE[name[1]]) for name in names]
    width = round(rules.BLOCK / runs[0].log.period) * screen.residual(0).shape[1]
    gram = gathered(screen.residuals(), columns, keep=m, base=m + len(own), block=width)
    moved = np.array([values.get(k, 0.0) / d for k, d in free.items()])
    gram = _centred(gram, m, moved)
    base = [*range(m), *own]
    nothing = evidence(gram, base)
    offered = []
    for h, at in places.items():
        gain = (evidence(gram, base, on=at) if h.switch else evidence(gram, [*base, *at])) - nothing
        if len(at) == 1 and not h.switch and h.lower[0] >= 0.0 and solution(gram, [*base, *at])[0][-1] < 0.0:
            continue
        offered.append((tempered(gain, gram, at) + log_prior(h, tried), h))
    nameless = [
        (tempered(evidence(gram, [*base, first + j]) - nothing, gram, [first + j]), name)
        for j, name in enumerate(names)
    ]
    offered.sort(key=lambda each: -each[0])
    nameless.sort(key=lambda each: -each[0])
    # the prior of accepted sizes is about zero, not about where they are
    gone = sum(float(np.sum((np.array(a.sizes) / np.array(a.hypothesis.scale)) ** 2)) for a in accepted if a.sizes)
    total = nothing - 0.5 * float(moved @ moved) - 0.5 * gone - _log_det(runs)
    return Stage(
        screen=screen, gram=gram, moved=moved, accepted=accepted, offered=tuple(offered), nameless=tuple(nameless),
        log_evidence=total,
    )  # fmt: skip


def tempered(gain: float, gram: Gram, at: Sequence[int]) -> float:
    """Return a gain in log evidence as it counts where scores scatter more than they should, see `Gram.scatter`."""
    return gain / float(np.mean(gram.scatter[list(at)])) if gain > 0.0 else gain


def _centred(gram: Gram, m: int, moved: Array) -> Gram:
    """Return products whose nuisances have priors about the model's own numbers, not about the screen's point."""
    b = gram.b.copy()
    b[:m] -= moved
    return replace(gram, b=b)


def _derivative(screen: Screen, accepted: Sequence[Refined], each: Refined, j: int, name: str) -> Column:
    h = each.hypothesis
    others = tuple(a.active for a in accepted if a is not each)
    step = 0.5 * h.probe[j]
    if each.sizes[j] + step > h.upper[j]:
        step = -step
    there = tuple(s + step if i == j else s for i, s in enumerate(each.sizes))

    def change(k: int) -> Array:
        moved = screen.at(k, screen.values, (*others, h.active(there)))
        return (moved - screen.residual(k)) * (h.scale[j] / step)

    return Column(("accepted", h, name), 1.0, change)


def _refined(stage: Stage, free: dict[Key, float], tried: Sequence[Hypothesis]) -> list[tuple[float, Refined]]:
    """Return the best hypotheses, fitted, with log odds against nothing more, best first."""
    m = len(free)
    base = [
        j for j, name in enumerate(stage.gram.names) if j < m or (isinstance(name, tuple) and name[0] == "accepted")
    ]
    nothing = evidence(stage.gram, base)
    found = []
    for _, h in stage.offered[: rules.REFINED]:
        at = [j for j, name in enumerate(stage.gram.names) if isinstance(name, tuple) and name[0] == h]
        start: tuple[float, ...] = ()
        if not h.switch:
            x, _ = solution(stage.gram, [*base, *at])
            own = x[len(base) :] * np.array(h.scale)
            if h.carrier and abs(own[0]) > 1e-9:
                own[1:] = own[1:] * h.scale[0] / own[0]
            start = tuple(own)
        fit = refined(stage.screen, stage.gram, free, h, start, stage.moved)
        gain = fit.log_evidence + 0.5 * float(stage.moved @ stage.moved) - nothing
        found.append((tempered(gain, stage.gram, at) + log_prior(h, tried), fit))
    return sorted(found, key=lambda each: -each[0])


def residual_correlation(runs: Sequence[Prepared]) -> Array:
    """Return how far each rotor's innovations follow from the ones before, in deviations of chance, (N,)."""
    out = []
    for i in range(runs[0].log.thrusters):
        r = [whitened(p, p.base)[:, 13 + i] for p in runs]
        pairs = sum(float(x[1:] @ x[:-1]) for x in r)
        out.append(pairs / max(np.sqrt(sum(float(x @ x) for x in r)), 1e-9) ** 2 * np.sqrt(sum(x.size for x in r)))
    return np.array(out)
