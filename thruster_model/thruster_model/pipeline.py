"""From state and acting throttle to rates and outputs: the equations of a class, with the effects where they enter."""

from thruster_model.compilation import equation, inlined
from thruster_model.effects.library.supply_sag import used_power_share
from thruster_model.effects.stages import NO_EFFECTS, stage
from thruster_model.equations.classes import axial_flow, axial_rate, loads, powered, rotor_rate, rotor_speed
from thruster_model.equations.dead_zone import dead_zone
from thruster_model.equations.thruster import ambient_acceleration

__all__ = [
    "derivative",
    "drawn",
    "heat_after",
    "lag_time",
    "memory_length",
    "outputs",
    "pipeline",
    "ramp_limit",
    "step_limit",
]

ramp_limit = stage("ramp")
lag_time = stage("lag")
_edges = stage("edges")
_drive = stage("drive")
_inflow = stage("inflow")
_approach = stage("approach")
_loads = stage("loads")
_rotor = stage("rotor")
_thrust_dynamics = stage("thrust_dynamics")
_axial = stage("axial")
_ambient = stage("ambient")
heat_after = stage("heat")
memory_length = stage("memory")
step_limit = stage("step")


@inlined
def _driven(n, u, heat, supply, p, e):  # type: ignore[no-untyped-def]
    lower, upper = _edges((p.delta_u1, p.delta_u2), n, p, e)
    return _drive(dead_zone(u, p.c_u1, lower, p.c_u2, upper), n, heat, supply, p, e)


@equation
def drawn(n, u, heat, p, e):  # type: ignore[no-untyped-def]
    """Return what a thruster draws from its supply, as a share of what it draws at full throttle and speed.

    Arguments as those of `pipeline`. A vehicle adds it up over thrusters that share one supply; `e` then has no
    `supply_sag` of its own.
    """
    return used_power_share(_driven(n, u, heat, 1.0, p, e), n, p)


@inlined
def pipeline(n, v, ambient, u, heat, past, gate, supply, p, e):  # type: ignore[no-untyped-def]
    """Return (dn/dt, dv/dt, dU/dt, rotor speed, axial flow, ambient flow, thrust, torque), SI units.

    n, v, ambient: states; u: acting throttle [V]; heat, past, gate: see `effects.effect.STAGES`; supply: its voltage
    over the nominal one, by which gamma is multiplied where the class has no table over it; p: coefficients of any
    class; e: `EffectValues` or `NO_EFFECTS`. States that are algebraic in the class of `p` do not move.
    """
    drive = powered(_driven(n, u, heat, supply, p, e), supply, p)
    speed = rotor_speed(n, drive, u, p)
    water = _inflow(ambient, p, e)
    met = _approach(water, p, e)
    axial = axial_flow(speed, v, met, p)
    force, moment = _loads(loads(speed, axial, u, supply, p), speed, axial, met, gate, p, e)
    n_dot = _rotor(rotor_rate(n, moment, drive, supply, p), n, drive, p, e)
    force = _thrust_dynamics(force, n_dot, p, e)
    v_dot = _axial(axial_rate(v, met, force, p), v, met, force, p, e)
    u_dot = _ambient(ambient_acceleration(ambient, force, p), ambient, past, force, p, e)
    return n_dot, v_dot, u_dot, speed, axial, water, force, moment


@equation
def derivative(n, v, ambient, u, p):  # type: ignore[no-untyped-def]
    """Return (dn/dt, dv/dt, dU/dt) without effects."""
    return pipeline(n, v, ambient, u, 0.0, 0.0, 1.0, 1.0, p, NO_EFFECTS)[:3]


@equation
def outputs(n, v, ambient, u, p):  # type: ignore[no-untyped-def]
    """Return (rotor speed [rad/s], axial flow [m/s], thrust [N], torque [N m]) without effects."""
    result = pipeline(n, v, ambient, u, 0.0, 0.0, 1.0, 1.0, p, NO_EFFECTS)
    return result[3], result[4], result[6], result[7]
