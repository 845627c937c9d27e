"""Effects of a vehicle that are switched on: what they act on, and what they make of its coefficients."""

import importlib
import pkgutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from rov_sim.vehicle.effects import library
from rov_sim.vehicle.effects.effect import TARGETS, VehicleEffect
from thruster_model.effects import stages
from thruster_model.effects.active import problems_of
from thruster_model.effects.effect import size_problems

__all__ = ["VEHICLE_LIBRARY", "ActiveVehicleEffect", "body_with", "sensing_with", "thruster_effects"]

VEHICLE_LIBRARY: Mapping[str, VehicleEffect] = MappingProxyType(
    {
        effect.id: effect
        for effect in (
            importlib.import_module(f"{library.__name__}.{name}").EFFECT
            for name in sorted(module.name for module in pkgutil.iter_modules(library.__path__))
        )
    }
)
"""All effects of a vehicle by identifier."""

_TANK = ("ambient_current", "tank_recirculation")
_RIG = ("axial", "ambient", "thrust", "torque")


@dataclass(frozen=True, kw_only=True)
class ActiveVehicleEffect:
    """One effect, of `VEHICLE_LIBRARY` or of a thruster, and what it acts on.

    Attributes:
        id: identifier.
        sizes: by parameter; what is not named is neutral.
        thruster: index, None: all; other: index of a second one.
        axis, sensor, kind: as the effect has them, None: all, or as it has none.
    """

    id: str
    sizes: Mapping[str, float] = field(default_factory=dict)
    thruster: int | None = None
    other: int | None = None
    axis: str | None = None
    sensor: str | None = None
    kind: str | None = None

    def __post_init__(self) -> None:
        problems = self.problems()
        if problems:
            raise ValueError("; ".join(problems))
        object.__setattr__(self, "sizes", MappingProxyType({k: float(v) for k, v in self.sizes.items()}))

    def size(self, parameter: str) -> float:
        """Return the size of a parameter of an effect of `VEHICLE_LIBRARY`."""
        neutral = {p.name: p.neutral for p in VEHICLE_LIBRARY[self.id].parameters}
        return float(self.sizes.get(parameter, neutral[parameter]))

    def problems(self) -> list[str]:
        """Return what is wrong, one sentence each."""
        key, effect = f"key 'effects.{self.id}", VEHICLE_LIBRARY.get(self.id)
        if effect is None:
            return self._problems_of_thruster(key)
        wrong = size_problems(self.id, effect.parameters, self.sizes)
        for target in TARGETS:
            given = getattr(self, target)
            if given is None and target in effect.needs:
                wrong.append(f"{key}.{target}': missing")
            elif given is not None and target not in (*effect.needs, *effect.may_take):
                wrong.append(f"{key}.{target}': expected none; found {given!r}")
            elif given is not None and given not in effect.choices.get(target, (given,)):
                wrong.append(f"{key}.{target}': expected one of {', '.join(effect.choices[target])}; found {given!r}")
        return wrong

    def _problems_of_thruster(self, key: str) -> list[str]:
        effect = stages.LIBRARY.get(self.id)
        if effect is None:
            known = ", ".join(sorted({*VEHICLE_LIBRARY, *stages.LIBRARY}))
            return [f"{key}': expected one of {known}"]
        if self.id in _TANK:
            return [f"{key}': expected an effect of a vehicle; found one of a tank: on a vehicle U follows from motion"]
        if effect.block == "sensor" and set(effect.channel.split()) <= set(_RIG):
            return [f"{key}': expected an effect of a vehicle's sensors; found one of a rig's, which a vehicle has not"]
        wrong = [f"{key}.{t}': expected none; found {getattr(self, t)!r}" for t in TARGETS[1:] if getattr(self, t)]
        return wrong + problems_of({self.id: self.sizes})


def sensing_with(c: Any, effects: Iterable[ActiveVehicleEffect]) -> Any:
    """Return `SensorCoefficients` with these effects; those that act elsewhere are passed over."""
    for effect, active in _in_order(effects):
        if effect.sensing is not None:
            c = effect.sensing(c, active)
    return c


def body_with(c: Any, effects: Iterable[ActiveVehicleEffect]) -> Any:
    """Return `VehicleCoefficients` with these effects; those that act elsewhere are passed over.

    Raises:
        ValueError: an effect of a thruster that the vehicle does not have, or that its coefficients cannot have.
    """
    for effect, active in _in_order(effects):
        for target in ("thruster", "other"):
            i = getattr(active, target)
            if i is not None and not 0 <= i < c.thrusters:
                raise ValueError(f"key 'effects.{active.id}.{target}': expected 0 to {c.thrusters - 1}; found {i}")
        if effect.body is not None:
            c = effect.body(c, active)
    return c


def thruster_effects(effects: Sequence[ActiveVehicleEffect], thrusters: int) -> tuple[Any, ...] | None:
    """Return `EffectValues` of each thruster, None where no effect of a thruster is on.

    Raises:
        ValueError: an effect of a thruster that the vehicle does not have.
    """
    own = [active for active in effects if active.id not in VEHICLE_LIBRARY]
    far = [active for active in own if active.thruster is not None and not 0 <= active.thruster < thrusters]
    if far:
        found = "; ".join(
            f"key 'effects.{a.id}.thruster': expected 0 to {thrusters - 1}; found {a.thruster}" for a in far
        )
        raise ValueError(found)
    if not own:
        return None
    sizes: list[dict[str, dict[str, float]]] = [{} for _ in range(thrusters)]
    for active in own:
        for i in range(thrusters) if active.thruster is None else (active.thruster,):
            sizes[i].setdefault(active.id, {}).update(active.sizes)
    return tuple(stages.effect_values(each) for each in sizes)


def _in_order(effects: Iterable[ActiveVehicleEffect]) -> list[tuple[VehicleEffect, ActiveVehicleEffect]]:
    found = [(VEHICLE_LIBRARY[active.id], active) for active in effects if active.id in VEHICLE_LIBRARY]
    return sorted(found, key=lambda each: (each[0].order, each[0].id))
