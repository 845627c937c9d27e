"""A compass beside iron: magnets turn with the vehicle (semicircular), and iron that the earth magnetises (quadrantal).

The formula of compass adjusters, without its constant, which is a misalignment of the IMU about z (National
Geospatial-Intelligence Agency, Handbook of Magnetic Compass Adjustment, 1980).
"""

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected

_TERMS = {
    "semicircular_sin": "of yaw, in proportion to sin psi",
    "semicircular_cos": "of yaw, in proportion to cos psi",
    "quadrantal_sin": "of yaw, in proportion to sin 2 psi",
    "quadrantal_cos": "of yaw, in proportion to cos 2 psi",
}


def sensing(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with larger terms of the deviation [rad]."""
    return c._replace(
        compass=tuple(known + active.size(name) for known, name in zip(c.compass, _TERMS, strict=True)),
    )


EFFECT = VehicleEffect(
    id="compass_deviation",
    title="heading that errs with the heading",
    block="sensor",
    equation="psi + B sin psi + C cos psi + D sin 2 psi + E cos 2 psi",
    parameters=tuple(
        EffectParameter(name=name, unit="rad", meaning=meaning, lower=-0.5, upper=0.5)
        for name, meaning in _TERMS.items()
    ),
    sensing=sensing,
    suspected=(Suspected(sizes=dict.fromkeys(_TERMS, (0.1, 0.02)), read_by="attitude"),),
)
