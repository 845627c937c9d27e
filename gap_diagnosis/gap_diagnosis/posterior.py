"""Probabilities of all hypotheses: none, single effects, pairs, and each of them with something unknown beside it.

Priors are those of somebody who has a reason to ask: eight times in nine something is wrong, be it too small to be
seen. So "none" stays modest, however well the model fits, and what is claimed is decided beside it (`verdict`). Where
the log shows an effect in the samples themselves, another one beside it is as rare as a pair. With these the first
candidate's probability is calibrated on simulated cases. Evidence is divided by how far the noise exceeds the samples'
own (a tempered likelihood), and mixed with the prior by a share of lapses: certainty is not to be had. What is not
refitted counts by its screening. An effect that is no more than conventions leave open counts as none. The equation of
an effect is an idealisation: beside one that explains much, a second one, or something unknown, pays for what its
shape may be off. So does whatever is held against none for what integrators and conventions disagree about; and what
parts two effects that explain alike counts by how far it exceeds that.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import softmax

from gap_diagnosis.candidate import Candidate
from gap_diagnosis.investigation import Investigation

__all__ = ["Posterior", "posterior_of"]

PRIOR_NONE = 0.10
PRIOR_SINGLE = 0.63
PRIOR_PAIR = 0.12
PRIOR_UNKNOWN = 0.04  # beside none; beside effects in the same proportion to them
LAPSE = 0.01
"""Share of simulated cases in which what seemed certain was wrong: stated probabilities are mixed with the prior by it.
"""

SHAPE = 0.03
"""Share of an effect's trace by which the real one may differ from its equation."""

Hypothesis = tuple[str, tuple[str, ...]]
"""Known or unknown (something nameless beside the rest), and the keys of the suspects at work."""


@dataclass(frozen=True, kw_only=True)
class Posterior:
    """Probabilities: of none and of unknown, of each single suspect by key (marginal, where pairs are in play), of
    each pair by its keys; `beside`: of each suspect with something unknown beside it, all in `unknown`; `leading`: the
    most probable hypothesis of effects alone, None where no effect was weighed; `prior`: before the recordings.
    """

    none: float
    unknown: float
    singles: Mapping[str, float]
    pairs: Mapping[tuple[str, ...], float]
    beside: Mapping[str, float]
    leading: Candidate | None = None
    prior: "Posterior | None" = None

    @property
    def marginal(self) -> dict[str, float]:
        """Probability that a suspect is at work, alone or in a pair, by key."""
        result = dict(self.singles)
        for keys, probability in self.pairs.items():
            for key in keys:
                result[key] = result.get(key, 0.0) + probability
        return result

    def of(self, keys: tuple[str, ...]) -> float:
        """Return the probability that just these suspects are at work, one or two."""
        return self.singles[keys[0]] if len(keys) == 1 else self.pairs[keys]

    @property
    def stated(self) -> "Posterior":
        """What a reader is told: the same, mixed with the prior by the share of lapses."""
        if self.prior is None:
            return self

        def mixed(seen: Mapping[Any, float], expected: Mapping[Any, float]) -> dict[Any, float]:
            return {key: (1.0 - LAPSE) * seen[key] + LAPSE * expected[key] for key in seen}

        return replace(
            self,
            none=(1.0 - LAPSE) * self.none + LAPSE * self.prior.none,
            unknown=(1.0 - LAPSE) * self.unknown + LAPSE * self.prior.unknown,
            singles=mixed(self.singles, self.prior.singles),
            pairs=mixed(self.pairs, self.prior.pairs),
            beside=mixed(self.beside, self.prior.beside),
            prior=None,
        )


