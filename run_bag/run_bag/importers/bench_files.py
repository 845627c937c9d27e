"""The bench's three file formats: load cell and tachometer (csv), velocimeter (dat), controller (mat)."""

from __future__ import annotations

import lzma
import re
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..budget import Budget
from ..errors import RecordingError
from .mat_numbers import read_numbers

Array = NDArray[np.float64]
CSV_COLUMNS = 21
DAT_COLUMNS = 19
LONGEST = 3600.0
"""[s]; the bench's recordings last a minute."""
LONGEST_AWAKE = 1e6
"""[s]; a velocimeter goes on by itself, and its clock does."""
LEAST_SAMPLES = 10
"""Of a controller, to be brought onto the load cell's clock."""
LONGEST_LINE = 4096
"""Characters; the bench's lines have 200."""
MAT_PERIOD = 0.04
_NUMBER = re.compile(r"\s*[-+]?(\d|\.\d|nan|inf)", re.IGNORECASE)
_HEADER_LINES = 20


@dataclass(frozen=True)
class LoadCellFile:
    """A csv.

    time [s] (N,); gauge voltages [V] and leg forces [N] (N, 6); forces [N] and moments [N m] of the load cell
    (N, 3); last column [V] (N,); what the header says.
    """

    time: Array
    voltages: Array
    legs: Array
    force: Array
    moment: Array
    last: Array
    header: dict[str, str]


@dataclass(frozen=True)
class VelocimeterFile:
    """A dat.

    time [s], counter, status bits (N,); velocity X Y Z Z2 [m/s], amplitude [counts],
    signal-to-noise ratio [dB], correlation [%], each (N, 4).
    """

    time: Array
    counter: Array
    status: Array
    velocity: Array
    amplitude: Array
    snr: Array
    correlation: Array


@dataclass(frozen=True)
class ControllerFile:
    """A mat: arrays with time as the first axis; only Td, u and y are always there.

    Td [N], nd [rad/s], u [V] (N,); n [rad/s] (N,) and ambient [m/s] (N,) out of y; nhat [rad/s], vhat,
    vahat [m/s] (N + 1,); covariance (N + 1, 3, 3) in the order n, v, U, NaN where it was not kept.
    """

    series: dict[str, Array]
    covariance: Array | None


def read_text(path: Path) -> list[str]:
    """Return the lines of a text file, decompressed if its name ends in .xz.

    Raises:
        RecordingError: it cannot be read or decompressed, or is no text.
        TooLargeError: more text or lines than its size lets expect.
    """
    try:
        budget = Budget(path.stat().st_size)
        with lzma.open(path) if path.suffix.lower() == ".xz" else path.open("rb") as file:
            data = file.read(budget.left_content() + 1)
        budget.content(len(data), path)
        text = data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except (OSError, lzma.LZMAError, EOFError, UnicodeDecodeError) as error:
        raise RecordingError(f"{path}: cannot be read as text: {error}", path=path) from error
    budget.take("lines", text.count("\n"), path)
    return text.split("\n")


def numbers(path: Path, lines: list[str], first: int, delimiter: str | None, columns: int) -> Array:
    """Parse lines of numbers; `first` is the index of the first one.

    Raises:
        RecordingError: with the line (1-based), the expected and the found.
    """
    body = [line for line in lines[first:] if line.strip()]
    if not body:
        text = f"{path}, line {first + 1}: expected lines of {columns} numbers, found none"
        raise RecordingError(text, path=path, position=first + 1, expected=columns, found=0)
    longest = max(range(first, len(lines)), key=lambda i: len(lines[i]))
    if len(lines[longest]) > LONGEST_LINE:
        found = len(lines[longest])
        text = f"{path}, line {longest + 1}: expected at most {LONGEST_LINE} characters, found {found}"
        raise RecordingError(text, path=path, position=longest + 1, expected=LONGEST_LINE, found=found)
    try:
        table = np.loadtxt(body, delimiter=delimiter, ndmin=2, dtype=np.float64, comments=None)
        if table.shape[1] == columns and np.isfinite(table).all():
            return table
    except ValueError:
        pass
    for i, line in enumerate(lines[first:], first + 1):
        if not line.strip():
            continue
        cells = line.split(delimiter)
        if len(cells) != columns:
            text = f"{path}, line {i}: expected {columns} columns, found {len(cells)}"
            raise RecordingError(text, path=path, position=i, expected=columns, found=len(cells))
        for column, cell in enumerate(cells, 1):
            if not _finite(cell):
                text = f"{path}, line {i}, column {column}: expected a number, found {cell.strip()!r}"
                raise RecordingError(text, path=path, position=i, expected="a number", found=cell.strip())
    raise RecordingError(f"{path}: expected lines of {columns} numbers", path=path, expected=columns)


def _finite(cell: str) -> bool:
    try:
        return bool(np.isfinite(float(cell)))
    except ValueError:
        return False


def data_start(lines: list[str]) -> int:
    """Return the index of the first line that starts with a number (0 if none of the first lines does)."""
    return next((i for i, line in enumerate(lines[:_HEADER_LINES]) if _NUMBER.match(line)), 0)


