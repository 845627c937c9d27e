"""What a vehicle's kernels work with: numbers of the body, one row of numbers per thruster, one sheet to work on.

Kernels that take dozens of arrays spend their time on counting who holds them. So the body's numbers are tuples, what
belongs to a thruster is a row of one array, and the state and all that a step needs are rows of one sheet.

Sheet, columns of its rows: position (3) [m], attitude (4), nu (6), then (N,) each of rotor speed [rad/s], axial flow
[m/s], acting throttle [V], heat. Row STATE is the state; from row MEMORY on, where there are effects, is what effects
of the command remember, a row for each thruster; kernels work in the other rows.
"""

from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_model.errors import VehicleError
from thruster_model.thruster_rows import ThrusterRows, rows_of
from thruster_model.vehicle_coefficients import VehicleCoefficients

__all__ = [
    "AFTER", "AMBIENT", "AT", "AXIAL", "BEFORE", "BODY", "END", "FIRST", "FORWARD", "GAINED", "INFLOW", "INTERACTION",
    "LATE", "LEFT", "MEMORY", "MIDDLE", "PLACE", "REACHED", "REACTION", "REVERSE", "SCALE", "SLOPE", "SPEED", "STATE",
    "TAU", "THRUST", "TORQUE", "TURNING", "WIRING", "Body", "Tables", "empty_sheet", "tables_of",
]  # fmt: skip

Array = NDArray[np.float64]
Vector = tuple[float, ...]
Matrix = tuple[Vector, ...]

BODY = 13
"""Columns of the body's state; those of the thrusters follow."""
(
    STATE, AT, SLOPE, GAINED, FIRST, MIDDLE, END, REACHED, SPEED, AXIAL, AMBIENT, THRUST, TORQUE, LEFT, TAU, BEFORE,
    LATE, AFTER, MEMORY,
) = range(19)  # fmt: skip
"""Rows of the sheet: state; where rates are taken; rates; what a step gains; throttles at the beginning, the middle and
the end of a piece; throttles aimed at; rotor speeds, axial and ambient flows, thrusts and torques where rates were last
taken; what others leave of the thrusts; wrench; throttles commanded at the beginning of a step, until when [s], and
then; memory of the first thruster."""
FORWARD, REVERSE, INFLOW, SCALE, TURNING, WIRING, REACTION, PLACE, INTERACTION = 0, 6, 12, 18, 19, 20, 21, 24, 27
"""First columns of a thruster's row: see `VehicleCoefficients`; the last ones are shares lost per newton of each."""
_WORST_CONDITION = 1e12


class Body(NamedTuple):
    """Numbers of body and water: see `VehicleCoefficients`; M = M_RB + M_A; which of the rarer terms act."""

    M: Matrix
    M_inverse: Matrix
    D_L: Matrix
    D_Q: Matrix
    weight: float
    buoyancy: float
    r_G: Vector
    r_B: Vector
    current: Vector
    tether: Vector
    ram: float
    supply: float
    sag: float
    stir: float
    interacts: bool
    reacts: bool
    tethered: bool
    sags: bool


class Tables(NamedTuple):
    """All that a kernel takes of a vehicle: body, layout (N, 27 + N), coefficients and effects of the thrusters."""

    body: Body
    layout: Array
    p: ThrusterRows
    e: ThrusterRows


def empty_sheet(thrusters: int, memory: int | None = None) -> Array:
    """Return a sheet for so many thrusters; memory: floats that each one's effects of the command remember, if any."""
    width = BODY + 4 * thrusters
    if memory is None:
        return np.zeros((MEMORY, width))
    return np.zeros((MEMORY + thrusters, max(width, memory)))


def tables_of(c: VehicleCoefficients, thrusters: Any, effects: Any) -> Tables:
    """Return the tables of a vehicle.

    Args:
        c: of N thrusters.
        thrusters: N coefficients of one class, see `equations.classes`.
        effects: N `EffectValues`, or N `NO_EFFECTS`.

    Raises:
        VehicleError: coefficients that are not finite, a matrix M that no motion follows from, numbers of thrusters
            that differ, thrusters of several classes.
    """
    problems = [
        f"{name}: expected finite numbers; found {np.asarray(value)[~np.isfinite(value)][0]}"
        for name, value in c._asdict().items()
        if not np.all(np.isfinite(value))
    ]
    N = c.thrusters
    problems += [
        f"{what}: expected {N}, one for each column of K_t; found {len(given)}"
        for what, given in (("thrusters", thrusters), ("effects", effects))
        if len(given) != N
    ]
    M = np.asarray(c.mass_matrix, dtype=np.float64)
    if not problems and not _condition(M.tobytes()) < _WORST_CONDITION:
        problems.append(
            "M = M_RB + M_A: expected a matrix with an inverse; found a singular one: some motion has neither mass nor "
            f"added mass (rank {np.linalg.matrix_rank(M)} of 6)"
        )
    if problems:
        raise VehicleError("vehicle", problems)
    try:
        p, e = rows_of(thrusters), rows_of(effects)
    except ValueError as error:
        raise VehicleError("vehicle", [f"thrusters: {error}"]) from error
    columns = [c.K_t, c.K_t_reverse, c.inflow, c.thrust_scale, c.turning, c.wiring, c.reaction]
    columns += [c.positions, c.interaction]
    body = Body(
        M=_rows(M), M_inverse=_inverse(M.tobytes()), D_L=_rows(c.D_L), D_Q=_rows(c.D_Q), weight=float(c.weight),
        buoyancy=float(c.buoyancy), r_G=_vector(c.r_G), r_B=_vector(c.r_B), current=_vector(c.current),
        tether=_vector(c.tether), ram=float(c.ram), supply=float(c.supply), sag=float(c.sag), stir=float(c.stir),
        interacts=bool(np.any(c.interaction)), reacts=bool(np.any(c.reaction)), tethered=bool(c.tether[0]),
        sags=bool(c.sag),
    )  # fmt: skip
    return Tables(body, np.ascontiguousarray(np.vstack(columns).T, dtype=np.float64), p, e)


@lru_cache(maxsize=512)
def _condition(M: bytes) -> float:
    return float(np.linalg.cond(np.frombuffer(M).reshape(6, 6)))


@lru_cache(maxsize=512)
def _inverse(M: bytes) -> Matrix:
    return _rows(np.linalg.inv(np.frombuffer(M).reshape(6, 6)))


def _vector(values: Any) -> Vector:
    return tuple(np.asarray(values, dtype=np.float64).tolist())


def _rows(matrix: Any) -> Matrix:
    return tuple(map(tuple, np.asarray(matrix, dtype=np.float64).tolist()))
