"""One set of effects, fitted beside all that moves at random, with the evidence for it."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from system_identification.fitting import Fitted, fit
from system_identification.learning import Caps, learned
from system_identification.loose import Loose, groups_of, learned_levels
from system_identification.noise import Whitener, whitener
from system_identification.suspects import Suspect

__all__ = ["Hypothesis", "weighed"]

Array = NDArray[np.float64]
_SHARES = (1.0, 0.4)
"""Of the way from the noise that was known to the one that was learned, which are tried."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Hypothesis:
    """A set of suspects, fitted under the noise that is most likely beside them.

    Attributes:
        suspects: at work together; none: re-tuned parameters alone.
        fitted: all unknowns.
        noise: learned from what this hypothesis leaves.
        loose: what moves from run to run, and what effects may be off.
    """

    suspects: tuple[Suspect, ...]
    fitted: Fitted
    noise: Whitener
    loose: Loose

    @property
    def keys(self) -> tuple[str, ...]:
        """Names of the suspects."""
        return tuple(each.key for each in self.suspects)

    @property
    def evidence(self) -> float:
        """Logarithm of the probability of the rows, nats, less what searched sizes cost."""
        return self.fitted.evidence - sum(each.price for each in self.suspects)

    @property
    def system(self) -> Any:
        """A `System` with the suspects' sizes as unknowns."""
        return self.fitted.problem

    def sizes_of(self, suspect: Suspect) -> Array:
        """Return where the unknown sizes of a suspect stand among the unknowns."""
        slots = list(self.system.slots)
        return np.array([self.system.nuisances + slots.index(slot) for slot in suspect.slots])


def weighed(
    system: Any,
    suspects: tuple[Suspect, ...],
    x: Array,
    noise: Whitener,
    *,
    caps: Caps | None = None,
    iterations: int = 10,
    steps: int = 3,
    near: Fitted | None = None,
    polish: bool = True,
    wild: Array | None = None,
) -> Hypothesis:
    """Return a set of suspects, fitted from x, and the noise that is most likely beside it.

    Args:
        system: with the sizes of the suspects as unknowns.
        suspects: of the set.
        x: where to start.
        noise: under which the first fit is made.
        caps: what noise may be.
        iterations: of that fit.
        steps: of the search for the noise's levels.
        near: a fit whose sensitivities to the nuisances serve at first.
        polish: end with sensitivities of its own.
        wild: how many times less single rows count, (R,); None: as they stand out of what is left.
    """
    caps = caps or Caps()

    def tamed(bare: Whitener, rows: Array) -> Whitener:
        return bare.tamed(rows) if wild is None else replace(bare, wild=wild, loose=None)

    first = fit(system, noise, x, iterations=iterations, near=near, polish=polish)
    groups = groups_of(first, suspects)

    def beside(bare: Whitener) -> Hypothesis:
        """Return the hypothesis as it is fitted, with what is loose beside a noise."""
        loose, here, whole = learned_levels(first, bare, groups)
        return Hypothesis(suspects=suspects, fitted=here, noise=whole, loose=loose)

    bare = tamed(whitener(system, first.x, noise.levels), first.residuals)
    found = beside(bare)
    rows = first.residuals - found.loose.explained
    anew = learned(bare, rows, caps, steps=steps, taken=first.x.size)
    # Noise was learned from what is left beside what is loose; both together are what counts.
    for share in _SHARES:
        tried = beside(tamed(replace(anew, levels=noise.levels.towards(anew.levels, share)), rows))
        if tried.evidence > found.evidence:
            found = tried
            break
    again = fit(system, found.noise, first.x, iterations=4, near=first, polish=False)
    return replace(found, fitted=again)
