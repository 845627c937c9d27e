"""Vehicle sets as YAML files, and the sets that come with the package.

name: ...
source: ...
model: hq                                           parameter set of the thrusters, a name or a file
parameters:
  mass: {value: 13.5, unit: kg, source: "...", standard_deviation: 0.3}
thrusters:
  - {name: T1, position: [0.1, 0.2, 0.0], axis: [1, 0, 0], hand: left}           m, body axes; the axis of any length
  - {name: T2, position: [0.1, -0.2, 0.0], yaw_deg: 30, pitch_deg: -30, model: simplified}   yaw from ahead to starboard
  - {name: T3, position: [0.0, 0.0, 0.0], pitch_deg: 90}                     down; an angle left out is 0
frame: vectored         in place of axes: an ArduSub frame, whose motors are the thrusters in order
effects:                optional
  - {id: thrust_loss, thruster: 2, parameters: {share: {value: 0.3, unit: "1"}}}         thrusters count from 0
"""

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from thruster_model.effect_entry import EffectEntry
from thruster_model.errors import VehicleError
from thruster_model.set_document_io import (
    mapping_of,
    number,
    parameter_entries,
    parameters_of,
    shipped,
    text_of,
    unknown_keys,
    wrong_beside_size,
)
from thruster_model.vehicle_layout import FRAMES, LayoutEntry, frame_axes
from thruster_model.vehicle_set import VehicleSet

__all__ = ["available_vehicles", "dump_vehicle_set", "load_vehicle_set", "parse_vehicle_set"]

_TOP = {"name", "source", "model", "parameters", "thrusters"}
_TOP_OPTIONAL = {"frame", "effects"}
_THRUSTER = {"name", "position", "axis", "yaw_deg", "pitch_deg", "hand", "model"}
_EFFECT = {"id", "thruster", "other", "axis", "sensor", "kind", "parameters"}
_FOLDER = "vehicle_sets"


def available_vehicles() -> tuple[str, ...]:
    """Return the names of the vehicles that come with the package."""
    return shipped(_FOLDER)


def load_vehicle_set(name_or_path: str | Path) -> VehicleSet:
    """Return the vehicle of that name in the package or, failing that, of that YAML file.

    Thrusters' sets that it names are looked for beside its file first.

    Raises:
        VehicleError: neither a known name nor a readable file, or its content is wrong.
    """
    text, origin = text_of(name_or_path, _FOLDER, "vehicles", VehicleError)
    found = parse_vehicle_set(text, origin=origin)
    if str(name_or_path) in available_vehicles():
        return found
    folder = Path(name_or_path).parent
    layout = tuple(replace(each, model=_beside(folder, each.model)) if each.model else each for each in found.layout)
    return replace(found, model=_beside(folder, found.model), layout=layout)


def _beside(folder: Path, model: str) -> str:
    """Return a thrusters' set as it is named, or its path where that is a file in this folder."""
    return str((folder / model).resolve()) if (folder / model).is_file() else model


def parse_vehicle_set(text: str, *, origin: str) -> VehicleSet:
    """Return the vehicle that a YAML text describes; `origin` names it in errors."""
    document = mapping_of(text, origin, VehicleError)
    problems = [f"key '{key}': missing" for key in sorted(_TOP - set(document))]
    problems += unknown_keys("", document, _TOP | _TOP_OPTIONAL)
    parameters = parameters_of(document.get("parameters", {}), problems)
    layout = _layout(document.get("thrusters", []), document.get("frame"), problems)
    effects = _effects(document.get("effects", []), problems)
    if problems:
        raise VehicleError(origin, problems)
    return VehicleSet(
        name=str(document["name"]), source=str(document["source"]), model=str(document["model"]),
        parameters=parameters, layout=layout, effects=effects, origin=origin,
    )  # fmt: skip


def _layout(entries: Any, frame: Any, problems: list[str]) -> tuple[LayoutEntry, ...]:
    if not isinstance(entries, list) or not all(isinstance(entry, Mapping) for entry in entries):
        problems.append(f"key 'thrusters': expected a list of mappings; found {entries!r}")
        return ()
    axes = None
    if frame is not None:
        if frame not in FRAMES:
            problems.append(f"key 'frame': expected one of {', '.join(FRAMES)}; found {frame!r}")
            return ()
        axes = frame_axes(frame)
        if len(axes) != len(entries):
            problems.append(f"key 'thrusters': expected {len(axes)}, the motors of frame {frame}; found {len(entries)}")
            return ()
    found = []
    for i, entry in enumerate(entries):
        key = f"thrusters.{i}"
        wrong = unknown_keys(f"{key}.", entry, _THRUSTER)
        position = _vector(entry.get("position"), f"{key}.position", wrong)
        axis = _axis(entry, None if axes is None else axes[i], key, wrong)
        hand, model = entry.get("hand"), entry.get("model")
        if hand not in (None, "left", "right"):
            wrong.append(f"key '{key}.hand': expected left or right; found {hand!r}")
        problems += wrong
        if not wrong and position is not None and axis is not None:
            name = str(entry.get("name", f"T{i + 1}"))
            found.append(LayoutEntry(name=name, position=position, axis=axis, hand=hand, model=model))
    return tuple(found)


