"""Bars with intervals, one group per label, drawn sideways so that labels stay readable."""

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from textwrap import wrap
from typing import Any

import numpy as np
import numpy.typing as npt
import plotly.graph_objects as go

from ..errors import ReportError
from ..theme import FITS, INK, MEASURED, REFERENCE
from .axis import Axis, plot_text
from .plot import Plot


@dataclass(frozen=True, kw_only=True, eq=False)
class Bars:
    """One bar for each label.

    Args:
        name: shown in the legend when there are several.
        value: (n,) in the unit of the axis; NaN leaves the bar out.
        low: (n,) lower end of the interval; NaN where there is none.
        high: (n,) upper end of it.
        color: index into the palette; -1 for the grey of measurements and floors.
    """

    name: str
    value: npt.ArrayLike
    low: npt.ArrayLike | None = None
    high: npt.ArrayLike | None = None
    color: int | None = None


def bars(labels: Sequence[str], groups: Sequence[Bars], *, quantity: Axis, reference: float | None = None) -> Plot:
    """Draw bars with intervals.

    Args:
        labels: (n,) from top to bottom.
        groups: one or more bars for each label.
        quantity: what the length of a bar means.
        reference: a value to compare with, drawn as a line.
    """
    wrong = [
        f"{g.name!r} has shape {np.shape(v)}"
        for g in groups
        for v in (g.value, g.low, g.high)
        if v is not None and np.shape(v) != (len(labels),)
    ]
    if wrong or not groups or not labels:
        raise ReportError(
            f"bars: expected values of shape ({len(labels)},) in at least one group, got: "
            f"{'; '.join(wrong) or 'nothing to draw'}"
        )
    rows = [f"{k}" for k in range(len(labels))]
    names = ["<br>".join(escape(part, quote=False) for part in wrap(label, 20) or [""]) for label in labels]
    traces: list[dict[str, Any]] = []
    for k, group in enumerate(groups):
        index = k if group.color is None else group.color
        colour = FITS[index % len(FITS)] if index >= 0 else REFERENCE
        value = np.array(group.value, dtype=np.float64)
        trace: dict[str, Any] = {
            "type": "bar",
            "orientation": "h",
            "y": rows,
            "x": value,
            "name": plot_text(group.name),
            "legendgroup": plot_text(group.name),
            "showlegend": len(groups) > 1,
            "marker": {"color": colour, "opacity": 0.85},
            "hovertemplate": "%{x:.4g} " + plot_text(quantity.unit) + "<extra>%{fullData.name}</extra>",
        }
        if group.low is not None and group.high is not None:
            trace["error_x"] = {
                "type": "data",
                "symmetric": False,
                "color": INK,
                "thickness": 1.6,
                "width": 4,
                "array": np.asarray(group.high, dtype=np.float64) - value,
                "arrayminus": value - np.asarray(group.low, dtype=np.float64),
            }
        traces.append(trace)
    lines = 1 + max(name.count("<br>") for name in names)
    height = len(labels) * max(34, 15 * len(groups) + 14, 15 * lines + 6) + 62
    layout: dict[str, Any] = {
        "barmode": "group",
        "bargap": 0.3,
        "hovermode": "closest",
        "margin": {"t": 8, "b": 46},
        "xaxis": {"title": {"text": quantity.full}, **quantity.scale([g.value for g in groups])},
        "yaxis": {
            "type": "category",
            "autorange": "reversed",
            "tickmode": "array",
            "tickvals": rows,
            "ticktext": names,
            "showgrid": False,
            "ticks": "",
        },
    }
    if reference is not None:
        layout["shapes"] = [
            {
                "type": "line",
                "xref": "x",
                "yref": "paper",
                "x0": reference,
                "x1": reference,
                "y0": 0,
                "y1": 1,
                "line": {"color": MEASURED, "width": 1.2, "dash": "4px,3px"},
            }
        ]
    return Plot(figure=go.Figure(data=traces, layout=layout), height=height)
