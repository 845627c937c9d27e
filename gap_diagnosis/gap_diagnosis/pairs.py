"""Two effects at once: the best second for the best single effect, then the best first for that second."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.candidate import Candidate, examined, extended, is_likely, with_air
from gap_diagnosis.fitting import fit_from_afar
from gap_diagnosis.screening import rated, tried
from gap_diagnosis.suspects import ROUNDED, SEARCHED, Suspect

__all__ = ["pairs_of", "with_parts"]

Array = NDArray[np.float64]

_PAIRS = 4
_RESOLVED = 5e-4
"""Time [s] below which an effect beside another is none: the stairs of a lagging command are four times as long."""

_NOT_BESIDE = dict.fromkeys((SEARCHED, ROUNDED), (SEARCHED, ROUNDED))
"""What is not looked for beside an effect: a converter's lattice hides in what another one leaves."""


def pairs_of(
    none: Candidate,
    singles: Sequence[Candidate],
    suspects: Sequence[Suspect],
    least: float = 0.0,
) -> list[Candidate]:
    """Return pairs: the best seconds for the best of `singles`, then the best firsts for the best second.

    `least`: first rating that a second effect must have.
    """
    found: dict[frozenset[str], Candidate] = {}
    noise = none.noise

    def keep(candidates: Sequence[Candidate]) -> None:
        for candidate in candidates:
            key = frozenset(candidate.keys)
            if key not in found or candidate.evidence > found[key].evidence:
                found[key] = candidate

    def extend(single: Candidate, least: float) -> None:
        first = single.suspects[0].effect
        others = [s for s in suspects if s.effect not in _NOT_BESIDE.get(first, (first,))]
        screened = rated(single.fitted, noise, tried(single.fitted, noise, others))
        likely = [each for each in screened[:_PAIRS] if each.criterion > least]
        keep(
            [
                c
                for c in (extended(single, each, is_likely(each, screened)) for each in likely)
                if not c.is_shorter(c.suspects[-1], _RESOLVED)
            ]
        )

    extend(singles[0], least)
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
            extend(alone, 0.0)
    return list(found.values())


def with_parts(ranked: Sequence[Candidate], none: Candidate) -> list[Candidate]:
    """Return hypotheses with both effects of a leading pair by themselves too, fitted from where they are in it.

    Some single effects have several valleys, and readings that jump hold a fit: that of a pair may have found a better
    place for one of them than its own did, and the other would have the credit.
    """
    found = {each.keys: each for each in ranked}
    asked: set[tuple[str, ...]] = set()
    best = ranked[0]
    while len(best.suspects) == 2 and best.keys not in asked:
        asked.add(best.keys)
        for alone in _parts(best, none):
            known = found.get(alone.keys)
            if known is None or alone.evidence > known.evidence + 0.5:
                found[alone.keys] = alone
        best = max(found.values(), key=lambda each: each.evidence)
    return examined(list(found.values()), none.noise) if asked else list(ranked)


def _parts(pair: Candidate, none: Candidate) -> list[Candidate]:
    """Return the effects of a pair by themselves, gates with those that need them."""
    nuisances = pair.fitted.problem.nuisances
    sizes = dict(zip(pair.fitted.problem.slots, pair.fitted.x[nuisances:], strict=True))
    parts = []
    for suspect in pair.suspects:
        start = np.array([sizes[slot] for slot in suspect.slots])
        gated = suspect.effect == "ventilation"
        gates = pair.fitted.problem.gates if gated else ()
        alone = _alone(none, suspect, pair.fitted.x[:nuisances], start, gates)
        parts.append(replace(alone, evidence=alone.evidence + pair.switches(none)) if gated else alone)
    return parts


def _alone(
    none: Candidate, suspect: Suspect, nuisances: Array, sizes: Array, gates: tuple[Array, ...] = ()
) -> Candidate:
    problem = none.fitted.problem.with_effects(suspect.slots, gates)
    fitted = fit_from_afar(problem, none.noise, np.concatenate((nuisances, sizes)))
    evidence = fitted.evidence - none.fitted.evidence
    return replace(none, suspects=(suspect,), fitted=fitted, evidence=evidence, unexplained=None)
