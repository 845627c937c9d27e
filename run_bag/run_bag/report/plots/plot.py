"""A plot that is ready to be put into a report."""

from dataclasses import dataclass, field

import plotly.graph_objects as go


@dataclass(frozen=True, kw_only=True)
class Plot:
    """A plotly figure with what a reader must know about how it was drawn.

    Args:
        figure: the plotly figure; colours and sizes of its template are replaced by the report's.
        notes: sentences below the caption, such as that samples were left out.
        height: in CSS pixels.
    """

    figure: go.Figure
    notes: tuple[str, ...] = field(default=())
    height: int = 360
