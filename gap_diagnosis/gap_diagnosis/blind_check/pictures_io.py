"""Pictures of a blind check's scores: SVG files whose text stays text."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gap_diagnosis.blind_check.catalogue import EFFECTS
from gap_diagnosis.blind_check.limits import kind_of_limit
from gap_diagnosis.blind_check.scoring import Scores
from safe_files.whole_files_io import whole_file

__all__ = ["draw_pictures"]

_BLUE, _GREY, _RED = "#0072b2", "#999", "#d55e00"


def draw_pictures(scores: Scores, stem: Path) -> list[Path]:
    """Draw `stem`_confusion, _reliability, _sizes, _shrink and _limits.svg; return the files that there is data for."""
    import matplotlib  # half a second to import

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    matplotlib.rcParams["svg.fonttype"] = "none"
    matplotlib.rcParams["svg.hashsalt"] = "blind check"
    pictures: Mapping[str, Any] = {
        "confusion": _confusion if scores.confusion else None,
        "reliability": _reliability if scores.reliability else None,
        "sizes": _sizes if scores.sizes else None,
        "shrink": _shrink if scores.shrinks else None,
        "limits": _limits if scores.limits else None,
    }
    files = []
    for name, paint in pictures.items():
        if paint is not None:
            figure = paint(scores, plt)
            figure.tight_layout()
            files.append(stem.with_name(f"{stem.name}_{name}.svg"))
            with whole_file(files[-1], replace=True) as partial:
                figure.savefig(partial, metadata={"Date": None})
            plt.close(figure)
    return files


def _confusion(scores: Scores, plt: Any) -> Any:
    order = [*EFFECTS, "none", "outside", "no_gap", "parameters", "unknown", "cannot_tell", "not_enough_data", "failed"]
    truths = [name for name in order if any(truth == name for truth, _ in scores.confusion)]
    said = [name for name in order if any(s == name for _, s in scores.confusion)]
    counts = np.array([[scores.confusion.get((t, s), 0) for s in said] for t in truths], dtype=float)
    shares = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1.0)
    figure, panel = plt.subplots(figsize=(2.5 + 0.21 * len(said), 2.2 + 0.21 * len(truths)))
    size = (0.0, len(said), len(truths), 0.0)
    panel.imshow(shares, cmap="Blues", vmin=0.0, vmax=1.0, interpolation="nearest", aspect="auto", extent=size)
    panel.vlines(np.arange(1, len(said)), 0.0, len(truths), color="#eee", linewidth=0.4)
    panel.hlines(np.arange(1, len(truths)), 0.0, len(said), color="#eee", linewidth=0.4)
    for row, column in zip(*np.nonzero(counts), strict=True):
        colour = "white" if shares[row, column] > 0.5 else "black"
        text = f"{counts[row, column]:.0f}"
        panel.text(column + 0.5, row + 0.5, text, ha="center", va="center", fontsize=6, color=colour)
    panel.set_xticks(np.arange(len(said)) + 0.5, said, rotation=90, fontsize=7)
    panel.set_yticks(np.arange(len(truths)) + 0.5, truths, fontsize=7)
    panel.set_xlabel("what was said")
    panel.set_ylabel("what was hidden")
    return figure


def _reliability(scores: Scores, plt: Any) -> Any:
    figure, panel = plt.subplots(figsize=(4.2, 4.2))
    panel.plot([0, 1], [0, 1], color=_GREY, linewidth=1, linestyle=":")
    counts = np.array([entry["count"] for entry in scores.reliability])
    means, rights = ([entry[key] for entry in scores.reliability] for key in ("mean", "right"))
    panel.scatter(means, rights, s=15 + 200 * counts / counts.sum(), color=_BLUE)
    for x, y, count in zip(means, rights, counts, strict=True):
        panel.annotate(f"{count}", (x, y), textcoords="offset points", xytext=(6, -10), fontsize=7)
    panel.set(xlim=(0, 1.03), ylim=(0, 1.03))
    panel.set_xlabel("probability of the first candidate")
    panel.set_ylabel("share in which it was the truth")
    return _plain(figure)


def _sizes(scores: Scores, plt: Any) -> Any:
    figure, panel = plt.subplots(figsize=(4.8, 4.8))
    for structural, colour, label in ((True, _BLUE, "structural"), (False, _RED, "parametric")):
        chosen = [entry for entry in scores.sizes if EFFECTS[entry[1]].structural == structural]
        true = [size / EFFECTS[name].size.upper for _, name, size, _, _ in chosen]
        estimate = [size / EFFECTS[name].size.upper for _, name, _, size, _ in chosen]
        panel.plot(true, estimate, ".", color=colour, markersize=4, label=label)
    panel.plot([-1, 1], [-1, 1], color=_GREY, linewidth=1, linestyle=":")
    panel.set_xlabel("true size / plausible maximum")
    panel.set_ylabel("estimated size / plausible maximum")
    panel.set(xlim=(-1.1, 1.1), ylim=(-1.3, 1.3))
    panel.legend(frameon=False)
    return _plain(figure)


def _shrink(scores: Scores, plt: Any) -> Any:
    figure, panel = plt.subplots(figsize=(4.2, 4.2))
    panel.plot([0, 1], [0, 1], color=_GREY, linewidth=1, linestyle=":")
    panel.plot([actual for *_, actual in scores.shrinks], [s[2] for s in scores.shrinks], ".", color=_BLUE)
    panel.set_xlabel("actual shrink, by the sealed truth")
    panel.set_ylabel("stated shrink")
    return _plain(figure)


def _limits(scores: Scores, plt: Any) -> Any:
    figure, panel = plt.subplots(figsize=(7.0, 1.0 + 0.2 * len(scores.limits)))
    for row, (name, limit) in enumerate(scores.limits.items()):
        size = kind_of_limit(name).size
        low, high, at = (np.clip(x / size.upper, 1e-2, 3.0) for x in (*limit.interval, limit.value))
        panel.plot([low, high], [row, row], color=_BLUE, linewidth=2)
        panel.plot(at, row, "o", color=_BLUE, markersize=5)
        panel.plot(np.array(limit.tried) / size.upper, [row, row], "|", color=_GREY, markersize=7)
    panel.set_xscale("log")
    panel.set_yticks(range(len(scores.limits)), list(scores.limits), fontsize=7)
    panel.invert_yaxis()
    panel.set_xlabel(
        "size found 9 times in 10 / plausible maximum, 90 % interval;\ngrey: sizes tried; at the edge: beyond them"
    )
    return _plain(figure)


def _plain(figure: Any) -> Any:
    for panel in figure.axes:
        panel.grid(color="#ddd", linewidth=0.6)
        panel.spines[["top", "right"]].set_visible(False)
    return figure
