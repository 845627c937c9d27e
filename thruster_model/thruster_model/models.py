"""The named thruster models: those of the thesis, and the classes that simulators ship."""

from thruster_model import printed_equations as printed
from thruster_model.equations.classes import (
    AirfoilCoefficients,
    AmbientInflowCoefficients,
    ForceTableCoefficients,
    RelativeFlowCoefficients,
    StaticCoefficients,
    SteadyFlowCoefficients,
    TableCoefficients,
)
from thruster_model.model import Model, ParameterDefinition
from thruster_model.parameter_definitions import (
    AIRFOIL,
    AMBIENT,
    AXIAL,
    DEAD_BAND_THRUST,
    DEAD_BAND_TORQUE,
    DRIVE,
    FORCE_TABLE,
    FOUR_QUADRANT,
    HYDRODYNAMIC_MAPS,
    LAG,
    PLAIN_MAPS,
    QUADRATIC_MAPS,
    RELATIVE_AXIAL,
    ROTOR,
    STATIC_DRIVE,
    STEADY_AXIAL,
    VOLTAGE_DRIVE,
    table_nodes,
)

__all__ = ["MODELS", "Model", "ParameterDefinition"]

_LOADS = ("speed", "thrust", "torque")
_FLOWS = ("speed", "axial", "ambient", "thrust", "torque")
_PLAIN = {"c_T": ("c_T1", "c_T2"), "c_Q": ("c_Q1", "c_Q2")}
_EVEN = {"c_n_T": ("c_T1", "c_T2"), "c_n_Q": ("c_Q1", "c_Q2")}
_VOLTAGE = {"k_1": ("k_n",), "k_3": ("c_u1", "c_u2")}
_STATIC = {"g_1": ("c_u1",), "g_2": ("c_u2",)}
TABLE_KNOTS = (-3.0, -2.5, -2.0, -1.5, -1.0, -0.75, 0.0, 0.75, 1.0, 1.5, 2.0, 2.5, 3.0)

