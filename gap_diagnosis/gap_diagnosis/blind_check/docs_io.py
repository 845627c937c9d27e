"""The page with the figures of a blind check: Markdown tables and pictures."""

import math
from collections.abc import Iterable
from pathlib import Path

from gap_diagnosis.blind_check.limits import LIMIT_TARGETS, kind_of_limit
from gap_diagnosis.blind_check.pictures_io import draw_pictures
from gap_diagnosis.blind_check.scoring import Scores
from gap_diagnosis.blind_check.statistics import Limit, Share
from safe_files.whole_files_io import write_whole

__all__ = ["TARGETS", "page", "summary_rows", "write_page"]

TARGETS = {
    "right verdict, above the limit": "≥ 95 %",
    "wrong effect named with probability 0.8 or more": "≤ 1 %",
    "right verdict, above the target of the limit": "≥ 95 %",
    "effect claimed where there is none": "≤ 3 %",
    "outside the library: unknown, or right block": "≥ 95 %",
    "both effects of a pair named": "≥ 80 %",
    "block right, above the limit": "≥ 98 %",
    "90 % intervals of sizes cover": "85–95 %",
    "median size error": "≤ 5 %",
    "median difference of stated and actual shrink": "≤ 0.03",
    "calibration error": "≤ 0.05",
}
_TITLES = {
    "confusion": "Confusion: hidden against said; a hidden effect that is named in a group counts as named",
    "reliability": "Reliability of the first candidate's probability, with the number of cases",
    "sizes": "Sizes, true and estimated",
    "shrink": "Shrink, stated and actual",
    "limits": "Limits of detection",
}


def summary_rows(scores: Scores) -> list[tuple[str, str, str]]:
    """Return (figure, value with its interval, target)."""
    rows = [(name, _share(found), TARGETS.get(name, "")) for name, found in scores.shares.items()]
    for name, value in scores.numbers.items():
        text = "–" if math.isnan(value) else f"{100 * value:.1f} %" if name == "median size error" else f"{value:.3f}"
        rows.append((name, text, TARGETS.get(name, "")))
    return rows


def page(scores: Scores, provenance: str, pictures: Iterable[Path] = ()) -> str:
    """Return the page as Markdown; `provenance`: how the figures were made, pictures: by file, shown by name."""
    lines = ["# Blind check", "", provenance, "", "Intervals of shares: Wilson, 95 %.", ""]
    lines += _table(("figure", "value", "target"), summary_rows(scores))
    lines += ["## By kind of case", ""]
    lines += _table(("kind", "right"), [(kind, _share(found)) for kind, found in scores.by_kind.items()])
    lines += ["## By effect", ""]
    header: tuple[str, ...] = ("effect", "right, all sizes", "right, above its limit")
    above = scores.by_effect_above
    rows = [(f"`{n}`", _share(found), _share(above[n]) if n in above else "–") for n, found in scores.by_effect.items()]
    lines += _table(header, rows)
    lines += [
        "## Limits",
        "",
        "The size found 9 times in 10 on the standard campaign, from a logistic curve, with its 90 % bootstrap",
        "interval. Of limits and time scales of a mode the smaller sizes are the stronger effects: what is found lies",
        "below the limit. Where a figure above speaks of sizes above the limit, a case is held against the limit that",
        "all others give.",
        "",
    ]
    lines += _table(("effect", "limit", "target", "sizes tried", "cases"), _limit_rows(scores))
    if scores.wrong:
        lines += ["## Confidently wrong names", ""]
        lines += _table(
            ("case", "hidden", "named"), [(case, truth or "none", name) for case, truth, name in scores.wrong]
        )
    for picture in pictures:
        title = _TITLES[picture.stem.rsplit("_", 1)[1]]
        lines += [f"## {title.split(':')[0].split(',')[0]}", "", f"![{title}]({picture.name})", ""]
    return "\n".join(lines).rstrip() + "\n"


def write_page(scores: Scores, file: Path, provenance: str) -> list[Path]:
    """Write the page and its pictures beside it, in place of earlier ones; return all files."""
    file.parent.mkdir(parents=True, exist_ok=True)
    pictures = draw_pictures(scores, file.with_suffix(""))
    write_whole(file, page(scores, provenance, pictures).encode(), replace=True)
    return [file, *pictures]


def _table(header: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> list[str]:
    lines = [f"| {' | '.join(header)} |", "|" + "---|" * len(header)]
    return [*lines, *(f"| {' | '.join(row)} |" for row in rows), ""]


def _share(found: Share) -> str:
    if not found.of:
        return "–"
    low, high = found.interval
    return f"{100 * found.value:.1f} % ({100 * low:.1f}–{100 * high:.1f}; {found.hits} of {found.of})"


def _limit_rows(scores: Scores) -> list[tuple[str, ...]]:
    return [
        (
            name,
            _limit(name, limit),
            "{:g} {}".format(*LIMIT_TARGETS[name]).strip() if name in LIMIT_TARGETS else "",
            f"{limit.tried[0]:.3g} to {limit.tried[1]:.3g}",
            str(limit.cases),
        )
        for name, limit in scores.limits.items()
    ]


def _limit(name: str, limit: Limit) -> str:
    falls = kind_of_limit(name).size.falls
    value, low, high = (_at(x, limit, falls=falls) for x in (limit.value, *limit.interval))
    return f"{value} ({low} to {high})"


def _at(value: float, limit: Limit, *, falls: bool) -> str:
    least, most = limit.tried
    if math.isinf(value):
        return f"> {most:.3g}" if falls else "not found"
    if value == 0.0:
        return "not found" if falls else f"< {least:.3g}"
    return f"{value:.3g}"
