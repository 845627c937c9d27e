"""Command line: diagnoses side by side, as a Markdown table and their paragraphs."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from run_bag.command_line import user_arguments

__all__ = ["main", "table"]

_NUMBERS = ("as_is", "retuned", "with_effect", "noise_floor")


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; return the exit status."""
    parser = argparse.ArgumentParser(prog="diagnosis_table", description=__doc__)
    parser.add_argument("files", nargs="+", type=Path, metavar="diagnosis.json", help="one for each row")
    given = parser.parse_args(user_arguments(arguments))
    try:
        found = {path.parent.name: json.loads(path.read_text(encoding="utf-8")) for path in given.files}
    except (OSError, ValueError) as error:
        print(f"diagnosis_table: {error}", file=sys.stderr)
        return 1
    print(table(found))
    return 0


def table(found: dict[str, dict[str, Any]]) -> str:
    """Return a table of verdicts and errors by name, one of errors by channel, and the paragraphs."""
    lines = ["| diagnosis | parameter set | runs | verdict | as stated | re-tuned | with effect | p(unknown) |"]
    lines.append("|---|---|---|---|---|---|---|---|")
    for name, each in found.items():
        total = each["gap"]["total"] or dict.fromkeys(_NUMBERS)
        numbers = " | ".join(_number(total[key]) for key in _NUMBERS[:3])
        runs = len(each["provenance"]["runs"])
        start = f"| {name} | {each['provenance']['parameter_set']} | {runs} | `{each['verdict']}`"
        lines.append(f"{start} | {numbers} | {each['p_unknown']:.2f} |")
    lines += ["", "| diagnosis | channel | unit | as stated | re-tuned | with effect | noise |"]
    lines.append("|---|---|---|---|---|---|---|")
    for name, each in found.items():
        for channel, errors in each["gap"]["channels"].items():
            numbers = " | ".join(_number(errors[key]) for key in _NUMBERS)
            lines.append(f"| {name} | {channel} | {errors['unit']} | {numbers} |")
    for name, each in found.items():
        lines += ["", f"**{name}.** {each['summary']}"]
    return "\n".join(lines)


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


if __name__ == "__main__":
    sys.exit(main())
