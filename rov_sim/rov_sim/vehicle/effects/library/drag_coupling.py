"""Motion along one axis drags along another: the first axis is pushed by motion along the second."""

from rov_sim.vehicle.effects.body_axes import AXIS_PAIRS, BODY_AXES, axis_pair
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects.effect import EffectParameter, Suspected


def body(c, active):  # type: ignore[no-untyped-def]
    """Return the coefficients with s more in that entry of D_L."""
    (a, b), matrix = axis_pair(active.axis), c.D_L.copy()
    matrix[a, b] += active.size("size")
    return c._replace(D_L=matrix)


_TRANSLATIONS = BODY_AXES[:3]
_BY_KIND = tuple(
    tuple(pair for pair in AXIS_PAIRS if sum(a in _TRANSLATIONS for a in pair.split("-")) == count)
    for count in range(3)
)
"""Pairs of axes with no translation, one and two: entries differ by their units."""


EFFECT = VehicleEffect(
    id="drag_coupling",
    title="coupling of two axes by drag",
    block="body",
    equation="D_L,ab + s, D_L,ba as it is",
    parameters=(
        EffectParameter(name="size", unit="N s/m, N s or N m s", meaning="entry more", lower=-100.0, upper=100.0),
    ),
    note="of axes a-b, motion along b pushes along a by -s nu_r,b: `surge-yaw` is a force along surge, `yaw-surge` a "
    "moment about yaw",
    needs=("axis",),
    choices={"axis": AXIS_PAIRS},
    body=body,
    suspected=tuple(
        Suspected(sizes={"size": (expected, 0.1 * expected)}, only={"axis": pairs})
        for expected, pairs in zip((0.3, 2.0, 10.0), _BY_KIND, strict=True)
    ),
)
