"""A vehicle's diagnosis as one self-contained HTML page, with a picture of the vehicle and the suspected part."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import plotly.graph_objects as go

from gap_diagnosis.vehicle.how_far import FORESEEN, Errors
from gap_diagnosis.vehicle.hypotheses import described, sized
from gap_diagnosis.vehicle.rules import TOLD_APART
from run_bag.report import Axis, Bars, Column, Plot, Report, bars
from thruster_model.vehicle_set import VehicleSet

__all__ = ["report_of"]

_CALM, _SUSPECT = "#7a8794", "#c2410c"
_OF_THRUSTERS = ("thrusters", "thrust", "rotor", "flow", "command")
"""Blocks of effects that are of all thrusters where none is named."""


def report_of(
    content: dict[str, Any], vehicle: VehicleSet, errors: Sequence[Errors], with_effect: str, title: str
) -> Report:  # fmt: skip
    """Return the report of `content` (see `content.content_of`)."""
    report = Report(title, f"verdict: {content['verdict'].replace('_', ' ')}", content["provenance"])
    for note in content["warnings"]:
        report.warning(note)
    report.section("Answer")
    report.paragraph(content["summary"])
    if content["wiring"]:
        for sentence in content["wiring"]["sentences"]:
            report.paragraph(sentence)
    report.figure(
        picture(vehicle, content), caption="The vehicle from above and from its side; what is suspected is marked.",
        alt="Positions and directions of the thrusters; " + content["summary"],
    )  # fmt: skip
    if content["effects"]:
        rows = []
        for e in content["effects"]:
            sizes = "; ".join(sized(n, p["value"], p["std"], p["unit"]) for n, p in e["parameters"].items())
            near = ", ".join(f"{r['words']} ({r['probability']:.2f})" for r in e["indistinguishable_from"]) or "none"
            rows.append([e["words"], e["probability"], sizes or "on", _closes(e), near])
        report.table(
            ["effect", Column(name="probability", format=".2f"), "size", "closes of the gap", "cannot be told from"],
            rows,
            caption="What is claimed; of the gap that re-tuning leaves in free runs, with its 90 % interval.",
        )  # fmt: skip
    if content["candidates"]:
        some = content["candidates"][:10]
        report.figure(
            bars(
                [c["words"] for c in some], [Bars(name="probability", value=[c["probability"] for c in some])],
                quantity=Axis(name="probability of one more effect", unit="1"),
            ),
            caption="What else was nearest.", alt="Probabilities of the next best effects, each alone.",
        )  # fmt: skip
    _add_budget(report, content["budget"], _whose(content["gap"]))
    report.section("How far")
    rows = [
        [f"{name} after {e.horizon:g} s", e.as_is[name], e.retuned[name], e.with_effect[name], unit]
        for e in errors
        for name, unit in FORESEEN.items()
        if not np.isnan(e.as_is[name])
    ]
    report.table(
        ["free run", "as it is", "re-tuned", "with the effects", "unit"], rows,
        caption=f"Root mean square error of free runs; {_whose(content['gap'])}.",
    )  # fmt: skip
    if content["retuned_parameters"]:
        report.table(
            ["parameter", Column(name="moved by", unit="deviations"), Column(name="left", unit="deviations")],
            [[n, p["deviations"], p["std"]] for n, p in content["retuned_parameters"].items()],
            caption="Parameters that moved most.",
        )  # fmt: skip
    report.section("What could not have been shown")
    missing = [name for name, there in content["sensors"].items() if not there]
    report.paragraph(f"Sensors that are missing: {', '.join(missing) or 'none'}.")
    if content["not_tried"]:
        names = ", ".join(each.replace("_", " ") for each in content["not_tried"])
        report.paragraph(f"Not looked for, as their sensor is missing or they were left out: {names}.")
    if content["hidden"]:
        report.table(
            ["effect", Column(name="least size that would be claimed"), "unit"],
            [[h["words"], h["least"], h["unit"]] for h in content["hidden"][:40]],
            caption="Effects whose whole range these sensors and this excitation leave in the dark.",
        )  # fmt: skip
    if content["next_experiment"]:
        report.section("What would settle it")
        _add_next(report, content["next_experiment"])
    if with_effect:
        report.section("Files")
        report.download("Vehicle set, re-tuned, with the effects", "with_effect.yaml", with_effect)
    return report


def _whose(gap: dict[str, Any]) -> str:
    """Return whose numbers free runs are made with."""
    if gap["left_out"]:
        return "each recording with numbers of the others"
    return "of the one recording that the numbers were fitted to: none was left out, so they flatter the fit"


def _add_budget(report: Report, budget: dict[str, Any], whose: str) -> None:
    report.section("Where the gap goes")
    if budget["parameters"] is None:
        report.paragraph(budget["why_not"])
        return
    names = {"as_is": "as it is", "retuned": "re-tuned"}
    labels = [names.get(each["step"], f"+ {each['step']}") for each in budget["left_out"]]
    sizes = [each["rms"] for each in budget["left_out"]]
    report.figure(
        bars(
            labels, [Bars(name="error", value=sizes)], quantity=Axis(name="error over what is foreseen", unit="1"),
            reference=1.0,
        ),
        caption=f"Free runs of {budget['horizon']:g} s, {whose}; the dashed line is what noise and the random wrench "
        "of calm water make of a right model.",
        alt="; ".join(f"{label} {size:.2f}" for label, size in zip(labels, sizes, strict=True)),
    )  # fmt: skip
    rows = [["re-tuned numbers", budget["parameters"]]]
    rows += [[cause["words"], cause] for cause in budget["causes"] if "share" in cause]
    rows.append(["nothing that has a name", budget["unexplained"]])
    report.table(
        ["cause", "share of the squared gap", "90 % interval"],
        [[name, _percent(s["share"]), " to ".join(map(_percent, s["interval"]))] for name, s in rows],
        caption="Shapley values at the joint fit: each is added in every order. They add up to the gap.",
    )


def _percent(share: float) -> str:
    return f"{100 * share:z.0f} %"


def _add_next(report: Report, planned: dict[str, Any]) -> None:
    report.paragraph(f"Next, record {planned['kind']}: {planned['why']}.")
    if "dry_run" not in planned:
        return
    run = planned["dry_run"]
    report.key_values(
        {
            "programme": f"{planned['file']}, {planned['duration_s']:.0f} s",
            "to the vehicle": f"ros2 run run_bag play {planned['file']} --restamp, beside its drivers and a recorder",
            "dry run": f"tilt to {run['tilt']:.2f} rad, depth by {run['depth']:.2f} m, speed to {run['speed']:.2f} m/s "
            f"at {run['level']:.2f} V",
        }
    )
    if planned["separates"]:
        report.table(
            ["candidates", Column(name="distance that it adds", unit="σ", format=".1f"),
             Column(name="in these recordings", unit="σ", format=".1f")],
            [
                [" against ".join(c["words"] for c in each["candidates"]), each["added"], each["distance_now"]]
                for each in planned["separates"]
            ],
            caption=f"How far apart candidates are, parameters re-tuned. From {TOLD_APART:g} σ that it adds, a "
            "programme tells them apart. What these recordings should tell by their noise did not decide.",
        )  # fmt: skip


def _closes(effect: dict[str, Any]) -> str:
    if effect["shrink"] is None:
        return "–"
    low, high = effect["shrink_interval"]
    if low < 0.0:
        return "nothing that is sure: numbers far beyond their deviations do as well"
    return f"{100 * effect['shrink']:.0f} % ({100 * low:.0f} to {100 * high:.0f} %)"


def picture(vehicle: VehicleSet, content: dict[str, Any]) -> Plot:
    """Return the thrusters of a vehicle from above and from its side, suspected ones marked."""
    suspects = {e[k] for e in content["effects"] for k in ("thruster", "other") if e[k] is not None}
    if any(e["thruster"] is None and described(e["id"]).block in _OF_THRUSTERS for e in content["effects"]):
        suspects = set(range(len(vehicle.layout)))
    figure = go.Figure()
    reach = max(float(np.abs([t.position for t in vehicle.layout]).max()), 0.1)
    offset = 3.2 * reach
    for view, (right, up, shift) in {"above": (1, 0, 0.0), "side": (0, 2, offset)}.items():
        places: dict[tuple[float, float], list[int]] = {}
        for i, t in enumerate(vehicle.layout):
            places.setdefault((round(t.position[right], 2), round(t.position[up], 2)), []).append(i)
        for i, t in sorted(enumerate(vehicle.layout), key=lambda each: each[0] in suspects):  # those on top
            together = places[round(t.position[right], 2), round(t.position[up], 2)]
            colour = _SUSPECT if i in suspects else _CALM
            x, y = shift + t.position[right], t.position[up] * (1.0 if view == "above" else -1.0)
            dx, dy = 0.45 * reach * t.axis[right], 0.45 * reach * t.axis[up] * (1.0 if view == "above" else -1.0)
            figure.add_trace(
                go.Scatter(
                    x=[x],
                    y=[y],
                    mode="markers+text",
                    text=[", ".join(map(str, together)) if i == together[-1] else ""],
                    textposition="top center",
                    marker={"size": 12, "color": colour},
                    showlegend=False,
                    hovertemplate=f"thruster {i}<extra></extra>",
                )
            )
            figure.add_annotation(
                x=x + dx, y=y + dy, ax=x, ay=y, axref="x", ayref="y", showarrow=True, arrowhead=2, arrowwidth=2,
                arrowcolor=colour, text="",
            )  # fmt: skip
        figure.add_annotation(
            x=shift, y=1.5 * reach, showarrow=False,
            text="from above, bow up" if view == "above" else "from starboard, bow right",
        )  # fmt: skip
    axes = [
        e["axis"] or e["sensor"] for e in content["effects"] if e["thruster"] is None and (e["axis"] or e["sensor"])
    ]
    if axes:
        figure.add_annotation(x=0.0, y=0.0, showarrow=False, text=f"<b>{', '.join(axes)}</b>", font={"color": _SUSPECT})
    figure.update_layout(
        height=380, margin={"t": 10, "b": 10, "l": 10, "r": 10}, xaxis={"visible": False},
        yaxis={"visible": False, "scaleanchor": "x"},
    )  # fmt: skip
    return Plot(figure=figure, height=380)
