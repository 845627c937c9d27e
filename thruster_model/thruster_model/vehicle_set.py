"""A vehicle set: what a vehicle weighs, how the water holds it, where its thrusters are; with source and deviation."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from thruster_model.effect_entry import EffectEntry
from thruster_model.equations.rigid_body import rigid_body_mass
from thruster_model.equations.vehicle_inflow import thruster_configuration
from thruster_model.errors import VehicleError
from thruster_model.parameter_set import Parameter
from thruster_model.vehicle_coefficients import VehicleCoefficients, vehicle_coefficients
from thruster_model.vehicle_layout import LayoutEntry
from thruster_model.vehicle_parameters import DEFAULTS, REQUIRED, defined, definition_of, matrix_of

__all__ = ["UNSTATED_DEVIATION", "VehicleSet"]

Array = NDArray[np.float64]
UNSTATED_DEVIATION = 0.05
"""Share of its value by which a parameter deviates where its set states nothing."""


@dataclass(frozen=True, kw_only=True)
class VehicleSet:
    """All of one vehicle, checked when constructed.

    Attributes:
        name: in words.
        source: where its numbers come from.
        parameters: by name, see `vehicle_parameters`.
        layout: its thrusters in order.
        model: parameter set of its thrusters.
        effects: beyond the model, switched on with it.
        origin: what errors call it.

    Raises:
        VehicleError: missing, unknown or inadmissible parameters; other units; no thrusters; no positive definite M.
    """

    name: str
    source: str
    parameters: Mapping[str, Parameter]
    layout: tuple[LayoutEntry, ...]
    model: str
    effects: tuple[EffectEntry, ...] = ()
    origin: str = "vehicle set"

    def __post_init__(self) -> None:
        trimmed = "net_buoyancy" in self.parameters
        wanted = [name for name in REQUIRED if name != "volume" or not trimmed]
        problems = [f"key 'parameters.{name}': missing" for name in wanted if name not in self.parameters]
        if trimmed and "volume" in self.parameters:
            problems.append("key 'parameters.net_buoyancy': expected in place of 'volume'; found both")
        for name, parameter in self.parameters.items():
            problems += _parameter_problems(name, parameter)
        problems += _layout_problems(self.layout)
        if not problems:
            problems = self._matrix_problems()
        if problems:
            raise VehicleError(self.origin, problems)
        spelled = {name: parameter.spelled_as(defined(name)) for name, parameter in self.parameters.items()}
        object.__setattr__(self, "parameters", MappingProxyType(spelled))
        object.__setattr__(self, "layout", tuple(self.layout))
        object.__setattr__(self, "effects", tuple(self.effects))

    def _matrix_problems(self) -> list[str]:
        c = self.coefficients
        problems = [] if c.buoyancy > 0.0 else [f"buoyancy: expected more than 0 N; found {c.buoyancy:.3g} N"]
        for name, matrix in (("M_RB", c.M_RB), ("M_A", c.M_A + 1e-12 * np.eye(6)), ("M_RB + M_A", c.mass_matrix)):
            least = float(np.linalg.eigvalsh(matrix)[0])
            if least <= 0.0:
                problems.append(f"{name}: expected a positive definite matrix; found the eigenvalue {least:.3g}")
        return problems

    @property
    def values(self) -> dict[str, float]:
        """Values by name, SI units, defaults included; the volume also where it follows from the net buoyancy."""
        v = {**DEFAULTS, **{name: parameter.value for name, parameter in self.parameters.items()}}
        if "net_buoyancy" in v:
            v["volume"] = (v["mass"] + v["net_buoyancy"] / v["gravity"]) / v["density"]
        return v

    def deviation(self, name: str) -> float:
        """Return the standard deviation of a parameter: as stated, else `UNSTATED_DEVIATION` of its value."""
        parameter = self.parameters[name]
        stated = parameter.standard_deviation
        return UNSTATED_DEVIATION * abs(parameter.value) if stated is None else stated

    @property
    def configuration(self) -> Array:
        """K_t (6, N)."""
        return thruster_configuration([t.position for t in self.layout], [t.axis for t in self.layout])

    @property
    def models(self) -> tuple[str, ...]:
        """The parameter set of each thruster."""
        return tuple(thruster.model or self.model for thruster in self.layout)

    @property
    def coefficients(self) -> VehicleCoefficients:
        """Coefficients without effects."""
        v = self.values
        r_G, r_B = ([v.get(f"{a}_{point}", 0.0) for a in "xyz"] for point in "GB")
        products = {name: v.get(f"I_{name}", 0.0) for name in ("xy", "xz", "yz")}
        I_G = np.array(
            [
                [v["I_x"], -products["xy"], -products["xz"]],
                [-products["xy"], v["I_y"], -products["yz"]],
                [-products["xz"], -products["yz"], v["I_z"]],
            ]
        )
        return vehicle_coefficients(
            M_RB=rigid_body_mass(v["mass"], r_G, I_G),
            M_A=matrix_of("A", v),
            D_L=matrix_of("L", v),
            D_Q=matrix_of("Q", v),
            weight=v["mass"] * v["gravity"],
            buoyancy=v["density"] * v["gravity"] * v["volume"],
            r_G=r_G,
            r_B=r_B,
            K_t=self.configuration,
            hands=[thruster.turn for thruster in self.layout],
            positions=np.array([thruster.position for thruster in self.layout]).T,
            propeller_torque=v.get("reaction_torque", 0.0),
            density=v["density"],
        )

    def with_values(self, values: Mapping[str, float], *, source: str) -> "VehicleSet":
        """Return a copy with some parameters' values replaced, their source stated, their deviations kept.

        A parameter that the set does not state, such as x_G, is stated then.
        """
        changed = dict(self.parameters)
        for name, value in values.items():
            if name in changed:
                changed[name] = replace(changed[name], value=float(value), source=source)
            elif (definition := definition_of(name)) is not None:
                changed[name] = Parameter(value=float(value), unit=definition.unit, source=source)
        return replace(self, parameters=changed)


def _parameter_problems(name: str, parameter: Parameter) -> list[str]:
    definition, key = definition_of(name), f"key 'parameters.{name}"
    if definition is None:
        return [
            f"{key}': expected a parameter of a vehicle, such as {', '.join(REQUIRED[:6])}, A_u, L_uq; found '{name}'"
        ]
    return parameter.problems(name, definition)


def _layout_problems(layout: tuple[LayoutEntry, ...]) -> list[str]:
    if not layout:
        return ["key 'thrusters': expected at least one thruster; found none"]
    problems = []
    for i, thruster in enumerate(layout):
        key = f"key 'thrusters.{i}"
        if not all(map(math.isfinite, (*thruster.position, *thruster.axis))):
            problems.append(f"{key}': expected finite position and axis; found {thruster.position}, {thruster.axis}")
        elif not abs(math.hypot(*thruster.axis) - 1.0) < 1e-6:
            problems.append(f"{key}.axis': expected a direction of length 1; found {math.hypot(*thruster.axis):g}")
        if thruster.hand not in (None, "left", "right"):
            problems.append(f"{key}.hand': expected left or right; found {thruster.hand!r}")
    names = [thruster.name for thruster in layout]
    problems += [
        f"key 'thrusters': expected names of their own; found '{n}' twice" for n in {*names} if names.count(n) > 1
    ]
    return problems
