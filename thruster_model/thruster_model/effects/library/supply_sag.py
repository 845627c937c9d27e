"""A supply whose voltage falls with the current drawn from it: V = V_0 - R i, with i in proportion to |gamma||n|.

s is the share of the drive lost at full speed and throttle: gamma (1 - s |gamma||n| / (gamma_full n_full)), the bracket
never below zero, with gamma_full = gamma at +-5 V and n_full the speed without load, k_n n_full + k_2 n_full^2 =
gamma_full times the gain of the drive; for k_2 = 0 and gain 1 that is gamma_full / k_n. R is one resistance: where the
directions of the drive differ, the one that draws more is full.
A rotor without inertia has no speed as a state, so it knows no sag. On a vehicle all thrusters share one supply: there
`pipeline.drawn` is added up, and the supply that is left goes into `pipeline` as an argument.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter

FULL_THROTTLE = 5.0
TINY = 1e-9


@equation
def drive(drive, n, heat, supply, p, e):  # type: ignore[no-untyped-def]
    """Return gamma(u) less what the supply sags."""
    return drive * np.maximum(1.0 - e.supply_sag_share * used_power_share(drive, n, p), 0.0)


@equation
def used_power_share(drive, n, p):  # type: ignore[no-untyped-def]
    """Return |gamma||n| / (gamma_full n_full); the full drive's reciprocals do not change within a run."""
    forward = _per_full_power(p.c_u2 * (FULL_THROTTLE - p.delta_u2), p)
    backward = _per_full_power(p.c_u1 * (FULL_THROTTLE + p.delta_u1), p)
    return np.abs(drive * n) * np.minimum(forward, backward)


@equation
def _per_full_power(full, p):  # type: ignore[no-untyped-def]
    """Return 1 / (gamma_full n_full) [s^3/rad^2], gamma_full > 0; 0 where nothing holds the rotor back."""
    gained = np.maximum(p.drive_gain * full, TINY)
    return (p.k_n + np.sqrt(p.k_n * p.k_n + 4.0 * p.k_2 * gained)) / (2.0 * gained * np.maximum(full, TINY))


EFFECT = Effect(
    id="supply_sag",
    title="sag of the supply voltage under load",
    block="command",
    equation="gamma (1 - s |gamma||n| / (gamma_full n_full))",
    parameters=(
        EffectParameter(
            name="share", unit="1", meaning="of the drive lost at full throttle and speed", lower=0.0, upper=0.5
        ),
    ),
    note="gamma_full is the drive at 5 V, or at -5 V where that draws more; n_full is the speed at which "
    "k_n n + k_2 n^2 makes up for it, without k_Q Q; `yoerger` has no k_n. Where k_2 is 0 that is gamma_full / k_n, "
    "in `first_order` g(5 V), in `force_table` the largest speed of its table times command_scale. A recorded supply "
    "has its own sag: this one is on top. A vehicle has [one for the supply of all thrusters]"
    "(vehicles.md#effects-of-a-vehicle) in place of it",
    hooks={"drive": drive},
    order=1,
)
