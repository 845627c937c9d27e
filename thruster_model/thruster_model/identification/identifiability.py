"""What the data do not determine, parameter by parameter, in plain words."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thruster_model.models import Model

__all__ = ["Determination", "determinations"]

Array = NDArray[np.float64]
_NEAR = 1e-3
"""Distance from its bound, over its prior deviation, within which a parameter is as good as there."""


@dataclass(frozen=True, kw_only=True)
class Determination:
    """How far the data determine one parameter.

    `status` is "determined", "traded off", "flat", "at a bound" or "not excited"; `sentence` says it with numbers;
    `partners` are the parameters it is traded off against; `settled`: it lies at its bound, and the data keep it near.
    """

    name: str
    status: str
    sentence: str
    partners: tuple[str, ...] = ()
    settled: bool = False


def determinations(
    model: Model,
    names: Sequence[str],
    values: Array,
    deviations: Array,
    correlation: Array,
    influence: Array,
    prior_deviations: Array,
    *,
    least_influence: float = 1.0,
    flat_share: float = 0.5,
    strong_correlation: float = 0.95,
) -> tuple[Determination, ...]:
    """Judge each free parameter.

    Args:
        model: whose parameters they are.
        names: of the free parameters, (P,).
        values, deviations: estimates and standard deviations in the parameters' units, (P,).
        correlation: of the estimates, (P, P).
        influence: by how many noise standard deviations (root sum of squares over all data) the predictions move
            when the parameter moves by its prior standard deviation, (P,).
        prior_deviations: (P,).
        least_influence: below this the data say nothing: not excited.
        flat_share: a standard deviation above this share of the prior's is flat: the prior decides.
        strong_correlation: from which on two parameters are traded off.
    """
    result = []
    for k, name in enumerate(names):
        definition = model.definition(name)
        partners = tuple(names[int(j)] for j in np.flatnonzero(np.abs(correlation[k]) > strong_correlation) if j != k)
        unit = "" if definition.unit == "1" else f" {definition.unit}"
        stated = f"{values[k]:.4g} ± {deviations[k]:.2g}{unit}"
        bound = min((definition.lower, definition.upper), key=lambda limit: abs(values[k] - limit))
        from_bound, exactly = abs(values[k] - bound), 1e-6 * prior_deviations[k]
        flat = deviations[k] > flat_share * prior_deviations[k]
        if influence[k] < least_influence:
            status, sentence = "not excited", f"the data do not respond to it; it stays at {values[k]:.4g}{unit}"
        elif from_bound <= max(deviations[k], exactly):
            status, sentence = "at a bound", f"{stated}: cannot be told from its bound, {bound:g}{unit}"
        elif flat:
            status = "flat"
            sentence = f"{stated}: hardly narrower than before the fit (± {prior_deviations[k]:.2g}{unit})"
        elif partners:
            strongest = max(partners, key=lambda partner: abs(correlation[k, names.index(partner)]))
            largest = correlation[k, names.index(strongest)]
            status = "traded off"
            sentence = (
                f"{stated}, but only together with {', '.join(partners)} (correlation {largest:+.3f} with {strongest})"
            )
        else:
            status, sentence = "determined", stated
        settled = status == "at a bound" and from_bound <= _NEAR * prior_deviations[k] and not flat
        result.append(
            Determination(name=name, status=status, sentence=sentence, partners=partners, settled=bool(settled))
        )
    return tuple(result)
