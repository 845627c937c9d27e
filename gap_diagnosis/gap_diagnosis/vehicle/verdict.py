"""From what the search found to a verdict: which effects, how sure, what is left, what could not have been shown."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import prepared_with
from gap_diagnosis.vehicle.gram import solution
from gap_diagnosis.vehicle.how_far import Errors
from gap_diagnosis.vehicle.hypotheses import Hypothesis, sized
from gap_diagnosis.vehicle.log import VehicleLog, wanting
from gap_diagnosis.vehicle.oddities import Logged, common_to
from gap_diagnosis.vehicle.refining import Refined
from gap_diagnosis.vehicle.screening import READINGS
from gap_diagnosis.vehicle.search import Found
from gap_diagnosis.vehicle.stage import Stage, least_shown
from gap_diagnosis.vehicle.unknowns import Key, unit_of, words_of
from gap_diagnosis.vehicle.whitening import log_likelihood
from rov_sim.vehicle.effects.body_axes import BODY_AXES

__all__ = ["Claim", "Verdict", "judged"]

Array = NDArray[np.float64]
_NAMED = 3
"""Numbers that a summary names, those that moved most."""
_ALONE = "nothing recorded, nor with the other axes"
"""What a wrench goes with that comes and goes on one axis."""


@dataclass(frozen=True, kw_only=True)
class Claim:
    """One effect: as fitted, its probability among what the data cannot tell from it, and those rivals, of the library
    and nameless ones; group: probability that it or one of these is at work, against nothing more."""

    refined: Refined
    probability: float
    group: float
    rivals: tuple[tuple[float, Hypothesis], ...]
    nameless: tuple[tuple[float, Key], ...] = ()

    @property
    def words(self) -> str:
        """It in sentences, with its sizes and what cannot be told from it."""
        h = self.refined.hypothesis
        sizes = ", ".join(
            sized(p, s, d, h.units[p])
            for p, s, d in zip(h.parameters, self.refined.told, self.refined.deviations, strict=True)
            if not h.switch  # it is, or it is not
        )
        says = [f"{h.words[0].upper()}{h.words[1:]}{': ' + sizes if sizes else ''} (p {self.probability:.2f})."]
        if self.refined.at_the_end:
            says.append(f"That {h.parameters[0]} is the end of the range that is searched: its form may be another.")
        alike = [rival.words for _, rival in self.rivals[:4]]
        if self.nameless:
            alike.append(f"something that {_acts(self.nameless[0][1])} and is in no library")
        if alike:
            says.append(f"These recordings cannot tell it from {', '.join(alike)}.")
        return " ".join(says)


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """The answer.

    Attributes:
        name: no_gap, parameters, effect, cannot_tell, unknown or not_enough_data.
        claims: effects, most probable explanation each.
        candidates: (log odds against nothing more, hypothesis), best first, of what is not claimed.
        p_none, p_unknown: of no effect at all; of a significant nameless part.
        shifted: parameters that moved: (key, in deviations, deviation left).
        left: nameless dependences that are significant: (gain, key).
        hidden: what could not have been shown: (hypothesis, least size), in its own unit.
        wrench: random wrench that remains (6,) [N, N m].
        logged: what the logs of sensors show by themselves.
        summary: in sentences.
    """

    name: str
    claims: tuple[Claim, ...]
    candidates: tuple[tuple[float, Hypothesis], ...]
    p_none: float
    p_unknown: float
    shifted: tuple[tuple[Key, float, float], ...]
    left: tuple[tuple[float, Key], ...]
    hidden: tuple[tuple[Hypothesis, float], ...]
    wrench: Array
    logged: tuple[Logged, ...]
    summary: str


def judged(found: Found, logs: Sequence[VehicleLog], errors: Sequence[Errors] = ()) -> Verdict:
    """Return the verdict on these recordings; errors: of free runs, shortest horizon first."""
    last = found.stages[-1]
    wrench = np.asarray(last.screen.runs[0].noises.wrench)
    begun = len(last.accepted) + 1 - len(found.stages)  # effects with which the search began
    where = [*([None] * begun), *pairwise(found.stages)]
    accepted = zip(last.accepted, found.odds, found.rivals, where, strict=True)
    claims = tuple(_claim(a, o, r, stages) for a, o, r, stages in accepted if worth_claiming(a))
    small = tuple(a for a in last.accepted if not worth_claiming(a))
    near = [(odds, each) for odds, each in found.left if worth_claiming(each)]
    best = near[0][0] if near else -np.inf
    p_none = float(1.0 / (1.0 + np.exp(np.clip(best, -500.0, 500.0)))) if not claims else 0.0
    nameless = [(gain, key) for gain, key in last.nameless if gain > rules.NAMELESS]
    hidden = [] if nameless else _in_calm_water(found) or _on_one_axis(last)
    total = float(np.log(len(last.nameless) / rules.P_NAMELESS))
    top = last.nameless[0][0] if last.nameless else -np.inf
    p_unknown = float(1.0 / (1.0 + np.exp(np.clip(total - top, -500.0, 500.0))))
    rough = _rough(last)
    if rough or hidden:
        p_unknown, nameless = max(p_unknown, 0.9), nameless or hidden
    shifted, logged, closed = _shifted(found), common_to([log.oddities for log in logs]), _closed(errors)
    held = any(abs(s) > rules.HELD for _, s, _ in shifted)
    if held:
        p_unknown = max(p_unknown, 0.95)
    if wanting(logs):
        name, claims = "not_enough_data", ()
    elif rough or held or (claims and _nameless_is_better(found)) or _misread(claims, nameless):
        name = "unknown"
    elif claims:
        name = "effect" if min(c.probability for c in claims) >= 0.5 else "cannot_tell"
    elif nameless:
        name = "unknown"
    elif best > np.log(rules.SUSPECTED):
        name = "cannot_tell"
    elif logged:
        name = "effect"
    elif any(abs(s) > rules.SHIFTED for _, s, _ in shifted) or closed is not None:
        name = "parameters"
    else:
        name = "no_gap"
    return Verdict(
        name=name, claims=claims, candidates=tuple((o, r.hypothesis) for o, r in found.left),
        p_none=p_none, p_unknown=p_unknown, shifted=shifted, left=tuple(nameless[:5]),
        hidden=least_shown(last.gram, range(len(found.nuisances))),
        wrench=wrench, logged=logged,
        summary=_summary(name, claims, logged, small, found, near, nameless, rough, wrench, shifted, closed),
    )  # fmt: skip


def _closed(errors: Sequence[Errors]) -> Errors | None:
    """Return the errors over the shortest horizon at which there is a gap, if re-tuning closes some of it surely."""
    found = next((each for each in errors if each.budget), None)
    return found if found is not None and found.budget[0].low > 0.0 else None


def _misread(claims: Sequence[Claim], nameless: Sequence[tuple[float, Key]]) -> bool:
    """Return whether a sensor that a claim is about errs in another way too, which has no name.

    The claim is then the nearest error that has one: a gyro that clips was a gyro of another scale.
    """
    read = {READINGS[place] for _, (_, place, _) in nameless if place in READINGS}
    return any(claim.refined.hypothesis.read_by in read for claim in claims)


def _acts(key: Key) -> str:
    """Return what a nameless dependence does, in words that a subject precedes."""
    _, place, feature = key
    return f"{'shows in' if place in READINGS else 'acts on'} {place} and goes with {feature}"


def _rough(last: Stage) -> bool:
    """Return whether the recordings ask for a random wrench that calm water does not have."""
    wrench, water = last.screen.runs[0].noises.wrench, last.screen.model.wrench_of_water
    return bool(np.any(wrench > water(rules.LARGE_WRENCH))) and (
        _asked_for(last, water(rules.CALM_WRENCH)) > rules.NAMELESS
    )


def _on_one_axis(last: Stage) -> list[tuple[float, Key]]:
    """Return the axis on which the random wrench is far larger than on the others of its kind, as no water's is."""
    wrench = last.screen.runs[0].noises.wrench
    most = np.repeat(rules.ONE_AXIS * np.median(wrench.reshape(2, 3), axis=1), 3)
    if np.all(wrench <= most):
        return []
    gain, axis = _asked_for(last, most), BODY_AXES[int(np.argmax(wrench / most))]
    return [(gain, ("nameless", axis, _ALONE))] if gain > rules.NAMELESS else []


