"""A vehicle's plant from names or files:   load_vehicle_settings("ngs", thruster="hl")."""

from collections.abc import Iterable
from pathlib import Path

from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from rov_sim.vehicle.plant import LARGEST_STEP, VehicleSettings
from rov_sim.vehicle.settings import vehicle_settings
from rov_sim.vehicle.truth import VehicleState
from thruster_model.parameter_set import ParameterSet
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set import VehicleSet
from thruster_model.vehicle_set_io import load_vehicle_set

__all__ = ["load_thruster_sets", "load_vehicle_settings"]


def load_thruster_sets(vehicle: VehicleSet, thruster: str | Path | None = None) -> tuple[ParameterSet, ...]:
    """Return the parameter set of each thruster: that of a name or file for all, or those that the vehicle names."""
    names = [str(thruster)] * len(vehicle.layout) if thruster is not None else list(vehicle.models)
    loaded = {name: load_parameter_set(name) for name in dict.fromkeys(names)}
    return tuple(loaded[name] for name in names)


def load_vehicle_settings(
    vehicle: str | Path | VehicleSet,
    *,
    thruster: str | Path | None = None,
    effects: Iterable[ActiveVehicleEffect] = (),
    initial: VehicleState | None = None,
    largest_step: float = LARGEST_STEP,
) -> VehicleSettings:
    """Return the settings of a plant.

    Args:
        vehicle: a set, or its name or file.
        thruster: parameter set of all thrusters, a name or a file; None: those that the vehicle names.
        effects, initial, largest_step: see `vehicle_settings`.

    Raises:
        VehicleError, ParameterSetError: what is wrong.
    """
    chosen = vehicle if isinstance(vehicle, VehicleSet) else load_vehicle_set(vehicle)
    sets = load_thruster_sets(chosen, thruster)
    return vehicle_settings(chosen, sets, effects=effects, initial=initial, largest_step=largest_step)
