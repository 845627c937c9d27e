"""From a vehicle's set, its thrusters' sets and effects to what its plant is made of."""

from collections.abc import Iterable, Sequence

import numpy as np

from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY, ActiveVehicleEffect, body_with, thruster_effects
from rov_sim.vehicle.plant import LARGEST_STEP, VehicleSettings
from rov_sim.vehicle.truth import VehicleState
from run_bag.unit_spelling import same_unit
from thruster_model.effect_entry import EffectEntry
from thruster_model.effects import stages
from thruster_model.equations.thruster import ThrusterCoefficients
from thruster_model.errors import VehicleError
from thruster_model.flow_tank import simulate
from thruster_model.parameter_set import ParameterSet
from thruster_model.vehicle_set import VehicleSet

__all__ = ["active_effect", "active_effects", "full_thrust", "vehicle_settings"]

_SETTLED = 10.0  # s
_FULL_THROTTLE = 5.0  # V


def active_effect(entry: EffectEntry) -> ActiveVehicleEffect:
    """Return the effect of a set's entry; ValueError says what is wrong with it."""
    effect = VEHICLE_LIBRARY.get(entry.id) or stages.LIBRARY.get(entry.id)
    units = {p.name: p.unit for p in effect.parameters} if effect is not None else {}
    wrong = [
        f"key 'effects.{entry.id}.{name}.unit': expected '{units[name]}'; found '{unit}'"
        for name, unit in entry.units.items()
        if name in units and not any(same_unit(unit, each) for each in units[name].replace(" or ", ", ").split(", "))
    ]
    if wrong:
        raise ValueError("; ".join(wrong))
    return ActiveVehicleEffect(
        id=entry.id, sizes=entry.sizes, thruster=entry.thruster, other=entry.other, axis=entry.axis,
        sensor=entry.sensor, kind=entry.kind,
    )  # fmt: skip


def active_effects(vehicle: VehicleSet, sets: Sequence[ParameterSet] = ()) -> tuple[ActiveVehicleEffect, ...]:
    """Return the effects that a vehicle's set and those of its thrusters switch on.

    Raises:
        VehicleError: effects that there are not on a vehicle, of another form, or that this one cannot have.
    """
    problems, found = [], []
    for entry in vehicle.effects:
        try:
            found.append(active_effect(entry))
        except ValueError as error:
            problems.append(str(error))
    for i, thruster in enumerate(sets):
        for name, sizes in thruster.effects.sizes.items():
            try:
                found.append(ActiveVehicleEffect(id=name, sizes=sizes, thruster=i))
            except ValueError as error:
                problems.append(f"{thruster.name}: {error}")
    if not problems:
        N = len(vehicle.layout)
        try:  # what the vehicle lacks for them is told with its file, before any run is read
            thruster_effects(found, N)
            body_with(vehicle.coefficients._replace(full_thrust=np.ones(N)), found)
        except ValueError as error:
            problems.append(str(error))
    if problems:
        raise VehicleError(vehicle.origin, problems)
    return tuple(found)


def full_thrust(p: ThrusterCoefficients) -> float:
    """Return the thrust [N] at full throttle, once settled, in water that stands still."""
    still = p._replace(k_U=0.0, k_UU=0.0, k_TU=0.0)
    return float(simulate(still, np.full(round(_SETTLED / 0.1), _FULL_THROTTLE), 0.1).thrust[-1])


def vehicle_settings(
    vehicle: VehicleSet,
    sets: Sequence[ParameterSet],
    *,
    effects: Iterable[ActiveVehicleEffect] = (),
    initial: VehicleState | None = None,
    largest_step: float = LARGEST_STEP,
) -> VehicleSettings:
    """Return what the plant of a vehicle is made of.

    Args:
        vehicle: its set; effects that it switches on are on.
        sets: of its thrusters in order, with their effects; one set: of all.
        effects: beyond those.
        initial: state at the first instant; at rest where none is given.
        largest_step: upper bound of the integration step [s].

    Raises:
        VehicleError: what is wrong.
    """
    N = len(vehicle.layout)
    if len(sets) not in (1, N):
        raise VehicleError(vehicle.origin, [f"sets of thrusters: expected 1 or {N}; found {len(sets)}"])
    each = tuple(sets) * N if len(sets) == 1 else tuple(sets)
    active = (*active_effects(vehicle, each), *effects)
    thrusters = tuple(s.coefficients for s in each)
    c = vehicle.coefficients._replace(full_thrust=np.array([full_thrust(p) for p in thrusters]))
    try:
        values = thruster_effects(active, N)
        body = body_with(c, active)
    except ValueError as error:
        raise VehicleError(vehicle.origin, [str(error)]) from error
    return VehicleSettings(
        coefficients=body, thrusters=thrusters, effects=values or (), initial=initial, largest_step=largest_step
    )
