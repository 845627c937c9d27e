"""A vehicle's fit as files: fit.json, report.html and vehicle.yaml, the set with the body's numbers as fitted."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gap_diagnosis.vehicle.fit import FittedNumber, VehicleFit, far_off
from gap_diagnosis.vehicle.how_far import FORESEEN
from gap_diagnosis.vehicle.model import Model, admissible
from gap_diagnosis.vehicle.unknowns import OF_RUN, unit_of, words_of
from run_bag.report import Column, Report
from safe_files.whole_files_io import new_folder, write_whole
from thruster_model.vehicle_set import VehicleSet
from thruster_model.vehicle_set_io import dump_vehicle_set

__all__ = ["content_of", "fitted_set", "summary_of", "written"]


def fitted_set(model: Model, numbers: Sequence[FittedNumber]) -> VehicleSet:
    """Return the vehicle's set with the body's numbers and deviations, and the places of its thrusters, as fitted; the
    thrusters' own sets are as they were.

    The source of a number says so where it moved farther than its stated deviation allows.
    """
    vehicle = model.vehicle
    for n in numbers:
        if n.key[0] == "vehicle" and n.told:
            name = n.key[1]
            far = f"; {n.moved / n.before:+.1f} stated deviations away" if n.shifted else ""
            value = admissible(name, vehicle.values.get(name, 0.0) + n.moved)  # as the model takes it, however far
            vehicle = vehicle.with_values({name: value}, source=f"fitted to recordings{far}")
            fitted = replace(vehicle.parameters[name], standard_deviation=n.after)
            vehicle = replace(vehicle, parameters={**vehicle.parameters, name: fitted})
    layout = model.layout_with({n.key: n.moved for n in numbers if n.told})
    return replace(vehicle, name=f"{vehicle.name}, fitted", layout=layout)


def summary_of(fit: VehicleFit) -> str:
    """Return in sentences what the fit says."""
    own = [n for n in fit.numbers if n.key[0] not in OF_RUN]
    open_ones = [n for n in own if not n.told]
    far = far_off(fit.numbers)
    says = [*fit.decided, f"The recordings determine {len(own) - len(open_ones)} of {len(own)} numbers."]
    if far:
        says.append(f"{far} An effect may be behind it.")
    for e in fit.errors:
        nearer = [c for c in FORESEEN if e.fitted[c] < e.as_stated[c]]
        measured = [c for c in FORESEEN if e.as_stated[c] == e.as_stated[c]]
        whose = "recordings left out" if fit.left_out else "the one recording, which is fitted too"
        says.append(
            f"Free runs of {e.horizon:g} s on {whose} come nearer in {len(nearer)} of {len(measured)} measured groups."
        )
    return " ".join(says)


def content_of(model: Model, fit: VehicleFit, provenance: dict[str, Any]) -> dict[str, Any]:
    """Return it for fit.json."""
    values = model.vehicle.values

    def row(n: FittedNumber) -> dict[str, Any]:
        stated = values.get(n.key[1], 0.0) if n.key[0] == "vehicle" else 0.0
        told_with = None if n.together is None else {"name": words_of(n.together[0]), "correlation": n.together[1]}
        return {
            "name": words_of(n.key), "key": list(n.key), "unit": unit_of(n.key), "stated": stated,
            "stated_std": n.before, "value": stated + n.moved, "std": n.after, "determined": n.told,
            "told_with": told_with,
        }  # fmt: skip

    return {
        "summary": summary_of(fit),
        "numbers": [row(n) for n in fit.numbers],
        "free_runs": [
            {"horizon": e.horizon, "as_stated": _finite(e.as_stated), "fitted": _finite(e.fitted)} for e in fit.errors
        ],
        "left_out": fit.left_out,
        "random_wrench": fit.wrench.tolist(),
        "provenance": provenance,
    }


def _finite(table: dict[str, float]) -> dict[str, float | None]:
    return {name: value if np.isfinite(value) else None for name, value in table.items()}


def _report(content: dict[str, Any], vehicle: VehicleSet) -> Report:
    report = Report(f"Fit of {vehicle.name}", content["summary"].split(".")[0], content["provenance"])
    report.section("Answer")
    report.paragraph(content["summary"])
    shares = [n for n in content["numbers"] if n["determined"]]
    rows = [[n["name"], n["stated"], n["stated_std"], n["value"], n["std"], n["unit"]] for n in shares]
    report.table(
        ["number", "stated", "± stated", "fitted", "±", "unit"], rows,
        caption="Numbers that the recordings determine; those of thrusters and of the battery are shares beside 0.",
    )  # fmt: skip
    left = [n for n in content["numbers"] if not n["determined"]]
    if left:
        report.table(
            ["number", Column(name="deviation kept", format=".2f"), "told only together with"],
            [[n["name"], n["std"] / n["stated_std"], (n["told_with"] or {"name": "–"})["name"]] for n in left],
            caption="Numbers that the recordings do not determine: they keep most of their stated deviation.",
        )  # fmt: skip
    report.section("How far")
    whose = "each recording with the numbers of the others" if content["left_out"] else "of the fitted recording itself"
    report.table(
        ["free run", "as stated", "fitted", "unit"],
        [
            [f"{name} after {e['horizon']:g} s", e["as_stated"][name], e["fitted"][name], unit]
            for e in content["free_runs"]
            for name, unit in FORESEEN.items()
            if e["as_stated"][name] is not None or e["fitted"][name] is not None
        ],
        caption=f"Root mean square errors of free runs, {whose}.",
    )  # fmt: skip
    return report


def written(model: Model, fit: VehicleFit, provenance: dict[str, Any], out: Path) -> list[Path]:
    """Write fit.json, report.html and vehicle.yaml into a new or empty folder; return their paths."""
    content, vehicle = content_of(model, fit, provenance), dump_vehicle_set(fitted_set(model, fit.numbers))
    report = _report(content, model.vehicle)
    report.section("Files")
    report.download("Vehicle set as fitted", "vehicle.yaml", vehicle)
    with new_folder(out) as folder:
        paths = [
            report.write(folder / "report.html"),
            write_whole(folder / "vehicle.yaml", vehicle),
            write_whole(folder / "fit.json", json.dumps(content, indent=1)),
        ]
    return [out / path.name for path in paths]
