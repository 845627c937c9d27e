"""Where the gap goes: a waterfall on runs left out, and the share of each cause."""

from collections.abc import Mapping, Sequence
from typing import Any

from gap_diagnosis.report.wording import (
    AS_STATED,
    COLOURS,
    RETUNED,
    WITH_EFFECT,
    key_of,
    number,
    percent,
    roomy,
    sentence,
    signal_of,
    title_of,
)
from run_bag.report import Axis, Bars, Column, Plot, Report, bars
from run_bag.report.theme import FITS, REFERENCE
from thruster_model.identification.experiment import SIGNALS

__all__ = ["add_budget", "budget_in_words"]

_STEPS = {
    "as_is": AS_STATED,
    "retuned": RETUNED,
    "disturbance": "random disturbances and noise",
    "noise": "noise alone",
}
_FLOORS = ("disturbance", "noise")
_IN_UNITS = ("speed", "thrust", "ambient", "axial", "torque")
"""Signals whose errors are drawn in their own units, as far as two of them were recorded."""
_SHAPLEY = "Share: Shapley value, noise and random disturbances set aside."
_IN_TURN = (
    "Nothing is claimed; these bring runs left out nearer, one after the other. Share: what each takes off beside "
    "those before it. Best without each run: in how many cases it stays the best choice when one run is left out."
)


def add_budget(report: Report, content: Mapping[str, Any]) -> None:
    """Add the waterfall, the shares and what stays unexplained."""
    budget = content["budget"]
    if budget is None:
        return
    report.section("Where the gap goes")
    report.paragraph(budget_in_words(content))
    _picture(report, [*budget["left_out"], *budget["floors"]])
    in_turn = any(cause["best_without_each_run"] is not None for cause in budget["causes"])
    rows = [["re-tuned parameters", None, *_share(budget["parameters"]), None, None, None]]
    for cause in budget["causes"]:
        alike = ", ".join(title_of(key) for key in cause["could_as_well_be"])
        best = percent(cause["best_without_each_run"]) if in_turn else alike or "–"
        sizes = [f"{min(own):.3g} to {max(own):.3g}" for own in cause["sizes_by_run_left_out"].values() if own]
        numbers = (f"{cause['probability']:.2f}", *_share(cause), f"{cause['helps']:.2f}")
        rows.append([sentence(title_of(key_of(cause))), *numbers, "; ".join(sizes), best])
    rows.append(["nothing that has a name", None, *_share(budget["unexplained"]), None, None, None])
    right = [
        Column(name=name, align="right")
        for name in ("Probability", "Share", "90 % interval", "Helps a new run", "Sizes, one run left out each")
    ]
    report.table(
        ["Cause", *right, "Best without each run" if in_turn else "Could as well be"],
        rows,
        caption="What each cause takes of the squared gap between recordings and the simulator as stated.",
        notes=[
            f"{_IN_TURN if in_turn else _SHAPLEY} Helps a new run: in how many re-drawn sets of the runs left out the "
            "cause makes these more probable, beside the others. Parameters and effects that they imitate compensate "
            "each other: their intervals are wide."
        ],
    )


def _picture(report: Report, steps: Sequence[Mapping[str, Any]]) -> None:
    """Add the waterfall: all channels over their noise, and two of them in their own units."""
    labels = [_STEPS.get(each["step"]) or f"+ {title_of(each['step'])}" for each in steps]
    channels = {signal_of(channel): channel for channel in steps[0]["channels"]}
    total = Axis(name="all channels, error over noise", unit="–")
    plots = [_waterfall(steps, labels, [each["rms"] for each in steps], total)]
    for signal in [name for name in _IN_UNITS if name in channels][:2]:
        values = [each["channels"][channels[signal]] for each in steps]
        axis = Axis(name=f"error of {SIGNALS[signal].title.lower()}", unit=SIGNALS[signal].unit)
        plots.append(_waterfall(steps, labels, values, axis))
    report.figure(
        plots,
        caption="Root mean square errors that each step leaves on runs that its fit has not seen, all channels over "
        "their noise and single ones in their unit. Grey: what a right model would leave, hatched where random "
        "disturbances are in it.",
        alt="; ".join(f"{label} {each['rms']:.2f}" for label, each in zip(labels, steps, strict=True)),
    )


def _waterfall(steps: Sequence[Mapping[str, Any]], labels: list[str], values: list[float], quantity: Axis) -> Plot:
    plot = roomy(bars(labels, [Bars(name="error", value=values)], quantity=quantity), labels)
    names = [each["step"] for each in steps]
    colours = [REFERENCE if name in _FLOORS else FITS[COLOURS[_STEPS.get(name, WITH_EFFECT)]] for name in names]
    shapes = ["/" if name == "disturbance" else "" for name in names]
    hatch = {"shape": shapes, "fillmode": "overlay", "fgcolor": "white", "solidity": 0.25}
    plot.figure.update_traces(
        marker={"color": colours, "pattern": hatch},
        text=[number(value, 3) for value in values],
        textposition="auto",
    )
    return plot


def budget_in_words(content: Mapping[str, Any]) -> str:
    """Return the budget as a sentence or two."""
    budget = content["budget"]
    named = [f"{percent(c['share'])} {title_of(key_of(c))}" for c in budget["causes"]]
    parts = [f"{percent(budget['parameters']['share'])} re-tuning", *named]
    rest = budget["unexplained"]
    text = f"Of the squared gap {', '.join(parts)}; {percent(rest['share'])} has no name"
    if rest["depends_on"]:
        text += f": it depends on {'; '.join(rest['depends_on'])}"
    pushes = {name: level for name, level in budget["disturbance"].items() if level > 0.1}
    if pushes:
        text += ". Random disturbances move readings by " + " and ".join(
            f"{level:.1f} times their noise ({name.replace('_', ' ')})" for name, level in pushes.items()
        )
    return text + "."


def _share(entry: Mapping[str, Any]) -> list[object]:
    low, high = entry["interval"]
    return [percent(entry["share"]), f"{percent(low)} to {percent(high)}"]
