"""A thruster that sits or points elsewhere than drawn: it pushes and meets the water there.

Kinds: `first_normal` turns the axis e about the horizontal normal of e (about x for a vertical thruster),
`second_normal` about the normal of both, `position` moves the thruster by (x, y, z).
"""

import numpy as np

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with thruster i turned or moved; wrench and inflow alike."""
    i, K = active.thruster, c.K_t.copy()
    e, r = K[:3, i].copy(), c.positions[:, i].copy()
    if active.kind == "position":
        s = np.array([active.size(a) for a in "xyz"])
        if not np.any(s):
            return c
        r += s
    else:
        s = active.size("angle")
        if s == 0.0:
            return c
        across = np.cross((0.0, 0.0, 1.0), e)
        first = across / np.linalg.norm(across) if np.linalg.norm(across) > 1e-6 else np.array([1.0, 0.0, 0.0])
        about = first if active.kind == "first_normal" else np.cross(e, first)
        e = e * np.cos(s) + np.cross(about, e) * np.sin(s)
    K[:, i] = np.concatenate((e, np.cross(r, e)))
    positions = c.positions.copy()
    positions[:, i] = r
    return c._replace(K_t=K, K_t_reverse=K.copy(), inflow=K.copy(), positions=positions)


EFFECT = VehicleEffect(
    id="thruster_misalignment",
    title="thruster misaligned",
    block="thrusters",
    equation="e turned by s, or r + s",
    parameters=(
        EffectParameter(name="angle", unit="rad", meaning="by which the axis is turned", lower=-0.3, upper=0.3),
        EffectParameter(name="x", unit="m", meaning="forward of the offset", lower=-0.15, upper=0.15),
        EffectParameter(name="y", unit="m", meaning="starboard of the offset", lower=-0.15, upper=0.15),
        EffectParameter(name="z", unit="m", meaning="down of the offset", lower=-0.15, upper=0.15),
    ),
    note="`first_normal` turns e about z x e (about x where e is vertical), `second_normal` about e x (z x e), "
    "`position` moves the thruster; wrench and inflow alike",
    needs=("thruster", "kind"),
    choices={"kind": ("first_normal", "second_normal", "position")},
    order=-1,
    body=body,
    suspected=(
        Suspected(sizes={"angle": (0.15, 0.02)}, only={"kind": ("first_normal", "second_normal")}),
        Suspected(sizes={"x": (0.07, 0.01), "y": (0.07, 0.01), "z": (0.07, 0.01)}, only={"kind": ("position",)}),
    ),
)
