"""A thruster that pushes less than its map says: damaged blades, growth in the duct, a wrong propeller."""

from thruster_model.compilation import equation
from thruster_model.effects.effect import Effect, EffectParameter, Suspected


@equation
def loads(loads, n, v, ambient, gate, p, e):  # type: ignore[no-untyped-def]
    """Return thrust times (1 - s), torque as it is."""
    force, moment = loads
    return force * (1.0 - e.thrust_loss_share), moment


EFFECT = Effect(
    id="thrust_loss",
    title="loss of thrust at all speeds",
    block="thrust",
    equation="T (1 - s)",
    parameters=(EffectParameter(name="share", unit="1", meaning="of the thrust lost", lower=-0.3, upper=1.0),),
    hooks={"loads": loads},
    suspected=(Suspected(sizes={"share": (0.3, 0.05)}, watched=(0.3, 1.0)),),
)
