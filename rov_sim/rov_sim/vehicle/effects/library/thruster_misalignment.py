"""A thruster that sits or points elsewhere than drawn: it pushes and meets the water there.

Kinds: `first_normal` turns the axis e about the horizontal normal of e (about x for a vertical thruster),
`second_normal` about the normal of both, `position` moves the thruster by (x, y, z).
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected
from thruster_model.equations.vehicle_inflow import thruster_configuration

Array = NDArray[np.float64]


def normals(axes: Array) -> tuple[Array, Array]:
    """Return the first and second normals (3, N) of thrusters' axes (3, N)."""
    return _normals(axes.tobytes(), axes.shape[1])


@lru_cache(maxsize=64)
def _normals(data: bytes, count: int) -> tuple[Array, Array]:
    axes = np.frombuffer(data).reshape(3, count)
    across = np.cross(np.array([0.0, 0.0, 1.0]), axes.T).T
    length = np.linalg.norm(across, axis=0)
    first = np.where(length > 1e-6, across / np.maximum(length, 1e-6), np.array([[1.0], [0.0], [0.0]]))
    return first, np.cross(axes.T, first.T).T


def displaced(c, first, second, offset):  # type: ignore[no-untyped-def]
    """Return the coefficients with thrusters turned by angles (N,) [rad] about their normals, the first one first, and
    moved by offsets (3, N) [m]; wrench and inflow alike."""
    e = c.K_t[:3]
    for angle, about in zip((first, second), normals(np.ascontiguousarray(e)), strict=True):
        e = e * np.cos(angle) + np.cross(about.T, e.T).T * np.sin(angle)
    r = c.positions + offset
    K = thruster_configuration(r.T, e.T)
    return c._replace(K_t=K, K_t_reverse=K.copy(), inflow=K.copy(), positions=r)


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with thruster i turned or moved."""
    kind = active.kind
    sizes = [active.size(a) for a in "xyz"] if kind == "position" else [active.size("angle")]
    if not np.any(sizes):
        return c
    own = np.arange(c.thrusters) == active.thruster
    if kind == "position":
        return displaced(c, 0.0 * own, 0.0 * own, np.outer(sizes, own))
    first, second = (sizes[0] * own * (kind == of) for of in ("first_normal", "second_normal"))
    return displaced(c, first, second, np.zeros((3, c.thrusters)))


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