def _check_clock(path: Path, time: Array, first: int, longest: float) -> None:
    falls = np.flatnonzero(np.diff(time) <= 0)
    if falls.size:
        i = int(falls[0])
        line = first + i + 2
        text = f"{path}, line {line}: expected time to increase, found {time[i + 1]:g} s after {time[i]:g} s"
        raise RecordingError(text, path=path, position=line, expected=float(time[i]), found=float(time[i + 1]))
    if len(time) < 2:
        raise RecordingError(f"{path}: expected at least two samples, found {len(time)}", path=path, found=len(time))
    if not (abs(time[0]) <= longest and time[-1] - time[0] <= longest):
        text = f"{path}: expected times within {longest:g} s, found {time[0]:g} to {time[-1]:g} s"
        raise RecordingError(text, path=path, expected=longest, found=float(time[-1]))


def read_load_cell(path: Path) -> LoadCellFile:
    """Read a csv or csv.xz.

    Raises:
        RecordingError: malformed; with file, line, expected and found.
    """
    lines = read_text(path)
    first = data_start(lines)
    table = numbers(path, lines, first, ",", CSV_COLUMNS)
    time = table[:, 1]
    _check_clock(path, time, first, LONGEST)
    pairs = (line.split(",", 1) for line in lines[:first] if line.count(",") == 1)
    header = {key.strip(): value.strip() for key, value in pairs}
    return LoadCellFile(time, table[:, 2:8], table[:, 8:14], table[:, 14:17], table[:, 17:20], table[:, 20], header)


def read_velocimeter(path: Path) -> VelocimeterFile:
    """Read a dat.

    Raises:
        RecordingError: malformed; with file, line, expected and found.
    """
    lines = read_text(path)
    table = numbers(path, lines, 0, None, DAT_COLUMNS)
    time = table[:, 0]
    _check_clock(path, time, 0, LONGEST_AWAKE)
    bits = [line.split()[2] for line in lines if line.strip()]
    wrong = next((i for i, b in enumerate(bits) if not re.fullmatch(r"[01]{1,8}", b)), None)
    if wrong is not None:
        text = f"{path}, line {wrong + 1}, column 3: expected up to eight status bits, found {bits[wrong]!r}"
        raise RecordingError(text, path=path, position=wrong + 1, expected="bits", found=bits[wrong])
    status = np.array([int(b, 2) for b in bits], dtype=np.float64)
    return VelocimeterFile(time, table[:, 1], status, table[:, 3:7], table[:, 7:11], table[:, 11:15], table[:, 15:19])


def read_controller(path: Path) -> ControllerFile:
    """Read a mat.

    Raises:
        RecordingError: no MATLAB file, a variable is missing, or the lengths do not fit together.
        TooLargeError: it unpacks to more than its size lets expect.
    """
    try:
        found = read_numbers(path)
    except (OSError, ValueError, zlib.error) as error:
        raise RecordingError(f"{path}: cannot be read as a MATLAB file: {error}", path=path) from error
    missing = [name for name in ("Td", "u", "y") if name not in found]
    if missing:
        names = sorted(found)
        text = f"{path}: expected the variables Td, u and y, found {', '.join(names) or 'none'}"
        raise RecordingError(text, path=path, expected=missing, found=names)
    count = int(np.size(found["u"]))
    series: dict[str, Array] = {}
    for name in ("Td", "u", "nd", "nhat", "vhat", "vahat"):
        if name in found:
            expected = count + 1 if name.endswith("hat") else count
            series[name] = _vector(path, name, found[name], expected)
    y = _numeric(path, "y", found["y"])
    rows = y if y.ndim == 2 and y.shape[1] == count else y.T
    if rows.ndim != 2 or rows.shape[1] != count or rows.shape[0] not in (1, 2):
        text = f"{path}: expected y of one or two rows of {count} samples, found shape {y.shape}"
        raise RecordingError(text, path=path, expected=(2, count), found=y.shape)
    series["n"] = rows[0]
    if rows.shape[0] == 2:
        series["ambient"] = rows[1]
    for name in ("u", "n"):
        wrong = int(np.count_nonzero(~np.isfinite(series[name])))
        if count < LEAST_SAMPLES or wrong:
            text = (
                f"{path}: expected {LEAST_SAMPLES} finite samples or more of {name}, found {count}, {wrong} not finite"
            )
            raise RecordingError(text, path=path, expected=LEAST_SAMPLES, found=count - wrong)
    return ControllerFile(series, _covariance(path, found.get("P"), count + 1))


def _vector(path: Path, name: str, value: NDArray[Any] | str, count: int) -> Array:
    array = _numeric(path, name, value)
    if array.size != count or max(array.shape, default=0) != array.size:
        text = f"{path}: expected {name} to be a vector of {count} numbers, found shape {array.shape}"
        raise RecordingError(text, path=path, expected=count, found=array.shape)
    return array.reshape(-1)


def _numeric(path: Path, name: str, value: NDArray[Any] | str) -> Array:
    if isinstance(value, str):
        raise RecordingError(f"{path}: expected {name} to hold numbers, found {value}", path=path, found=value)
    return value.astype(np.float64)


def _covariance(path: Path, value: NDArray[Any] | str | None, count: int) -> Array | None:
    if value is None:
        return None
    array = _numeric(path, "P", value)
    result = np.full((count, 3, 3), np.nan)
    if array.size == count:
        result[:, 0, 0] = array.reshape(-1)
    elif array.shape == (3, 3, count):
        result[:] = np.moveaxis(array, 2, 0)
    else:
        text = f"{path}: expected P of shape ({count}, 1) or (3, 3, {count}), found {array.shape}"
        raise RecordingError(text, path=path, expected=(3, 3, count), found=array.shape)
    return result
