"""Where the gap goes: a waterfall on runs left out, and the share of each cause."""

from collections.abc import Mapping
from typing import Any

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.report.wording import key_of, percent, roomy, sentence, title_of
from run_bag.report import Axis, Bars, Column, Report, bars

__all__ = ["add_budget", "budget_in_words"]

_STEPS = {"as_is": "as stated", "retuned": "re-tuned"}
_SHAPLEY = "Share: Shapley value, noise and random disturbances set aside."
_IN_TURN = (
    "Nothing is claimed; these bring runs left out nearer, one after the other. Share: what each takes off beside "
    "those before it. Best without each run: in how many cases it stays the best choice when one run is left out."
)


def add_budget(report: Report, found: Diagnosis, content: Mapping[str, Any]) -> None:
    """Add the waterfall, the shares and what stays unexplained."""
    budget = content["budget"]
    if budget is None:
        return
    report.section("Where the gap goes")
    report.paragraph(budget_in_words(content))
    steps = budget["left_out"]
    labels = [_STEPS.get(each["step"]) or f"+ {title_of(each['step'])}" for each in steps]
    report.figure(
        roomy(
            bars(
                labels,
                [Bars(name="error over noise", value=[each["rms"] for each in steps])],
                quantity=Axis(name="error on runs left out, over the noise", unit="–"),
                reference=1.0,
            ),
            labels,
        ),
        caption="What each step leaves on runs that its fit has not seen; the dashed line is noise alone.",
        alt="; ".join(f"{label} {each['rms']:.2f}" for label, each in zip(labels, steps, strict=True)),
    )
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
            f"{level:.1f} times their noise ({name})" for name, level in pushes.items()
        )
    return text + "."


def _share(entry: Mapping[str, Any]) -> list[object]:
    low, high = entry["interval"]
    return [percent(entry["share"]), f"{percent(low)} to {percent(high)}"]
