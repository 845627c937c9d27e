"""Two effects at once: the best second for the best single effect, then the best first for that second."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from gap_diagnosis.candidate import Candidate, extended, is_likely, with_air
from gap_diagnosis.fitting import fit
from gap_diagnosis.screening import rated, tried
from gap_diagnosis.suspects import Suspect

__all__ = ["pairs_of"]

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
            x = np.concatenate((none.fitted.x, best.fitted.x[-len(second.slots) :]))
            fitted = fit(none.fitted.problem.with_effects(second.slots), noise, x)
            evidence = fitted.evidence - none.fitted.evidence
            alone = replace(none, suspects=(second,), fitted=fitted, evidence=evidence)
        if best.suspects[0].effect == "ventilation":
            keep(with_air(alone))  # gates decoded without the second effect have patched what it leaves
        else:
            extend(alone)
    return list(found.values())
