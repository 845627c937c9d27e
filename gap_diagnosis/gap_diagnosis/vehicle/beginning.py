"""What a search begins with: wrong wires, a delay of all commands or of one sensor, a drift of clocks, or nothing."""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import Prepared
from gap_diagnosis.vehicle.hypotheses import WIRING, Hypothesis
from gap_diagnosis.vehicle.learning import unlearned
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.refining import Fit, Problem, Refined
from gap_diagnosis.vehicle.rivals import Rivals
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.settling import likelihood, log_evidence, settled, settled_with
from gap_diagnosis.vehicle.side_by_side import side_by_side
from gap_diagnosis.vehicle.stage import log_prior
from gap_diagnosis.vehicle.unknowns import Key, in_deviations, in_units
from gap_diagnosis.vehicle.whitening import log_determinant, log_likelihood, whitened
from rov_sim.vehicle.innovations import CHANNELS

__all__ = ["Begun", "RoughFit", "begun", "beyond_numbers", "delays_in", "foreseen"]

_TWICE, _FINELY = 2.0, 0.05
"""Times the best size tried up to which a delay or a drift is searched, and how finely at least, as a share of it."""


class RoughFit(NamedTuple):
    """A fit under noises that are only typical: its log likelihood, what it gained, numbers, effects that are on."""

    likelihood: float
    gained: float
    values: Mapping[Key, float]
    effects: tuple[Refined, ...]


class Begun(NamedTuple):
    """Recordings and fit without any effect; those that a search begins with, rivals of each effect that they have on,
    and log odds for each."""

    retuned: tuple[list[Prepared], Fit]
    first: tuple[list[Prepared], Fit]
    rivals: list[Rivals]
    odds: list[float]


def begun(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], tried: Sequence[Hypothesis],
    told: Callable[[str], None] = lambda text: None,
) -> Begun:  # fmt: skip
    """Return what a search begins with: wrong wires, or a delay, without which recordings are far less likely.

    Numbers that are fitted with a thruster the wrong way round, or to an IMU that is late, are no place to look for it
    from. So the believed ones are asked first. What re-tuned numbers explain as well is no delay.
    Where a delay begins, numbers without it are those nearest to it: from the believed ones they wander far.
    """
    switches = [h for h in tried if h.switch]
    nothing = foreseen(model, logs, ())
    late_ones, values = beyond_numbers(model, logs, free, delays_in(model, logs, tried, nothing))
    if late_ones and not _wired_wrongly(model, logs, switches, max(gain for gain, _ in late_ones) + nothing):
        told(f"fits {', or '.join(a.hypothesis.words for _, each in late_ones for a in each.effects)}")
        # quick fits beside each other's noises do not tell two delays apart
        fits = [settled(model, logs, free, each.effects, each.values) for _, each in late_ones]
        found = max(fits, key=lambda each: log_evidence(*each))
        late = found[1].effects[0]
        others = [
            (log_evidence(*each) - log_evidence(*found), each[1].effects[0]) for each in fits if each is not found
        ]
        bare = settled_with([], model, logs, free, found[0], found[1].values)
        odds = log_evidence(*found) - log_evidence(*bare) + log_prior(late.hypothesis, tried)
        if odds > np.log(rules.CLAIM):
            return Begun(bare, found, [tuple(others)], [odds])
    told("fits the numbers")
    retuned = settled(model, logs, free, (), values)
    moved = zip(free, retuned[1].moved, strict=True)
    far = {k[2] for k, deviations in moved if k[0] == "own" and abs(deviations) > rules.SHIFTED}
    wires = _wired_wrongly(model, logs, [h for h in switches if far & {h.thruster, h.other}], nothing)
    if wires:
        found = settled(model, logs, free, wires)
        if likelihood(*found) > likelihood(*retuned) + np.log(rules.CLAIM):
            return Begun(retuned, found, [() for _ in wires], [np.inf for _ in wires])
    return Begun(retuned, retuned, [], [])


def _wired_wrongly(
    model: Model, logs: Sequence[VehicleLog], switches: Sequence[Hypothesis], nothing: float
) -> list[Refined]:  # fmt: skip
    """Return the wrong wires with which believed numbers foresee recordings far better; nothing: without any.

    A thruster that they would rather have stopped is not wired wrongly; whether it has stopped is told from among all
    effects, most of which would do as well here.
    """
    on: list[Refined] = []
    best, switches = nothing, list(switches)
    while switches and len(on) < rules.MOST_EFFECTS:
        scores = side_by_side(lambda h: foreseen(model, logs, [*on, _of_size(h)]), switches)
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


