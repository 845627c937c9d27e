"""What each effect of a fitted set does to the rows beside the others."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from system_identification.fitting import Fitted
from system_identification.suspects import Suspect

__all__ = ["traces_of"]


def traces_of(fitted: Fitted, suspects: Sequence[Suspect]) -> dict[str, NDArray[np.float64]]:
    """Return what each suspect does to the rows (R,) beside the others, by key."""
    system = fitted.problem
    if not suspects:
        return {}
    here = system.predicted(fitted.x)
    found = {}
    for suspect in suspects:
        kept = [k for k, slot in enumerate(system.slots) if slot not in suspect.slots]
        x = fitted.x[[*range(system.nuisances), *(system.nuisances + k for k in kept)]]
        without = system.with_effects(tuple(system.slots[k] for k in kept))
        found[suspect.key] = here - without.predicted(x)
    return found
