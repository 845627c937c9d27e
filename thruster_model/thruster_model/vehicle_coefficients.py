"""The numbers of a vehicle: body, water, layout, and what effects change of them."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

__all__ = ["STIR", "VehicleCoefficients", "vehicle_coefficients"]

Array = NDArray[np.float64]
STIR = 1e-3
"""[m/s] Axial flow with which an idle thruster in a stream leaves v = 0, an equilibrium from which (4.4) turns away."""


class VehicleCoefficients(NamedTuple):
    """Body, water and layout of N thrusters, SI units, body axes unless said otherwise.

    M_RB, M_A, D_L, D_Q: (6, 6); weight, buoyancy: W, B [N]; r_G, r_B: (3,) [m]; current: v_c (3,), earth axes [m/s].
    K_t, K_t_reverse: (6, N), wrench of a newton of forward and of reverse thrust; inflow: (6, N), U = inflow^T nu_r.
    hands: (N,), +1 right-handed, -1 left-handed, 0 not known.
    Beyond the thesis, neutral where no effect is on: thrust_scale (N,) factors of the thrusts; interaction (N, N)
    [1/N], share of thrust j lost per newton of thruster i; reaction (3, N) [N m s^2], moment per n|n|; tether (4,):
    drag [N s^2/m^2] and anchor point [m]; ram: [N^0.5 s/m], force across a thruster's axis per velocity there and root
    of thrust; supply: relative voltage without load; sag: share of it lost with all thrusters at full; wiring (N,):
    whose command thruster i gets; turning (N,): 0 where a rotor is stuck, else 1; stir: [m/s], axial flow with which an
    idle thruster leaves v = 0. What only effects ask for: positions (3, N) [m] of the thrusters, full_thrust (N,) [N]
    at full throttle in still water, propeller_torque [N m s^2] per n|n|, density of the water [kg/m^3].
    """

    M_RB: Any
    M_A: Any
    D_L: Any
    D_Q: Any
    weight: float
    buoyancy: float
    r_G: Any
    r_B: Any
    K_t: Any
    inflow: Any
    current: Any
    hands: Any
    K_t_reverse: Any
    thrust_scale: Any
    interaction: Any
    reaction: Any
    tether: Any
    ram: float
    supply: float
    sag: float
    wiring: Any
    turning: Any
    stir: float
    positions: Any
    full_thrust: Any
    propeller_torque: float
    density: float

    @property
    def thrusters(self) -> int:
        """Number of thrusters."""
        return int(self.K_t.shape[1])

    @property
    def mass_matrix(self) -> Array:
        """M = M_RB + M_A (6, 6)."""
        return np.asarray(self.M_RB + self.M_A)


def vehicle_coefficients(
    *,
    M_RB: ArrayLike,
    M_A: ArrayLike,
    D_L: ArrayLike,
    D_Q: ArrayLike,
    weight: float,
    buoyancy: float,
    r_B: ArrayLike,
    K_t: ArrayLike,
    r_G: ArrayLike = (0.0, 0.0, 0.0),
    hands: ArrayLike | None = None,
    current: ArrayLike = (0.0, 0.0, 0.0),
    positions: ArrayLike | None = None,
    propeller_torque: float = 0.0,
    density: float = 1000.0,
) -> VehicleCoefficients:
    """Return the coefficients of a vehicle without effects; drag may be given by its diagonal (6,)."""
    wrenches = _array(K_t)
    count = wrenches.shape[1]
    return VehicleCoefficients(
        M_RB=_array(M_RB),
        M_A=_matrix(M_A),
        D_L=_matrix(D_L),
        D_Q=_matrix(D_Q),
        weight=float(weight),
        buoyancy=float(buoyancy),
        r_G=_array(r_G),
        r_B=_array(r_B),
        K_t=wrenches,
        inflow=wrenches.copy(),
        current=_array(current),
        hands=np.zeros(count) if hands is None else _array(hands),
        K_t_reverse=wrenches.copy(),
        thrust_scale=np.ones(count),
        interaction=np.zeros((count, count)),
        reaction=np.zeros((3, count)),
        tether=np.zeros(4),
        ram=0.0,
        supply=1.0,
        sag=0.0,
        wiring=np.arange(count),
        turning=np.ones(count),
        stir=STIR,
        positions=np.zeros((3, count)) if positions is None else _array(positions),
        full_thrust=np.zeros(count),
        propeller_torque=float(propeller_torque),
        density=float(density),
    )


def _array(values: ArrayLike) -> Array:
    return np.array(values, dtype=np.float64, order="C")


def _matrix(values: ArrayLike) -> Array:
    given = _array(values)
    return np.diag(given) if given.ndim == 1 else given
