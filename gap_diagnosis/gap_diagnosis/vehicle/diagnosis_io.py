"""A diagnosis of a vehicle from files to files."""

import json
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from gap_diagnosis.diagnose_io import package_version
from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.content import PROGRAMME, content_of
from gap_diagnosis.vehicle.conventions import conventions_of
from gap_diagnosis.vehicle.fit import numbers_of
from gap_diagnosis.vehicle.fit_io import fitted_set
from gap_diagnosis.vehicle.how_far import Errors, left_out_errors
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.log import VehicleLog, fewer_throttles
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.next_experiment import NextExperiment, next_experiment
from gap_diagnosis.vehicle.programmes import Limits
from gap_diagnosis.vehicle.programmes_io import write_programme
from gap_diagnosis.vehicle.report_io import report_of
from gap_diagnosis.vehicle.search import Found, search
from gap_diagnosis.vehicle.stretches import stretches_of
from gap_diagnosis.vehicle.verdict import Verdict, judged
from rov_sim.vehicle.sensors.settings_io import load_sensors
from rov_sim.vehicle.settings import active_effects
from rov_sim.vehicle.settings_io import load_thruster_sets
from safe_files.whole_files_io import new_folder, write_whole
from thruster_model.effect_entry import EffectEntry
from thruster_model.vehicle_set_io import dump_vehicle_set, load_vehicle_set

__all__ = ["Diagnosed", "diagnosed", "load_model", "names_of", "provenance_of", "written"]


@dataclass(frozen=True, kw_only=True)
class Diagnosed:
    """The verdict, what goes into diagnosis.json, errors of free runs, the vehicle's set, re-tuned, with the effects as
    YAML ("": see `_with_effect`), and what to record next, where that was asked for."""

    verdict: Verdict
    content: dict[str, Any]
    errors: tuple[Errors, ...]
    with_effect: str
    model: Model
    proposed: NextExperiment | None = None


def load_model(vehicle: str, thruster: str | None = None, sensors: Path | None = None) -> Model:
    """Return the model of a vehicle's set, of its thrusters' set where one is named, of the sensors' settings.

    Raises:
        ThrusterModelError: what is wrong with one of them, or with the effects that they switch on.
    """
    chosen = load_vehicle_set(vehicle)
    sets = load_thruster_sets(chosen, thruster)
    active_effects(chosen, sets)
    return Model(vehicle=chosen, sets=sets, sensors=load_sensors(sensors))


def names_of(runs: Sequence[Path]) -> list[str]:
    """Return the name of each run's folder, with that of the folder it is in where several have the same."""
    whole = [path.resolve() for path in runs]
    alike = Counter(path.name for path in whole)
    return [path.name if alike[path.name] == 1 else f"{path.parent.name}/{path.name}" for path in whole]


def provenance_of(runs: Sequence[Path], model: Model) -> dict[str, Any]:
    """Return what a result was made of: runs, vehicle, its thrusters' set and the version."""
    return {
        "runs": names_of(runs), "vehicle": model.vehicle.name,
        "parameter_set": model.sets[0].name, "version": package_version(), "seed": 0,
    }  # fmt: skip


def diagnosed(
    model: Model, logs: Sequence[VehicleLog], provenance: dict[str, Any],
    told: Callable[[str], None] = lambda text: None,
    only: Callable[[Hypothesis], bool] = lambda h: True, *, how_far: bool = True, experiment: Limits | None = None,
    longest: float | None = None,
) -> Diagnosed:  # fmt: skip
    """Return the diagnosis of recordings; experiment: limits of the next one, if one is to be proposed; longest: see
    `stretches_of`."""
    conventions = conventions_of(model, logs)
    logs = [conventions.read(log) for log in logs]
    searched, thinned = stretches_of(logs, longest)
    asked = [*fewer_throttles(logs), *thinned]
    for sentence in (*asked, *conventions.sentences):
        told(sentence)
    found = search(model, searched, told, only)
    horizons = [h for h in rules.HORIZONS if h + 4.0 < max(log.duration for log in searched)] if how_far else []
    errors = left_out_errors(found, horizons)
    verdict = judged(found, logs, errors)
    verdict = replace(verdict, summary=" ".join((*conventions.turned, verdict.summary, *asked)))
    if experiment is not None:
        told("next experiment")
    proposed = None if experiment is None else next_experiment(found, verdict, searched, experiment)
    content = content_of(
        verdict, found, errors, conventions, logs, provenance, proposed, experiment is not None
    )  # fmt: skip
    return Diagnosed(
        verdict=verdict, content=content, errors=errors, with_effect=_with_effect(model, found, verdict, errors),
        model=model, proposed=proposed,
    )  # fmt: skip


def _with_effect(model: Model, found: Found, verdict: Verdict, errors: Sequence[Errors]) -> str:
    """Return the vehicle's set, re-tuned, with what is claimed; "" where nothing is and re-tuning does not help either.

    Where the verdict is unknown numbers have taken over what has no name: they are none of the vehicle.
    """
    steps: tuple[float, ...] = errors[0].steps if errors else ()
    helps = verdict.name in ("no_gap", "parameters", "effect") and len(steps) > 1 and steps[1] < steps[0]
    if verdict.name == "unknown" or not (verdict.claims or helps):
        return ""
    tuned = fitted_set(model, numbers_of(found.stages[-1].fit, found.nuisances))
    on = tuple(_entry(c.refined) for c in verdict.claims)
    return dump_vehicle_set(replace(tuned, name=f"{model.vehicle.name}, diagnosed", effects=(*tuned.effects, *on)))


def _entry(refined: Any) -> EffectEntry:
    h, active = refined.hypothesis, refined.active
    return EffectEntry(
        id=h.effect, sizes=dict(active.sizes), thruster=h.thruster, other=h.other, axis=h.axis, sensor=h.sensor,
        kind=h.kind, units={n: unit for n, unit in h.units.items() if n in active.sizes},
    )  # fmt: skip


def written(found: Diagnosed, out: Path) -> list[Path]:
    """Write diagnosis.json, report.html and, where there are, with_effect.yaml and the next experiment into a new or
    empty folder."""
    report = report_of(
        found.content, found.model.vehicle, found.errors, found.with_effect, f"Diagnosis of {found.model.vehicle.name}"
    )
    with new_folder(out) as folder:
        paths = [
            report.write(folder / "report.html"),
            write_whole(folder / "diagnosis.json", json.dumps(found.content, indent=1)),
        ]
        if found.with_effect:
            paths.append(write_whole(folder / "with_effect.yaml", found.with_effect))
        if found.proposed is not None:
            paths.append(write_programme(found.proposed.programme, found.model, folder / PROGRAMME))
    return [out / path.name for path in paths]
