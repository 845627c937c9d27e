"""A table of text: rows of one width, with the names of its columns if it has a header line.

Separator and decimal sign are those that the first lines show. A long table, with a row for each reading and its name
in a column, is read as one with a column for each name; dates and times of day are read as seconds. Columns are read by
pandas where every cell needed is a number; where one is not, row by row, to name the cell.
"""

from __future__ import annotations

import csv
import io
import itertools
import math
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pandas
from numpy.typing import NDArray

from ..errors import NotThereError, RecordingError, TooLargeError
from .chosen_rows import listed, rows_with
from .column_names import unit_behind, without_unit
from .dated import READ, called_date, in_seconds
from .foreign import told_of_others
from .long_table import made_wide
from .recording_map import Mapped, RecordingMap
from .sources import Array, Series
from .table_form import SEPARATORS, decimal_of, is_uniform, without_comments
from .table_start import BLANKS, Start, in_tabs, start_of, stated_words, without_lines

MAX_BYTES = 2 << 30
MAX_SPAN_S = float((1 << 31) - 2)
LOOK = 200
"""Lines by which a table is known."""
IN_ONE = f" in one column; what separates them? {SEPARATORS}"
BEFORE = "; lines before a table are passed over where they have no readings: remove others, or begin them with #"
MOST_MARKS = 3  # of "not measured" in one column
NAN = ("nan", "NaN", "NAN", "Nan", "+nan", "-nan", "-NaN")
_BRACKETS = re.compile(r"^[\[(](.*)[\])]$")


