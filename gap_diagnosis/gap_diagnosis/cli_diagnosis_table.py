"""Diagnoses side by side, as a Markdown table and their paragraphs."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from run_bag.command_line import described, user_arguments

__all__ = ["main", "table"]

_NEEDED = ("verdict", "gap", "p_unknown", "summary", "provenance")
_NUMBERS = ("as_is", "retuned", "with_effect", "noise_floor")


EXAMPLES = """
  %(prog)s diagnosis/diagnosis.json
  %(prog)s before/diagnosis.json after/diagnosis.json > table.md"""


def main(arguments: Sequence[str] | None = None, program: str = "diagnosis_table") -> int:
    """Print the table; return the exit status."""
    parser = argparse.ArgumentParser(prog=program, **described(__doc__, EXAMPLES))
    parser.add_argument("files", nargs="+", type=Path, metavar="diagnosis.json", help="one for each row")
    given = parser.parse_args(user_arguments(arguments))
    try:
        found = dict(zip(_names(given.files), map(_read, given.files), strict=True))
    except (OSError, ValueError) as error:
        print(f"{program}: {error}", file=sys.stderr)
        return 1
    print(table(found))
    return 0


def _names(files: Sequence[Path]) -> list[str]:
    """Return the folders' names, with as many parents as tell them apart."""
    folders = [file.absolute().parent for file in files]
    depth = 1
    while len({folder.parts[-depth:] for folder in folders}) < len(set(folders)):
        depth += 1
    names = ["/".join(folder.parts[-depth:]) for folder in folders]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise ValueError(f"expected each diagnosis once; found {', '.join(twice)} several times")
    return names


def _read(file: Path) -> dict[str, Any]:
    """Return the content of a diagnosis.

    Raises:
        ValueError: it is no JSON, or no diagnosis.
    """
    try:
        content = json.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{file}: expected JSON; {error}") from error
    missing = [key for key in _NEEDED if not isinstance(content, dict) or key not in content]
    if missing:
        raise ValueError(f"{file}: expected a diagnosis.json; it has no {', '.join(missing)}")
    return dict(content)


def table(found: dict[str, dict[str, Any]]) -> str:
    """Return a table of verdicts and errors by name, of budgets, of errors by channel, and the paragraphs."""
    lines = ["| diagnosis | parameter set | runs | verdict | as stated | re-tuned | with effect | p(unknown) |"]
    lines.append("|---|---|---|---|---|---|---|---|")
    for name, each in found.items():
        total = each["gap"]["total"] or dict.fromkeys(_NUMBERS)
        numbers = " | ".join(_number(total[key]) for key in _NUMBERS[:3])
        runs = len(each["provenance"]["runs"])
        start = f"| {name} | {each['provenance']['parameter_set']} | {runs} | `{each['verdict']}`"
        lines.append(f"{start} | {numbers} | {each['p_unknown']:.2f} |")
    lines += _budgets(found)
    lines += ["", "| diagnosis | channel | unit | as stated | re-tuned | with effect | noise |"]
    lines.append("|---|---|---|---|---|---|---|")
    for name, each in found.items():
        for channel, errors in each["gap"]["channels"].items():
            numbers = " | ".join(_number(errors[key]) for key in _NUMBERS)
            lines.append(f"| {name} | {channel} | {errors['unit']} | {numbers} |")
    for name, each in found.items():
        lines += ["", f"**{name}.** {each['summary']}"]
    return "\n".join(lines)


def _budgets(found: dict[str, dict[str, Any]]) -> list[str]:
    """Return where each gap goes: causes with their shares, how stable they are, and their sizes."""
    lines = [
        "",
        "| diagnosis | cause | share of the squared gap, 90 % | helps a new run | best without each run | sizes |",
    ]
    lines.append("|---|---|---|---|---|---|")
    for name, each in found.items():
        budget = each.get("budget")
        if not budget:
            continue
        steps = {step["step"]: step["helps"] for step in budget["left_out"]}
        lines.append(
            f"| {name} | re-tuned | {_share(budget['parameters'])} | {_number(steps.get('retuned'))} | – | – |"
        )
        for cause in budget["causes"]:
            key = cause["id"] + (f":{cause['channel']}" if cause["channel"] else "")
            ranges = [f"{n} {min(v):.3g} to {max(v):.3g}" for n, v in cause["sizes_by_run_left_out"].items() if v]
            numbers = f"{_number(cause['helps'])} | {_number(cause['best_without_each_run'])}"
            lines.append(f"| {name} | {key} | {_share(cause)} | {numbers} | {'; '.join(ranges)} |")
        lines.append(f"| {name} | nothing with a name | {_share(budget['unexplained'])} | – | – | – |")
    return lines


def _share(entry: dict[str, Any]) -> str:
    low, high = entry["interval"]
    return f"{entry['share']:.2f} ({low:.2f} to {high:.2f})"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.3g}"


if __name__ == "__main__":
    sys.exit(main())
