"""A steady current of the water: it acts in drag, in added mass and at the thrusters.

How a vehicle moves through the water, and all that gyro and accelerometer read of it, is the same in any steady current
(Galileo): without a sensor of motion over ground a current is but another motion at the start. A depth tells what is
vertical.
"""

import numpy as np

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with v_c added to the current."""
    v_c = np.array([active.size(a) for a in ("north", "east", "down")])
    return c._replace(current=c.current + v_c)


EFFECT = VehicleEffect(
    id="water_current",
    title="current of the water",
    block="water",
    equation="nu_r = nu - J_1(eta)^T v_c",
    parameters=(
        EffectParameter(name="north", unit="m/s", meaning="v_c, north", lower=-0.5, upper=0.5),
        EffectParameter(name="east", unit="m/s", meaning="v_c, east", lower=-0.5, upper=0.5),
        EffectParameter(name="down", unit="m/s", meaning="v_c, down", lower=-0.5, upper=0.5),
    ),
    body=body,
    suspected=(
        Suspected(
            sizes={"north": (0.2, 0.03), "east": (0.2, 0.03), "down": (0.1, 0.03)},
            told_by={"north": ("velocity",), "east": ("velocity",), "down": ("velocity", "depth")},
        ),
    ),
)
