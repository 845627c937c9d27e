"""A maker's table of forces from a csv or an xlsx file, by a map of its columns."""

import csv
import math
import re
import sys
import zipfile
import zlib
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from thruster_model.bounded_pattern import LONGEST_FILE, LONGEST_NAME
from thruster_model.errors import ForceTableError
from thruster_model.force_table import QUANTITIES, ForceTable
from thruster_model.force_table_map_io import ColumnMap, MappedColumn

__all__ = ["Sheet", "read_force_table", "read_sheets"]

MAX_ROWS = 100_000
MAX_PROBLEMS = 20


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """One sheet: its name and its rows that are not empty, each with its number (1 is the first)."""

    name: str
    rows: Sequence[tuple[int, Sequence[Any]]]


class _Problems(list[str]):
    """The first of many sentences, and how many more there were."""

    def raise_if_any(self, path: Path) -> None:
        if self:
            more = len(self) - MAX_PROBLEMS
            raise ForceTableError(str(path), [*self[:MAX_PROBLEMS], *([f"and {more} more"] if more > 0 else [])])


def read_force_table(path: Path, columns: ColumnMap) -> ForceTable:
    """Return the table in a maker's file.

    Raises:
        ForceTableError: all that is wrong, with sheet and row.
    """
    sheets = read_sheets(path)
    _refuse_long_names(path, sheets, columns)
    chosen = sheets
    if path.suffix.lower() == ".xlsx":  # else its name is the file's, which the maker's names of sheets do not bind
        chosen = [sheet for sheet in sheets if re.fullmatch(columns.sheets, sheet.name)]
    if not chosen:
        found = ", ".join(repr(sheet.name) for sheet in sheets) or "none"
        raise ForceTableError(str(path), [f"expected sheets named as {columns.sheets!r}; found {found}"])
    problems = _Problems()
    points: dict[tuple[float, float], dict[str, float]] = {}
    where: dict[tuple[float, float], str] = {}
    for sheet in chosen:
        for row, values in _values(sheet, columns, problems):
            node = (values["supply"], values["command"])
            place = f"sheet '{sheet.name}', row {row}"
            if node in points:
                text = f"{node[0]:g} V, {node[1]:g} {columns.command_unit}"
                problems.append(f"{place}: expected each command once at a voltage; found {text} also in {where[node]}")
            points[node], where[node] = values, place
    problems.raise_if_any(path)
    supply, command = (np.array(sorted({node[i] for node in points})) for i in (0, 1))
    for v in supply:
        missing = [c for c in command if (v, c) not in points]
        if missing:
            text = f"at {v:g} V: expected the {command.size} commands of the other voltages"
            problems.append(f"{text}; {len(missing)} are missing, first {missing[0]:g} {columns.command_unit}")
    problems.raise_if_any(path)
    given = [c.quantity for c in columns.columns if c.quantity in QUANTITIES]
    tables: dict[str, Any] = {q: [[points[v, c][q] for c in command] for v in supply] for q in given}
    force = np.array(tables["force"])
    tables["force"] = np.where(np.abs(force) <= columns.zero_up_to, 0.0, force)
    return ForceTable(
        **tables, supply=supply, command=command, command_unit=columns.command_unit, stop=columns.stop,
        name=columns.name, source=f"{columns.source}; {path.name}", origin=str(path),
    )  # fmt: skip


def _refuse_long_names(path: Path, sheets: Sequence[Sheet], columns: ColumnMap) -> None:
    """Refuse names in which a pattern of the map would be looked for too long."""
    most = LONGEST_NAME
    if path.suffix.lower() != ".xlsx":
        most = LONGEST_FILE if any(c.sheet for c in columns.columns) else sys.maxsize
    problems = _Problems(
        f"sheet '{s.name[:most]}...': expected a name of at most {most} characters; found {len(s.name)}"
        for s in sheets
        if len(s.name) > most
    )
    problems.raise_if_any(path)


