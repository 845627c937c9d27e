"""A matrix as colours: correlations by default."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import plotly.graph_objects as go

from ..errors import ReportError
from ..theme import INK, MIDDLE, NEGATIVE, POSITIVE
from .axis import Axis, plot_text
from .plot import Plot

CORRELATION = Axis(name="correlation", unit="–")
_NUMBERS_UP_TO = 12


def heat_map(
    values: npt.ArrayLike,
    *,
    columns: Sequence[str],
    rows: Sequence[str] | None = None,
    quantity: Axis = CORRELATION,
    limit: float = 1.0,
) -> Plot:
    """Draw a matrix, blue for positive and brown for negative values, with the numbers while they fit.

    Args:
        values: (rows, columns); NaN is left blank.
        columns: names of the columns.
        rows: names of the rows; those of the columns if not given.
        quantity: what the colour means.
        limit: the colours span −limit … +limit, in the quantity's unit.
    """
    matrix = np.array(values, dtype=np.float64)
    names = columns if rows is None else rows
    if matrix.shape != (len(names), len(columns)):
        raise ReportError(f"heat map: expected shape ({len(names)}, {len(columns)}) by its names, got {matrix.shape}")
    trace: dict[str, Any] = {
        "type": "heatmap",
        "z": matrix,
        "zmin": -limit,
        "zmax": limit,
        "xgap": 1,
        "ygap": 1,
        "colorscale": [[0.0, NEGATIVE], [0.5, MIDDLE], [1.0, POSITIVE]],
        "colorbar": {
            "thickness": 10,
            "outlinewidth": 0,
            "title": {"text": quantity.full, "side": "right"},
            "len": 1.0,
            "lenmode": "fraction",
        },
        "hovertemplate": "%{y} – %{x}: %{z:.3f}<extra></extra>",
    }
    if max(matrix.shape, default=0) <= _NUMBERS_UP_TO:
        trace["text"] = [[_two_decimals(v) for v in row] for row in matrix]
        trace["texttemplate"] = "%{text}"
        trace["textfont"] = {"color": INK}
    axis = {"tickmode": "array", "showgrid": False, "ticks": "", "showline": False, "zeroline": False}
    layout = {
        "margin": {"t": 8, "b": 40},
        "hovermode": "closest",
        "xaxis": axis | {"tickvals": list(range(len(columns))), "ticktext": [plot_text(c) for c in columns]},
        "yaxis": axis
        | {
            "tickvals": list(range(len(names))),
            "ticktext": [plot_text(n) for n in names],
            "autorange": "reversed",
        },
    }
    return Plot(figure=go.Figure(data=[trace], layout=layout), height=max(220, min(560, 44 * len(names) + 70)))


def _two_decimals(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.2f}".replace("-", "−")
