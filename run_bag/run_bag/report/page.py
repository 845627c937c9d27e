"""The HTML page around the content: head, contents list, style, scripts, plotly.js once."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from json import dumps

from .figure import script_safe
from .library import libraries_for
from .theme import dark_partners, template

# The browser itself refuses every request: the report stays readable, and private, wherever it is opened.
_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; "
    "base-uri 'none'; form-action 'none'"
)
GENERATOR = "rov thrusters: report"
"""By which a page of ours is known."""


@dataclass(frozen=True, kw_only=True)
class Heading:
    """A heading of level 2 or 3 and the anchor that the contents list points to."""

    text: str
    anchor: str
    level: int

    def render(self) -> str:
        """Return the heading as HTML."""
        return f'<h{self.level} id="{self.anchor}">{escape(self.text)}</h{self.level}>'


def render_page(
    *, title: str, subtitle: str, description: str, headings: Sequence[Heading], body: str, traces: Collection[str]
) -> str:
    """Return the whole page.

    Args:
        title: of the report.
        subtitle: below it.
        description: what the report says in a sentence or two, for pages that link it.
        headings: all headings in order, for the contents list.
        body: content as HTML, its texts already escaped.
        traces: types of plotly's traces in it, which decide what of plotly.js is needed.
    """
    libraries = "".join(f"{each.render()}\n" for each in libraries_for(traces))
    setup = dumps({"light": template(dark=False), "dark": template(dark=True), "partners": dark_partners()})
    contents = "".join(f'<li class="level-{h.level}"><a href="#{h.anchor}">{escape(h.text)}</a></li>' for h in headings)
    below = f'<p class="subtitle">{escape(subtitle)}</p>' if subtitle else ""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<meta name="generator" content="{GENERATOR}">\n<meta name="description" content="{escape(description)}">\n'
        '<meta name="color-scheme" content="light dark">\n<link rel="icon" href="data:,">\n'
        f"<title>{escape(title)}</title>\n<style>\n{_asset('report.css')}</style>\n"
        f"<script>\n{_asset('errors.js')}</script>\n</head>\n<body>\n"
        '<a class="skip" href="#content">Skip to the content</a>\n<div class="page">\n'
        f"<header><h1>{escape(title)}</h1>{below}</header>\n"
        f'<nav aria-label="Contents"><details open><summary>Contents</summary>'
        f"<ol>{contents}</ol></details></nav>\n"
        '<main id="content">\n<noscript><p class="warnings">Plots need JavaScript.</p></noscript>\n'
        f"{body}\n</main>\n</div>\n"
        f"{libraries}<script>\n{_asset('library.js')}</script>\n"
        f'<script type="application/json" id="setup">{script_safe(setup)}</script>\n'
        f"<script>\n{_asset('report.js')}</script>\n</body>\n</html>\n"
    )


def _asset(name: str) -> str:
    return (files(__package__) / "assets" / name).read_text(encoding="utf-8")
