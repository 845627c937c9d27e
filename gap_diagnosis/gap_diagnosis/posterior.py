"""Probabilities of all hypotheses: none, single effects, pairs, and each of them with something unknown beside it.

Priors are those of somebody who has a reason to ask: six times in seven something is wrong, be it too small to be seen.
So "none" stays modest, however well the model fits, and what is claimed is decided beside it (`verdict`). With these
the first candidate's probability is calibrated on simulated cases; evidence needs no temperature there.
What is not refitted counts by its screening.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gap_diagnosis.candidate import Candidate
from gap_diagnosis.investigation import Investigation

__all__ = ["Posterior", "posterior_of"]

PRIOR_NONE = 0.15
PRIOR_SINGLE = 0.63
PRIOR_PAIR = 0.12
PRIOR_UNKNOWN = 0.04  # beside none; beside effects in the same proportion to them


@dataclass(frozen=True, kw_only=True)
class Posterior:
    """Probabilities: of none and of unknown, of each single suspect by key (marginal, where pairs are in play), of
    each pair by its keys; `beside`: of each suspect with something unknown beside it, all in `unknown`; `leading`: the
    most probable hypothesis without an unknown part, None for none.
    """

    none: float
    unknown: float
    singles: Mapping[str, float]
    pairs: Mapping[tuple[str, ...], float]
    beside: Mapping[str, float]
    leading: Candidate | None

    @property
    def marginal(self) -> dict[str, float]:
        """Probability that a suspect is at work, alone or in a pair, by key."""
        result = dict(self.singles)
        for keys, probability in self.pairs.items():
            for key in keys:
                result[key] = result.get(key, 0.0) + probability
        return result


def posterior_of(found: Investigation) -> Posterior:
    """Return the probabilities of all hypotheses that were weighed."""
    count = max(len(found.screened), 1)
    couples = count * (count - 1) / 2.0
    doubt = np.log(PRIOR_UNKNOWN / (1.0 - PRIOR_UNKNOWN))
    weights: list[tuple[str, tuple[str, ...], float]] = [("none", (), float(np.log(PRIOR_NONE)))]
    weights.append(("unknown", (), float(np.log(PRIOR_NONE) + doubt + _unexplained(found.none))))
    refitted = set()
    for candidate in found.candidates:
        share = PRIOR_SINGLE / count if len(candidate.suspects) == 1 else PRIOR_PAIR / couples
        weight = float(np.log(share) + candidate.evidence)
        kind = "single" if len(candidate.suspects) == 1 else "pair"
        weights.append((kind, candidate.keys, weight))
        if candidate.unexplained is not None:
            weights.append(("unknown", candidate.keys, weight + doubt + _unexplained(candidate)))
        if len(candidate.suspects) == 1:
            refitted.add(candidate.keys[0])
    for screened in found.screened:
        if screened.suspect.key not in refitted:
            evidence = min(screened.criterion, 0.0) - 2.0
            weights.append(("single", (screened.suspect.key,), float(np.log(PRIOR_SINGLE / count) + evidence)))
    top = max(weight for _, _, weight in weights)
    mass = sum(np.exp(weight - top) for _, _, weight in weights)
    probability = {(kind, keys): float(np.exp(weight - top) / mass) for kind, keys, weight in weights}
    singles = {keys[0]: p for (kind, keys), p in probability.items() if kind == "single"}
    pairs = {keys: p for (kind, keys), p in probability.items() if kind == "pair"}
    none = probability["none", ()]
    unknown = sum(p for (kind, _), p in probability.items() if kind == "unknown")
    beside: dict[str, float] = {}
    for (kind, keys), p in probability.items():
        for key in keys if kind == "unknown" else ():
            beside[key] = beside.get(key, 0.0) + p
    return Posterior(
        none=none,
        unknown=unknown,
        singles=singles,
        pairs=pairs,
        beside=beside,
        leading=_leading(found.candidates, singles, pairs),
    )


def _unexplained(candidate: Candidate) -> float:
    """Return the logarithm of evidence for an unknown part; where nothing was found it costs as much as a search."""
    return candidate.unexplained.evidence if candidate.unexplained and candidate.unexplained.features else -3.0


def _leading(
    candidates: Sequence[Candidate], singles: Mapping[str, float], pairs: Mapping[tuple[str, ...], float]
) -> Candidate | None:
    def probability(candidate: Candidate) -> float:
        return singles[candidate.keys[0]] if len(candidate.keys) == 1 else pairs[candidate.keys]

    best = max(candidates, key=probability, default=None)
    return best if best is not None and probability(best) > 0.0 else None
