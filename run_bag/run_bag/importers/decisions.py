"""What an importer decided about a recording, as it goes into the run's metadata."""

from __future__ import annotations

import hashlib
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any


@dataclass(frozen=True, kw_only=True)
class Decision:
    """One decision: what, its value and unit, how well known (None: not quantified), how it was found."""

    what: str
    value: Any
    unit: str
    how: str
    standard_deviation: float | None = None


@dataclass
class Decisions:
    """The decisions about one recording, in order."""

    items: list[Decision] = field(default_factory=list)

    def add(
        self, what: str, value: Any, unit: str, how: str, standard_deviation: float | None = None, *, digits: int = 9
    ) -> None:  # fmt: skip
        """Add one decision; numbers are rounded to so many digits (17: all)."""
        deviation = None if standard_deviation is None else float(f"{standard_deviation:.3g}")
        value = float(f"{value:.{digits}g}") if isinstance(value, float) else value
        self.items.append(Decision(what=what, value=value, unit=unit, how=how, standard_deviation=deviation))

    def json(self) -> list[dict[str, Any]]:
        """Return the decisions as JSON values."""
        return [asdict(d) for d in self.items]

    def value(self, what: str) -> Any:
        """Return the value decided for `what`, None if nothing was."""
        return next((d.value for d in self.items if d.what == what), None)

    def deviation(self, what: str) -> float | None:
        """Return the standard deviation of the decision on `what`, None if there is none."""
        return next((d.standard_deviation for d in self.items if d.what == what), None)


def source(path: Path) -> dict[str, Any]:
    """Describe a source file: name, size in bytes, SHA-256."""
    data = path.read_bytes()
    return {"file": path.name, "bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
