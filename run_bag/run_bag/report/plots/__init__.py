"""Plots from plain arrays, each axis with its unit."""

from .axis import FREQUENCY, TIME, Axis
from .bars import Bars, bars
from .curves import curves
from .heat_map import heat_map
from .plot import Plot
from .residuals import Residual, residuals
from .series import Series
from .space import Track, needles, space
from .time_series import Panel, Span, time_series

__all__ = [
    "FREQUENCY",
    "TIME",
    "Axis",
    "Bars",
    "Panel",
    "Plot",
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
