"""A parameter set: the values of one model's parameters with unit, source and standard deviation."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

from run_bag.unit_spelling import same_unit
from thruster_model.command_scale import VOLTS, CommandScale
from thruster_model.effects.active import NOTHING, ActiveEffects
from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.errors import ForceTableError, ParameterSetError
from thruster_model.force_curves import ForceCurves
from thruster_model.force_table import ForceTable
from thruster_model.models import MODELS, Model, ParameterDefinition

__all__ = ["Parameter", "ParameterSet"]


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter's value with its unit, where it comes from and how uncertain it is (None: not stated)."""

    value: float
    unit: str
    source: str
    standard_deviation: float | None = None

    def problems(self, name: str, definition: ParameterDefinition) -> list[str]:
        """Return what is wrong with it as the parameter of that name and definition, one sentence each."""
        problems = []
        key = f"key 'parameters.{name}"
        if not same_unit(self.unit, definition.unit):
            problems.append(f"{key}.unit': expected '{definition.unit}'; found '{self.unit}'")
        if not math.isfinite(self.value) or not definition.lower <= self.value <= definition.upper:
            expected = f"a number from {definition.lower:g} to {definition.upper:g} {definition.unit}"
            problems.append(f"{key}.value': expected {expected}; found {self.value!r}")
        deviation = self.standard_deviation
        if deviation is not None and not (math.isfinite(deviation) and deviation >= 0):
            problems.append(f"{key}.standard_deviation': expected a number >= 0 or nothing; found {deviation!r}")
        return problems

    def spelled_as(self, definition: ParameterDefinition) -> "Parameter":
        """Return it with the unit spelt as its definition does."""
        return self if self.unit == definition.unit else replace(self, unit=definition.unit)


@dataclass(frozen=True, kw_only=True)
class ParameterSet:
    """All parameters of one model, checked when constructed; `effects` beyond the model may be switched on with it.

    `command` says how the thruster's commands are written; `force_table` is the table of a model that needs one.

    Raises:
        ParameterSetError: unknown model; missing, unknown or inadmissible parameters; other units than the model's.
    """

    name: str
    model_name: str
    source: str
    parameters: Mapping[str, Parameter]
    origin: str = "parameter set"
    effects: ActiveEffects = NOTHING
    command: CommandScale = VOLTS
    force_table: ForceTable | None = None

    def __post_init__(self) -> None:
        problems = self._problems()
        if problems:
            raise ParameterSetError(self.origin, problems)
        ordered = {
            name: self.parameters[name].spelled_as(self.model.definition(name)) for name in self.model.parameter_names
        }
        object.__setattr__(self, "parameters", MappingProxyType(ordered))

    def _problems(self) -> list[str]:
        if self.model_name not in MODELS:
            return [f"key 'model': expected one of {', '.join(MODELS)}; found '{self.model_name}'"]
        model = MODELS[self.model_name]
        names = set(model.parameter_names)
        problems = [
            f"key 'parameters': '{name}' is missing; model '{self.model_name}' needs it: "
            f"{model.definition(name).meaning} [{model.definition(name).unit}]"
            for name in model.parameter_names
            if name not in self.parameters
        ]
        problems += [
            f"key 'parameters.{name}': model '{self.model_name}' has none such; it has {', '.join(sorted(names))}"
            for name in self.parameters
            if name not in names
        ]
        for name in names & set(self.parameters):
            problems += self.parameters[name].problems(name, model.definition(name))
        return problems + self._table_problems()

    def _table_problems(self) -> list[str]:
        table, needed = self.force_table, MODELS[self.model_name].needs_curves
        if needed and table is None:
            return [f"key 'force_table': missing; model '{self.model_name}' needs one"]
        if table is None:
            return []
        if not needed:
            return [f"key 'force_table': model '{self.model_name}' takes none"]
        try:
            ForceCurves(table=table, scale=self.command)
        except ForceTableError as error:
            return [f"key 'force_table': {problem}" for problem in error.problems]
        nominal, (low, high) = self.parameters.get("nominal_supply"), table.supply[[0, -1]]
        if nominal is not None and not low <= nominal.value <= high:
            measured = f"a supply that the table holds, {low:g} to {high:g} V"
            return [f"key 'parameters.nominal_supply.value': expected {measured}; found {nominal.value!r}"]
        return []

    @cached_property
    def model(self) -> Model:
        """The model whose parameters these are."""
        model = MODELS[self.model_name]
        if not (model.needs_curves and self.force_table is not None):
            return model
        return model.with_curves(ForceCurves(table=self.force_table, scale=self.command))

    @property
    def values(self) -> dict[str, float]:
        """Values by name, SI units."""
        return {name: parameter.value for name, parameter in self.parameters.items()}

    @property
    def coefficients(self) -> ThrusterCoefficients:
        """Coefficients of the common form of the equations."""
        return self.model.coefficients(self.values)

    def with_values(
        self, values: Mapping[str, float], *, source: str, standard_deviations: Mapping[str, float | None] | None = None
    ) -> "ParameterSet":
        """Return a copy with some values replaced, their source stated, their deviations set (None where not given)."""
        deviations = standard_deviations or {}
        changed = {
            name: replace(p, value=values[name], source=source, standard_deviation=deviations.get(name))
            if name in values
            else p
            for name, p in self.parameters.items()
        }
        return replace(self, parameters=changed, source=source)
