"""Colours and axis style, light and dark.

Figures are written in the light colours. The page exchanges them for their dark partners when the reader's
system asks for a dark page, and always prints the light ones. The series colours follow Okabe and Ito's
palette (distinct under the common colour blindnesses), made darker or lighter until each has contrast on its
background.
"""

from typing import Any

MEASURED = "#59626e"
FITS = ("#0072b2", "#d55e00", "#00825f", "#a8457f", "#9a6700", "#4b4fc4")
DASHES = ("solid", "solid", "solid", "7px,3px", "7px,3px", "2px,2px")
REFERENCE = "#8b949e"
SPAN = "rgba(110,118,129,0.14)"
NEGATIVE, MIDDLE, POSITIVE = "#e69f5c", "#f4f4f2", "#6aaadf"
INK = "#24292f"

_DARK = {
    MEASURED: "#aeb6c0",
    "#0072b2": "#56b4e9",
    "#d55e00": "#ff8a3d",
    "#00825f": "#36c99b",
    "#a8457f": "#e592c0",
    "#9a6700": "#e8b93a",
    "#4b4fc4": "#a3a5ff",
    REFERENCE: "#7d8590",
    INK: "#d9dee4",
    NEGATIVE: "#94501c",
    MIDDLE: "#22262c",
    POSITIVE: "#245f9c",
}


def faint(colour: str, opacity: float = 0.2) -> str:
    """Return a colour for areas: `colour` (#rrggbb) with some transparency."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return f"rgba({red},{green},{blue},{opacity:g})"


def dark_partner(colour: str) -> str:
    """Return the colour that replaces `colour` on a dark page (itself where there is none)."""
    return dark_partners().get(colour, colour)


def dark_partners() -> dict[str, str]:
    """Return light → dark for all series colours and their faint versions."""
    return _DARK | {faint(light): faint(dark, 0.26) for light, dark in _DARK.items()}


def template(*, dark: bool) -> dict[str, Any]:
    """Return the plotly template of one colour scheme."""
    text, muted, grid, line = (
        ("#d9dee4", "#aeb6c0", "#2d333b", "#565e68") if dark else ("#24292f", "#59626e", "#e6e9ec", "#9aa3ad")
    )
    axis = {
        "gridcolor": grid,
        "linecolor": line,
        "tickcolor": line,
        "zerolinecolor": line,
        "zerolinewidth": 1,
        "showline": True,
        "showgrid": True,
        "spikecolor": line,
        "spikethickness": 1,
        "spikedash": "solid",
        "ticks": "outside",
        "exponentformat": "power",
        "ticklen": 4,
        "tickfont": {"color": muted},
        "title": {"standoff": 8},
        "automargin": True,
        "minor": {"ticklen": 2, "tickcolor": line},
    }
    flat = {
        "gridcolor": grid,
        "linecolor": line,
        "zerolinecolor": line,
        "showbackground": False,
        "tickfont": {"color": muted, "size": 10},
        "title": {"font": {"size": 11}},
        "showspikes": False,
        "nticks": 6,
    }
    return {
        "layout": {
            "font": {
                "color": text,
                "family": 'system-ui, -apple-system, "Segoe UI", Roboto, "DejaVu Sans", sans-serif',
            },
            "paper_bgcolor": "rgba(0,0,0,0)",
            "plot_bgcolor": "rgba(0,0,0,0)",
            "colorway": [dark_partner(c) if dark else c for c in FITS],
            "xaxis": axis,
            "yaxis": axis,
            "scene": dict.fromkeys(("xaxis", "yaxis", "zaxis"), flat),
            "hoverlabel": {
                "bgcolor": "#22262c" if dark else "#ffffff",
                "bordercolor": line,
                "font": {"color": text},
            },
            "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": line, "activecolor": text},
            "annotationdefaults": {"font": {"color": text}, "showarrow": False},
        }
    }
