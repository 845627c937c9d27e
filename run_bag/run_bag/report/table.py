"""Tables: typed columns with units, aligned numbers, cells marked best or worse."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Literal

from .errors import ReportError
from .numbers import MISSING, column_decimals, format_number, is_number

Mark = Literal["best", "worse", "emphasis"]
_SIGNS: dict[str, str] = {"best": "✓", "worse": "▲", "emphasis": ""}


@dataclass(frozen=True, kw_only=True)
class Column:
    """One column: its heading, unit, and how its numbers are written.

    Args:
        name: heading.
        unit: shown in brackets in the heading; empty for text or where each row has its own. The
            numbers of a column with a unit get the same number of decimals.
        digits: significant digits of the column's largest value.
        format: a format specification such as ".3f" that overrides `digits`.
        align: "right" or "left"; by default numbers are right-aligned, text left.
    """

    name: str
    unit: str = ""
    digits: int = 4
    format: str = ""
    align: Literal["auto", "left", "right"] = "auto"


@dataclass(frozen=True)
class Cell:
    """A value that stands out in its table."""

    value: object
    mark: Mark | None = None


@dataclass(frozen=True, kw_only=True)
class Table:
    """A checked table, ready to be rendered.

    Raises:
        ReportError: when rows and columns do not match, listing every row that is wrong.
    """

    columns: Sequence[Column | str]
    rows: Sequence[Sequence[object]]
    caption: str
    notes: Sequence[str] = field(default=())

    def __post_init__(self) -> None:
        columns = tuple(c if isinstance(c, Column) else Column(name=c) for c in self.columns)
        rows = tuple(tuple(row) for row in self.rows)
        object.__setattr__(self, "columns", columns)
        object.__setattr__(self, "rows", rows)
        object.__setattr__(self, "notes", tuple(self.notes))
        wrong = [f"row {i} has {len(row)}" for i, row in enumerate(rows) if len(row) != len(columns)]
        if wrong or not columns:
            raise ReportError(
                f"table {self.caption!r}: expected {len(columns)} cells in every row (at least one "
                f"column), got: {'; '.join(wrong) or 'no column'}"
            )

    def render(self, number: int) -> str:
        """Return the table as HTML, numbered for its caption."""
        columns = [c for c in self.columns if isinstance(c, Column)]
        cells = [[c if isinstance(c, Cell) else Cell(c) for c in row] for row in self.rows]
        by_column = [[row[k].value for row in cells] for k in range(len(columns))]
        right = [_is_right(c, values) for c, values in zip(columns, by_column, strict=True)]
        decimals = [column_decimals(v, c.digits) if c.unit else None for c, v in zip(columns, by_column, strict=True)]
        head = "".join(_heading(c, r) for c, r in zip(columns, right, strict=True))
        body = []
        for row in cells:
            body.append(
                "<tr>"
                + "".join(
                    _cell(cell, column, right[k], decimals[k], first=k == 0)
                    for k, (cell, column) in enumerate(zip(row, columns, strict=True))
                )
                + "</tr>"
            )
        marks = {cell.mark for row in cells for cell in row}
        told = " ".join(self.notes)  # a note may say what a sign means here
        legend = [f"{_SIGNS[m]} {m}" for m in ("best", "worse") if m in marks and _SIGNS[m] not in told]
        notes = list(self.notes) + ([" · ".join(legend)] if legend else [])
        foot = "".join(f'<p class="note">{escape(note)}</p>' for note in notes)
        return (
            f'<figure class="table" id="table-{number}">'
            f'<figcaption id="table-{number}-caption"><b>Table {number}.</b> '
            f"{escape(self.caption)}</figcaption>"
            f'<div class="scroll" tabindex="0" role="region" aria-labelledby="table-{number}-caption">'
            f'<table aria-labelledby="table-{number}-caption"><thead><tr>{head}</tr></thead>'
            f"<tbody>{''.join(body)}</tbody></table></div>{foot}</figure>"
        )


def _is_right(column: Column, values: Sequence[object]) -> bool:
    if column.align != "auto":
        return column.align == "right"
    known = [v for v in values if v is not None]
    return bool(known) and all(is_number(v) for v in known)


def _heading(column: Column, right: bool) -> str:
    unit = f' <span class="unit">[{escape(column.unit)}]</span>' if column.unit else ""
    return f'<th scope="col"{_class(right, None)}>{escape(column.name)}{unit}</th>'


def _cell(cell: Cell, column: Column, right: bool, decimals: int | None, *, first: bool) -> str:
    if is_number(cell.value) and column.format and cell.value == cell.value:
        text = format(cell.value, column.format).replace("-", "−")
    elif cell.value is None or is_number(cell.value):
        text = format_number(cell.value, column.digits, decimals)
    else:
        text = str(cell.value)
    shown = escape(text)
    if text == MISSING:
        shown = f'<span title="not available">{MISSING}</span>'
    if cell.mark and _SIGNS[cell.mark]:
        sign = f'<span class="sign" aria-hidden="true">{_SIGNS[cell.mark]}</span>'
        shown = f'{sign}{shown}<span class="spoken"> ({cell.mark})</span>'
    attributes = _class(right, cell.mark, long=len(text) > 32)
    return f'<th scope="row"{attributes}>{shown}</th>' if first else f"<td{attributes}>{shown}</td>"


def _class(right: bool, mark: str | None, *, long: bool = False) -> str:
    names = " ".join(n for n in ("number" if right else "", mark or "", "long" if long else "") if n)
    return f' class="{names}"' if names else ""
