"""Which effects earn their place on runs left out: for models that are wrong in more ways than have a name.

There evidence says little: noise, pushes and colour take up what has no name, and with them what an effect does. So
effects are added one at a time, each fitted for free runs, as they bring free runs of runs left out nearer. Which one
is the best is asked anew without each run: where that differs from run to run, none of them is the cause (cross-
validatory choice: Stone 1974, J. R. Stat. Soc. B 36:111).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from system_identification.fitting import Fitted, fit
from system_identification.hypothesis import Hypothesis
from system_identification.left_out import LeftOut, fit_to_free_runs, foreseen, helps_by, left_out
from system_identification.noise import Whitener
from system_identification.rating import rated, tried
from system_identification.suspects import Suspect

__all__ = ["Earned", "earned"]

Array = NDArray[np.float64]
_FITTED = 6
"""Suspects that are fitted in a step: those that promise most."""
_MOST = 4
_EARNS = 0.9
"""Probability of helping on a new run that an effect must have."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Earned:
    """A set fitted for free runs.

    Attributes:
        found: the set; its noise is what free runs are off by.
        out: what fits that have not seen a run predict for it.
        helps: probability that the effect added last makes a new run more probable; None where there is none.
        chosen: share of the runs, each left out in turn, without which it is still the best of all.
    """

    found: Hypothesis
    out: LeftOut
    helps: float | None = None
    chosen: float | None = None


def earned(none: Hypothesis, offer: Callable[[Hypothesis], Sequence[Suspect]]) -> list[Earned]:
    """Return re-tuned parameters alone and, one after the other, the sets whose last effect earns its place."""
    chain = [_judged(none, (), *fit_to_free_runs(none.fitted, none.noise))]
    while len(chain) <= _MOST:
        better = _step(chain[-1], offer, none.noise)
        if better is None:
            break
        chain.append(better)
    return chain


def _judged(like: Hypothesis, suspects: tuple[Suspect, ...], fitted: Fitted, noise: Whitener) -> Earned:
    found = replace(like, suspects=suspects, fitted=fitted, noise=noise)
    return Earned(found=found, out=left_out(fitted, noise))


def _step(current: Earned, offer: Callable[[Hypothesis], Sequence[Suspect]], innovations: Whitener) -> Earned | None:
    found = current.found
    named = {each.effect for each in found.suspects}
    # What was read from all runs, as gates and steps of converters are, foresees none of them.
    foreseeing = [each for each in offer(found) if not each.gates and not each.price]
    suspects = [each for each in foreseeing if each.effect not in named]
    looks = rated(
        found.fitted, found.noise, tried(found.fitted, suspects, lambda s: found.system.tried(found.fitted.x, s))
    )
    tries = [_with(found, each.suspect, each.sizes) for each in looks[:_FITTED] if each.promise > 0.0]
    if not tries:
        return None
    gains, surer = (
        np.array([foreseen(noise, each.out.predicted) - foreseen(noise, current.out.predicted) for each in tries])
        for noise in (found.noise, innovations)
    )
    # Pushes move free runs at random: what brings these nearer must make innovations more probable as well.
    helps = np.array([min(helps_by(one), helps_by(other)) for one, other in zip(gains, surer, strict=True)])
    best = int(np.argmax(np.where(helps >= _EARNS, gains.sum(axis=1), -np.inf)))
    if helps[best] < _EARNS:
        return None
    without = gains.sum(axis=1, keepdims=True) - gains
    return replace(tries[best], helps=float(helps[best]), chosen=float(np.mean(np.argmax(without, axis=0) == best)))


def _with(found: Hypothesis, suspect: Suspect, sizes: Array) -> Earned:
    suspects = (*found.suspects, suspect)
    posed = found.system.with_effects(tuple(slot for each in suspects for slot in each.slots))
    start = fit(
        posed, found.noise, np.concatenate((found.fitted.x, sizes)), iterations=4, near=found.fitted, polish=False
    )
    return _judged(found, suspects, *fit_to_free_runs(start, found.noise))
