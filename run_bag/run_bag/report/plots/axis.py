"""What an axis measures, always with its unit."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import ReportError


@dataclass(frozen=True, kw_only=True)
class Axis:
    """A quantity with its unit.

    Args:
        name: in words, for example "rotor speed".
        unit: for example "rad/s"; "–" for a quantity without dimension.
        symbol: for example "n"; optional.
        log: draw a logarithmic scale.
    """

    name: str
    unit: str
    symbol: str = ""
    log: bool = False

    def __post_init__(self) -> None:
        if not self.name or not self.unit:
            raise ReportError(
                f"axis: expected a name and a unit (– where there is none), got name={self.name!r}, unit={self.unit!r}"
            )

    def scale(self, values: Sequence[npt.ArrayLike]) -> dict[str, Any]:
        """Return plotly's settings for the scale; logarithmic ticks depend on the decades in the values."""
        if not self.log:
            return {"type": "linear"}
        seen = np.concatenate([np.ravel(np.asarray(v, dtype=np.float64)) for v in values])
        seen = seen[np.isfinite(seen) & (seen > 0.0)]
        low, high = (np.log10(seen.min()), np.log10(seen.max())) if seen.size else (0.0, 1.0)
        minor = {"ticks": "outside", "dtick": "D1"}
        if high - low > 2.5:
            plain = {"tickformat": "~g"} if low > -4.5 and high < 5.5 else {}
            return {"type": "log", "dtick": max(1, round((high - low) / 6)), "minor": minor} | plain
        exponents = range(int(np.floor(low)) - 1, int(np.ceil(high)) + 2)
        ticks = [step * 10.0**k for k in exponents for step in (1, 2, 5)]
        return {"type": "log", "tickvals": ticks, "ticktext": [f"{t:g}" for t in ticks], "minor": minor}

    def readout(self, variable: str) -> str:
        """Return what plotly shows beside the pointer for the coordinate "x" or "y"."""
        return plot_text(self.symbol or self.name) + f" = %{{{variable}:.4g}} " + plot_text(self.unit)

    @property
    def short(self) -> str:
        """Symbol (or name) and unit, for narrow places."""
        return plot_text(f"{self.symbol or self.name} [{self.unit}]")

    @property
    def full(self) -> str:
        """Name, symbol and unit."""
        return plot_text(f"{self.name} {self.symbol} [{self.unit}]" if self.symbol else f"{self.name} [{self.unit}]")


TIME = Axis(name="time", unit="s", symbol="t")
FREQUENCY = Axis(name="frequency", unit="Hz", symbol="f")


def plot_text(text: str) -> str:
    """Escape a text for plotly, which would read tags in it."""
    return escape(text, quote=False)
