"""What a thruster model is: its parameters, their units and ranges, and their place in the common form."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.force_curves import ForceCurves

__all__ = ["Model", "ParameterDefinition", "Role"]

Role = Literal["drive", "rotor", "map", "axial", "ambient", "given"]


@dataclass(frozen=True, kw_only=True)
class ParameterDefinition:
    """What one parameter is: unit, meaning, admissible range and the size that one expects of it.

    `role` says to which stage of an identification it belongs; "given" parameters are measured otherwise (a radius, a
    density, a limit of the device) and are not fitted.
    """

    name: str
    unit: str
    meaning: str
    lower: float
    upper: float
    scale: float
    role: Role

    def __post_init__(self) -> None:
        if not self.lower < self.upper or not self.scale > 0:
            raise ValueError(f"{self.name}: lower {self.lower}, upper {self.upper}, scale {self.scale}")


@dataclass(frozen=True, kw_only=True)
class Model:
    """A thruster model: its parameters and their place in the common form of the equations.

    Attributes:
        name: identifier.
        title: in words.
        equations: as text, a line each.
        cannot: what this class cannot describe, in a sentence.
        parameters: in the order in which tables list them.
        signals: which signals it predicts (names of `identification.experiment.SIGNALS`).
        kind: class of its coefficients, which decides on the equations.
        slots: coefficients that a parameter sets, where they are not the one of its own name.
        constants: coefficients that the model fixes.
        knots: throttle levels [V] of a table's nodes; the parameters are then named by `node_name`.
        needs_curves: whether a set of this model brings a maker's table, whose curves are bound to it (`with_curves`).
        curves: those of the set.
    """

    name: str
    title: str
    equations: tuple[str, ...]
    cannot: str
    parameters: tuple[ParameterDefinition, ...]
    signals: tuple[str, ...]
    kind: Callable[..., ThrusterCoefficients] = ThrusterCoefficients
    slots: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    constants: Mapping[str, float] = field(default_factory=dict)
    knots: tuple[float, ...] = ()
    needs_curves: bool = False
    curves: ForceCurves | None = None

    def with_curves(self, curves: ForceCurves) -> "Model":
        """Return the model of one set's table; a speed that was not measured is no signal."""
        signals = tuple(name for name in self.signals if name != "speed" or curves.speed_measured)
        return replace(self, curves=curves, signals=signals)

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Names of the parameters, in the order in which tables list them."""
        return tuple(definition.name for definition in self.parameters)

    @property
    def has_flow(self) -> bool:
        """Whether the model predicts the ambient flow."""
        return "ambient" in self.signals

    def definition(self, name: str) -> ParameterDefinition:
        """Return what parameter `name` is; KeyError where the model has none of that name."""
        for definition in self.parameters:
            if definition.name == name:
                return definition
        raise KeyError(name)

    def of_role(self, *roles: Role) -> tuple[str, ...]:
        """Return the names of the parameters of these roles."""
        return tuple(d.name for d in self.parameters if d.role in roles)

    def coefficients(self, values: Mapping[str, float]) -> ThrusterCoefficients:
        """Return the coefficients of the common form for parameter values in SI units."""
        filled = {**_NEUTRAL, **self.constants}
        if self.knots:
            nodes = [[float(values[node_name(kind, u)]) for u in self.knots] for kind in NODE_KINDS]
            return self.kind(**filled, table=np.array([self.knots, *nodes]))
        for name in self.parameter_names:
            for slot in self.slots.get(name, (name,)):
                filled[slot] = float(values[name])
        if not self.needs_curves:
            return self.kind(**filled)
        if self.curves is None:
            raise ValueError(f"model '{self.name}': expected the curves of a parameter set's table; found none")
        slopes = {side: filled[side] * self.curves.gain for side in ("c_u1", "c_u2")}
        return self.kind(**{**filled, **slopes}, supplies=self.curves.supplies, curves=self.curves.curves)


NODE_KINDS = ("speed", "thrust", "torque")


def node_name(kind: str, throttle: float) -> str:
    """Return the name of a table's node, such as `thrust_at_m1.5` for -1.5 V."""
    return f"{kind}_at_{'m' if throttle < 0 else 'p'}{abs(throttle):g}"


# Without a ramp limit, a class follows its command at once.
_NEUTRAL: dict[str, float] = {
    **dict.fromkeys(ThrusterCoefficients._fields, 0.0),
    **ThrusterCoefficients._field_defaults,
    "u_dot_max": 1e6,
}
