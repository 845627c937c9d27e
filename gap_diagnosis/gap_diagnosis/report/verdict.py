"""The verdict: one line, one paragraph, what to do about it, what the log shows."""

from collections.abc import Mapping
from typing import Any

from gap_diagnosis.report.wording import key_of, number, percent, sentence, title_of, unit
from run_bag.report import Report

__all__ = ["add_verdict", "headline"]

_LINES = {
    "no_gap": "none; the simulator predicts these recordings to within their noise",
    "parameters": "re-tuned parameters close it, no effect is needed",
    "cannot_tell": "this data cannot tell what causes it",
    "unknown": "none of the known effects explains it",
    "not_enough_data": "not enough data to judge",
}


def headline(content: Mapping[str, Any]) -> str:
    """Return the verdict as one line."""
    if content["verdict"] == "effect":
        return " and ".join(title_of(key_of(effect)) for effect in content["effects"])
    return _LINES[content["verdict"]]


def add_verdict(report: Report, content: Mapping[str, Any]) -> None:
    """Add the verdict."""
    report.section("Verdict")
    report.paragraph(content["summary"])
    items: dict[str, object] = {"verdict": content["verdict"], "what to change in the simulator": content["next_step"]}
    for effect in content["effects"]:
        items[f"{sentence(title_of(key_of(effect)))}"] = _effect(effect)
    if content["candidates"]:
        items["probability of no effect at all"] = f"{content['p_none']:.2f}"
        items["probability of something unknown"] = f"{content['p_unknown']:.2f}"
    if content["where"]:
        first = content["where"][0]
        items["where"] = f"block {first['block']} ({percent(first['share'])}), regime: {first['regime'] or 'all alike'}"
    if content["log"]:
        items["in the log"] = content["log"]
    report.key_values(items)


def _effect(effect: Mapping[str, Any]) -> dict[str, object]:
    items: dict[str, object] = {
        name.replace("_", " "): f"{number(size['value'])} ± {number(size['std'], 2)}"
        + ("" if size["unit"] == "1" else f" {unit(size['unit'])}")
        for name, size in effect["parameters"].items()
    }
    items["identifier"] = effect["id"]
    items["class"] = effect["class"]
    items["probability"] = f"{effect['probability']:.2f}"
    if effect["indistinguishable_from"]:
        alike = ", ".join(title_of(key) for key in effect["indistinguishable_from"])
        items["look-alikes"] = f"{alike}; with them {effect['group_probability']:.2f}"
    if effect["shrink"] is not None:
        items["shrinks the gap by"] = _interval(effect)
    return items


def _interval(effect: Mapping[str, Any]) -> str:
    text = percent(effect["shrink"]) or ""
    if effect["shrink_interval"]:
        low, high = effect["shrink_interval"]
        text += f" (90 %: {percent(low)} to {percent(high)})"
    return text
