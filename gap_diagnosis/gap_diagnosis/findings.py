"""Findings about runs, before any fit or diagnosis, and what they come to."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

__all__ = ["Finding", "Kind", "lines_of", "usable"]

Kind = Literal["good", "note", "refused"]
_MARKS: dict[Kind, str] = {"good": "  ", "note": "? ", "refused": "! "}


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One sentence about recordings: "good", a "note" of what is in the way, or why something is "refused".

    Attributes:
        kind, sentence: of it.
        about: what it is about, "" where that is a run as a whole.
        run: name of the recording, "" where it is about all of them.
        of_fit: whether it is about a fit alone, and asks nothing of a diagnosis.
    """

    kind: Kind
    sentence: str
    about: str = ""
    run: str = ""
    of_fit: bool = False


def usable(found: Sequence[Finding]) -> bool:
    """Tell whether nothing would be refused."""
    return all(each.kind != "refused" for each in found)


def lines_of(found: Sequence[Finding]) -> list[str]:
    """Return a line for each finding, marked, and one of what they come to; what holds of several runs is one."""
    runs: dict[tuple[Kind, str, str], list[str]] = {}
    for each in found:
        runs.setdefault((each.kind, each.about, each.sentence), []).append(each.run)
    count = len({each.run for each in found} - {""})
    lines = []
    for (kind, about, sentence), of in runs.items():
        whose = "each run" if len(of) == count > 1 else ", ".join(filter(None, of)) + " alike" * (len(of) > 1)
        lines.append(_MARKS[kind] + ": ".join(filter(None, (whose, about, sentence))))
    refused = sum(kind == "refused" for kind, _, _ in runs)
    notes = _counted(sum(kind == "note" for kind, _, _ in runs), "note", "?")
    of_fit = len({(each.about, each.sentence) for each in found if each.kind == "note" and each.of_fit})
    notes += f", {of_fit} of a fit alone" if of_fit else ""
    told = f"not usable as it is: {_counted(refused, 'refusal', '!')}, {notes}" if refused else f"usable: {notes}"
    return [*lines, told]


def _counted(number: int, what: str, mark: str) -> str:
    return f"{number} {what}{'' if number == 1 else 's'} ({mark})"
