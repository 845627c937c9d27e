"""A study's plan as plain data: what is written beside its results, sent to workers, and compared when resuming."""

import json
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from rov_sim.bench_study.controllers import InputMap, parameter_sets
from rov_sim.bench_study.experiment import Conditions
from rov_sim.closed_loop import CALM, ProcessNoise, Timing
from rov_sim.rig_sensors import Rig
from thruster_model.effects.active import ActiveEffects
from thruster_model.errors import ParameterSetError
from thruster_model.parameter_set import ParameterSet
from thruster_model.parameter_set_io import (
    available_sets,
    dump_parameter_set,
    load_parameter_set,
    parse_parameter_set,
)

__all__ = ["GivenPlant", "conditions_of", "load_plant", "plan_text"]


class GivenPlant(NamedTuple):
    """A plant to study: its set, what pushes it, and where it was fitted to runs, the set as fitted without each."""

    truth: ParameterSet
    process_noise: ProcessNoise = CALM
    without: Mapping[str, ParameterSet] = MappingProxyType({})


def plan_text(
    plant: GivenPlant, *, deviation: float, form: str, beliefs: str, rig: Rig, timing: Timing, seed: int,
    input_map: InputMap | None = None, table: Any = None,
) -> str:  # fmt: skip
    """Return the plan as JSON, the same text for the same plan."""
    believed = {name: dump_parameter_set(load_parameter_set(s)) for name, s in parameter_sets(beliefs).items()}
    plan = {
        "truth": dump_parameter_set(plant.truth),
        "process_noise": vars(plant.process_noise),
        "deviation": deviation,
        "believed": believed,
        "form": form,
        "beliefs": beliefs,
        "input_map": None if input_map is None else list(input_map),
        "table": None if table is None else np.asarray(table).tolist(),
        "rig": vars(rig),
        "timing": vars(timing),
        "seed": seed,
    }
    return json.dumps(plan, indent=1, sort_keys=True)


@lru_cache(maxsize=16)
def conditions_of(plan: str) -> Conditions:
    """Return the conditions that a plan describes."""
    given: Mapping[str, Any] = json.loads(plan)
    sets = {text: parse_parameter_set(text, origin="plan") for text in {*given["believed"].values(), given["truth"]}}
    return Conditions(
        truth=sets[given["truth"]],
        deviation=given["deviation"],
        believed={name: sets[text] for name, text in given["believed"].items()},
        form=given["form"],
        beliefs=given["beliefs"],
        input_map=None if given["input_map"] is None else InputMap(*given["input_map"]),
        table=None if given["table"] is None else np.array(given["table"]),
        rig=Rig(**given["rig"]),
        timing=Timing(**given["timing"]),
        seed=given["seed"],
        process_noise=ProcessNoise(**given["process_noise"]),
    )


def load_plant(name_or_path: str) -> GivenPlant:
    """Return a plant: a known set, a YAML file, or what a `diagnosis.json` makes of one.

    That has re-tuned parameters, the process noise that was learned and, where whole runs were left out in turn, the
    parameters and effects that were fitted without each of them.

    Raises:
        ParameterSetError: neither of these, or its content is wrong.
    """
    path = Path(name_or_path)
    if path.suffix != ".json":
        return GivenPlant(load_parameter_set(name_or_path))
    try:
        diagnosis = json.loads(path.read_text("utf-8"))
        found, title = diagnosis["retuned_parameters"], diagnosis["provenance"]["parameter_set"]
        values = {name: float(entry["value"]) for name, entry in found.items()}
        budget = diagnosis.get("budget") or {}
        noise = ProcessNoise(**budget.get("process_noise", {}))
        told = dict(budget.get("with_causes_without_each_run") or {})
        without = {run: (dict(fit["parameters"]), dict(fit["effects"])) for run, fit in told.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        expected = "expected a diagnosis.json with retuned_parameters and provenance.parameter_set"
        raise ParameterSetError(str(path), [f"{expected}; found {error!r}"]) from error
    for known in available_sets():
        nominal = load_parameter_set(known)
        if nominal.name == title:
            source = f"{path.name}: re-tuned from {known}"
            fitted = {run: _fitted(nominal, *fit, f"{source}, without {run}") for run, fit in without.items()}
            return GivenPlant(_fitted(nominal, values, {}, source), noise, fitted)
    raise ParameterSetError(str(path), [f"expected a diagnosis of one of the known sets; found {title!r}"])


def _fitted(
    nominal: ParameterSet, values: Mapping[str, float], sizes: Mapping[str, Mapping[str, float]], source: str
) -> ParameterSet:
    """Return a set with fitted values and, where sizes are given, effects; deviations are those stated."""
    kept = {name: p.standard_deviation for name, p in nominal.parameters.items()}
    known = {k: v for k, v in values.items() if k in nominal.parameters}
    fitted = nominal.with_values(known, source=source, standard_deviations=kept)
    return replace(fitted, effects=ActiveEffects(sizes=sizes)) if sizes else fitted