def _asked_for(last: Stage, most: Array) -> float:
    """Return by how much recordings are likelier with the random wrench that was learned than with one of at most this.

    Without a velocity log they hardly tell its size: then one that is learned as large is not evidence of it.
    """
    noises = last.screen.runs[0].noises
    effects = [e.active for e in last.fit.effects]

    def likelihood(wrench: Array) -> float:
        again = (
            prepared_with(
                last.screen.model, p.log, p.run, noises._replace(wrench=wrench), last.fit.values, effects, p.base.states
            )
            for p in last.screen.runs
        )
        return sum(log_likelihood(p) for p in again)

    return likelihood(noises.wrench) - likelihood(np.minimum(noises.wrench, most))


def _in_calm_water(found: Found) -> list[tuple[float, Key]]:
    """Return nameless dependences with which calm water explains more than rough water does without, by so much."""
    if found.calm is None:
        return []
    behind = found.stages[-1].log_evidence - found.calm.log_evidence
    return [(gain - behind, key) for gain, key in found.calm.nameless if gain > rules.NAMELESS + max(behind, 0.0)]


def _claim(
    accepted: Refined, odds: float, rivals: Sequence[tuple[float, Refined]], stages: tuple[Stage, Stage] | None
) -> Claim:  # fmt: skip
    """Return a claim; stages: where it was accepted with these odds, and the next one; None: nothing else was tried.

    What something nameless explains no less beside the effect than without it is not what the effect explains.
    """
    h, own, beside = accepted.hypothesis, odds, []
    if stages is not None:
        stage, after = stages
        # a fit may gain more than its first order foresaw
        own = max([odds, *(o for o, offered in stage.offered if offered == h)])
        beside = [(o - max(after.odds.get(key, 0.0), 0.0) - own, key) for key, o in stage.odds.items()]
    weights = np.exp(np.clip([o for o, _ in (*rivals, *beside)], -50.0, 0.0))
    probability = float(1.0 / (1.0 + weights.sum())) * (rules.AT_AN_END if accepted.at_the_end else 1.0)
    found = [
        (float(w) * probability, each) for w, (_, each) in zip(weights, (*rivals, *beside), strict=True) if w > 0.02
    ]
    return Claim(
        refined=accepted,
        probability=probability,
        group=float(1.0 / (1.0 + probability * np.exp(-min(odds, 500.0)))),
        rivals=tuple((p, each.hypothesis) for p, each in found if isinstance(each, Refined)),
        nameless=tuple(sorted(((p, each) for p, each in found if isinstance(each, tuple)), key=lambda e: -e[0])),
    )