def posterior_of(found: Investigation, *, scatters: bool = False) -> Posterior:
    """Return the probabilities of all hypotheses that were weighed.

    Args:
        found: the hypotheses.
        scatters: whether an effect is at work that only scatters the samples; all others are then beside it.
    """
    count = max(len(found.screened), 1)
    alone, single, pair = PRIOR_NONE, PRIOR_SINGLE, PRIOR_PAIR
    if scatters:
        alone, single, pair = PRIOR_SINGLE, PRIOR_PAIR, PRIOR_PAIR**2 / PRIOR_SINGLE
    shares = np.log([alone, single / count, pair / max(count * (count - 1) / 2.0, 1.0)])
    doubt = np.log(PRIOR_UNKNOWN / (1.0 - PRIOR_UNKNOWN))
    nameless = found.stretches.evidence if found.stretches is not None else -np.inf
    evidence: dict[Hypothesis, float] = {
        ("known", ()): found.inexact,
        ("unknown", ()): max(_unexplained(found.none), nameless),
    }
    alone_explains = {c.named[0]: c.evidence for c in found.candidates if len(c.named) == 1}
    for candidate in found.candidates:
        known, unknown = ("known", candidate.named), ("unknown", candidate.named)
        nats = candidate.evidence
        if len(candidate.named) == 2:
            nats -= _for_shape(_explained_by_shape(candidate, alone_explains))
        if not candidate.pressed:
            evidence[known] = max(nats, evidence.get(known, -np.inf))
        else:
            evidence.setdefault(known, -np.inf)
        if candidate.unexplained is not None or candidate.pressed:
            # A pair that still leaves something has explained a wrong shape by a second effect.
            left = nats + _unexplained(candidate)
            left -= _for_shape(_explained_by_shape(candidate, alone_explains)) if len(candidate.named) == 1 else 0.0
            evidence[unknown] = max(left, evidence.get(unknown, -np.inf))
    for screened in found.screened:
        evidence.setdefault(("known", (screened.suspect.key,)), min(screened.criterion, 0.0) - 2.0)
    singles = [each for each in evidence if each[0] == "known" and len(each[1]) == 1]
    best = max((evidence[each] for each in singles), default=0.0)
    evidence |= {each: best - _beyond_shape(best - evidence[each], best) for each in singles}
    priors = {(kind, keys): shares[len(keys)] + (doubt if kind == "unknown" else 0.0) for kind, keys in evidence}
    seen = _shared({each: priors[each] + nats / found.beyond_sensors for each, nats in evidence.items()})
    return replace(seen, leading=_leading(found.candidates, seen), prior=_shared(priors))


def _explained_by_shape(candidate: Candidate, alone: Mapping[str, float]) -> float:
    """Return what an effect, or the larger one of two, explains by a shape that may be off.

    A thruster that is wired the wrong way round has no size and no shape: of such a pair the rest is the other one's.
    """
    exact = {s.key for s in candidate.suspects if all(slot.lower == slot.upper for slot in s.slots)}
    if exact:
        return candidate.evidence - max(alone.get(key, 0.0) for key in exact)
    return max(alone.get(key, 0.0) for key in candidate.named)


def _for_shape(explained: float) -> float:
    """Return what something beside an effect that explains so much pays for the shape of that."""
    return SHAPE**2 * max(explained, 0.0)


def _beyond_shape(behind: float, explained: float) -> float:
    """Return by how much an effect is really behind another one that explains so much: what its shape may be is not."""
    return behind * behind / (behind + _for_shape(explained)) if np.isfinite(behind) and behind > 0.0 else behind


def _shared(weights: Mapping[Hypothesis, float]) -> Posterior:
    """Return probabilities in proportion to weights, which are logarithms."""
    probability = dict(zip(weights, softmax(list(weights.values())).tolist(), strict=True))
    beside: dict[str, float] = {}
    for (kind, keys), p in probability.items():
        for key in keys if kind == "unknown" else ():
            beside[key] = beside.get(key, 0.0) + p
    return Posterior(
        none=probability["known", ()],
        unknown=sum(p for (kind, _), p in probability.items() if kind == "unknown"),
        singles={keys[0]: p for (kind, keys), p in probability.items() if kind == "known" and len(keys) == 1},
        pairs={keys: p for (kind, keys), p in probability.items() if kind == "known" and len(keys) == 2},
        beside=beside,
    )


def _unexplained(candidate: Candidate) -> float:
    """Return the logarithm of evidence for an unknown part; where nothing was found it costs as much as a search.

    What only resembles an effect, as that would have to be larger than is plausible, is unknown by itself.
    """
    if candidate.pressed:
        return max(candidate.unexplained.evidence, 0.0) if candidate.unexplained else 0.0
    return candidate.unexplained.evidence if candidate.unexplained and candidate.unexplained.features else -3.0


def _leading(candidates: Sequence[Candidate], seen: Posterior) -> Candidate | None:
    named = [candidate for candidate in candidates if candidate.named]
    best = max(named, key=lambda c: (seen.of(c.named), c.evidence), default=None)
    return best if best is not None and seen.of(best.named) > 0.0 else None
