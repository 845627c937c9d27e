"""One line or cloud of points, and the plotly traces that draw it."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from ..decimation import compact, keep_extremes
from ..errors import ReportError
from ..theme import DASHES, FITS, MEASURED, REFERENCE, faint
from .axis import plot_text

Role = Literal["data", "fit", "reference"]


class Coloured(Protocol):
    """What takes its colour from its role and name."""

    @property
    def name(self) -> str:
        """Shown in the legend."""

    @property
    def role(self) -> Role:
        """As that of a `Series`."""

    @property
    def color(self) -> int | None:
        """Index into the palette, None: the next one."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Series:
    """Samples of one quantity over another.

    Args:
        name: shown in the legend; series of one name share colour and legend entry within a figure.
        x: (n,) in the unit of the x axis, finite.
        y: (n,) in the unit of the y axis; NaN makes a gap.
        role: "data" is drawn in grey beneath, "fit" in colour on top, "reference" thin and light.
        points: draw points instead of a line.
        low: (n,) lower end of an interval around y: a band for lines, error bars for points.
        high: (n,) upper end of it.
        color: index into the palette; by default fits are numbered by first appearance in the figure. Give it
            where one model appears in several figures, so that it keeps its colour.
    """

    name: str
    x: npt.ArrayLike
    y: npt.ArrayLike
    role: Role = "fit"
    points: bool = False
    low: npt.ArrayLike | None = None
    high: npt.ArrayLike | None = None
    color: int | None = None

    def __post_init__(self) -> None:
        wrong = []
        for name in ("x", "y", "low", "high"):
            given = getattr(self, name)
            if given is not None:
                array = np.array(given, dtype=np.float64)
                array.setflags(write=False)
                object.__setattr__(self, name, array)
                if array.ndim != 1 or array.shape != np.shape(self.x):
                    wrong.append(f"{name} has shape {array.shape}, expected {np.shape(self.x)[:1]}")
        if not np.isfinite(np.asarray(self.x)).all():
            wrong.append("x is not finite everywhere")
        if (self.low is None) != (self.high is None):
            wrong.append("low and high: expected both or neither")
        if wrong:
            raise ReportError(f"series {self.name!r}: {'; '.join(wrong)}")


def colour_indices(series: Sequence[Coloured]) -> dict[str, int]:
    """Number the fits by first appearance, around the indices that were asked for."""
    fixed = {s.name: s.color for s in series if s.role == "fit" and s.color is not None}
    free = (i for i in range(len(series) + len(fixed) + 1) if i not in fixed.values())
    for s in series:
        if s.role == "fit" and s.name not in fixed:
            fixed[s.name] = next(free)
    return fixed


def colour_of(series: Coloured, indices: dict[str, int]) -> str:
    """Return the colour of a series by its role."""
    if series.role != "fit":
        return MEASURED if series.role == "data" else REFERENCE
    return FITS[indices[series.name] % len(FITS)]


def draw(series: Series, indices: dict[str, int], max_points: int, **where: Any) -> tuple[list[dict[str, Any]], int]:
    """Turn a series into plotly traces.

    Args:
        series: what to draw.
        indices: colours of the fits, from `colour_indices`.
        max_points: longer series are reduced to about this many samples.
        where: axis references and legend settings for every trace.

    Returns:
        the traces, and the number of samples before reduction if it was reduced (else 0).
    """
    x, y = np.asarray(series.x), np.asarray(series.y)
    low, high = (None if v is None else np.asarray(v) for v in (series.low, series.high))
    kept = keep_extremes(y, *(v for v in (low, high) if v is not None), max_points=max_points)
    colour = colour_of(series, indices)
    common = {
        "type": "scatter",
        "x": compact(x[kept]),
        "name": plot_text(series.name),
        "legendgroup": plot_text(series.name),
        **where,
    }
    dash = DASHES[indices.get(series.name, 0) % len(DASHES)] if series.role == "fit" else "solid"
    main: dict[str, Any] = common | {"y": compact(y[kept])}
    traces = []
    if series.points:
        main |= {"mode": "markers", "marker": {"color": colour, "size": 6 if len(kept) < 200 else 3}}
        if low is not None and high is not None:
            main["error_y"] = {
                "type": "data",
                "symmetric": False,
                "array": compact((high - y)[kept]),
                "width": 3,
                "arrayminus": compact((y - low)[kept]),
                "color": colour,
                "thickness": 1.2,
            }
    else:
        width = {"data": 1.3, "fit": 1.8, "reference": 1.2}[series.role]
        main |= {"mode": "lines", "line": {"color": colour, "width": width, "dash": dash}}
        if low is not None and high is not None:
            traces += _band(common, low[kept], high[kept], colour)
    return [*traces, main], len(y) if len(kept) < len(y) else 0


def _band(common: dict[str, Any], low: npt.NDArray[Any], high: npt.NDArray[Any], colour: str) -> list[dict[str, Any]]:
    edge = common | {
        "mode": "lines",
        "line": {"width": 0, "color": colour},
        "hoverinfo": "skip",
        "showlegend": False,
    }
    return [
        edge | {"y": compact(low)},
        edge | {"y": compact(high), "fill": "tonexty", "fillcolor": faint(colour)},
    ]


def reduction_note(longest: int, max_points: int) -> tuple[str, ...]:
    """Say that samples were left out of the drawing, or nothing when none were."""
    if not longest:
        return ()
    return (
        f"Drawn with fewer samples (about {max_points} of up to {longest} per line): each interval keeps its "
        "smallest and largest value, so no peak is lost.",
    )