def worth_claiming(accepted: Refined) -> bool:
    """Return whether an effect is large enough to be named, see `rules.WORTH`."""
    h = accepted.hypothesis
    if h.switch or h.grid:
        return True
    sizes, scale = np.abs(accepted.sizes), np.array(h.scale)
    worth = sizes > rules.WORTH * scale
    return bool(worth[0]) if h.carrier or h.about else bool(np.any(worth))


def _nameless_is_better(found: Found) -> bool:
    """Return whether some nameless dependence alone explains far more than the best effect of the library did."""
    first = found.stages[0]
    best = max([o for o, _ in first.offered[:1]] + [o for o in found.odds[:1] if np.isfinite(o)], default=np.inf)
    return bool(first.nameless and first.nameless[0][0] > best + rules.NAMELESS)


def _shifted(found: Found) -> tuple[tuple[Key, float, float], ...]:
    last = found.stages[-1]
    m = len(found.nuisances)
    x, covariance = solution(last.gram, range(last.fit.columns[0].shape[1]))
    moved = last.moved + x[:m]
    rows = [
        (key, float(moved[j]), float(np.sqrt(covariance[j, j])))
        for j, key in enumerate(found.nuisances)
        if key[0] in ("vehicle", "shared", "own", "product", "tilt", "trim", "sensor")
    ]
    rows.sort(key=lambda row: -abs(row[1]))
    return tuple(row for row in rows if abs(row[1]) > 1.5)[:8]


