"""What is known with some effects accepted: what each further one would explain, to first order, with its odds."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import Prepared
from gap_diagnosis.vehicle.gram import Column, Gram, evidence, gathered, solution
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.onset_search import likeliest_onsets
from gap_diagnosis.vehicle.refining import Fit, Refined
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.settling import log_evidence
from gap_diagnosis.vehicle.unknowns import Key

__all__ = ["Stage", "least_shown", "log_prior", "of_any_size", "stage_at"]

Array = NDArray[np.float64]
_ODDS = rules.P_EFFECT / (1.0 - rules.P_EFFECT)


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
        return log_evidence(self.screen.runs, self.fit)

    @property
    def leaves_more(self) -> bool:
        """Whether a further effect, or something without a name, seems to be at work beside what is on."""
        offered = max((odds for odds, _ in self.offered), default=-np.inf)
        nameless = max((gain for gain, _ in self.nameless), default=-np.inf)
        return bool(offered > np.log(rules.CLAIM) or nameless > rules.NAMELESS)


def log_prior(h: Hypothesis, tried: Sequence[Hypothesis]) -> float:
    """Return that of a hypothesis: shared evenly by effects, then by the places where each can be, and by onsets."""
    effects = {each.effect for each in tried}
    places = sum(each.effect == h.effect for each in tried)
    onsets = 1 if h.since is None else h.since.among
    return float(np.log(_ODDS * (1.0 - rules.P_NAMELESS) / len(effects) / places / onsets))


def stage_at(
    model: Model, runs: list[Prepared], fit: Fit, free: dict[Key, float], tried: Sequence[Hypothesis],
    nameless_of: Sequence[Key],
) -> Stage:  # fmt: skip
    """Return what more these hypotheses and nameless dependences would explain where a fit ended."""
    screen = Screen(model=model, runs=runs, values=fit.values, effects=tuple(a.active for a in fit.effects))
    m, known = len(free), fit.columns[0].shape[1]
    names: list[object] = [
        *free,
        *(("accepted", a.hypothesis, p) for a in fit.effects for p in a.hypothesis.parameters),
    ]
    columns = [Column(name, 1.0, _known(screen, fit, j)) for j, name in enumerate(names)]
    places: dict[Hypothesis, list[int]] = {}
    used = {a.hypothesis.place for a in fit.effects}
    new_ones = [h for h in tried if h.place not in used]
    for h in (*new_ones, *likeliest_onsets([h for h in new_ones if h.begins], screen, fit)):
        new = screen.of_hypothesis(h)
        places[h] = list(range(len(columns), len(columns) + len(new)))
        columns += new
    first = len(columns)
    columns += [screen.of_nameless(name) for name in nameless_of]
    width = round(rules.BLOCK / runs[0].log.period) * screen.residual(0).shape[1]
    gram = gathered(screen.residuals(), columns, base=known, block=width)
    gram = _centred(gram, fit.unknowns)
    base = list(range(known))
    nothing = evidence(gram, base)
    offered = []
    for h, at in places.items():
        gain = (evidence(gram, base, on=at) if h.switch else evidence(gram, [*base, *at])) - nothing
        one_sided = h.of_one_size and h.lower[0] >= 0.0
        if one_sided and solution(gram, [*base, *at])[0][len(base)] < 0.0:
            continue
        offered.append((gain + log_prior(h, tried), h))
    gains = [of_any_size(gram, base, first + j) - nothing for j in range(len(nameless_of))]
    prior = np.log(_ODDS * rules.P_NAMELESS / max(len(nameless_of), 1))
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


def of_any_size(gram: Gram, base: Sequence[int], j: int) -> float:
    """Return the log evidence with column j of a size that nobody knows: small, or as large as anything there is."""
    each = []
    for size in rules.NAMELESS_SIZES:
        deviations = gram.deviations.copy()
        deviations[j] = size
        each.append(evidence(replace(gram, deviations=deviations), [*base, j]))
    return float(np.logaddexp.reduce(each) - np.log(len(each)))


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


def least_shown(gram: Gram, numbers: Sequence[int]) -> tuple[tuple[Hypothesis, float], ...]:
    """Return the least size at which each hypothesis of one size, in each place, would be claimed: log(odds) = gain.

    numbers: columns of the numbers that are uncertain.
    """
    base = list(numbers)
    H = np.linalg.inv(gram.A[np.ix_(base, base)] + np.eye(len(base)))
    out: dict[object, tuple[Hypothesis, float]] = {}
    for j, name in enumerate(gram.names):
        if not (isinstance(name, tuple) and isinstance(name[0], Hypothesis)) or name[0].switch:
            continue
        h = name[0]
        if name[1] != h.parameters[0] or not h.of_one_size:
            continue
        left = gram.A[j, j] - gram.A[base, j] @ H @ gram.A[base, j]
        need = 2.0 * gram.scatter[j] * (np.log(rules.CLAIM) + 6.0 + 0.5 * np.log1p(max(left, 0.0)))
        least = float(h.scale[0] * np.sqrt(need / max(left, 1e-12)))
        if h.error not in out or least < out[h.error][1]:
            out[h.error] = h, least
    return tuple(out.values())
