"""What would settle it: the next experiment, where one was designed."""

from collections.abc import Mapping
from typing import Any

from gap_diagnosis.report.wording import title_of, titles_of
from run_bag.report import Axis, Column, Panel, Report, Series, time_series

__all__ = ["add_next_experiment"]


def add_next_experiment(report: Report, content: Mapping[str, Any]) -> None:
    """Add the next experiment, or a sentence where there is none."""
    report.section("What would settle it")
    planned = content["next_experiment"]
    if not planned:
        report.paragraph(_without(content))
        return
    report.paragraph(planned["sentence"])
    if planned.get("file"):
        played = planned["file"].removesuffix(".csv")
        report.key_values(
            {
                "throttle programme": planned["file"],
                "to a thruster": f"ros2 run run_bag play {played} --restamp, beside its driver and a recorder",
                "to the simulator": f"ros2 run rov_sim bench_campaign --programme {planned['file']} --out DIR",
            }
        )
    if planned.get("separates"):
        now = all("distance_now" in each for each in planned["separates"])
        columns: list[Column | str] = ["Candidates", Column(name="Distance", unit="σ", format=".1f")]
        columns += [Column(name="In these recordings", unit="σ", format=".1f")] if now else []
        rows = []
        for each in planned["separates"]:
            row: list[object] = [" against ".join(_title(k) for k in each["candidates"]), each["distance"]]
            rows.append([*row, each["distance_now"]] if now else row)
        report.table(
            columns,
            rows,
            caption="How far apart the experiment would drive the candidates' predictions.",
            notes=["Over the noise of the sensors, parameters re-tuned; from 3 σ on two candidates can be told apart."],
        )
    programme = planned.get("programme")
    if programme:
        series = Series(name="throttle", x=programme["time"], y=programme["throttle"])
        report.figure(
            time_series([Panel(axis=Axis(name="Throttle", unit="V", symbol="u"), series=[series])]),
            caption="The throttle programme to record next.",
            alt="Throttle over time of the proposed experiment.",
        )


def _title(key: object) -> str:
    return title_of(key) if isinstance(key, str) else titles_of([str(k) for k in key])  # type: ignore[attr-defined]


def _without(content: Mapping[str, Any]) -> str:
    alike = [effect["id"] for effect in content["effects"] if effect["indistinguishable_from"]]
    if content["verdict"] == "not_enough_data":
        return "Recordings that move the thruster: " + "; ".join(content["warnings"]) + "."
    if content["verdict"] in ("no_gap", "parameters"):
        return "Nothing is open: these recordings need no effect. Recordings in other regimes may."
    if content["verdict"] == "effect" and not alike:
        return "Nothing is open: no other known effect predicts these recordings as well."
    return str(content["next_step"])
