"""The plain blocks of a report: paragraph, key-value list, download."""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from urllib.parse import quote

from .errors import ReportError
from .glossary import explained
from .numbers import format_number, is_number

_MIME = {"yaml": "text/yaml", "json": "application/json", "csv": "text/csv", "html": "text/html"}


@dataclass(frozen=True)
class Paragraph:
    """Running text; blank lines start a new paragraph."""

    text: str

    def render(self, told: set[str] | None = None) -> str:
        """Return the text as HTML; house words are explained but for those that were told already, and join them."""
        told = set() if told is None else told
        parts = [part.strip() for part in self.text.split("\n\n") if part.strip()]
        return "".join(f"<p>{explained(part, told)}</p>" for part in parts)


@dataclass(frozen=True)
class KeyValues:
    """A definition list; a mapping as value becomes a list of its own."""

    items: Mapping[str, object]

    def render(self) -> str:
        """Return the list as HTML."""
        rows = "".join(f"<div><dt>{escape(str(k))}</dt><dd>{_value(v)}</dd></div>" for k, v in self.items.items())
        return f'<dl class="values">{rows}</dl>'


@dataclass(frozen=True)
class Download:
    """A text that travels inside the report: a link that saves it, and the text to unfold."""

    label: str
    filename: str
    text: str

    def __post_init__(self) -> None:
        if not self.filename or "/" in self.filename or "\\" in self.filename:
            raise ReportError(f"download: expected a plain file name, got {self.filename!r}")

    def render(self) -> str:
        """Return link and text as HTML."""
        content = self.text.encode()
        kind = _MIME.get(self.filename.rpartition(".")[2].lower(), "text/plain")
        data = base64.b64encode(content).decode("ascii")
        size = f"{len(content)} B" if len(content) < 1000 else f"{len(content) / 1000:.1f} kB"
        return (
            f'<div class="download"><p><a download="{escape(self.filename)}" '
            f'href="data:{kind};charset=utf-8;base64,{data}">{escape(self.label)}</a> '
            f'<span class="note">{escape(self.filename)}, {size}</span></p>'
            f"<details><summary>Show the text</summary>"
            f'<pre tabindex="0">{escape(self.text)}</pre></details></div>'
        )


@dataclass(frozen=True, kw_only=True)
class Link:
    """A link to a file beside the report, what it is, and further files that belong to it.

    Attributes:
        label: the link's text.
        path: of the file, from the report's folder, parts joined by "/".
        text: a sentence or two about it.
        beside: other files, as `path`.
    """

    label: str
    path: str
    text: str = ""
    beside: Sequence[str] = ()


@dataclass(frozen=True)
class Links:
    """A list of links to files beside the report."""

    items: Sequence[Link]

    def render(self) -> str:
        """Return the list as HTML."""
        return f'<ul class="links">{"".join(f"<li>{self._item(each)}</li>" for each in self.items)}</ul>'

    @staticmethod
    def _item(link: Link) -> str:
        text = f"<p>{escape(link.text)}</p>" if link.text else ""
        beside = " ".join(_anchor(path, path.rpartition("/")[2]) for path in link.beside)
        return f'{_anchor(link.path, link.label)} <span class="note">{escape(link.path)}</span>{text}' + (
            f'<p class="note">beside it: {beside}</p>' if beside else ""
        )


def _anchor(path: str, label: str) -> str:
    # "./": a name with a colon is no address of another kind
    return f'<a href="./{escape(quote(path))}">{escape(label)}</a>'


def _value(value: object) -> str:
    if isinstance(value, Mapping):
        return KeyValues(value).render() if value else "–"
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return "".join(f'<span class="item">{_value(v)}</span>' for v in value) or "–"
    if value is None or is_number(value):
        return escape(format_number(value, digits=6))
    return escape(str(value))
