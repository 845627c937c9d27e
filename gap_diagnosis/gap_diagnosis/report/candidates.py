"""Which effect: ranked candidates, how probable each is, its size, what it explains, what it is confused with."""

from collections.abc import Mapping
from typing import Any

from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.investigation import Investigation
from gap_diagnosis.report.explained import add_explained
from gap_diagnosis.report.wording import key_of, probability, roomy, title_of, titles_of
from gap_diagnosis.report.wording import unit as raised
from gap_diagnosis.sizes import sizes_of
from run_bag.report import Axis, Bars, Column, Report, bars

__all__ = ["add_candidates"]

_LISTED, _DRAWN = 12, 8
_PROBABILITY = Axis(name="probability", unit="–")


def add_candidates(report: Report, found: Diagnosis, content: Mapping[str, Any]) -> None:
    """Add what is claimed, how probable each effect is to be at work, and the sets that were weighed."""
    investigation = found.investigation
    if investigation is None:
        return
    report.section("Which")
    report.paragraph(
        "Every effect of the library was tried with all parameters re-tuned beside it, alone and beside those that "
        "were found before; the most promising sets were fitted, each with the noise that it leaves. Several effects "
        "may be at work together, so their probabilities need not sum to 1. Evidence is the logarithm (in nats) of how "
        "much more probable a set makes the data than no effect; the freedom of its sizes is paid for in it."
    )
    ranked = [(each["id"], each["probability"]) for each in content["candidates"]]
    _picture(report, ranked, content)
    _claims(report, content)
    _sets(report, investigation)
    add_explained(report, found)


def _picture(report: Report, ranked: list[tuple[str, float]], content: Mapping[str, Any]) -> None:
    beside = [("no effect at all", content["p_none"]), ("something nameless", content["p_unknown"])]
    shown = [*((title_of(key), p) for key, p in ranked[:_DRAWN]), *beside]
    labels = [label for label, _ in shown]
    bar = Bars(name="probability", value=[p for _, p in shown])
    report.figure(
        roomy(bars(labels, [bar], quantity=_PROBABILITY), labels),
        caption="Probability that an effect is at work.",
        alt="; ".join(f"{label} {p:.2f}" for label, p in shown),
    )


def _claims(report: Report, content: Mapping[str, Any]) -> None:
    if not content["effects"]:
        return
    rows = []
    for claim in content["effects"]:
        alike = ", ".join(claim["indistinguishable_from"])
        rows.append(
            [
                title_of(key_of(claim)),
                probability(claim["probability"]),
                probability(claim["group_probability"]),
                claim["class"],
                _sizes_of_claim(claim),
                alike or "none",
            ]
        )
    report.table(
        [
            "Claimed",
            Column(name="Probability", align="right"),
            Column(name="With look-alikes", align="right"),
            "Class",
            "Sizes",
            "Look-alikes",
        ],
        rows,
        caption="What is claimed.",
        notes=[
            "Structural: no parameters can imitate it. Parametric: nominal parameters far beyond their stated "
            "deviations could. Look-alikes: effects that these recordings cannot tell apart from it."
        ],
    )


def _sets(report: Report, looked: Investigation) -> None:
    rows = []
    for found in looked.ranked[:_LISTED]:
        sizes = "; ".join(
            ", ".join(_size(n, s.value, s.std, s.unit) for n, s in sizes_of(found.fitted, found.noise, each).items())
            for each in found.suspects
        )
        gained = looked.search.score(found) - looked.search.score(looked.none)
        rows.append(
            [titles_of(found.keys) or "no effect", probability(looked.probabilities[found.keys]), _nats(gained), sizes]
        )
    report.table(
        ["Set", Column(name="Probability", align="right"), Column(name="Evidence [nats]", align="right"), "Sizes"],
        rows,
        caption="The most probable sets of effects; their rarity before the data is counted in the evidence.",
    )


def _nats(value: float) -> str:
    return f"{value:.1f}".replace("-", "−")


def _sizes_of_claim(claim: Mapping[str, Any]) -> str:
    return ", ".join(_size(name, s["value"], s["std"], s["unit"]) for name, s in claim["parameters"].items())


def _size(name: str, value: float, std: float, unit: str) -> str:
    text = f"{name.replace('_', ' ')} {value:.3g} ± {std:.2g}".replace("-", "−")
    return text if unit == "1" else f"{text} {raised(unit)}"