def _vector(value: Any, key: str, problems: list[str]) -> tuple[float, float, float] | None:
    numbers = [number(each) for each in value] if isinstance(value, list) else []
    if len(numbers) == 3:
        x, y, z = numbers
        if x is not None and y is not None and z is not None:
            return x, y, z
    problems.append(f"key '{key}': expected three numbers [x, y, z]; found {value!r}")
    return None


def _axis(entry: Mapping[str, Any], of_frame: Any, key: str, problems: list[str]) -> tuple[float, float, float] | None:
    """Return the direction of forward thrust, of length one; of yaw_deg and pitch_deg one left out is 0."""
    given = [name for name in ("axis", "yaw_deg", "pitch_deg") if name in entry]
    if of_frame is not None:
        if given:
            problems.append(f"key '{key}.{given[0]}': the frame gives the axes; expected none here")
            return None
        x, y, z = map(float, of_frame)
    elif given == ["axis"]:
        axis = _vector(entry["axis"], f"{key}.axis", problems)
        if axis is None:
            return None
        x, y, z = axis
    elif given and given[0] != "axis":
        angles = [number(entry.get(name, 0.0)) for name in ("yaw_deg", "pitch_deg")]
        if angles[0] is None or angles[1] is None:
            problems.append(f"key '{key}': expected numbers yaw_deg and pitch_deg; found {dict(entry)!r}")
            return None
        yaw, pitch = math.radians(angles[0]), math.radians(angles[1])
        x, y, z = math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), math.sin(pitch)
    else:
        problems.append(
            f"key '{key}': expected either axis or yaw_deg and pitch_deg; found {', '.join(given) or 'none'}"
        )
        return None
    length = math.hypot(x, y, z)
    if not 0.0 < length < math.inf:
        problems.append(f"key '{key}.axis': expected a direction; found one of length {length:g}")
        return None
    return x / length, y / length, z / length


def _effects(entries: Any, problems: list[str]) -> tuple[EffectEntry, ...]:
    if not isinstance(entries, list) or not all(isinstance(e, Mapping) and "id" in e for e in entries):
        problems.append(f"key 'effects': expected a list of mappings with an id; found {entries!r}")
        return ()
    found = []
    for i, entry in enumerate(entries):
        key = f"effects.{i}"
        wrong = unknown_keys(f"{key}.", entry, _EFFECT)
        wrong += [
            f"key '{key}.{name}': expected the number of a thruster, from 0; found {entry[name]!r}"
            for name in ("thruster", "other")
            if entry.get(name) is not None and (isinstance(entry[name], bool) or not isinstance(entry[name], int))
        ]
        sizes, units = {}, {}
        parameters = entry.get("parameters", {})
        for name, size in parameters.items() if isinstance(parameters, Mapping) else ():
            value = number(size.get("value")) if isinstance(size, Mapping) else None
            if value is None or not isinstance(size.get("unit"), str):
                wrong.append(f"key '{key}.parameters.{name}': expected value and unit; found {size!r}")
            else:
                sizes[str(name)], units[str(name)] = value, size["unit"]
                wrong += wrong_beside_size(f"{key}.parameters.{name}", size)
        problems += wrong
        if not wrong:
            axis, sensor, kind = (None if entry.get(k) is None else str(entry[k]) for k in ("axis", "sensor", "kind"))
            thruster, other = entry.get("thruster"), entry.get("other")
            found.append(
                EffectEntry(
                    id=str(entry["id"]),
                    sizes=sizes,
                    thruster=thruster,
                    other=other,
                    axis=axis,
                    sensor=sensor,
                    kind=kind,
                    units=units,
                )
            )
    return tuple(found)


def dump_vehicle_set(vehicle: VehicleSet) -> str:
    """Return the vehicle as YAML text that `parse_vehicle_set` reads back to the same numbers."""
    thrusters = []
    for thruster in vehicle.layout:
        row: dict[str, Any] = {
            "name": thruster.name, "position": list(thruster.position), "axis": list(thruster.axis),
        }  # fmt: skip
        row |= {key: value for key in ("hand", "model") if (value := getattr(thruster, key)) is not None}
        thrusters.append(row)
    document: dict[str, Any] = {
        "name": vehicle.name, "source": vehicle.source, "model": vehicle.model,
        "parameters": parameter_entries(vehicle.parameters), "thrusters": thrusters,
    }  # fmt: skip
    if vehicle.effects:
        document["effects"] = [_effect_entry(effect) for effect in vehicle.effects]
    return yaml.safe_dump(document, sort_keys=False, width=1000, allow_unicode=True)


def _effect_entry(effect: EffectEntry) -> dict[str, Any]:
    targets = ("thruster", "other", "axis", "sensor", "kind")
    entry: dict[str, Any] = {"id": effect.id}
    entry |= {key: value for key in targets if (value := getattr(effect, key)) is not None}
    if effect.sizes:
        entry["parameters"] = {
            name: {"value": size, "unit": effect.units.get(name, "1")} for name, size in effect.sizes.items()
        }
    return entry
