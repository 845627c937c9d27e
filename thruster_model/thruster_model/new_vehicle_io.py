"""The text of a new vehicle's set to be edited: each parameter with its meaning and unit as comments."""

import yaml

from thruster_model.new_set_io import commented
from thruster_model.vehicle_parameters import DEFAULTS, defined
from thruster_model.vehicle_set import UNSTATED_DEVIATION, VehicleSet
from thruster_model.vehicle_set_io import dump_vehicle_set, load_vehicle_set

__all__ = ["new_vehicle"]

_HEAD = (
    "A vehicle's set. All values are those of the vehicle that it was written from: replace them, and each `source`, "
    "by your own.",
    "Body axes x forward, y starboard, z down, from an origin of your choice, near the centre of mass. A, L and Q "
    "are about it. Equations: docs/vehicles.md, or `ros2 run rov_sim reference`.",
    "`standard_deviation` says how far a value may be off: one sigma, half of a tolerance. A fit and a diagnosis take "
    f"{100 * UNSTATED_DEVIATION:g} % of the value where there is none: that number stands behind the unit. A 0 without "
    "one counts as exact, but for x_G and y_G: where neither they nor x_B and y_B are stated, they are 0 to within 1 % "
    "of the vehicle's size.",
    "`model` is the thrusters' parameter set, a name or a file beside this one. A thruster with other numbers names "
    "its own set, of the same model.",
)
_THRUSTERS = (
    "In the order of the commands, thruster_0 first. Position [m]; axis: where a positive command pushes the vehicle, "
    "or yaw_deg, pitch_deg or both in its place: yaw_deg 90 is starboard, pitch_deg 90 down, one left out is 0. `hand: "
    "right` turns clockwise, seen along the axis, while it pushes along it; leave it out where you do not know."
)


def new_vehicle(base: str) -> str:
    """Return the commented YAML text of a new vehicle's set, which the reader of sets takes as it is.

    Args:
        base: a vehicle, by name or file, whose values it has; a file's own comments are not copied.

    Raises:
        VehicleError: it cannot be read.
    """
    vehicle = load_vehicle_set(base)
    document = yaml.safe_load(dump_vehicle_set(vehicle))
    parts = [commented(*_HEAD)]
    for key, value in document.items():
        if key == "parameters":
            parts += ["parameters:\n", *(_parameter(n, entry, more=_taken(vehicle, n)) for n, entry in value.items())]
            parts += [_unstated(name, default) for name, default in DEFAULTS.items() if name not in value]
        else:
            parts.append(commented(_THRUSTERS) if key == "thrusters" else "")
            parts.append(_dumped({key: value}))
    return "".join(parts)


def _parameter(name: str, entry: object, mark: str = "", more: str = "") -> str:
    definition = defined(name)
    return f"  # {definition.meaning} [{definition.unit}]{more}\n  {mark}{_dumped({name: entry})}"


def _taken(vehicle: VehicleSet, name: str) -> str:
    """Return the deviation that is taken where the set states none, "" where it does."""
    stated = vehicle.parameters[name].standard_deviation is not None
    return "" if stated else f"; standard_deviation as long as none is stated: {vehicle.deviation(name):.3g}"


def _unstated(name: str, default: float) -> str:
    """Return a line to take the # off, for what holds where nothing is stated."""
    entry = {"value": default, "unit": defined(name).unit, "source": "taken where none is stated"}
    return _parameter(name, entry, "# ")


def _dumped(entry: dict[str, object]) -> str:
    """Return an entry as YAML, what is innermost in one line."""
    flow = False if all(isinstance(value, str) for value in entry.values()) else None
    return yaml.safe_dump(entry, sort_keys=False, width=1000, allow_unicode=True, default_flow_style=flow)
