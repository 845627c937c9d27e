"""The vehicle's model at any point of the space of its unknowns, as tables for the filter's kernel."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import ceil
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.onset import on_in
from gap_diagnosis.vehicle.rules import PERIOD, SIZED, STEP
from gap_diagnosis.vehicle.turns import Stated
from gap_diagnosis.vehicle.unknowns import CHARGE, PLACING, PRODUCTS, Key, acts_in, share_of_trim
from rov_sim.vehicle.effects.active import (
    VEHICLE_LIBRARY,
    ActiveVehicleEffect,
    body_with,
    sensing_with,
    thruster_effects,
)
from rov_sim.vehicle.effects.body_axes import coupled
from rov_sim.vehicle.effects.library.thruster_misalignment import displaced, normals
from rov_sim.vehicle.innovations import PARTS
from rov_sim.vehicle.plant import VehicleSettings
from rov_sim.vehicle.sensors.coefficients import SensorCoefficients, sensor_coefficients
from rov_sim.vehicle.sensors.settings import VehicleSensors
from rov_sim.vehicle.settings import active_effects, full_thrust
from rov_sim.vehicle.truth import VehicleState
from thruster_model.parameter_set import Parameter, ParameterSet
from thruster_model.vehicle_coefficients import VehicleCoefficients
from thruster_model.vehicle_layout import LayoutEntry
from thruster_model.vehicle_parameters import definition_of
from thruster_model.vehicle_set import VehicleSet

__all__ = ["GROUPS", "OF_LOG", "Built", "Model", "admissible"]

Array = NDArray[np.float64]
_Sizes = tuple[float, ...]
_Changes = tuple[tuple[str, float], ...]
GROUPS: dict[str, tuple[str, ...]] = {
    "c_u1": ("c_u1",),
    "c_u2": ("c_u2",),
    "drive": ("c_u1", "c_u2"),
    "delta_u1": ("delta_u1",),
    "delta_u2": ("delta_u2",),
    "rotor": ("k_n",),
    "rate": ("k_n", "drive_gain"),
    "k_2": ("k_2",),
    "k_Q": ("k_Q",),
    "thrust": ("c_T1", "c_T2"),
    "c_T1": ("c_T1",),
    "c_T2": ("c_T2",),
    "delta_T1": ("delta_T1",),
    "delta_T2": ("delta_T2",),
    "flow_loss": ("c_nv_T",),
    "flow_drag": ("c_v_T",),
    "k_v": ("k_v",),
    "k_Uv": ("k_Uv",),
    "k_w": ("k_w",),
    "k_Tv": ("k_Tv",),
}
"""Coefficients of a thruster that move together, as those that one published number sets do.

Thrust is that on the vehicle where a table gives it; where a set has a number for each way, each moves by itself, and
where one number is both, they move together. Of k_Q and c_Q a rotor feels the product alone.
"""
_LEAST_SHARE = 0.05
"""Of a coefficient that is left of it, however far a fit goes: none of them changes its sign."""
_TACH = ("tach_scale", "tach_lag")
OF_LOG = ("log_alignment", "clock_drift")
"""Effects of when commands are said to act, not of the vehicle."""
_VEHICLES = 512
"""Vehicles with changed numbers that are kept: a fit asks for the same ones with other thrusters, run after run."""


class Built(NamedTuple):
    """What a filter takes: settings with tables, sensors' coefficients, each tachometer's scale and lag [s] (N, 2),
    and by which share of its nominal voltage the battery is off at first, with its rate [1/s]."""

    settings: VehicleSettings
    sensors: SensorCoefficients
    tach: Array
    charge: tuple[float, float]

    def steps(self, period: float) -> tuple[int, float]:
        """Return how many steps of which length [s] a part of a filter's period takes, as `innovations` has them."""
        count = self.settings.steps_in(period / PARTS)
        return count, period / PARTS / count


