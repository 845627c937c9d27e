"""The named thruster models: which parameters each has, in which unit and range, and how they enter the equations."""

from collections.abc import Mapping
from dataclasses import dataclass

from thruster_model.equations.thruster import ThrusterCoefficients

__all__ = ["MODELS", "Model", "ParameterDefinition"]


@dataclass(frozen=True, kw_only=True)
class ParameterDefinition:
    """What one parameter is: unit, meaning, admissible range and the size that one expects of it."""

    name: str
    unit: str
    meaning: str
    lower: float
    upper: float
    scale: float

    def __post_init__(self) -> None:
        if not self.lower < self.upper or not self.scale > 0:
            raise ValueError(f"{self.name}: lower {self.lower}, upper {self.upper}, scale {self.scale}")


def _positive(name: str, unit: str, meaning: str, scale: float) -> ParameterDefinition:
    return ParameterDefinition(name=name, unit=unit, meaning=meaning, lower=0.0, upper=1e3 * scale, scale=scale)


def _negative(name: str, unit: str, meaning: str, scale: float) -> ParameterDefinition:
    return ParameterDefinition(name=name, unit=unit, meaning=meaning, lower=-1e3 * scale, upper=0.0, scale=scale)


_INPUT_AND_ROTOR = (
    _positive("c_u1", "1/(V s^2)", "slope of the input map (3.9), reverse", 700.0),
    _positive("c_u2", "1/(V s^2)", "slope of the input map (3.9), forward", 700.0),
    _negative("delta_u1", "V", "dead-zone edge of the throttle (3.9), reverse", 0.9),
    _positive("delta_u2", "V", "dead-zone edge of the throttle (3.9), forward", 0.9),
    _positive("u_dot_max", "V/s", "largest rate of the throttle (3.20)", 100.0),
    _positive("k_n", "1/s", "linear friction of the rotor (3.8), (4.3)", 12.0),
    _positive("k_Q", "1/(N m s^2)", "rotor deceleration per load torque (3.8), (4.3)", 500.0),
)
_FLOW = (
    _positive("k_v", "1/s", "linear damping of the axial flow (4.4)", 1.0),
    _positive("k_Uv", "1/m", "quadratic damping of the axial flow (4.4)", 60.0),
    _positive("k_w", "1", "share of the ambient flow that reaches the disc (4.4)", 1.0),
    _positive("k_Tv", "m/(N s^2)", "axial acceleration per thrust (4.4)", 0.012),
    _positive("k_U", "1/s", "linear damping of the ambient flow (4.5)", 0.24),
    _positive("k_UU", "1/m", "quadratic damping of the ambient flow (4.5)", 1.2),
    _positive("k_TU", "m/(N s^2)", "ambient acceleration per thrust (4.5)", 0.005),
)
_SIMPLIFIED_MAPS = (
    _positive("c_T1", "N s^2", "thrust per n|n| (3.5), reverse", 9e-4),
    _positive("c_T2", "N s^2", "thrust per n|n| (3.5), forward", 9e-4),
    _negative("delta_T1", "1/s^2", "dead-zone edge of the thrust in n|n| (3.5), reverse", 500.0),
    _positive("delta_T2", "1/s^2", "dead-zone edge of the thrust in n|n| (3.5), forward", 500.0),
    _positive("c_Q1", "N m s^2", "torque per n|n| (3.11), reverse", 5e-6),
    _positive("c_Q2", "N m s^2", "torque per n|n| (3.11), forward", 5e-6),
    _negative("delta_Q1", "1/s^2", "dead-zone edge of the torque in n|n| (3.11), reverse", 500.0),
    _positive("delta_Q2", "1/s^2", "dead-zone edge of the torque in n|n| (3.11), forward", 500.0),
)
_HYDRODYNAMIC_MAPS = (
    _positive("c_n_T", "N s^2", "thrust per n|n| at rest of the water (4.12), (4.14)", 1.5e-3),
    _positive("c_nv_T", "N s^2/m", "loss of thrust per |n| v (4.12), (4.14)", 0.4),
    _positive("c_n_Q", "N m s^2", "torque per n|n| at rest of the water (4.13), (4.15)", 3e-6),
    _positive("c_nv_Q", "N s^2", "loss of torque per |n| v (4.13), (4.15)", 3e-3),
)
_QUADRATIC_MAPS = (
    _positive("c_v_T", "N s^2/m^2", "loss of thrust per v|v| (4.14)", 40.0),
    _positive("c_v_Q", "N s^2/m", "loss of torque per v|v| (4.15)", 0.1),
)


@dataclass(frozen=True, kw_only=True)
class Model:
    """A thruster model: its parameters and their place in the common form of the equations."""

    name: str
    title: str
    equations: str
    parameters: tuple[ParameterDefinition, ...]
    has_flow: bool

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the parameters, in the order in which tables list them."""
        return tuple(definition.name for definition in self.parameters)

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals that the model predicts (names of `identification.experiment.SIGNALS`)."""
        flows = ("axial", "ambient") if self.has_flow else ()
        return ("speed", *flows, "thrust", "torque")

    def definition(self, name: str) -> ParameterDefinition:
        """Return what parameter `name` is; KeyError where the model has none of that name."""
        return next(d for d in self.parameters if d.name == name) if name in self.parameter_names else _missing(name)

    def coefficients(self, values: Mapping[str, float]) -> ThrusterCoefficients:
        """Return the coefficients of the common form for parameter values in SI units."""
        slots = dict.fromkeys(ThrusterCoefficients._fields, 0.0)
        for name in self.parameter_names:
            for slot in _SLOTS.get(name, (name,)):
                slots[slot] = float(values[name])
        return ThrusterCoefficients(**slots)


def _missing(name: str) -> ParameterDefinition:
    raise KeyError(name)


_SLOTS = {"c_n_T": ("c_T1", "c_T2"), "c_n_Q": ("c_Q1", "c_Q2")}

MODELS: dict[str, Model] = {
    model.name: model
    for model in (
        Model(
            name="simplified",
            title="Simplified (thrust and torque from rotor speed alone)",
            equations="(3.5), (3.8), (3.9), (3.11)",
            parameters=_INPUT_AND_ROTOR + _SIMPLIFIED_MAPS,
            has_flow=False,
        ),
        Model(
            name="hl",
            title="Hydrodynamic, linear in the axial flow (HL)",
            equations="(3.9), (4.3)-(4.5), (4.12), (4.13)",
            parameters=_INPUT_AND_ROTOR + _HYDRODYNAMIC_MAPS + _FLOW,
            has_flow=True,
        ),
        Model(
            name="hq",
            title="Hydrodynamic, quadratic in the axial flow (HQ)",
            equations="(3.9), (4.3)-(4.5), (4.14), (4.15)",
            parameters=_INPUT_AND_ROTOR + _HYDRODYNAMIC_MAPS + _QUADRATIC_MAPS + _FLOW,
            has_flow=True,
        ),
    )
}
