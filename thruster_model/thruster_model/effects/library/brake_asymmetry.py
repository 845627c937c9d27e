"""A driver that brakes the rotor where it should let it coast (or the reverse): k_n (1 + s) while |n| falls.

Whether |n| falls is decided without this effect, a = -n dn/dt / |n| > 0. The additional deceleration is s k_n |n| once
a reaches w k_n |n|, and s a / w on gentler ways down: a driver with w = 1 brakes as far as the drive falls short, one
with w = 0 brakes at once, as a switch does (0.01 at least is simulated, in steps of 1 ms). It never
speeds the rotor up: where s < 0 leaves less friction than slowing down takes, the rotor keeps its speed.
"""

import numpy as np

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected
from thruster_model.equations.selection import selected

LEAST_ONSET = 0.01
LONGEST = 0.1  # [s], over w: with |s| <= 0.8 stable for time constants of the rotor from 30 ms


@equation
def rotor(n_dot, n, drive, p, e):  # type: ignore[no-untyped-def]
    """Return dn/dt with k_n (1 + s) while |n| falls."""
    sense = np.sign(n)
    falling = np.maximum(-n_dot * sense, 0.0)
    onset = np.maximum(e.brake_asymmetry_onset, LEAST_ONSET)
    braking = e.brake_asymmetry_share * np.minimum(falling * (1.0 / onset), p.k_n * np.abs(n))
    return n_dot - sense * np.maximum(braking, -falling)


@equation
def step(step, n, n_dot, v, v_dot, e):  # type: ignore[no-untyped-def]
    """Return a step [s] that is short enough for the onset."""
    longest = LONGEST * np.maximum(e.brake_asymmetry_onset, LEAST_ONSET)
    return selected(e.brake_asymmetry_share != 0.0, np.minimum(step, longest), step)


EFFECT = Effect(
    id="brake_asymmetry",
    title="braking unlike acceleration",
    block="rotor",
    equation="k_n (1 + s) while |n| falls, all of it from a deceleration of w k_n |n|",
    parameters=(
        EffectParameter(
            name="share", unit="1", meaning="of k_n in addition while braking", lower=0.0, upper=0.8, both_signs=True
        ),
        EffectParameter(
            name="onset",
            unit="1",
            meaning="w, deceleration over k_n |n| from which it brakes in full",
            lower=0.0,
            upper=1.0,
            neutral=1.0,
        ),
    ),
    note="the deceleration a is that of the whole rotor equation without this effect, k_n n included; "
    "while a < w k_n |n|, what it adds is s a / w; w counts as 0.01 at least, which is at once",
    hooks={"rotor": rotor, "step": step},
    order=1,
    suspected=tuple(
        Suspected(sizes={"share": (0.4, 0.1), "onset": (0.3 * onset, 0.1 * onset)}, about={"onset": onset})
        for onset in (1.0, 0.4)
    ),
)
