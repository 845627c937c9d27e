"""From paths to a diagnosis, and from a diagnosis to files."""

import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from gap_diagnosis.diagnosis import Diagnosis, diagnose
from gap_diagnosis.diagnosis_json import as_json
from gap_diagnosis.recording_io import read_recordings
from safe_files.whole_files_io import write_whole
from thruster_model.effects.active import ActiveEffects
from thruster_model.parameter_set import ParameterSet
from thruster_model.parameter_set_io import load_parameter_set, write_parameter_set

__all__ = ["diagnose_paths", "package_version", "with_effect", "write_diagnosis"]

Progress = Callable[[str], None]


def diagnose_paths(
    paths: Sequence[Path], parameter_set_path: Path | str, excluded: tuple[str, ...] = (), seed: int = 0
) -> dict[str, Any]:
    """Return the content of diagnosis.json for runs, with held-out "predictions" by kind, run and channel beside it."""
    parameter_set = load_parameter_set(str(parameter_set_path))
    found = diagnose(read_recordings(paths), parameter_set, excluded=excluded, seed=seed)
    content = as_json(
        found,
        runs=[Path(path).resolve().name for path in paths],
        parameter_set=parameter_set.name,
        version=package_version(),
        seed=seed,
    )
    if "with_effect" in found.predictions and found.problem is not None:
        content["predictions"] = {kind: _by_run(found, kind) for kind in ("retuned", "with_effect")}
    return content


_PLAIN = {"speed": "n", "axial": "axial", "ambient": "ambient", "thrust": "thrust", "torque": "torque"}


def _by_run(found: Diagnosis, kind: str) -> dict[str, dict[str, list[float]]]:
    result: dict[str, dict[str, list[float]]] = {}
    assert found.problem is not None
    for each in found.problem.series:
        rows = np.asarray(found.predictions[kind][each.rows])
        name = found.problem.recordings[each.recording].name
        result.setdefault(name, {})[_PLAIN[each.signal]] = rows.tolist()
    return result


def package_version() -> str:
    """Return the version of this package."""
    try:
        return version("gap_diagnosis")
    except PackageNotFoundError:
        return "unknown"


_BEYOND = 2.0


def with_effect(found: Diagnosis) -> ParameterSet:
    """Return the parameter set, re-tuned, with the diagnosed effects switched on: ready for simulator and fit."""
    base, fitted = found.parameter_set, found.retuned
    if fitted is None or found.problem is None:
        return base
    values = {name: fitted.problem.values(fitted.x)[name] for name in found.problem.names}
    deviations = np.sqrt(np.diag(fitted.covariance))
    stated = {name: float(deviations[k]) * found.problem.deviations[name] for k, name in enumerate(found.problem.names)}
    source = f"{base.name}, re-tuned by a diagnosis"
    beyond = [f"{n} by {fitted.x[k]:+.1f}" for k, n in enumerate(found.problem.names) if abs(fitted.x[k]) > _BEYOND]
    if beyond:
        source += f"; more than {_BEYOND:g} stated deviations away: {', '.join(beyond)}"
    retuned = base.with_values(values, source=source, standard_deviations=stated)
    sizes = {name: dict(s) for name, s in base.effects.sizes.items()}
    for claim in found.verdict.claims:
        for name, size in claim.sizes.items():
            sizes.setdefault(claim.effect, {})[name] = size.value
    return replace(retuned, effects=ActiveEffects(sizes=sizes))


def write_diagnosis(found: Diagnosis, content: dict[str, Any], folder: Path) -> list[Path]:
    """Write diagnosis.json and, where it improves the set, with_effect.yaml to a new or empty folder; return the paths.

    Raises:
        FileExistsError: there are files in the folder already.
    """
    folder.mkdir(parents=True, exist_ok=True)
    parameters = folder / "with_effect.yaml"
    if found.improves:
        write_parameter_set(with_effect(found), parameters)
    result = folder / "diagnosis.json"
    write_whole(result, json.dumps(content, indent=1, allow_nan=False) + "\n")
    return [result, *([parameters] if found.improves else [])]
