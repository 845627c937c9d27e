"""The parameters of the thruster models, by group, each with unit, meaning, sign and usual size."""

from thruster_model.model import NODE_KINDS, ParameterDefinition, Role, node_name

__all__ = [
    "AIRFOIL",
    "AMBIENT",
    "AXIAL",
    "DEAD_BAND_THRUST",
    "DEAD_BAND_TORQUE",
    "DRIVE",
    "FORCE_TABLE",
    "FOUR_QUADRANT",
    "HYDRODYNAMIC_MAPS",
    "LAG",
    "PLAIN_MAPS",
    "QUADRATIC_MAPS",
    "RELATIVE_AXIAL",
    "ROTOR",
    "STATIC_DRIVE",
    "STEADY_AXIAL",
    "VOLTAGE_DRIVE",
    "table_nodes",
]


def _positive(role: Role, name: str, unit: str, meaning: str, scale: float) -> ParameterDefinition:
    limits = {"lower": 0.0, "upper": 1e3 * scale}
    return ParameterDefinition(name=name, unit=unit, meaning=meaning, **limits, scale=scale, role=role)


def _negative(role: Role, name: str, unit: str, meaning: str, scale: float) -> ParameterDefinition:
    limits = {"lower": -1e3 * scale, "upper": 0.0}
    return ParameterDefinition(name=name, unit=unit, meaning=meaning, **limits, scale=scale, role=role)


def _either(role: Role, name: str, unit: str, meaning: str, scale: float) -> ParameterDefinition:
    limits = {"lower": -1e3 * scale, "upper": 1e3 * scale}
    return ParameterDefinition(name=name, unit=unit, meaning=meaning, **limits, scale=scale, role=role)


