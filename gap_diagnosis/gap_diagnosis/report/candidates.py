"""Which effect: ranked candidates, how probable each is, its size, what it explains, what it is confused with."""

from collections.abc import Mapping
from typing import Any

from gap_diagnosis.candidate import Candidate
from gap_diagnosis.diagnosis import Diagnosis
from gap_diagnosis.investigation import Investigation
from gap_diagnosis.report.explained import add_explained
from gap_diagnosis.report.wording import key_of, probability, roomy, title_of, titles_of
from gap_diagnosis.report.wording import unit as raised
from gap_diagnosis.scatter import Scatter
from gap_diagnosis.sizes import sizes_of
from gap_diagnosis.suspects import Suspect
from run_bag.report import Axis, Bars, Cell, Column, Report, bars

__all__ = ["add_candidates"]

_LISTED, _DRAWN, _PAIRS = 12, 6, 6
_PROBABILITY = Axis(name="probability", unit="–")
_NONE, _UNKNOWN = "none", "unknown"


def add_candidates(report: Report, found: Diagnosis, content: Mapping[str, Any]) -> None:
    """Add the ranked candidates, pairs where they were weighed, and what each explains."""
    investigation = found.investigation
    if investigation is None or found.posterior is None:
        return
    report.section("Which")
    report.paragraph(
        "Every effect of the library was tried with all parameters re-tuned beside it; the most promising ones were "
        "refitted. Probabilities over single candidates, none and unknown sum to 1; a pair's is shared by its two. "
        "Evidence is the logarithm (in nats) of how much more probable a candidate makes the data than no effect; the "
        "freedom of its sizes is paid for in it."
    )
    ranked = _ranked(content)
    _picture(report, ranked)
    _claims(report, content)
    _singles(report, found, investigation, content, ranked)
    _pairs(report, found, investigation)
    add_explained(report, found)


def _ranked(content: Mapping[str, Any]) -> list[tuple[str, float]]:
    singles = [(each["id"], each["probability"]) for each in content["candidates"]]
    everything = [*singles, (_NONE, content["p_none"]), (_UNKNOWN, content["p_unknown"])]
    return sorted(everything, key=lambda each: -each[1])


def _title(key: str) -> str:
    return {_NONE: "no effect", _UNKNOWN: "something unknown"}.get(key) or title_of(key)


def _picture(report: Report, ranked: list[tuple[str, float]]) -> None:
    shown = ranked[:_DRAWN]
    shown += [each for each in ranked[_DRAWN:] if each[0] in (_NONE, _UNKNOWN)]
    rest = sum(p for _, p in ranked) - sum(p for _, p in shown)
    labels = [*(key.replace(":", " of ") for key, _ in shown), "all others"]
    shares = [*(p for _, p in shown), max(rest, 0.0)]
    report.figure(
        roomy(bars(labels, [Bars(name="probability", value=shares)], quantity=_PROBABILITY), labels),
        caption="Probability of the leading candidates.",
        alt="; ".join(f"{_title(key)} {p:.2f}" for key, p in shown),
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


def _singles(
    report: Report, found: Diagnosis, looked: Investigation, content: Mapping[str, Any], ranked: list[tuple[str, float]]
) -> None:
    refitted = {c.keys[0]: c for c in looked.candidates if len(c.suspects) == 1}
    claimed = {key_of(e): e for e in content["effects"]}
    logged = {each.effect: each for each in found.scatters}
    listed = [key for key, _ in ranked[:_LISTED]]
    listed += [key for key, _ in ranked[_LISTED:] if key in (_NONE, _UNKNOWN) or key in claimed]
    likely = dict(ranked)
    rated = {each.suspect.key: each.criterion for each in looked.screened}
    rows: list[list[object]] = []
    for key in listed:
        candidate = refitted.get(key)
        claim = claimed.get(key)
        evidence, sizes = _weighed(key, candidate, logged, rated)
        if claim:
            sizes = _sizes_of_claim(claim)
        rows.append(
            [
                Cell(key, "emphasis") if claim else key,
                Cell(probability(likely[key]), "best") if claim else probability(likely[key]),
                evidence,
                sizes,
                _title(key),
            ]
        )
    left = len(ranked) - len(listed)
    notes = ["✓: claimed. Evidence in brackets: not refitted but from a first rating, or from the log."]
    if left > 0:
        most = max(likely[key] for key in likely if key not in listed)
        notes.append(f"{left} further candidates have {'' if most < 0.001 else 'at most '}{probability(most)} each.")
    report.table(
        [
            "Candidate",
            Column(name="Probability", align="right"),
            Column(name="Evidence [nats]", align="right"),
            "Sizes",
            "In words",
        ],
        rows,
        caption="Candidates, the most probable first.",
        notes=notes,
    )


def _weighed(
    key: str, candidate: Candidate | None, logged: Mapping[str, Scatter], rated: Mapping[str, float]
) -> tuple[str | None, str | None]:
    """Return evidence and sizes of a candidate as text."""
    if key == _NONE:
        return "0.0", None
    if candidate is not None:
        return _nats(candidate.evidence), "; ".join(_sizes(candidate, s) for s in candidate.suspects)
    if key in logged:
        scatter = logged[key]
        return f"({_nats(scatter.log_odds)})", f"{scatter.parameter} {scatter.size:.3g} ± {scatter.deviation:.2g}"
    return (f"({_nats(rated[key])})" if key in rated else None), None


def _nats(value: float) -> str:
    return f"{value:.1f}".replace("-", "−")


def _sizes_of_claim(claim: Mapping[str, Any]) -> str:
    return ", ".join(_size(name, s["value"], s["std"], s["unit"]) for name, s in claim["parameters"].items())


def _sizes(candidate: Candidate, suspect: Suspect) -> str:
    """Return the sizes of one suspect of a candidate, each with its standard deviation."""
    found = sizes_of(candidate.fitted, candidate.noise, suspect)
    return ", ".join(_size(name, size.value, size.std, size.unit) for name, size in found.items())


def _size(name: str, value: float, std: float, unit: str) -> str:
    text = f"{name.replace('_', ' ')} {value:.3g} ± {std:.2g}".replace("-", "−")
    return text if unit == "1" else f"{text} {raised(unit)}"


def _pairs(report: Report, found: Diagnosis, looked: Investigation) -> None:
    pairs = [c for c in looked.candidates if len(c.suspects) > 1]
    if not pairs or found.posterior is None:
        return
    weights = found.posterior.stated.pairs
    rows = [
        [
            titles_of(c.keys),
            probability(weights.get(c.keys, 0.0)),
            c.evidence,
            "; ".join(_sizes(c, s) for s in c.suspects),
        ]
        for c in pairs[:_PAIRS]
    ]
    report.table(
        [
            "Pair",
            Column(name="Probability", align="right"),
            Column(name="Evidence [nats]", format=".1f"),
            "Sizes",
        ],
        rows,
        caption="Pairs that were weighed because the best single effect leaves structure.",
    )
