"""The report of a diagnosis: its parts in the reader's order."""

import json
from collections.abc import Mapping
from typing import Any

from gap_diagnosis.diagnose_io import with_effect
from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.report.before_after import add_before_and_after
from gap_diagnosis.report.budget import add_budget
from gap_diagnosis.report.candidates import add_candidates
from gap_diagnosis.report.experiment import add_next_experiment
from gap_diagnosis.report.how_far import add_how_far
from gap_diagnosis.report.location import add_where
from gap_diagnosis.report.parameters import add_parameters
from gap_diagnosis.report.unexplained import add_unexplained
from gap_diagnosis.report.verdict import add_verdict, headline
from run_bag.report import Report
from thruster_model.parameter_set_io import dump_parameter_set

__all__ = ["diagnosis_report"]


def diagnosis_report(found: Diagnosis, content: Mapping[str, Any]) -> Report:
    """Return the report of a diagnosis.

    Args:
        found: the diagnosis.
        content: of its diagnosis.json; every number that stands there too is taken from it.
    """
    report = Report(f"Sim-to-real gap: {headline(content)}", _subtitle(found, content), content["provenance"])
    for text in content["warnings"]:
        report.warning(text)
    add_verdict(report, content)
    if found.problem is not None and found.investigation is not None:
        add_budget(report, content)
        add_before_and_after(report, found)
        add_how_far(report, found, content)
        add_where(report, found, content)
        add_candidates(report, found, content)
        add_unexplained(report, found, content)
        add_parameters(report, found, content)
    add_next_experiment(report, content)
    _add_notes(report, found)
    _add_files(report, found, content)
    return report


def _subtitle(found: Diagnosis, content: Mapping[str, Any]) -> str:
    runs = len(content["provenance"]["runs"])
    model = found.parameter_set
    text = f"{runs} run{'s' if runs != 1 else ''} against the parameter set {model.name} (model {model.model_name})"
    if found.problem is not None:
        text += f", thruster {found.problem.recordings[0].thruster}"
    return text


def _add_notes(report: Report, found: Diagnosis) -> None:
    experiments = [recording.experiment for recording in found.problem.recordings] if found.problem else []
    notes = {each.name: [*each.warnings, *each.notes] for each in experiments if each.warnings or each.notes}
    if notes:
        report.section("What was done to the recordings")
        report.key_values(notes)


def _add_files(report: Report, found: Diagnosis, content: Mapping[str, Any]) -> None:
    report.section("Take it with you")
    if found.improves:
        switched = [effect["id"] for effect in content["effects"]]
        what = f"with {', '.join(switched)} switched on" if switched else "without any effect"
        text = f"The parameter set, re-tuned within its stated deviations, {what}; simulator and fit read it."
        report.paragraph(text)
        text = dump_parameter_set(with_effect(found))
        report.download("Parameter set of the diagnosis", "with_effect.yaml", text)
    plain = {key: value for key, value in content.items() if key != "predictions"}
    report.download("The diagnosis for programs", "diagnosis.json", json.dumps(plain, indent=1) + "\n")
