"""Scripts of set points as YAML files.

moves:
  - {time: 2.0, shape: quintic, duration: 4.0, size: {surge: 0.2, pitch: 0.5}}     # s, m/s, rad
  - {time: 20.0, shape: sine, duration: 12.0, period: 6.0, size: {yaw: 0.3}}
end: 42.0                                                                          # s; optional
"""

import math
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from thruster_control.errors import ScriptError
from thruster_control.vehicle_set_points import Move, Script, script_of
from thruster_model.set_document_io import mapping_of

__all__ = ["known_scripts", "load_script", "parse_script"]

_KEYS = {"time", "shape", "size", "duration", "period"}


def known_scripts() -> tuple[str, ...]:
    """Return the names of the scripts that come with this package."""
    folder = files("thruster_control") / "vehicle_scripts"
    return tuple(sorted(each.name.removesuffix(".yaml") for each in folder.iterdir() if each.name.endswith(".yaml")))


def load_script(name_or_path: str | Path) -> Script:
    """Return a script by its name, or from a YAML file.

    Raises:
        ScriptError: it cannot be read, or all that is wrong with it.
    """
    given = str(name_or_path)
    if given in known_scripts():
        return parse_script((files("thruster_control") / "vehicle_scripts" / f"{given}.yaml").read_text("utf-8"), given)
    if not given.endswith((".yaml", ".yml")):
        raise ScriptError(given, [f"expected a YAML file or one of the known scripts {', '.join(known_scripts())}"])
    try:
        text = Path(given).read_text("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise ScriptError(given, [f"cannot be read: {error}"]) from error
    return parse_script(text, given)


def parse_script(text: str, origin: str) -> Script:
    """Return the script that a YAML text describes; `origin` names it in errors."""
    document = mapping_of(text, origin, ScriptError)
    if not isinstance(document.get("moves"), list):
        raise ScriptError(origin, ["key 'moves': expected a list of moves; found none"])
    problems = [f"key '{key}': expected one of moves, end" for key in document if key not in ("moves", "end")]
    moves = []
    for k, entry in enumerate(document["moves"]):
        move, wrong = _move_of(entry)
        problems += [f"move {k}: {problem}" for problem in wrong]
        if move is not None:
            moves.append(move)
    end = document.get("end", math.inf)
    if not _number(end):
        problems.append(f"end: expected a number of seconds; found {end!r}")
    if problems:
        raise ScriptError(origin, problems)
    try:
        return script_of(moves, float(end))
    except ValueError as error:
        raise ScriptError(origin, str(error).split("\n")) from error


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _move_of(entry: Any) -> tuple[Move | None, list[str]]:
    if not isinstance(entry, Mapping) or not {"time", "shape", "size"} <= set(entry) <= _KEYS:
        return None, [f"expected the keys time, shape, size and perhaps duration, period; found {entry!r}"]
    size = entry["size"]
    wrong = [
        f"{name}: expected a number of seconds; found {entry[name]!r}"
        for name in ("time", "duration", "period")
        if not _number(entry.get(name, 0.0))
    ]
    if not isinstance(size, Mapping) or not all(_number(value) for value in size.values()):
        wrong.append(f"size: expected a number for each degree of freedom; found {size!r}")
    if wrong:
        return None, wrong
    times = {name: float(entry.get(name, 0.0)) for name in ("time", "duration", "period")}
    return Move(shape=str(entry["shape"]), size={str(k): float(v) for k, v in size.items()}, **times), []
