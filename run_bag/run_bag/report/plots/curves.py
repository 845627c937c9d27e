"""One quantity over another: steady-state curves with the points they were fitted to."""

from collections.abc import Sequence
from typing import Any

import plotly.graph_objects as go

from ..errors import ReportError
from .axis import Axis
from .plot import Plot
from .series import Series, colour_indices, draw, reduction_note


def curves(series: Sequence[Series], *, x: Axis, y: Axis, max_points: int = 1500, height: int = 360) -> Plot:
    """Draw curves and points in one plot.

    Args:
        series: points for measurements (`points=True`; `low` and `high` become error bars),
            lines for models.
        x: what runs to the right.
        y: what runs upwards.
        max_points: longer series are reduced for display, keeping every extreme; the plot then says so.
        height: in CSS pixels.
    """
    if not series:
        raise ReportError("curves: expected at least one series, got none")
    indices = colour_indices(series)
    traces: list[dict[str, Any]] = []
    named: set[str] = set()
    longest = 0
    hover = f"{x.readout('x')}<br>{y.readout('y')}"
    for one in sorted(series, key=lambda s: (s.role == "fit", s.points)):
        drawn, samples = draw(one, indices, max_points, showlegend=one.name not in named, hovertemplate=hover)
        named.add(one.name)
        traces += drawn
        longest = max(longest, samples)
    layout = {
        "hovermode": "closest",
        "margin": {"t": 10, "b": 46},
        "xaxis": {"title": {"text": x.full}, **x.scale([s.x for s in series])},
        "yaxis": {"title": {"text": y.full}, **y.scale([s.y for s in series])},
    }
    return Plot(figure=go.Figure(data=traces, layout=layout), notes=reduction_note(longest, max_points), height=height)