def _values(sheet: Sheet, columns: ColumnMap, problems: list[str]) -> Iterator[tuple[int, dict[str, float]]]:
    """Yield each row with its number as quantities in the map's units; rows with a problem are left out."""
    place = f"sheet '{sheet.name}'"
    if len(sheet.rows) < 2:
        problems.append(f"{place}: expected a line of headings and rows of numbers; found {len(sheet.rows)} rows")
        return
    first, header = sheet.rows[0]
    headings = ["" if cell is None else str(cell).strip() for cell in header]
    index: dict[str, int] = {}
    fixed: dict[str, float] = {}
    before = len(problems)
    for c in columns.columns:
        if c.sheet:
            _supply_of(sheet.name, c, fixed, problems)
        elif headings.count(c.column) == 1:
            index[c.quantity] = headings.index(c.column)
        else:
            found = ", ".join(repr(h) for h in headings if h) + (" (more than once)" if c.column in headings else "")
            problems.append(f"{place}, row {first}: expected a column {c.column!r} ({c.quantity}); found {found}")
    if len(problems) > before:
        return
    for number, cells in sheet.rows[1:]:
        values, wrong = dict(fixed), len(problems)
        for c in columns.columns:
            if c.quantity not in index:
                continue
            cell = cells[index[c.quantity]] if index[c.quantity] < len(cells) else None
            value = _float(cell)
            if value is None:
                found = "nothing" if cell is None or cell == "" else repr(cell)
                problems.append(f"{place}, row {number}: expected a number in {c.column!r}; found {found}")
            else:
                values[c.quantity] = c.scale * value
        if len(problems) > wrong:
            continue
        for c in columns.columns:
            if not c.signed:
                side = values["command"] - columns.stop
                values[c.quantity] = math.copysign(values[c.quantity], side) + 0.0  # no -0
        yield number, values


def _supply_of(name: str, column: MappedColumn, fixed: dict[str, float], problems: list[str]) -> None:
    match = re.search(column.sheet, name)
    value = _float(match[1]) if match else None
    if value is None:
        problems.append(f"sheet '{name}': expected the voltage in its name, as {column.sheet!r}; found none")
    else:
        fixed[column.quantity] = column.scale * value


def read_sheets(path: Path) -> list[Sheet]:
    """Return the sheets of an xlsx, or the one of a csv; ForceTableError where it is neither."""
    readers = {".csv": _read_csv, ".xlsx": _read_xlsx}
    if path.suffix.lower() not in readers:
        raise ForceTableError(str(path), [f"expected a .csv or .xlsx file; found '{path.suffix}'"])
    if not path.is_file():
        raise ForceTableError(str(path), ["expected a file; found none"])
    return readers[path.suffix.lower()](path)


def _read_csv(path: Path) -> list[Sheet]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            return [Sheet(name=path.stem, rows=_rows(csv.reader(file), path, path.stem))]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise ForceTableError(str(path), [f"expected a csv file in UTF-8; found {error}"]) from error


def _read_xlsx(path: Path) -> list[Sheet]:
    try:
        import openpyxl  # a third of a second, and only spreadsheets need it
    except ImportError as error:
        raise ForceTableError(str(path), ["expected the library openpyxl to read it; pip install openpyxl"]) from error
    try:
        book = openpyxl.load_workbook(path, read_only=True, data_only=True)
        try:
            for sheet in book.worksheets:
                sheet.reset_dimensions()  # some writers state them wrongly, and rows would be cut
            return [Sheet(name=sheet.title, rows=_rows(sheet.values, path, sheet.title)) for sheet in book.worksheets]
        finally:
            book.close()
    except (OSError, EOFError, KeyError, SyntaxError, ValueError, zipfile.BadZipFile, zlib.error) as error:
        raise ForceTableError(str(path), [f"expected an xlsx file; found {error}"]) from error


def _rows(rows: Iterable[Sequence[Any]], path: Path, name: str) -> list[tuple[int, Sequence[Any]]]:
    found = []
    for number, row in enumerate(rows, 1):
        if number > MAX_ROWS:
            raise ForceTableError(str(path), [f"sheet '{name}': expected at most {MAX_ROWS} rows; found more"])
        if any(cell is not None and str(cell).strip() for cell in row):
            found.append((number, row))
    return found


def _float(cell: Any) -> float | None:
    """Return a finite number; None for a text that is none, for nothing and for true or false."""
    if cell is None or isinstance(cell, bool):
        return None
    try:
        value = float(cell)
    except (TypeError, ValueError):
        return None
    return value if math.isfinite(value) else None
