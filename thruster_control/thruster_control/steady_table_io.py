"""Measured steady states from a file: rows of throttle [V], thrust [N], torque [N m], speed [rad/s], axial flow [m/s].

Comma-separated, without a header, as the rig's Steady_State_Data.csv.
"""

from pathlib import Path

import numpy as np

from thruster_control.errors import SteadyStatesError
from thruster_control.steady_table import force_table
from thruster_model.force_table import ForceTable

__all__ = ["read_steady_states"]

_COLUMNS = ("throttle [V]", "thrust [N]", "torque [N m]", "speed [rad/s]", "axial flow [m/s]")


def read_steady_states(path: Path, *, supply: float, edges: tuple[float, float] | None = None) -> ForceTable:
    """Return the file's steady states as a table over the throttle; `supply` [V], `edges` [V]: see `force_table`.

    Raises:
        SteadyStatesError: the file cannot be read, or its rows are others than those above.
    """
    try:
        rows = np.loadtxt(path, delimiter=",", ndmin=2, encoding="utf-8")
    except (OSError, ValueError) as error:
        raise SteadyStatesError(str(path), [f"expected rows of numbers; found {error}"]) from error
    if rows.shape[1] != len(_COLUMNS):
        expected = f"{len(_COLUMNS)} columns ({', '.join(_COLUMNS)})"
        raise SteadyStatesError(str(path), [f"expected {expected}; found {rows.shape[1]}"])
    return force_table(rows[:, 0], rows[:, 1], rows[:, 3], supply=supply, source=str(path), edges=edges)
