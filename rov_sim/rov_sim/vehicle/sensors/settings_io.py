"""Settings of a vehicle's sensors from YAML, each with value, unit and source, as in `vehicle_sensors.yaml`."""

from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from rov_sim.vehicle.sensors.settings import MOUNTED, QUANTITIES, Sensor, VehicleSensors
from run_bag.importers.conversions import Conversion, conversion
from safe_files.yaml_io import yaml_mapping
from thruster_model.errors import ThrusterModelError

__all__ = ["SensorSettingsError", "load_sensors", "parse_sensors", "usual_settings"]

_USUAL = "vehicle_sensors.yaml"
_SHARED = {"rate": "Hz", "phase": "s", "delay": "s", "lost_share": "1", "lost_length": "1"}
_PLACE = {"position": "m", "rotation": "rad"}
_OWN = {
    "tachometer": {"signed": "1"},
    "battery": {"nominal_voltage": "V", "current_at_full": "A", "idle_current": "A"},
}
_PARTS = ("noise", "bias", "bias_deviation")
_ENTRY = {"value", "unit", "source"}


class SensorSettingsError(ThrusterModelError, ValueError):
    """Settings that cannot be used; `problems` holds one sentence for each thing that is wrong."""

    def __init__(self, origin: str, problems: list[str]) -> None:
        self.origin, self.problems = origin, tuple(problems)
        super().__init__("\n".join(f"{origin}: {problem}" for problem in problems))


def load_sensors(path: str | Path | None = None) -> VehicleSensors:
    """Return the sensors of a YAML file; without one those that come with the package.

    Raises:
        SensorSettingsError: no such file, or its content is wrong.
    """
    if path is None:
        return parse_sensors("", origin=_USUAL)
    if not Path(path).is_file():
        raise SensorSettingsError(str(path), ["expected a YAML file; found none"])
    return parse_sensors(Path(path).read_text("utf-8"), origin=str(path))


def parse_sensors(text: str, *, origin: str) -> VehicleSensors:
    """Return the sensors that a YAML text describes; what it leaves out is as in the package's file.

    origin: names it in errors.
    """
    usual = usual_settings()
    document = yaml_mapping(text, SensorSettingsError, origin) if text.strip() else {}
    known = ", ".join(QUANTITIES)
    problems = [f"key '{key}': expected one of {known}" for key in document if key not in QUANTITIES]
    values: dict[str, dict[str, Any]] = {}
    for name in QUANTITIES:
        entries = document.get(name, {})
        if not isinstance(entries, Mapping):
            problems.append(f"key '{name}': expected the settings of this sensor; found {entries!r}")
            continue
        values[name], wrong = _parse_sensor(name, {**usual[name], **entries})
        problems += wrong
    if problems:
        raise SensorSettingsError(origin, problems)
    own = {key: values[name].pop(key) for name, keys in _OWN.items() for key in keys}
    sensors: dict[str, Any] = {name: Sensor(**_columns(name, values[name])) for name in QUANTITIES}
    try:
        return VehicleSensors(**sensors, **own, origin=origin)
    except ValueError as error:
        raise SensorSettingsError(origin, str(error).split("\n")) from error


def usual_settings() -> Mapping[str, Any]:
    """Return the package's settings as they are written: value, unit and source of each entry of each sensor."""
    file = resources.files("rov_sim") / "vehicle/sensors" / _USUAL
    return yaml_mapping(file.read_text("utf-8"), SensorSettingsError, _USUAL)


def _units(name: str) -> dict[str, tuple[str, int]]:
    """Return unit and number of values of each key of a sensor."""
    units = {key: (unit, 1) for key, unit in (_SHARED | _OWN.get(name, {})).items()}
    units |= {key: (_PLACE[key], 3) for key in MOUNTED.get(name, ())}
    return units | {f"{q.name}_{part}": (q.unit, q.axes) for q in QUANTITIES[name] for part in _PARTS}


def _read(name: str) -> str:
    """Return the keys of a sensor that a diagnosis reads; all others are a simulation's."""
    own = [*MOUNTED.get(name, ()), *(_OWN["battery"] if name == "battery" else ())]
    return f"{', '.join(own)} alone" if own else "none of it"


def _parse_sensor(name: str, entries: Mapping[Any, Any]) -> tuple[dict[str, Any], list[str]]:
    """Return values by key and what is wrong with them."""
    units, values = _units(name), {}
    problems: list[str] = []
    for key, entry in entries.items():
        where = f"key '{name}.{key}"
        if key not in units:
            problems.append(f"{where}': unknown; known are {', '.join(units)}; a diagnosis reads {_read(name)}")
            continue
        if not isinstance(entry, Mapping) or set(entry) != _ENTRY:
            problems.append(f"{where}': expected value, unit and source; found {entry!r}")
            continue
        unit, count = units[key]
        convert = conversion(str(entry["unit"]), unit)
        if convert is None:
            problems.append(f"{where}.unit': expected '{unit}'; found {entry['unit']!r}")
        value = _value(entry["value"], count, truth=key == "signed", each=key in _PLACE)
        if value is None:
            problems.append(f"{where}.value': expected {_expected(key, count)}; found {entry['value']!r}")
        values[str(key)] = value if convert is None or value is None else _converted(value, convert)
    return values, problems


def _converted(value: Any, convert: Conversion) -> Any:
    """Return a value, see `_value`, in our unit."""
    if isinstance(value, bool):
        return value
    numbers = convert(np.array(value)).tolist()
    return tuple(numbers) if isinstance(value, tuple) else numbers


def _expected(key: str, count: int) -> str:
    """Return what the value of a key is, in words."""
    if key == "signed":
        return "true or false"
    if key in _PLACE:
        return f"{count} numbers"
    return "a number" if count == 1 else f"a number or {count}"


def _value(value: Any, count: int, *, truth: bool, each: bool) -> Any:
    """Return a truth value, a float, or a tuple of `count` floats where there are several; None where it is neither.

    each: whether one number cannot stand for all of them.
    """
    if truth:
        return value if isinstance(value, bool) else None
    given = value if isinstance(value, list) else [value] * (1 if each else count)
    try:
        numbers = tuple(float(x) for x in given if not isinstance(x, bool))
    except (TypeError, ValueError):
        return None
    if len(numbers) != count:
        return None
    return numbers[0] if count == 1 else numbers


def _columns(name: str, values: dict[str, Any]) -> dict[str, Any]:
    """Return the arguments of `Sensor`: the parts of all quantities in a row."""
    columns = dict(values)
    for part in _PARTS:
        row: tuple[float, ...] = ()
        for q in QUANTITIES[name]:
            value = columns.pop(f"{q.name}_{part}")
            row += (value,) if q.axes == 1 else value
        columns[part] = row
    return columns