@dataclass(frozen=True, kw_only=True)
class Model:
    """A vehicle with its thrusters and sensors as they are believed to be.

    Attributes:
        vehicle: its set; effects that it switches on are on.
        sets: of its thrusters, one each.
        sensors: their places.
        period: of the filter that it is used in [s]; the plant's steps divide it.
    """

    vehicle: VehicleSet
    sets: tuple[ParameterSet, ...]
    sensors: VehicleSensors
    period: float = PERIOD

    @property
    def edges(self) -> list[float]:
        """Of the dead zone of each thruster, the farther one [V]; 0 where its set has none."""
        both = ("delta_u1", "delta_u2")
        return [max(abs(float(getattr(s.coefficients, edge, 0.0))) for edge in both) for s in self.sets]

    @cached_property
    def _full(self) -> Array:
        known: dict[int, float] = {}
        return np.array([known.setdefault(id(s), full_thrust(s.coefficients)) for s in self.sets])

    @cached_property
    def _believed(self) -> tuple[Any, ...]:
        return tuple(each.coefficients for each in self.sets)

    @cached_property
    def _fields(self) -> dict[str, tuple[str, ...]]:
        """Coefficients of each group that these thrusters have and that are not zero."""
        return {name: tuple(f for f in of if getattr(self._believed[0], f, 0.0)) for name, of in GROUPS.items()}

    @cached_property
    def _switched_on(self) -> tuple[ActiveVehicleEffect, ...]:
        return active_effects(self.vehicle, self.sets)

    @cached_property
    def _coefficients(self) -> Callable[[_Changes, _Sizes, _Sizes], VehicleCoefficients]:
        """Coefficients of the vehicle with numbers changed by so much, (name, change) each, thrusters displaced, see
        `_displacements`, and `PRODUCTS`.
        """
        base = self.vehicle.values

        def changed(changes: _Changes, moved: _Sizes, products: _Sizes) -> VehicleCoefficients:
            values = {n: admissible(n, base.get(n, 0.0) + v) for n, v in changes}
            vehicle = self.vehicle.with_values(values, source="unknown") if values else self.vehicle
            c = _slanted(vehicle.coefficients._replace(full_thrust=self._full), products)
            return _placed(c, moved)

        return lru_cache(maxsize=_VEHICLES)(changed)

    @cached_property
    def _sensing(self) -> Callable[[tuple[tuple[Key, float], ...]], SensorCoefficients]:
        """Coefficients of the sensors with what is off of them, key and size each."""
        exact = sensor_coefficients(self.sensors, self.vehicle.values["gravity"])
        exact = exact._replace(imu_read=exact.imu_rotation, velocity_read=exact.velocity_rotation)  # as `log_of` reads

        def off(sizes: tuple[tuple[Key, float], ...]) -> SensorCoefficients:
            found: SensorCoefficients = sensing_with(exact, [_of_sensor(key, size) for key, size in sizes])
            return found

        return lru_cache(maxsize=_VEHICLES)(off)

    @property
    def thrusters(self) -> int:
        """Number of thrusters."""
        return len(self.sets)

    @property
    def mounted(self) -> Stated:
        """How its IMU and velocity log are stated to be mounted."""
        return Stated(self.sensors.imu.rotation, self.sensors.velocity.rotation)

    def wrench_of_water(self, of: tuple[float, float]) -> Array:
        """Return the force and moment (6,) by which water pushes this vehicle where it pushes one of `SIZED` by these
        [N, N m]: the one goes with its area, the other with its volume.
        """
        larger = self.vehicle.values["volume"] / SIZED
        return np.repeat((of[0] * larger ** (2.0 / 3.0), of[1] * larger), 3)

    def groups(self) -> tuple[str, ...]:
        """Return the groups of coefficients that these thrusters have and that are not zero."""
        p = self._believed[0]
        lagged = p.drive_gain == p.k_n  # a lag whose rate sets both: its steady speed must not move with it
        each_way = "c_T1" in self.sets[0].parameters
        driven_alike = GROUPS["drive"] in self.sets[0].model.slots.values()
        passed_over = {
            "rotor" if lagged else "rate",
            *(("thrust",) if each_way else ("c_T1", "c_T2")),
            *(("c_u1", "c_u2") if driven_alike else ("drive",)),
        }
        told = (name for name in GROUPS if self._fields[name] or name == "thrust")
        return tuple(name for name in told if name not in passed_over)

    def stated(self, group: str) -> list[Parameter]:
        """Return the parameters of the thrusters' set that a group of coefficients is made of."""
        first, made = self.sets[0], {*GROUPS[group], *(("thrust_scale",) if group == "thrust" else ())}
        return [p for name, p in first.parameters.items() if made & set(first.model.slots.get(name, (name,)))]

    @property
    def volts_of_table(self) -> bool:
        """Whether the thrusters' set knows the supply in volts, those that the battery's sensor reads."""
        supply = self.sets[0].parameters.get("nominal_supply")
        return supply is not None and supply.value == self.sensors.nominal_voltage

    def layout_with(self, values: Mapping[Key, float]) -> tuple[LayoutEntry, ...]:
        """Return the thrusters where and as these values have them."""
        moved = _displacements(values, self.thrusters)
        c, layout = _placed(self.vehicle.coefficients, moved), list(self.vehicle.layout)
        for i in {key[2] for key in values if key[0] == "own" and key[1] in PLACING}:
            place, axis = c.positions[:, i].tolist(), c.K_t[:3, i].tolist()
            layout[i] = replace(layout[i], position=tuple(place), axis=tuple(axis))
        return tuple(layout)

    def built(
        self,
        values: Mapping[Key, float],
        effects: Sequence[ActiveVehicleEffect] = (),
        *,
        run: int = 0,
        signed: bool = True,
        initial: VehicleState | None = None,
    ) -> Built:
        """Return the model with these values of the unknowns and these effects, for one run."""
        N = self.thrusters
        thrusters, scale = [], np.ones(N)
        for i, p in enumerate(self._believed):
            changed: dict[str, float] = {}
            for name, fields in self._fields.items():
                share = values.get(("shared", name), 0.0) + values.get(("own", name, i), 0.0)
                if share and name == "thrust" and not fields:
                    scale[i] = 1.0 + share
                elif share:
                    changed |= {f: getattr(p, f) * max(1.0 + share, _LEAST_SHARE) for f in fields}
            thrusters.append(p._replace(**changed) if changed else p)
        active = (*self._switched_on, *on_in(effects, run))
        tach = np.tile([1.0, 0.0], (N, 1))
        for effect in active:
            for i in range(N) if effect.thruster is None else (effect.thruster,):
                if effect.id == "tach_scale":
                    tach[i, 0] *= 1.0 + next(iter(effect.sizes.values()))
                elif effect.id == "tach_lag":
                    tach[i, 1] = max(next(iter(effect.sizes.values())), 0.0)
        products = tuple(values.get(("product", pair), 0.0) for pair in PRODUCTS)
        body = body_with(self._coefficients(_changes(values, run), _displacements(values, N), products), active)
        body = body._replace(thrust_scale=body.thrust_scale * scale)
        if initial is not None and not body.turning.all():  # a rotor that has stopped stood still before
            thrusters_then = initial.thrusters.copy()
            thrusters_then[body.turning == 0.0, 0] = 0.0
            initial = initial._replace(thrusters=thrusters_then)
        own = thruster_effects([a for a in active if a.id not in (*_TACH, *OF_LOG)], N)
        part = self.period / PARTS
        settings = VehicleSettings(
            coefficients=body, thrusters=tuple(thrusters), effects=own or (), initial=initial,
            largest_step=part / ceil(part / STEP - 1e-9),
        )  # fmt: skip
        off = tuple((key, size) for key, size in values.items() if key[0] == "sensor" and size)
        c = sensing_with(self._sensing(off), active)
        gyro = tuple(b + values.get(("gyro", run, a), 0.0) for a, b in enumerate(c.gyro_bias))
        force = tuple(b + values.get(("force", run, a), 0.0) for a, b in enumerate(c.force_bias))
        tilt = tuple(b + values.get(("tilt", run, a), 0.0) for a, b in enumerate(c.attitude_bias))
        power = {
            name: getattr(c, name) * (1.0 + values.get(("power", name), 0.0))
            for name in ("nominal_voltage", "idle_current", "current_at_full")
        }
        sensors = c._replace(
            gyro_bias=gyro, force_bias=force, attitude_bias=tilt,
            imu_late=c.imu_late + values.get(("late", "imu"), 0.0), signed=int(signed), **power,
        )  # fmt: skip
        level, rate = (values.get(("charge", run, what), 0.0) for what in CHARGE)
        return Built(settings, sensors, tach, (level, rate))


