"""A figure of the report: one or several plots, legend, caption, text for those who cannot see it."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

import plotly.graph_objects as go

from .errors import ReportError
from .legend import legend
from .plots.plot import Plot


@dataclass(frozen=True, kw_only=True)
class Figure:
    """Plots with caption and alternative text."""

    plots: Sequence[Plot]
    caption: str
    alt: str

    def __post_init__(self) -> None:
        if not self.plots or not self.alt.strip() or not self.caption.strip():
            raise ReportError(
                f"figure {self.caption!r}: expected plots, a caption and an alternative text, got "
                f"{len(self.plots)} plots, caption {self.caption!r}, alt {self.alt!r}"
            )

    @property
    def traces(self) -> set[str]:
        """Types of plotly's traces in it."""
        return {trace.type or "scatter" for plot in self.plots for trace in plot.figure.data}

    def render(self, number: int) -> str:
        """Return the figure as HTML; the plots' data are embedded as JSON that the page draws when needed."""
        described = [plot.figure.to_dict() for plot in self.plots]
        keys = legend(trace for figure in described for trace in figure["data"])
        boxes = "".join(self._box(plot, number, k) for k, plot in enumerate(self.plots))
        notes = "".join(
            f' <span class="note">{escape(n)}</span>'
            for n in dict.fromkeys(note for plot in self.plots for note in plot.notes)
        )
        return (
            f'<figure class="figure" id="figure-{number}">{keys}'
            f'<div class="plots" style="--columns:{min(2, len(self.plots))}">{boxes}</div>'
            f"<figcaption><b>Figure {number}.</b> {escape(self.caption)}{notes}</figcaption></figure>"
        )

    def _box(self, plot: Plot, number: int, k: int) -> str:
        bare = go.Figure(plot.figure)
        bare.layout.template = None
        alt = self.alt if len(self.plots) == 1 else f"{self.alt} (part {k + 1} of {len(self.plots)})"
        return (
            f'<div class="plot" id="plot-{number}-{k + 1}" role="img" aria-label="{escape(alt)}" '
            f'style="height:{plot.height}px" data-height="{plot.height}">'
            f'<script type="application/json">{script_safe(bare.to_json())}</script></div>'
        )


def script_safe(json: str | None) -> str:
    """Return JSON that cannot end the script element it is put into."""
    return re.sub("[<\u2028\u2029]", lambda m: f"\\u{ord(m.group()):04x}", json or "{}")
