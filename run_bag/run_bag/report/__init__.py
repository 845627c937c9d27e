"""Build self-contained HTML reports from plain data: text, tables, plots. No maths, no models."""

from .blocks import Link
from .document import Report
from .errors import BrowserMissing, ReportError, ReportExists
from .plots import (
    FREQUENCY,
    TIME,
    Axis,
    Bars,
    Panel,
    Plot,
    Residual,
    Series,
    Span,
    Track,
    bars,
    curves,
    heat_map,
    needles,
    residuals,
    space,
    time_series,
)
from .table import Cell, Column

__all__ = [
    "FREQUENCY",
    "TIME",
    "Axis",
    "Bars",
    "BrowserMissing",
    "Cell",
    "Column",
    "Link",
    "Panel",
    "Plot",
    "Report",
    "ReportError",
    "ReportExists",
    "Residual",
    "Series",
    "Span",
    "Track",
    "bars",
    "curves",
    "heat_map",
    "needles",
    "residuals",
    "space",
    "time_series",
]
