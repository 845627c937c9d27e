r"""How well a vehicle followed its set points, how well v was estimated, as section 5.2 scores it.

Per degree of freedom, e = actual - wanted over the samples at which both are known,

    rmse          sqrt(mean e^2)
    set_point     mean |wanted|
    normalised    rmse / set_point, NaN where nothing but 0 was wanted

The thesis divides by the average set point; for one of mean zero, as its pitch, that has no meaning, and the mean of
its absolute value is taken, the same for a set point that does not change its sign. Errors of angles are wrapped.
Wanted body rates are nu_2d = J_2(eta)^-1 d(eta_d)/dt with the actual eta, as the outer loop wants them; one that would
be 0 at the wanted attitude comes of errors alone, and nothing was wanted of it.

The estimate of v is scored over all thrusters at once: rmse over the mean of |v| of all of them (figure 5.14).
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rov_sim.vehicle.poses import body_rates
from thruster_model.equations.attitude import wrapped

__all__ = ["DEGREES_OF_FREEDOM", "DegreeOfFreedom", "Score", "flow_score", "score", "vehicle_scores"]

Array = NDArray[np.float64]

_NOTHING = 1e-9  # m/s, rad/s, rad, N: a mean set point below this is rounding


class DegreeOfFreedom(NamedTuple):
    """One thing that is to follow a set point: identifier, words, symbol, unit."""

    id: str
    words: str
    symbol: str
    unit: str


DEGREES_OF_FREEDOM = (
    DegreeOfFreedom("surge", "Surge", "u", "m/s"),
    DegreeOfFreedom("sway", "Sway", "v", "m/s"),
    DegreeOfFreedom("heave", "Heave", "w", "m/s"),
    DegreeOfFreedom("roll_rate", "Roll rate", "p", "rad/s"),
    DegreeOfFreedom("pitch_rate", "Pitch rate", "q", "rad/s"),
    DegreeOfFreedom("yaw_rate", "Yaw rate", "r", "rad/s"),
    DegreeOfFreedom("roll", "Roll", "φ", "rad"),
    DegreeOfFreedom("pitch", "Pitch", "θ", "rad"),
    DegreeOfFreedom("yaw", "Yaw", "ψ", "rad"),
)
"""In the order of `vehicle_scores`."""


class Score(NamedTuple):
    """Of one degree of freedom: see the module; `largest` is max |e|, `samples` how many were scored."""

    rmse: float
    normalised: float
    set_point: float
    largest: float
    samples: int


def score(actual: ArrayLike, wanted: ArrayLike, *, angle: bool = False) -> Score:
    """Return the score of one signal against another of its shape; what is NaN in either is left out.

    Args:
        actual, wanted: any one shape; all samples count alike.
        angle: both are angles [rad]: a turn more or less is no error.
    """
    x, x_d = np.asarray(actual, dtype=np.float64), np.asarray(wanted, dtype=np.float64)
    if x.shape != x_d.shape:
        raise ValueError(f"expected actual and wanted of one shape; found {x.shape} and {x_d.shape}")
    known = np.isfinite(x) & np.isfinite(x_d)
    e, reference = (x - x_d)[known], x_d[known]
    if e.size == 0:
        return Score(np.nan, np.nan, np.nan, np.nan, 0)
    e = wrapped(e) if angle else e
    rmse, size = float(np.sqrt(np.mean(e**2))), float(np.mean(np.abs(reference)))
    return Score(rmse, rmse / size if size > _NOTHING else np.nan, size, float(np.max(np.abs(e))), int(e.size))


def vehicle_scores(
    angles: ArrayLike,
    velocity: ArrayLike,
    wanted_angles: ArrayLike,
    wanted_rates: ArrayLike,
    wanted_velocity: ArrayLike,
) -> dict[str, Score]:
    """Return the score of each degree of freedom by its identifier, over K instants.

    Args:
        angles: eta, roll, pitch, yaw [rad], (K, 3).
        velocity: nu in body axes [m/s, rad/s], (K, 6).
        wanted_angles: eta_d [rad], (K, 3).
        wanted_rates: time derivative of eta_d [rad/s], (K, 3).
        wanted_velocity: nu_1d [m/s], (K, 3).
    """
    eta, nu = np.asarray(angles, dtype=np.float64), np.asarray(velocity, dtype=np.float64)
    eta_d, nu_1d = np.asarray(wanted_angles, dtype=np.float64), np.asarray(wanted_velocity, dtype=np.float64)
    actual = np.hstack([nu, eta])
    wanted = np.hstack([nu_1d, body_rates(eta, wanted_rates), eta_d])
    moves = np.nanmax(np.abs(np.hstack([nu_1d, body_rates(eta_d, wanted_rates), eta_d])), axis=0, initial=0.0)
    found = {}
    for k, each in enumerate(DEGREES_OF_FREEDOM):
        one = score(actual[:, k], wanted[:, k], angle=k >= 6)
        found[each.id] = one if moves[k] > _NOTHING else one._replace(normalised=np.nan)
    return found


def flow_score(estimated: ArrayLike, true: ArrayLike) -> Score:
    """Return the score of v̂ against v [m/s], (K, N) each: over all thrusters at once; `set_point` is the mean |v|."""
    return score(estimated, true)
