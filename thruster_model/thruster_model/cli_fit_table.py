"""The errors of a finished fit as a Markdown table, channel by channel, also where the fit loses."""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from run_bag.command_line import user_arguments
from thruster_model.identification.experiment import SIGNALS

_COLUMNS = ("model", "signal", "noise", "published", "fit", "difference", "left out", "difference left out")


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; return the exit status."""
    parser = argparse.ArgumentParser(prog="fit_table", description=__doc__)
    parser.add_argument("folder", type=Path, help="the --out folder of fit")
    file = parser.parse_args(user_arguments(arguments)).folder / "fit.json"
    try:
        document = json.loads(file.read_text("utf-8"))
        print(table(document["models"]))
    except (OSError, ValueError, KeyError) as error:
        print(f"{file}: expected the summary of a fit; found {error!r}", file=sys.stderr)
        return 1
    return 0


def table(models: Sequence[Mapping[str, Any]]) -> str:
    """Return the table of the models in a fit's summary."""
    lines = [f"| {' | '.join(_COLUMNS)} |", "|" + "---|" * len(_COLUMNS)]
    for model in models:
        left_out = {c["signal"]: c for c in model["errors_left_out"] or []}
        for c in model["errors"]:
            signal = c["signal"]
            total = signal == "total"
            name = "total, noise-weighted" if total else f"{SIGNALS[signal].title.lower()} [{SIGNALS[signal].unit}]"
            noise = 1.0 if total else model["noise"][signal]
            cells = [model["model"], name, f"{noise:.3g}", f"{c['reference']:.3g}", f"{c['error']:.3g}", _difference(c)]
            other = left_out.get(signal)
            cells += [f"{other['error']:.3g}", _difference(other)] if other else ["–", "–"]
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _difference(comparison: Mapping[str, Any]) -> str:
    """Return fit less published with its standard error; in bold where the fit loses by more than that."""
    difference = comparison["error"] - comparison["reference"]
    text = f"{difference:+.2g} ± {comparison['difference_error']:.1g}"
    return f"**{text}**" if difference > comparison["difference_error"] else text


if __name__ == "__main__":
    sys.exit(main())