def _of_sensor(key: Key, size: float) -> ActiveVehicleEffect:
    """Return by what a sensor is off as an effect, within its range."""
    _, effect, sensor, axis = key
    of = VEHICLE_LIBRARY[effect].parameters[0]
    sizes = {of.name: min(max(size, of.lower), of.upper)}
    return ActiveVehicleEffect(id=effect, sizes=sizes, sensor=sensor, axis=axis)


def _displacements(values: Mapping[Key, float], thrusters: int) -> _Sizes:
    """Return by how much thrusters are turned and moved, those of one kind of `PLACING` after those of another."""
    return tuple(values.get(("own", name, i), 0.0) for name in PLACING for i in range(thrusters))


def _slanted(c: VehicleCoefficients, products: _Sizes) -> VehicleCoefficients:
    """Return the coefficients with products of inertia, those of `PRODUCTS`."""
    if not any(products):
        return c
    M_A = c.M_A
    for axes, size in zip(PRODUCTS.values(), products, strict=True):
        M_A = coupled(M_A, axes, size)
    return c._replace(M_A=M_A)


def _placed(c: VehicleCoefficients, moved: _Sizes) -> VehicleCoefficients:
    """Return the coefficients with thrusters displaced, see `_displacements`."""
    if not any(moved):
        return c
    along = normals(np.ascontiguousarray(c.K_t[:3]))
    first, second, along_first, along_second = np.reshape(moved, (len(PLACING), -1))
    placed: VehicleCoefficients = displaced(c, first, second, along_first * along[0] + along_second * along[1])
    return placed


def _changes(values: Mapping[Key, float], run: int) -> _Changes:
    """Return by how much parameters of the vehicle are changed in one run, (name, change) each.

    What runs differ by sums to zero over all of them: what is the same in all is the vehicle's.
    """
    found: dict[str, float] = {}
    for key, value in values.items():
        if key[0] == "vehicle" and value:
            found[key[1]] = found.get(key[1], 0.0) + value
        elif key[0] == "trim" and value and acts_in(key, run):
            found[key[1]] = found.get(key[1], 0.0) + value * share_of_trim(key[2], run)
    return tuple(found.items())


def admissible(name: str, value: float) -> float:
    """Return a number of a vehicle within its range, in its own unit."""
    definition = definition_of(name)
    return value if definition is None else min(max(value, definition.lower), definition.upper)
