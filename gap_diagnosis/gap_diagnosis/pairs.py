"""Two effects at once: the best second for the best single effect, then the best first for that second."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.candidate import Candidate, examined, extended, is_likely, with_air
from gap_diagnosis.fitting import fit
from gap_diagnosis.screening import rated, tried
from gap_diagnosis.suspects import Suspect

__all__ = ["pairs_of", "with_parts"]

Array = NDArray[np.float64]

_PAIRS = 4


def pairs_of(
    none: Candidate,
    singles: Sequence[Candidate],
    suspects: Sequence[Suspect],
) -> list[Candidate]:
    """Return pairs: the best seconds for the best of `singles`, then the best firsts for the best second."""
    found: dict[frozenset[str], Candidate] = {}
    noise = none.noise

    def keep(candidates: Sequence[Candidate]) -> None:
        for candidate in candidates:
            key = frozenset(candidate.keys)
            if key not in found or candidate.evidence > found[key].evidence:
                found[key] = candidate

    def extend(single: Candidate) -> None:
        others = [s for s in suspects if s.effect != single.suspects[0].effect]
        screened = rated(single.fitted, noise, tried(single.fitted, noise, others))
        likely = [each for each in screened[:_PAIRS] if each.criterion > 0.0]
        keep([extended(single, each, is_likely(each, screened)) for each in likely])

    extend(singles[0])
    if found:
        best = max(found.values(), key=lambda c: c.evidence)
        second = best.suspects[1]
        alone = next((s for s in singles if s.keys == (second.key,)), None)
        if alone is None:
            alone = _alone(none, second, none.fitted.x, best.fitted.x[-len(second.slots) :])
        if best.suspects[0].effect == "ventilation":
            # Gates decoded without the second effect have patched what it leaves.
            aired = with_air(alone)
            keep([aired] if aired is not None and not aired.nameless else [])
        else:
            extend(alone)
    return list(found.values())


def with_parts(ranked: Sequence[Candidate], none: Candidate) -> list[Candidate]:
    """Return hypotheses with both effects of a leading pair by themselves too, fitted from where they are in it.

    Some single effects have several valleys: the fit of a pair may have found a better one of them than its own did.
    """
    pair, found = ranked[0], {each.keys: each for each in ranked}
    if len(pair.suspects) < 2 or pair.fitted.problem.gates:
        return list(ranked)
    nuisances = none.fitted.problem.nuisances
    sizes = dict(zip(pair.fitted.problem.slots, pair.fitted.x[nuisances:], strict=True))
    for suspect in pair.suspects:
        start = np.array([sizes[slot] for slot in suspect.slots])
        alone = _alone(none, suspect, pair.fitted.x[:nuisances], start)
        known = found.get(alone.keys)
        if known is None or alone.fitted.cost < known.fitted.cost - 1.0:
            found[alone.keys] = alone
    return examined(list(found.values()), none.noise)


def _alone(none: Candidate, suspect: Suspect, nuisances: Array, sizes: Array) -> Candidate:
    problem = none.fitted.problem.with_effects(suspect.slots)
    fitted = fit(problem, none.noise, np.concatenate((nuisances, sizes)), iterations=25)
    evidence = fitted.evidence - none.fitted.evidence
    return replace(none, suspects=(suspect,), fitted=fitted, evidence=evidence, unexplained=None)