_ALL = (
    Model(
        name="simplified",
        title="Simplified (thrust and torque from rotor speed alone)",
        equations=printed.DEAD_ZONE + printed.ROTOR + printed.DEAD_BAND_LOADS,
        cannot="It knows no flow: thrust overshoot and loss in a current are beyond it.",
        parameters=DRIVE + ROTOR + DEAD_BAND_THRUST + DEAD_BAND_TORQUE,
        signals=_LOADS,
    ),
    Model(
        name="hl",
        title="Hydrodynamic, linear in the axial flow (HL)",
        equations=printed.DEAD_ZONE + printed.ROTOR + printed.AXIAL + printed.AMBIENT + printed.LINEAR_LOADS,
        cannot="Thrust and torque are odd in (n, v): a propeller that is weaker in reverse is beyond it.",
        parameters=DRIVE + ROTOR + HYDRODYNAMIC_MAPS + AXIAL + AMBIENT,
        signals=_FLOWS,
        slots=_EVEN,
    ),
    Model(
        name="hq",
        title="Hydrodynamic, quadratic in the axial flow (HQ)",
        equations=printed.DEAD_ZONE + printed.ROTOR + printed.AXIAL + printed.AMBIENT + printed.QUADRATIC_LOADS,
        cannot="As HL; its quadratic terms need flow against the propeller to be told from the linear ones.",
        parameters=DRIVE + ROTOR + HYDRODYNAMIC_MAPS + QUADRATIC_MAPS + AXIAL + AMBIENT,
        signals=_FLOWS,
        slots=_EVEN,
    ),
    Model(
        name="two_state",
        title="Two states, axial flow against the ambient one (Healey et al.), HL maps",
        equations=(
            "dn/dt = -k_1 n - k_Q Q + k_3 u  (4.1)",
            *printed.RELATIVE_AXIAL,
            *printed.AMBIENT,
            *printed.LINEAR_LOADS,
        ),
        cannot="Driven by the voltage itself: it has no dead zone in the throttle.",
        parameters=VOLTAGE_DRIVE[::2] + ROTOR[1:] + HYDRODYNAMIC_MAPS + RELATIVE_AXIAL + AMBIENT,
        signals=_FLOWS,
        kind=RelativeFlowCoefficients,
        slots={**_EVEN, **_VOLTAGE},
    ),
    Model(
        name="airfoil",
        title="Blade as an airfoil, three states",
        equations=printed.DEAD_ZONE + printed.ROTOR + printed.AXIAL + printed.AMBIENT + printed.AIRFOIL,
        cannot="One pitch and one pair of coefficients for both directions; stall is only what two sinusoids give.",
        parameters=DRIVE + ROTOR + AIRFOIL + AXIAL + AMBIENT,
        signals=_FLOWS,
        kind=AirfoilCoefficients,
    ),
    Model(
        name="kim_chung",
        title="Steady axial flow (Kim and Chung), HQ maps",
        equations=printed.DEAD_ZONE + printed.ROTOR + printed.STEADY_AXIAL + printed.AMBIENT + printed.QUADRATIC_LOADS,
        cannot="The axial flow follows the rotor at once: no overshoot from water that must first be set in motion.",
        parameters=DRIVE + ROTOR + HYDRODYNAMIC_MAPS + QUADRATIC_MAPS + STEADY_AXIAL + AMBIENT,
        signals=_FLOWS,
        kind=SteadyFlowCoefficients,
        slots=_EVEN,
    ),
    Model(
        name="four_quadrant",
        title="Open-water propeller in four quadrants, C_T*(beta)",
        equations=printed.DEAD_ZONE + printed.ROTOR + printed.AMBIENT + printed.FOUR_QUADRANT,
        cannot="The inflow is the ambient flow: the propeller's own induced flow, and its delay, are in its series.",
        parameters=DRIVE + ROTOR + FOUR_QUADRANT + AMBIENT,
        signals=_FLOWS,
        kind=AmbientInflowCoefficients,
    ),
    Model(
        name="bessa",
        title="Voltage-driven rotor with a dead band in the thrust (Bessa et al.)",
        equations=("dn/dt = -k_1 n - k_2 n|n| + k_3 u  (3.7)", printed.DEAD_BAND_LOADS[0], printed.PLAIN_LOADS[1]),
        cannot="No dead zone in the throttle and no flow.",
        parameters=VOLTAGE_DRIVE + DEAD_BAND_THRUST + PLAIN_MAPS[1:],
        signals=_LOADS,
        slots={**_PLAIN, **_VOLTAGE},
    ),
    Model(
        name="yoerger",
        title="Rotor with quadratic friction alone (Yoerger et al.)",
        equations=("dn/dt = -k_2 n|n| + k_3 u", *printed.PLAIN_LOADS),
        cannot="No dead zone, no linear friction, no flow; both directions alike.",
        parameters=VOLTAGE_DRIVE[1:] + PLAIN_MAPS,
        signals=_LOADS,
        slots={**_PLAIN, **_VOLTAGE},
    ),
    Model(
        name="first_order",
        title="First-order lag behind a static speed",
        equations=printed.FIRST_ORDER + printed.PLAIN_LOADS,
        cannot="Load torque does not act on the rotor; no flow; both directions alike but for the input.",
        parameters=STATIC_DRIVE + LAG + PLAIN_MAPS,
        signals=_LOADS,
        slots={**_PLAIN, **_STATIC, "rate": ("k_n", "drive_gain")},
    ),
    Model(
        name="static_dead_band",
        title="Static: speed from the throttle, asymmetric dead band in n|n|",
        equations=printed.STATIC + printed.DEAD_BAND_LOADS,
        cannot="No dynamics at all: the rotor is where the throttle tells it.",
        parameters=STATIC_DRIVE + DEAD_BAND_THRUST + DEAD_BAND_TORQUE,
        signals=_LOADS,
        kind=StaticCoefficients,
        slots=_STATIC,
        constants={"k_n": 1.0},
    ),
    Model(
        name="static_quadratic",
        title="Static and quadratic: T = c u|u|",
        equations=("n = g_2 u", *printed.PLAIN_LOADS),
        cannot="No dynamics, no dead zone, both directions alike.",
        parameters=(STATIC_DRIVE[1], *PLAIN_MAPS),
        signals=_LOADS,
        kind=StaticCoefficients,
        slots={**_PLAIN, "g_2": ("c_u1", "c_u2")},
        constants={"k_n": 1.0},
    ),
    Model(
        name="table",
        title="Interpolated table of steady states over the throttle",
        equations=printed.TABLE,
        cannot="No dynamics; valid only where and at the supply voltage at which it was measured.",
        parameters=table_nodes(TABLE_KNOTS),
        signals=_LOADS,
        kind=TableCoefficients,
        knots=TABLE_KNOTS,
    ),
    Model(
        name="force_table",
        title="Maker's table of force over command and supply voltage, behind a first-order lag",
        equations=printed.CURVES,
        cannot="Measured at a standstill: no flow acts on the force, and no torque is known (it is given as zero).",
        parameters=FORCE_TABLE,
        signals=("speed", "thrust"),
        kind=ForceTableCoefficients,
        slots={"rate": ("k_n", "drive_gain"), "command_scale": ("c_u1", "c_u2")},
        needs_curves=True,
    ),
)
MODELS: dict[str, Model] = {model.name: model for model in _ALL}
