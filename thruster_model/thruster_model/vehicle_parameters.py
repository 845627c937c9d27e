"""The parameters of a vehicle: what each is, with unit and admissible range.

Axes are those of nu: u, v, w, p, q, r (surge, sway, heave, roll, pitch, yaw). Added mass A, linear drag L and quadratic
drag Q are positive numbers, `A_u` the entry of M_A for surge; a pair, `A_uq`, is an entry beside the diagonal, for A on
both sides of it, for L and Q the force along the first axis by motion along the second.
"""

import re
from functools import lru_cache

import numpy as np

from thruster_model.model import ParameterDefinition

__all__ = ["AXES", "AXIS_NAMES", "REQUIRED", "defined", "definition_of", "matrix_of"]

AXES = "uvwpqr"
AXIS_NAMES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
_UNITS = {
    "A": {0: "kg", 1: "kg m", 2: "kg m^2"},
    "L": {0: "N s/m", 1: "N s", 2: "N m s"},
    "Q": {0: "N s^2/m^2", 1: "N s^2/m", 2: "N m s^2"},
}
_WORDS = {"A": "added mass", "L": "linear drag", "Q": "quadratic drag"}
_PLAIN = {
    "mass": ("kg", "mass", 1e-6, 1e6, 10.0),
    "volume": ("m^3", "displaced volume", 1e-9, 1e3, 0.01),
    "net_buoyancy": ("N", "buoyancy less weight, in place of `volume`", -1e6, 1e6, 1.0),
    "density": ("kg/m^3", "density of the water", 900.0, 1100.0, 1000.0),
    "gravity": ("m/s^2", "acceleration of gravity", 9.7, 9.9, 9.81),
    "reaction_torque": ("N m s^2", "torque of a propeller per n|n|", 0.0, 1e-2, 2.5e-5),
    **{f"{a}_{p}": ("m", f"centre of {word}, {a}", -10.0, 10.0, 0.1)
       for p, word in (("G", "mass"), ("B", "buoyancy")) for a in "xyz"},
    **{f"I_{a}": ("kg m^2", f"inertia about {a} through the centre of mass", 1e-9, 1e6, 0.3) for a in "xyz"},
    **{f"I_{a}": ("kg m^2", f"product of inertia {a}", -1e6, 1e6, 0.1) for a in ("xy", "xz", "yz")},
}  # fmt: skip
DIAGONALS = tuple(f"{kind}_{axis}" for kind in "ALQ" for axis in AXES)
REQUIRED = ("mass", "volume", "z_B", "I_x", "I_y", "I_z", *DIAGONALS)
"""What every vehicle's set states; all others are zero, or the water's, where they are not stated. In place of the
volume it may state the net buoyancy: whoever trims a vehicle knows that to a newton, mass and volume to 10 N."""
DEFAULTS = {"density": 1000.0, "gravity": 9.81}


@lru_cache(maxsize=1024)
def definition_of(name: str) -> ParameterDefinition | None:
    """Return what a parameter is, or None where no vehicle has it."""
    if name in _PLAIN:
        unit, meaning, lower, upper, scale = _PLAIN[name]
        return ParameterDefinition(
            name=name, unit=unit, meaning=meaning, lower=lower, upper=upper, scale=scale, role="given"
        )
    entry = _entry(name)
    if entry is None or (len(name) == 4 and name[2] == name[3]):
        return None
    kind, row, column = entry
    if kind == "A" and column < row:
        return None
    turns = (row >= 3) + (column >= 3)
    unit = "N s^2" if kind == "Q" and row < 3 <= column else _UNITS[kind][turns]
    between = (" about the origin" if row >= 3 else "") if row == column else f" by {AXIS_NAMES[column]}"
    return ParameterDefinition(
        name=name, unit=unit, meaning=f"{_WORDS[kind]}, {AXIS_NAMES[row]}{between}",
        lower=0.0 if row == column else -1e6, upper=1e6, scale=1.0, role="given",
    )  # fmt: skip


def defined(name: str) -> ParameterDefinition:
    """Return what a parameter is that a set of a vehicle has."""
    definition = definition_of(name)
    assert definition is not None, name
    return definition


def matrix_of(kind: str, values: dict[str, float]) -> np.ndarray:
    """Return M_A, D_L or D_Q (6, 6), kind A, L or Q, of the values by name."""
    matrix = np.zeros((6, 6))
    for name, value in values.items():
        entry = _entry(name)
        if entry is not None and entry[0] == kind:
            _, row, column = entry
            matrix[row, column] = value
            if kind == "A":
                matrix[column, row] = value
    return matrix


@lru_cache(maxsize=1024)
def _entry(name: str) -> tuple[str, int, int] | None:
    """Return matrix, row and column that a name stands for, None where it stands for none."""
    match = re.fullmatch(r"([ALQ])_([uvwpqr])([uvwpqr])?", name)
    return None if match is None else (match[1], AXES.index(match[2]), AXES.index(match[3] or match[2]))
