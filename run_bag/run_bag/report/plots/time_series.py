"""Channels over time: stacked panels that share the time axis and therefore its zoom."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import plotly.graph_objects as go

from ..errors import ReportError
from ..theme import SPAN
from .axis import TIME, Axis, plot_text
from .plot import Plot
from .series import Series, colour_indices, draw, reduction_note

TOP, BOTTOM = 28, 46


@dataclass(frozen=True, kw_only=True)
class Panel:
    """One quantity: its axis and all series that show it."""

    axis: Axis
    series: Sequence[Series]


@dataclass(frozen=True)
class Span:
    """A shaded stretch of the x axis, such as a held-out block; spans of one label share a legend entry."""

    start: float
    stop: float
    label: str


def time_series(
    panels: Sequence[Panel],
    *,
    x: Axis = TIME,
    spans: Sequence[Span] = (),
    max_points: int = 1500,
    panel_height: int = 150,
) -> Plot:
    """Draw channels over time, one panel each, data against any number of fits.

    Args:
        panels: from top to bottom; each series brings its own time stamps.
        x: the common axis.
        spans: shaded stretches of it.
        max_points: longer series are reduced for display, keeping every extreme; the plot then says so.
        panel_height: height of one panel in CSS pixels.
    """
    if not panels:
        raise ReportError("time series: expected at least one panel, got none")
    gap = 34
    inner = len(panels) * panel_height + (len(panels) - 1) * gap
    indices = colour_indices([s for panel in panels for s in panel.series])
    traces: list[dict[str, Any]] = []
    named: set[str] = set()
    longest = 0
    layout: dict[str, Any] = {
        "hovermode": "x unified",
        "margin": {"t": TOP, "b": BOTTOM},
        "annotations": [],
        "xaxis": {
            "title": {"text": x.full},
            "anchor": f"y{len(panels) if len(panels) > 1 else ''}",
            **x.scale([s.x for panel in panels for s in panel.series]),
        },
        "shapes": [
            {
                "type": "rect",
                "xref": "x",
                "yref": "paper",
                "x0": s.start,
                "x1": s.stop,
                "y0": 0,
                "y1": 1,
                "line": {"width": 0},
                "fillcolor": SPAN,
                "layer": "below",
                "name": plot_text(s.label),
            }
            for s in spans
        ],
    }
    for k, panel in enumerate(panels):
        suffix = str(k + 1) if k else ""
        top = 1.0 - k * (panel_height + gap) / inner
        layout[f"yaxis{suffix}"] = {
            "domain": [max(0.0, top - panel_height / inner), top],
            "anchor": "x",
            "title": {"text": panel.axis.short},
            "nticks": 6,
            **panel.axis.scale([s.y for s in panel.series]),
        }
        layout["annotations"].append(
            {
                "text": f"<b>{plot_text(panel.axis.name)}</b>",
                "xref": "paper",
                "yref": "paper",
                "x": 0,
                "y": top,
                "xanchor": "left",
                "yanchor": "bottom",
                "yshift": 3,
                "showarrow": False,
            }
        )
        for series in sorted(panel.series, key=lambda s: s.role == "fit"):
            drawn, samples = draw(
                series,
                indices,
                max_points,
                xaxis="x",
                yaxis=f"y{suffix}",
                hovertemplate=panel.axis.readout("y"),
                showlegend=series.name not in named,
            )
            named.add(series.name)
            traces += drawn
            longest = max(longest, samples)
    traces += _span_keys(spans)
    return Plot(
        figure=go.Figure(data=traces, layout=layout),
        notes=reduction_note(longest, max_points),
        height=inner + TOP + BOTTOM,
    )


def _span_keys(spans: Sequence[Span]) -> list[dict[str, Any]]:
    """Return an empty trace for each label, so that the legend explains the shading."""
    return [
        {
            "type": "scatter",
            "mode": "markers",
            "x": [None],
            "y": [None],
            "name": plot_text(label),
            "legendgroup": plot_text(label),
            "marker": {"color": SPAN, "symbol": "square"},
            "hoverinfo": "skip",
        }
        for label in dict.fromkeys(s.label for s in spans)
    ]