def delays_in(
    model: Model, logs: Sequence[VehicleLog], tried: Sequence[Hypothesis], nothing: float
) -> list[tuple[float, Refined]]:  # fmt: skip
    """Return the delays, and drifts of clocks, of all alike with which believed numbers foresee recordings far better
    than without any (nothing), each with its gain at its best size."""
    delays = [h for h in tried if h.thruster is None and h.further and not h.carrier]
    sized = [_of_size(h, size) for h in delays for size in h.further]
    scores = side_by_side(lambda each: foreseen(model, logs, [each]), sized)
    if max(scores, default=-np.inf) < nothing + np.log(rules.CLAIM):
        return []
    order = sorted(range(len(sized)), key=lambda j: -scores[j])
    found = []
    for h in list(dict.fromkeys(sized[j].hypothesis for j in order))[: rules.REFINED_LATE]:
        nearest, *others = next(sized[j].sizes for j in order if sized[j].hypothesis is h)

        def late(share: float, h: Hypothesis = h, size: float = nearest, others: Sequence[float] = others) -> Refined:
            return _of_size(h, (share * size, *others))

        def of(share: float, late: Callable[[float], Refined] = late) -> float:
            return -foreseen(model, logs, [late(share)])

        most = min(_TWICE, h.most / abs(nearest))
        finely = min(rules.TIMING / abs(nearest), _FINELY)
        best = minimize_scalar(of, bounds=(0.0, most), method="bounded", options={"xatol": finely})
        found.append((-float(best.fun) - nothing, late(float(best.x))))
    return [each for each in found if each[0] > np.log(rules.CLAIM)]


def beyond_numbers(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], late_ones: Sequence[tuple[float, Refined]]
) -> tuple[list[tuple[float, RoughFit]], Mapping[Key, float]]:
    """Return those of some delays that explain what no numbers do, by rough fits, each with its gain at the believed
    numbers: the one that does most, and others that do nearly as much; and the numbers without any."""
    if not late_ones:
        return [], {}
    bare = _rough(model, logs, free, ())
    found = [(own, _rough(model, logs, free, (each,))) for own, each in late_ones]
    much = rules.ROUGH * bare.gained

    def beyond(bare: RoughFit) -> list[tuple[float, RoughFit]]:
        gains = [each.likelihood - bare.likelihood for _, each in found]
        least = max(np.log(rules.CLAIM), much, rules.ALSO_LATE * max(gains))
        return [each for each, gain in zip(found, gains, strict=True) if gain >= least]

    # Numbers are fitted from where a delay's fit ended, too: it may have led to where they do as well without.
    for _, each in beyond(bare):
        bare = max(bare, _rough(model, logs, free, (), each.values), key=lambda one: one.likelihood)
    return beyond(bare), bare.values


def _rough(
    model: Model, logs: Sequence[VehicleLog], free: dict[Key, float], on: Sequence[Refined],
    values: Mapping[Key, float] = MappingProxyType({}),
) -> RoughFit:  # fmt: skip
    """Return a rough fit of numbers and effects from values, or the believed ones, with what is typical of noises."""
    runs = unlearned(model, logs, {}, [each.active for each in on])
    screen = Screen(model=model, runs=runs, values={})
    problem = Problem(screen=screen, nuisances=free, effects=tuple(each.hypothesis for each in on))
    sizes = [each.sizes for each in on]
    start = in_deviations(values, free)
    before = problem.score(start, sizes)
    moved, sizes, _ = problem.most_likely(start, sizes)
    score = problem.score(moved, sizes)
    effects = tuple(_of_size(h, s) for h, s in zip(problem.effects, sizes, strict=True))
    return RoughFit(score - 0.5 * sum(map(log_determinant, runs)), score - before, in_units(moved, free), effects)


def _of_size(h: Hypothesis, sizes: tuple[float, ...] = ()) -> Refined:
    return Refined(hypothesis=h, sizes=sizes, deviations=())


def foreseen(model: Model, logs: Sequence[VehicleLog], on: Sequence[Refined]) -> float:
    """Return the log likelihood of recordings under the believed numbers, with effects on."""
    found = unlearned(model, logs, {}, [a.active for a in on])
    rotors = slice(CHANNELS, CHANNELS + model.thrusters)
    return sum(log_likelihood(p) - 0.5 * float(np.sum(whitened(p, p.base)[:, rotors] ** 2)) for p in found)