class CsvSource:
    """A csv in memory as bytes; columns are parsed when they are asked for.

    Raises:
        RecordingError: not readable, without rows, or a row of another width than the first; `position` is the line.
    """

    def __init__(self, path: Path, told: RecordingMap | None = None) -> None:
        self.path = path
        try:
            if path.stat().st_size > MAX_BYTES:
                raise TooLargeError(f"{path}: expected a table of at most {MAX_BYTES} bytes", path=path)
            content = path.read_bytes()
            if other := told_of_others(path, content):
                raise RecordingError(f"{path}: cannot be read as csv: {other}", path=path, expected="text")
            self.data = without_comments(content.removeprefix(b"\xef\xbb\xbf"))
            first = [line.decode("utf-8") for line in self.data[: 1 << 20].splitlines()[:LOOK]]
            start = start_of(first, told.separator if told else "")
        except UnicodeDecodeError as error:
            text = f"{path}: cannot be read as csv: expected UTF-8: {error}"
            raise RecordingError(text, path=path, expected="UTF-8") from error
        except OSError as error:
            raise RecordingError(f"{path}: cannot be read as csv: {error.strerror or error}", path=path) from error
        self.warnings = _passed_over(path, first, start)
        self.data = without_lines(self.data, start.passed)
        if start.separator == BLANKS:
            self.data, first = in_tabs(self.data), ["\t".join(line.split()) for line in first]
        self.separator = "\t" if start.separator == BLANKS else start.separator
        lines = [line for k, line in enumerate(first) if line.strip() and k not in start.passed]
        self.decimal = (told.decimal if told else "") or decimal_of(lines, self.separator)
        self.data, dated = in_seconds(self.data, self.separator, self.decimal)
        wide = made_wide(self.data, self.separator, self.number)
        self.is_long = wide is not None
        self.left_out: tuple[str, ...] = ()
        if wide is not None:
            (self.data, self.left_out), dated = wide, frozenset({0} if dated else ())
        rows = self._all_rows()
        head = next(rows, None)
        words = head is not None and any(self.number(c) is None and c.strip() and not _nan(c) for c in head[1])
        named = words and (wide is not None or start.named is not False)
        self.heading = [cell.strip() for cell in head[1]] if named and head else []
        self.width = len(head[1]) if head else 0
        self.dated = frozenset(name for k, name in enumerate(self.names()) if k in dated)
        self.first_line = self.last_heading = head[0] if head else 1
        self._units: dict[str, str] = {}
        below = next(rows, None) if self.heading else None
        if below is not None and len(below[1]) == self.width and stated_words(below[1]):
            self._units = dict(zip(self.names(), (_BRACKETS.sub(r"\1", c.strip()) for c in below[1]), strict=True))
            self.last_heading = below[0]
        self._columns: dict[tuple[int, frozenset[str]], Array] = {}
        self._marks: dict[int, frozenset[str]] = {}
        self._texts: dict[int, list[str]] = {}
        self.quick = self._uniform()
        if not self.quick:
            for _ in self.rows():  # refuses a row of another width
                pass

    def names(self) -> list[str]:
        """Return the names in the header line; the number of a column without one, or whose name others have."""
        once = {name for name, times in Counter(self.heading).items() if times == 1}
        heading = self.heading or [""] * self.width
        return [name if name in once else str(k + 1) for k, name in enumerate(heading)]

    def written(self, name: str) -> str:
        """Return what the header line has for one of `names`."""
        return self.heading[self.names().index(name)] if self.heading else name

    def unit(self, name: str) -> str:
        """Return the unit in brackets behind a name, or in the line of units below the names, "" without."""
        if name in self.dated:
            return "s"
        behind = unit_behind(self.written(name))
        return self._units.get(name, "") if behind is None else behind

    def has(self, entry: Mapped) -> bool:
        """Tell whether the table has the entry's column, and rows of it where the entry says which."""
        columns = [entry.column, *(column for column, _ in entry.where)]
        if entry.is_field or not all(map(self._has_column, columns)):
            return False
        return not entry.where or bool(self._counted(entry).any())

    def refuse_one_column(self) -> None:
        """Refuse a table of one column, which has no reading beside its time.

        Raises:
            RecordingError: with what separates columns.
        """
        if self.width == 1:
            text = f"{self.path}: expected columns of a time and of readings, found {', '.join(self.names())}{IN_ONE}"
            raise RecordingError(text, path=self.path, expected=2, found=1)

    def index(self, column: str | int, channel: str) -> int:
        """Return the 0-based index of a column."""
        if isinstance(column, int):
            if column <= self.width:
                return column - 1
            found = f"{self.width} columns"
        elif len(called := self._called(column)) == 1:
            return called[0]
        else:
            found = ", ".join(self.heading) or "no header line"
            found += (
                f" ({column!r} more than once): say which by its number from 1" if called else self._as_a_cell(column)
            )
            found += IN_ONE if self.width == 1 else ""
        raise NotThereError(channel, f"column {column!r}", found, path=self.path)

    def refuse_missing(self, entry: Mapped) -> None:
        """Refuse an entry whose columns, or rows, the table has not.

        Raises:
            NotThereError: with what there is.
        """
        for column in (entry.column, *(column for column, _ in entry.where)):
            self.index(column, entry.channel)
        if entry.where and not self._counted(entry).any():
            there = [(column, self.cells(self.index(column, entry.channel))) for column, _ in entry.where]
            raise NotThereError(entry.channel, entry.place, listed(there), path=self.path)

    def prepare(self, entries: Sequence[Mapped]) -> None:
        """Parse all columns of some entries at once, where they can be parsed so."""
        wanted: dict[int, frozenset[str]] = {}
        for e in entries:
            for column, whose in ((e.column, e.channel), (e.time_column, f"{e.channel}, its time")):
                if column is not None:
                    at = self.index(column, whose)
                    if wanted.setdefault(at, e.nan) != e.nan:
                        return  # one column with two readings of its marks
        if self.quick and wanted:
            read = self._read(wanted)
            self._columns = (
                {} if read is None else {(at, wanted[at]): read[:, k] for k, at in enumerate(sorted(wanted))}
            )

    def series(self, entry: Mapped) -> Series:
        """Return the rows in which a column has a time.

        Raises:
            RecordingError: a column is missing, a cell is no number, or rows are out of order (`position`: line).
        """
        assert entry.time_column is not None
        at, index = self.index(entry.time_column, f"{entry.channel}, its time"), self.index(entry.column, entry.channel)
        seconds = self.numbers(at, entry.nan) * entry.time_scale
        values = self.numbers(index, entry.nan)
        counted = self._counted(entry)
        timeless = np.flatnonzero(np.isnan(seconds) & ~np.isnan(values) & counted)
        there = np.flatnonzero(~np.isnan(seconds) & ~(self.is_long & np.isnan(values)) & counted)
        if not there.size:
            text = f"{self.path}: {entry.channel}: time column {entry.time_column!r} has no number"
            raise RecordingError(text, path=self.path, found=entry.time_column)
        if timeless.size:
            raise self.cell(int(timeless[0]), at, f"the time of the value in column {index + 1}")
        seconds, values = seconds[there], values[there]
        falls = np.flatnonzero(np.diff(seconds) < 0)
        if falls.size:
            i = int(falls[0]) + 1
            line = self.line(int(there[i]))
            text = f"{self.path}, line {line}: rows out of order: {seconds[i]:g} s after {seconds[i - 1]:g} s; "
            text += f"expected that {entry.time_column!r}, the time of {entry.channel}, never falls"
            raise RecordingError(
                text, path=self.path, position=line, expected=float(seconds[i - 1]), found=float(seconds[i])
            )
        far = np.flatnonzero((np.abs(seconds) > 1e18) | (seconds - seconds[0] > MAX_SPAN_S))
        if far.size:
            raise self.cell(int(there[far[0]]), at, f"a time at most {MAX_SPAN_S:g} s after the first one")
        whole = math.floor(seconds[0])
        stamps = np.round((seconds - whole) * 1e9).astype(np.int64)
        return Series(origin=whole * 1_000_000_000, stamps=stamps, values=values, rows=there)

    def numbers(self, index: int, nan: frozenset[str] = frozenset()) -> Array:
        """Return a column; empty cells, `nan` in any case and those in `nan` are NaN.

        Raises:
            RecordingError: another cell is no finite number.
        """
        key = (index, nan)
        if key not in self._columns:
            read = self._read({index: nan}) if self.quick else None
            self._columns[key] = self._slowly(index, nan) if read is None else read[:, 0]
        return self._columns[key]

    def marks(self, index: int) -> frozenset[str]:
        """Return the texts in a column of numbers that are few and have no digit, as marks of "not measured"."""
        if index not in self._marks:
            cells: list[str] = []
            try:
                self.numbers(index)
            except RecordingError:
                cells = [cell for _, row in self.rows() if (cell := row[index].strip()) and not _nan(cell)]
            texts = [cell for cell in cells if (value := self.number(cell)) is None or math.isinf(value)]
            few = len(set(texts)) <= MOST_MARKS and 2 * len(texts) < len(cells)
            told = few and not any(letter.isdigit() for text in set(texts) for letter in text)
            self._marks[index] = frozenset(texts if told else ())
        return self._marks[index]

    def cells(self, index: int) -> list[str]:
        """Return the cells of a column as they are written."""
        if index not in self._texts:
            self._texts[index] = [row[index].strip() for _, row in self.rows()]
        return self._texts[index]

    def refusal(self, entry: Mapped, row: int, expected: str) -> RecordingError:
        """Return the error about the cell of an entry in a 0-based row."""
        return self.cell(row, self.index(entry.column, entry.channel), expected)

    def cell(self, row: int, index: int, expected: str) -> RecordingError:
        """Return the error about one cell."""
        line, cells = next(pair for i, pair in enumerate(self.rows()) if i == row)
        text = (
            f"{self.path}, line {line}, {self._place(index)}: expected {expected}, found {cells[index].strip()[:80]!r}"
        )
        return RecordingError(text, path=self.path, position=line, expected=expected, found=cells[index])

    def line(self, row: int) -> int:
        """Return the line in the file of a 0-based row."""
        return next(line for i, (line, _) in enumerate(self.rows()) if i == row)

    def rows(self) -> Iterator[tuple[int, list[str]]]:
        """Yield the lines (1-based) and cells of the rows of numbers, blank lines left out."""
        count = 0
        for line, row in self._all_rows():
            if len(row) != self.width:
                text = f"{self.path}, line {line}: expected {self.width} columns as in line {self.first_line}, "
                text += f"found {len(row)}"
                text += BEFORE if line < LOOK and self.first_line == 1 else ""
                raise RecordingError(text, path=self.path, position=line, expected=self.width, found=len(row))
            if self.heading and line <= self.last_heading:
                continue
            count += 1
            yield line, row
        if not count:
            raise RecordingError(f"{self.path}: expected rows of numbers, found none", path=self.path, found=0)

    def number(self, cell: str) -> float | None:
        """Return the number in a cell, None where there is none."""
        cell = cell.strip()
        if self.decimal == ",":
            cell = "?" if "." in cell else cell.replace(",", ".")
        try:
            return None if "_" in cell else float(cell)  # Python reads 1_000 as a number
        except ValueError:
            return None

    def _has_column(self, column: str | int) -> bool:
        return column <= self.width if isinstance(column, int) else bool(self._called(column))

    def _counted(self, entry: Mapped) -> NDArray[np.bool_]:
        """Tell of each row whether an entry takes it; one value for all of them where it does not say which."""
        counted = np.ones(1, dtype=np.bool_)
        for column, told in entry.where:
            counted = counted & rows_with(self.cells(self.index(column, entry.channel)), told, self.number)
        return counted

    def _called(self, name: str) -> list[int]:
        """Return the 0-based columns of a name, which may lack the unit that the header has in brackets."""
        whole = [k for k, each in enumerate(self.heading) if each == name]
        return whole or [k for k, each in enumerate(self.heading) if without_unit(each) == name]

    def _as_a_cell(self, name: str) -> str:
        """Return what a person should know where a name is no column's, but in the cells of one: "" elsewhere."""
        rows = (row for _, row in itertools.islice(self.rows(), 100 * LOOK))
        at = next((k for row in rows for k, cell in enumerate(row) if cell.strip() == name), None)
        if at is None or not self.heading:
            return ""
        return (
            f" ({name!r} is in {self.heading[at]!r}: a long table has two columns of numbers alone, time and value, "
            "and one called `name`, `signal`, `channel` or alike)"
        )

    def _place(self, index: int) -> str:
        return f"value of {self.heading[index]!r}" if self.is_long and index else f"column {index + 1}"

    def _all_rows(self) -> Iterator[tuple[int, list[str]]]:
        try:
            text = io.TextIOWrapper(io.BytesIO(self.data), encoding="utf-8", newline="")
            reader = csv.reader(text, strict=True, delimiter=self.separator)
            for row in reader:
                if len(row) > 1 or any(c.strip() for c in row):
                    yield reader.line_num, row
        except (UnicodeDecodeError, csv.Error) as error:
            raise RecordingError(f"{self.path}: cannot be read as csv: {error}", path=self.path) from error

    def _body(self) -> bytes:
        """Return the rows of numbers as they are in the file."""
        if not self.heading:
            return self.data
        return b"".join(self.data.split(b"\n", self.last_heading)[self.last_heading :])

    def _uniform(self) -> bool:
        body = self._body()
        if not body.strip():
            next(self.rows())
        return is_uniform(body, self.separator, self.width)

    def _read(self, wanted: dict[int, frozenset[str]]) -> Array | None:
        """Return the columns, (N, k) in order of their index; None where a cell is no number."""
        order = sorted(wanted)
        try:
            frame = pandas.read_csv(
                io.BytesIO(self._body()),
                sep=self.separator,
                decimal=self.decimal,
                header=None,
                usecols=order,
                dtype=np.float64,
                na_values={i: [*NAN, "", *wanted[i]] for i in order},
                keep_default_na=False,
                skipinitialspace=True,
                quoting=csv.QUOTE_NONE,
                float_precision="round_trip",
                low_memory=False,
            )
        except (ValueError, OverflowError, pandas.errors.ParserError, pandas.errors.EmptyDataError):
            return None
        values = frame.to_numpy(dtype=np.float64)
        return None if np.isinf(values).any() else values

    def _slowly(self, index: int, nan: frozenset[str]) -> Array:
        result = []
        for line, row in self.rows():
            cell = row[index].strip()
            value = math.nan if not cell or cell in nan or _nan(cell) else self.number(cell)
            if value is None or math.isinf(value):
                expected = "a finite number, or this text in the map's `nan`"
                hint = "; is the decimal sign a comma? then say `csv: {decimal: ','}`" if "," in cell else ""
                hint = (
                    f"; is it a date? those are read as {READ}, the whole column alike" if called_date(cell) else hint
                )
                text = f"{self.path}, line {line}, {self._place(index)}: expected {expected}, found {cell[:80]!r}{hint}"
                raise RecordingError(text, path=self.path, position=line, expected=expected, found=cell)
            result.append(value)
        return np.array(result, dtype=np.float64)


def _passed_over(path: Path, lines: Sequence[str], start: Start) -> list[str]:
    """Return in a sentence which lines of a file are passed over, none where none are."""
    told = [k for k in start.passed if lines[k].strip()]
    if not told:
        return []
    which = ", ".join(str(k + 1) for k in told) if len(told) < 3 else f"{told[0] + 1} to {told[-1] + 1}"
    what = " ".join(lines[told[0]].split())[:40]
    return [f"{path.name}: line{'s'[: len(told) - 1]} {which} before the rows of the table passed over: {what!r}"]


def _nan(cell: str) -> bool:
    return cell.strip().lower().lstrip("+-") == "nan"


def indices(values: Array) -> NDArray[np.intp]:
    """Return the row of each sample of a recording that has no lines."""
    return np.arange(values.size, dtype=np.intp)
