"""The report: content in order, then one self-contained HTML file."""

import os
import re
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

import plotly.graph_objects as go

from safe_files.whole_files_io import write_whole

from .blocks import Download, KeyValues, Link, Links, Paragraph
from .errors import ReportError, ReportExists
from .figure import Figure
from .page import Heading, render_page
from .plots.plot import Plot
from .table import Column, Table

SHOWN = 3
"""Warnings that are shown; the others are folded."""
_Block = Heading | Paragraph | KeyValues | Download | Links | Table | Figure


class Report:
    """Collect content and write it as one HTML file that needs nothing else.

    All text is plain text: it is escaped, never read as HTML. Same content, same bytes.

    Args:
        title: heading of the page.
        subtitle: one line below it.
        provenance: what the report was made from (runs, parameter set, version, seed, …); shown at the end.
            Mappings and sequences may be nested.
    """

    def __init__(self, title: str, subtitle: str = "", provenance: Mapping[str, object] | None = None) -> None:
        if not title.strip():
            raise ReportError("report: expected a title, got none")
        self.title = title
        self.subtitle = subtitle
        self.provenance = dict(provenance or {})
        self._warnings: list[str] = []
        self._blocks: list[_Block] = []
        self._anchors: set[str] = set()

    def warning(self, text: str) -> None:
        """Add something the reader must know first; all warnings stand above the content."""
        self._warnings.append(text)

    def section(self, title: str) -> None:
        """Start a section."""
        self._blocks.append(Heading(text=title, anchor=self._anchor(title), level=2))

    def subsection(self, title: str) -> None:
        """Start a part of the current section."""
        if not any(isinstance(block, Heading) for block in self._blocks):
            raise ReportError(f"subsection {title!r}: expected a section before it, got none")
        self._blocks.append(Heading(text=title, anchor=self._anchor(title), level=3))

    def paragraph(self, text: str) -> None:
        """Add running text; blank lines separate paragraphs."""
        self._blocks.append(Paragraph(text))

    def key_values(self, items: Mapping[str, object]) -> None:
        """Add a definition list; values may be nested mappings or sequences."""
        self._blocks.append(KeyValues(dict(items)))

    def download(self, label: str, filename: str, text: str) -> None:
        """Embed a text, such as a YAML file, behind a link that saves it."""
        self._blocks.append(Download(label, filename, text))

    def links(self, items: Sequence[Link]) -> None:
        """Add links to files beside the report, which a reader gets together with it."""
        self._blocks.append(Links(tuple(items)))

    def table(
        self,
        columns: Sequence[Column | str],
        rows: Sequence[Sequence[object]],
        *,
        caption: str,
        notes: Sequence[str] = (),
    ) -> None:
        """Add a table.

        Args:
            columns: headings, with units as `Column(name=…, unit=…)`; the first column names the rows.
            rows: cells: text, numbers, None or NaN for what is missing, `Cell(value, mark)` for what stands
                out.
            caption: what the table shows.
            notes: sentences below it.
        """
        self._blocks.append(Table(columns=columns, rows=rows, caption=caption, notes=notes))

    def figure(self, plots: Plot | go.Figure | Sequence[Plot | go.Figure], *, caption: str, alt: str) -> None:
        """Add a figure.

        Args:
            plots: one plot, or several that stand side by side where there is room and share one legend.
            caption: what the figure shows.
            alt: what a reader who cannot see it should know: what is drawn and what follows from it.
        """
        several = [plots] if isinstance(plots, Plot | go.Figure) else list(plots)
        ready = tuple(p if isinstance(p, Plot) else Plot(figure=p, height=int(p.layout.height or 360)) for p in several)
        self._blocks.append(Figure(plots=ready, caption=caption, alt=alt))

    def html(self) -> str:
        """Return the page."""
        body, tables, figures = [self._render_warnings()], 0, 0
        told: set[str] = set()  # house words
        for block in self._blocks:
            if isinstance(block, Table):
                tables += 1
                body.append(block.render(tables))
            elif isinstance(block, Figure):
                figures += 1
                body.append(block.render(figures))
            elif isinstance(block, Paragraph):
                body.append(block.render(told))
            else:
                body.append(block.render())
        headings = [Heading(text="Warnings", anchor="warnings", level=2)] if self._warnings else []
        headings += [block for block in self._blocks if isinstance(block, Heading)]
        if self.provenance:
            last = Heading(text="Provenance", anchor="provenance", level=2)
            headings.append(last)
            body += [last.render(), KeyValues(self.provenance).render()]
        return render_page(
            title=self.title,
            subtitle=self.subtitle,
            description=self._description(),
            headings=headings,
            body="\n".join(body),
            traces={kind for block in self._blocks if isinstance(block, Figure) for kind in block.traces},
        )

    def write(self, path: str | os.PathLike[str], *, replace: bool = False) -> Path:
        """Write the report, whole or not at all.

        Raises:
            ReportExists: when there is a file already and `replace` is not set.
            NotWrittenError: the file system refuses.
        """
        target = Path(path)
        page = self.html()
        if target.exists() and not replace:
            raise ReportExists(f"report {target}: expected no file there, found one; pass replace=True to overwrite it")
        return write_whole(target, page, replace=replace)

    def _description(self) -> str:
        """Return what the report says: the answer of its first list or, before that, its first paragraph."""
        for block in self._blocks:
            if isinstance(block, KeyValues) and isinstance(answer := block.items.get("answer"), str):
                return answer
            if isinstance(block, Paragraph):
                return block.text.split("\n\n")[0].strip()
        return ""

    def _render_warnings(self) -> str:
        if not self._warnings:
            return '<p class="no-warnings">No warnings.</p>'
        items = [f"<li>{escape(text)}</li>" for text in self._warnings]
        count, more = len(items), items[SHOWN:]
        folded = ""
        if more:
            folded = f"<details><summary>{len(more)} more</summary><ul>{''.join(more)}</ul></details>"
        return (
            f'<section class="warnings" aria-labelledby="warnings"><h2 id="warnings">'
            f"{count} warning{'s' if count > 1 else ''}</h2><ul>{''.join(items[:SHOWN])}</ul>{folded}</section>"
        )

    def _anchor(self, title: str) -> str:
        base = "s-" + (re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-") or "section")
        anchor = next(
            a for a in (base, *(f"{base}-{k}" for k in range(2, len(self._anchors) + 3))) if a not in self._anchors
        )
        self._anchors.add(anchor)
        return anchor