def _retuned(shifted: Sequence[tuple[Key, float, float]], found: Found, closed: Errors | None) -> str:
    """Return what re-tuning does, in words, and which numbers moved most."""
    far = [_moved(key, moved, found) for key, moved, _ in shifted if abs(moved) > rules.SHIFTED or closed][:_NAMED]
    beyond = "beyond" if any(abs(moved) > rules.SHIFTED for _, moved, _ in shifted) else "within"
    steps = ""
    if closed is not None:
        steps = (
            f" As stated, the model errs after {closed.horizon:g} s by {closed.steps[0]:.2f} times what a right one "
            f"does; re-tuned, by {closed.steps[1]:.2f} times."
        )
    named = f": {', '.join(far)}" if far else ""
    return f"Parameters {beyond} their stated deviations explain the gap{named}.{steps}"


def _moved(key: Key, deviations: float, found: Found) -> str:
    """Return by how much a number moved, in words."""
    unit, size = unit_of(key), deviations * found.nuisances[key]
    by = f"{100.0 * size:+.1f} %" if unit == "1" else f"{size:+.3g} {unit}"
    return f"{words_of(key)} by {by} ({deviations:+.1f} deviations)"


def _summary(
    name: str, claims: Sequence[Claim], logged: Sequence[Logged], small: Sequence[Refined], found: Found,
    near: Sequence[tuple[float, Refined]], nameless: Sequence[tuple[float, Key]], rough: bool, wrench: Array,
    shifted: Sequence[tuple[Key, float, float]], closed: Errors | None,
) -> str:  # fmt: skip
    says = []
    if name == "not_enough_data":
        return "The recordings are too short or too quiet to say anything."
    if name == "unknown" and claims:
        says.append("More is wrong than the library explains; what follows holds only if the rest leaves it alone.")
        key, moved, _ = max(shifted, key=lambda row: abs(row[1]), default=(("",), 0.0, 0.0))
        if abs(moved) > rules.HELD:
            says.append(f"It needs {words_of(key)} to be {moved:+.0f} deviations from what is stated.")
    says += [claim.words for claim in claims]
    says += [each.sentence for each in logged]
    if name == "no_gap":
        says.append("The model as it is stated explains the recordings.")
    if name == "unknown" and not claims and not nameless and not rough:
        says.append(
            f"{_retuned(shifted, found, closed)} So far off is either what is stated, or what the model takes for it: "
            "something that it lacks may act alike."
        )
    if small:
        says.append("Too small to be claimed: " + ", ".join(a.hypothesis.words for a in small) + ".")
    if name == "parameters":
        says.append(_retuned(shifted, found, closed))
    if name == "cannot_tell" and not claims:
        says.append(f"Something may be there, but not surely: {near[0][1].hypothesis.words} is the nearest.")
    if nameless:
        says.append(f"What is left {_acts(nameless[0][1])}: no effect of the library does that.")
    if rough:
        says.append(
            f"A wrench of {wrench[:3].max():.1f} N and {wrench[3:].max():.2f} N m comes and goes unexplained, more "
            "than calm water has."
        )
    return " ".join(says)
