"""A finished fit of several classes as one Markdown table and one picture, on runs left out."""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from run_bag.command_line import user_arguments
from safe_files.whole_files_io import whole_file
from thruster_model.identification.experiment import SIGNALS
from thruster_model.models import MODELS

_ORDER = ("speed", "thrust", "torque", "axial", "ambient", "total")


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table, draw the picture; return the exit status."""
    parser = argparse.ArgumentParser(prog="class_table", description=__doc__)
    parser.add_argument("folder", type=Path, help="the --out folder of fit, run with --hold-out")
    parser.add_argument("--picture", type=Path, help="SVG or PNG file for the picture; must not exist")
    given = parser.parse_args(user_arguments(arguments))
    file = given.folder / "fit.json"
    try:
        models = json.loads(file.read_text("utf-8"))["models"]
        if not all(model["errors_left_out"] for model in models):
            raise ValueError("expected errors on runs left out; run fit with --hold-out")
        if given.picture is not None:
            if given.picture.exists():
                raise FileExistsError(f"{given.picture}: exists and is not overwritten")
            draw(models, given.picture)
        print(table(models))
    except (OSError, ValueError, KeyError) as error:
        print(f"{file}: {error!r}", file=sys.stderr)
        return 1
    return 0


def ranked(models: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return the models by their total error on runs left out, best first."""
    return sorted(models, key=lambda model: float(_errors(model)["total"]["error"]))


def table(models: Sequence[Mapping[str, Any]]) -> str:
    """Return the table, a class a line, best first, each error with its 90 % interval."""
    names = [f"{SIGNALS[s].symbol} [{SIGNALS[s].unit}]" if s in SIGNALS else "total" for s in _ORDER]
    lines = [f"| class | {' | '.join(names)} | what it cannot do |", "|" + "---|" * (len(names) + 2)]
    for model in ranked(models):
        errors = _errors(model)
        cells = [_cell(errors[s]) if s in errors else "–" for s in _ORDER]
        lines.append(f"| `{model['model']}` | {' | '.join(cells)} | {MODELS[model['model']].cannot} |")
    return "\n".join(lines)


def _errors(model: Mapping[str, Any]) -> dict[str, Mapping[str, Any]]:
    return {c["signal"]: c for c in model["errors_left_out"]}


def _cell(comparison: Mapping[str, Any]) -> str:
    low, high = comparison["interval"]
    return f"{comparison['error']:.3g} ({low:.2g} to {high:.2g})"


def draw(models: Sequence[Mapping[str, Any]], file: Path) -> None:
    """Draw the errors with their intervals, a panel a signal, classes in the order of the table."""
    import matplotlib  # half a second to import

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    matplotlib.rcParams["svg.fonttype"] = "none"
    matplotlib.rcParams["svg.hashsalt"] = "classes"
    ordered = ranked(models)[::-1]
    figure, panels = plt.subplots(1, len(_ORDER), figsize=(14, 0.34 * len(ordered) + 1.2), sharey=True)
    for panel, signal in zip(panels, _ORDER, strict=True):
        for row, model in enumerate(ordered):
            errors = _errors(model)
            if signal in errors:
                low, high = errors[signal]["interval"]
                panel.plot([low, high], [row, row], color="#0072b2", linewidth=2)
                panel.plot(errors[signal]["error"], row, "o", color="#0072b2", markersize=5)
        if signal in SIGNALS:
            panel.axvline(ordered[-1]["noise"].get(signal, float("nan")), color="#999", linewidth=1, linestyle=":")
            panel.set_xlabel(f"{SIGNALS[signal].title} {SIGNALS[signal].symbol} [{SIGNALS[signal].unit}]")
        else:
            panel.axvline(1.0, color="#999", linewidth=1, linestyle=":")
            panel.set_xlabel("total, noise-weighted")
        shown = [_errors(model)[signal] for model in ordered if signal in _errors(model)]
        if max(c["error"] for c in shown) > 2.0 * min(c["error"] for c in shown):
            panel.set_xscale("log")
            panel.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
            panel.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
            panel.xaxis.set_minor_formatter(NullFormatter())
        else:
            panel.set_xlim(left=0.0)
        panel.grid(axis="both", color="#ddd", linewidth=0.6)
        panel.spines[["top", "right"]].set_visible(False)
    panels[0].set_yticks(range(len(ordered)), [model["model"] for model in ordered])
    figure.suptitle("Error on runs left out of the fit, 90 % interval; dotted: noise of a cell mean", fontsize=11)
    figure.tight_layout()
    with whole_file(file, replace=True) as partial:
        figure.savefig(partial, metadata={"Date": None} if file.suffix == ".svg" else None)
    plt.close(figure)


if __name__ == "__main__":
    sys.exit(main())
