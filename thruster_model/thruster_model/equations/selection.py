"""Choose between two values: `np.where` for arrays, a plain branch in kernels, where `np.where` would make arrays."""

from typing import Any

import numpy as np
from numba.extending import overload


def selected(condition: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where the condition holds, else `no`; arguments broadcast, in kernels they are scalars."""
    return np.where(condition, yes, no)


@overload(selected)
def _compile_selected(condition, yes, no):  # type: ignore[no-untyped-def]
    return lambda condition, yes, no: yes if condition else no
