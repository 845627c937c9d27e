"""A current past the thruster that it does not drive itself: U + s for the propeller and for the instrument.

The tank's own flow U, which the thruster drives in (4.5), goes on without it.
"""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter


@equation
def inflow(ambient, p, e):  # type: ignore[no-untyped-def]
    """Return U + s."""
    return ambient + e.ambient_current_speed


EFFECT = Effect(
    id="ambient_current",
    title="current past the thruster",
    block="flow",
    equation="U + s in the axial equation and in the measurement",
    parameters=(
        EffectParameter(name="speed", unit="m/s", meaning="of the current", lower=0.0, upper=0.3, both_signs=True),
    ),
    note="a measured v follows by the axial equation, at once in `kim_chung`, and is U + s in `four_quadrant`; the "
    "flow of (4.5) goes on without s. A simulation begins with v = 0, where (4.4) keeps it until there is thrust; a "
    "diagnosis estimates v at the start where a flow is recorded and moves",
    hooks={"inflow": inflow},
)