DRIVE = (
    _positive("drive", "c_u1", "1/(V s^2)", "slope of the input map (3.9), reverse", 700.0),
    _positive("drive", "c_u2", "1/(V s^2)", "slope of the input map (3.9), forward", 700.0),
    _negative("drive", "delta_u1", "V", "dead-zone edge of the throttle (3.9), reverse", 0.9),
    _positive("drive", "delta_u2", "V", "dead-zone edge of the throttle (3.9), forward", 0.9),
    _positive("given", "u_dot_max", "V/s", "largest rate of the throttle (3.20)", 100.0),
)
ROTOR = (
    _positive("rotor", "k_n", "1/s", "linear friction of the rotor (3.8), (4.3)", 12.0),
    _positive("rotor", "k_Q", "1/(N m s^2)", "rotor deceleration per load torque (3.8), (4.3)", 500.0),
)
VOLTAGE_DRIVE = (
    _positive("rotor", "k_1", "1/s", "linear friction of the rotor (3.7), (4.1)", 5.0),
    _positive("rotor", "k_2", "1", "quadratic friction of the rotor (3.7)", 0.06),
    _positive("drive", "k_3", "1/(V s^2)", "rotor acceleration per volt (3.7), (4.1)", 400.0),
)
STATIC_DRIVE = (
    _positive("drive", "g_1", "rad/s/V", "rotor speed per volt beyond the dead zone, reverse", 50.0),
    _positive("drive", "g_2", "rad/s/V", "rotor speed per volt beyond the dead zone, forward", 50.0),
    _negative("drive", "delta_u1", "V", "dead-zone edge of the throttle, reverse", 0.9),
    _positive("drive", "delta_u2", "V", "dead-zone edge of the throttle, forward", 0.9),
)
LAG = (_positive("rotor", "rate", "1/s", "rate at which the rotor speed follows its static value", 12.0),)
FORCE_TABLE = (
    _positive("drive", "command_scale", "1", "command beyond the dead zone as a share of the table's", 1.0),
    _negative("drive", "delta_u1", "V", "dead-zone edge of the throttle, reverse", 0.9),
    _positive("drive", "delta_u2", "V", "dead-zone edge of the throttle, forward", 0.9),
    *LAG,
    _positive("map", "thrust_scale", "1", "thrust as a share of the table's", 1.0),
    _positive("given", "nominal_supply", "V", "supply voltage that counts as the nominal one", 16.0),
)
PLAIN_MAPS = (
    _positive("map", "c_T", "N s^2", "thrust per n|n|", 1e-3),
    _positive("map", "c_Q", "N m s^2", "torque per n|n|", 4e-6),
)
DEAD_BAND_THRUST = (
    _positive("map", "c_T1", "N s^2", "thrust per n|n| (3.5), reverse", 9e-4),
    _positive("map", "c_T2", "N s^2", "thrust per n|n| (3.5), forward", 9e-4),
    _negative("map", "delta_T1", "1/s^2", "dead-zone edge of the thrust in n|n| (3.5), reverse", 500.0),
    _positive("map", "delta_T2", "1/s^2", "dead-zone edge of the thrust in n|n| (3.5), forward", 500.0),
)
DEAD_BAND_TORQUE = (
    _positive("map", "c_Q1", "N m s^2", "torque per n|n| (3.11), reverse", 5e-6),
    _positive("map", "c_Q2", "N m s^2", "torque per n|n| (3.11), forward", 5e-6),
    _negative("map", "delta_Q1", "1/s^2", "dead-zone edge of the torque in n|n| (3.11), reverse", 500.0),
    _positive("map", "delta_Q2", "1/s^2", "dead-zone edge of the torque in n|n| (3.11), forward", 500.0),
)
HYDRODYNAMIC_MAPS = (
    _positive("map", "c_n_T", "N s^2", "thrust per n|n| at rest of the water (4.12), (4.14)", 1.5e-3),
    _positive("map", "c_nv_T", "N s^2/m", "loss of thrust per |n| v (4.12), (4.14)", 0.4),
    _positive("map", "c_n_Q", "N m s^2", "torque per n|n| at rest of the water (4.13), (4.15)", 3e-6),
    _positive("map", "c_nv_Q", "N s^2", "loss of torque per |n| v (4.13), (4.15)", 3e-3),
)
QUADRATIC_MAPS = (
    _positive("map", "c_v_T", "N s^2/m^2", "loss of thrust per v|v| (4.14)", 40.0),
    _positive("map", "c_v_Q", "N s^2/m", "loss of torque per v|v| (4.15)", 0.1),
)
AIRFOIL = (
    _positive("given", "radius", "m", "radius R of the propeller disc (4.7)", 0.05),
    _positive("given", "density", "kg/m^3", "density of the water (4.8)", 1000.0),
    _positive("map", "pitch", "rad", "blade pitch angle p (4.8)", 0.3),
    _positive("map", "lift", "1", "largest lift coefficient (4.8)", 0.8),
    _positive("map", "drag", "1", "largest drag coefficient (4.9)", 0.3),
)
FOUR_QUADRANT = (
    _positive("given", "radius", "m", "radius R of the propeller disc", 0.05),
    _either("map", "a1_T", "N s^2/m^2", "thrust, cosine of the advance angle", 1.0),
    _either("map", "b1_T", "N s^2/m^2", "thrust, sine of the advance angle", 10.0),
    _either("map", "a3_T", "N s^2/m^2", "thrust, cosine of three times the advance angle", 1.0),
    _either("map", "b3_T", "N s^2/m^2", "thrust, sine of three times the advance angle", 10.0),
    _either("map", "a1_Q", "N s^2/m", "torque, cosine of the advance angle", 0.003),
    _either("map", "b1_Q", "N s^2/m", "torque, sine of the advance angle", 0.03),
    _either("map", "a3_Q", "N s^2/m", "torque, cosine of three times the advance angle", 0.003),
    _either("map", "b3_Q", "N s^2/m", "torque, sine of three times the advance angle", 0.03),
)
AXIAL = (
    _positive("axial", "k_v", "1/s", "linear damping of the axial flow (4.4)", 1.0),
    _positive("axial", "k_Uv", "1/m", "quadratic damping of the axial flow (4.4)", 60.0),
    _positive("axial", "k_w", "1", "share of the ambient flow that reaches the disc (4.4)", 1.0),
    _positive("axial", "k_Tv", "m/(N s^2)", "axial acceleration per thrust (4.4)", 0.012),
)
RELATIVE_AXIAL = (
    _positive("axial", "k_4", "1/m", "damping of the axial against the ambient flow (4.2)", 20.0),
    _positive("axial", "k_5", "m/(N s^2)", "axial acceleration per thrust (4.2)", 0.012),
)
STEADY_AXIAL = (
    _positive("axial", "k_s", "1", "axial flow per ambient flow (Kim and Chung)", 1.0),
    _positive("axial", "k_r", "m", "axial flow per rotor speed (Kim and Chung)", 5e-4),
    _either("given", "inflow_angle", "rad", "angle of the ambient flow to the thruster's axis", 1.0),
)
AMBIENT = (
    _positive("ambient", "k_U", "1/s", "linear damping of the ambient flow (4.5)", 0.24),
    _positive("ambient", "k_UU", "1/m", "quadratic damping of the ambient flow (4.5)", 1.2),
    _positive("ambient", "k_TU", "m/(N s^2)", "ambient acceleration per thrust (4.5)", 0.005),
)


def table_nodes(knots: tuple[float, ...]) -> tuple[ParameterDefinition, ...]:
    """Return the nodes of a table over these throttle levels [V]."""
    sizes = {"speed": ("rad/s", 50.0), "thrust": ("N", 10.0), "torque": ("N m", 0.04)}
    return tuple(
        _either("map", node_name(kind, u), sizes[kind][0], f"{kind} at {u:+g} V", sizes[kind][1])
        for kind in NODE_KINDS
        for u in knots
    )
