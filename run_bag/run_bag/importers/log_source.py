"""Logs of ArduPilot's vehicles (ArduSub among them): `.BIN` of the autopilot, `.tlog` of the ground station.

A field is called MESSAGE.FIELD, with the instance where the message has one (`ESC[0].RPM`), or with system and
component where not only the first one sends it (`HEARTBEAT@255/190.type`). Times are those since boot (BIN), or of
arrival (tlog).
"""

from __future__ import annotations

import contextlib
import os
import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from ..budget import Budget
from ..errors import RecordingError, RunError
from .bag_source import without_marks
from .csv_source import indices
from .recording_map import Mapped
from .sources import Array, Series

LOGS = (".bin", ".tlog")
_NUMPY = {"b": "i1", "B": "u1", "h": "i2", "H": "u2", "i": "i4", "I": "u4", "f": "f4", "d": "f8", "q": "i8", "Q": "u8",
          "e": "f2"}  # fmt: skip
_BROKEN = (OSError, ValueError, KeyError, IndexError, TypeError, AttributeError, struct.error, UnicodeDecodeError,
           AssertionError, EOFError, OverflowError, ZeroDivisionError, MemoryError)  # fmt: skip
_HEADS = {0xFE: (6, 2), 0xFD: (10, 2)}  # MAVLink 1, 2: bytes before and behind the payload
_SIGNATURE = 13
_HEAD = 3  # bytes before the fields of an autopilot's message
_LAST = 2.0**53  # [us]
_MOST_WARNINGS = 20
_INSTANCES = ("Instance", "Inst", "I")
"""Fields that tell instances apart where the log's FMTU messages do not say which one does."""
_EARLIEST, _LATEST = 10**15, 10**16  # [us] of the epoch: 2001 to 2286


class LogSource:
    """A log, decoded when it is opened.

    Raises:
        RecordingError: not such a log, or pymavlink is not installed.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._series: dict[str, tuple[Array, Array]] = {}  # name -> times [us], values
        self._units: dict[str, str] = {}
        self.warnings: tuple[str, ...] = ()
        try:
            size = path.stat().st_size
            if path.suffix.lower() == ".tlog":
                self._telemetry(Budget(size))
            else:
                self._autopilot()
        except ImportError as error:
            text = f"{path}: logs of vehicles are read by pymavlink: python3 -m pip install pymavlink"
            raise RecordingError(text, path=path, found=str(error)) from error
        except RunError:
            raise
        except Exception as error:  # the library raises all kinds, Exception itself among them
            why = " ".join(str(error).split())[:200] or type(error).__name__
            raise RecordingError(f"{path}: cannot be read as a log of a vehicle: {why}", path=path) from error
        if not self._series:
            raise RecordingError(f"{path}: expected messages of a vehicle's log with times, found none", path=path)

    def names(self) -> list[str]:
        """Return the fields with numbers."""
        return list(self._series)

    def unit(self, name: str) -> str:
        """Return the unit that the log or the protocol states."""
        return self._units.get(self._whole(name), "")

    def has(self, entry: Mapped) -> bool:
        """Tell whether the log has the field."""
        return entry.is_field and self._whole(entry.column) in self._series

    def _whole(self, name: str | int) -> str:
        """Return a field with its instance, which may be left out where the log has one alone: BAT.Volt is
        BAT[0].Volt."""
        if name in self._series:
            return str(name)
        message, _, field = str(name).partition(".")
        instance = re.compile(rf"{re.escape(message)}\[\d+\]\.{re.escape(field)}")
        alike = [each for each in self._series if instance.fullmatch(each)]
        return alike[0] if len(alike) == 1 else str(name)

    def series(self, entry: Mapped) -> Series:
        """Return the samples of a field."""
        times, values = self._series[self._whole(entry.column)]
        origin = int(times[0])
        stamps = (times - origin).astype(np.int64) * 1000
        return Series(
            origin=origin * 1000, stamps=stamps, values=without_marks(values, entry.nan), rows=indices(values)
        )

    def refusal(self, entry: Mapped, row: int, expected: str) -> RecordingError:
        """Return the error about one message."""
        found = self._series[self._whole(entry.column)][1][row]
        text = f"{self.path}: {entry.column}, message {row}: expected {expected}, found {found:g}"
        return RecordingError(text, path=self.path, position=row, expected=expected, found=float(found))

    def _keep(self, name: str, times: Any, values: Any, unit: str) -> None:
        times, values = np.asarray(times, dtype=np.float64), np.asarray(values, dtype=np.float64)
        there = times < _LAST
        if not there.all():
            self._warn(f"{name}: {int(np.sum(~there))} messages have a time that no clock shows; left out")
            times, values = times[there], values[there]
        if np.isfinite(values).any():
            order = np.argsort(times, kind="stable")
            moved = int(np.sum(np.diff(times) < 0))
            if moved:
                self._warn(f"{name}: {moved} messages of {times.size} came late; sorted by their times")
            self._series[name] = (times[order], np.where(np.isinf(values), np.nan, values)[order])
            self._units[name] = unit

    def _warn(self, sentence: str) -> None:
        if len(self.warnings) < _MOST_WARNINGS:
            self.warnings += (sentence,)

    def _autopilot(self) -> None:
        from pymavlink import DFReader

        class Reader(DFReader.DFReader_binary):
            formats: Any

            def init_clock(self) -> None:  # times since boot are enough
                return

            def init_arrays_fast(self, progress_callback: Any = None) -> None:
                self.formats = _Formats(self.formats)
                self.init_arrays(progress_callback)  # in Python: safe with broken files, and silent

        with open(os.devnull, "w", encoding="utf-8") as nothing, _silent(nothing):
            log = Reader(str(self.path))
        data = np.memmap(self.path, dtype=np.uint8, mode="r")
        for kind, form in log.formats.items():
            offsets = (
                np.asarray(log.offsets[kind], dtype=np.int64) if kind < len(log.offsets) else np.zeros(0, np.int64)
            )
            offsets = offsets[offsets + form.len <= data.size]
            if offsets.size and ("TimeUS" in form.colhash or "TimeMS" in form.colhash):
                self._messages(form, DFReader.FORMAT_TO_STRUCT, data, offsets)
        log.close()

    def _messages(self, form: Any, known: Any, data: Any, offsets: Any) -> None:
        fields, at = [], _HEAD
        for column, code in zip(form.columns, form.msg_fmts, strict=False):
            letters, factor, _ = known[code]
            if letters in _NUMPY:
                fields.append((column, _NUMPY[letters], at, factor))
            at += struct.calcsize("<" + letters)
        if at > form.len or not fields:
            return
        names = [f[0] for f in fields]
        layout = np.dtype({"names": names, "formats": ["<" + f[1] for f in fields], "offsets": [f[2] for f in fields],
                           "itemsize": form.len})  # fmt: skip
        block = np.ascontiguousarray(data[offsets[:, None] + np.arange(form.len)])
        rows = block.view(layout)[:, 0]
        clock = "TimeUS" if "TimeUS" in names else "TimeMS"
        if clock not in names:
            return
        times = rows[clock].astype(np.float64) * (1.0 if clock == "TimeUS" else 1e3)
        counts = [name for name, kind, *_ in fields if kind == "u1" and name in _INSTANCES]
        which = form.instance_field if form.instance_field in names else next(iter(counts), None)
        parts = [("", slice(None))]
        if which is not None:
            parts = [(f"[{i}]", rows[which] == i) for i in np.unique(rows[which])]
        for name, _, _, factor in fields:
            if name in (clock, which):
                continue
            with np.errstate(over="ignore"):  # what is spoiled; infinite counts as not measured
                values = rows[name].astype(np.float64) * (factor or 1.0)
            unit = form.get_unit(name) if form.units else ""
            for part, chosen in parts:
                self._keep(f"{form.name}{part}.{name}", times[chosen], values[chosen], unit)

    def _telemetry(self, budget: Budget) -> None:
        from pymavlink.dialects.v20 import ardupilotmega

        link = ardupilotmega.MAVLink(None)
        first: dict[str, tuple[int, int]] = {}
        found: dict[str, tuple[list[float], list[float], str]] = {}
        for time, packet in _packets(self.path.read_bytes()):
            try:
                message = link.decode(bytearray(packet))
            except (ardupilotmega.MAVError, *_BROKEN):
                continue
            budget.message(20 * len(packet), self.path)
            kind, own = message.get_type(), (message.get_srcSystem(), message.get_srcComponent())
            sender = "" if first.setdefault(kind, own) == own else f"@{own[0]}/{own[1]}"
            units = getattr(message, "fieldunits_by_name", {})
            for field in message.get_fieldnames():
                value = getattr(message, field)
                several = value if isinstance(value, list | tuple) else [value]
                for i, number in enumerate(several):
                    if isinstance(number, int | float):
                        place = f"[{i}]" if several is value else ""
                        name = f"{kind}{sender}.{field}{place}"
                        times, values, _ = found.setdefault(name, ([], [], units.get(field, "")))
                        times.append(time)
                        values.append(float(number))
        for name, (times, values, unit) in found.items():
            self._keep(name, times, values, unit)


class _Formats(dict[int, Any]):
    """Formats of an autopilot's messages: past one without a length the library would never come."""

    def __setitem__(self, kind: int, form: Any) -> None:
        if form.len < _HEAD:
            raise ValueError(f"format of message {form.name}: expected at least {_HEAD} bytes, found {form.len}")
        super().__setitem__(kind, form)


@contextlib.contextmanager
def _silent(sink: Any) -> Iterator[None]:
    with contextlib.redirect_stderr(sink), contextlib.redirect_stdout(sink):
        yield


def _packets(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield time [us] and packet of a telemetry log: each packet behind eight bytes of time, big end first."""
    position, size = 0, len(data)
    while position + 8 < size:
        head = _HEADS.get(data[position + 8])
        time = int.from_bytes(data[position : position + 8], "big")
        if head is not None and _EARLIEST < time < _LATEST and position + 10 < size:
            begin = position + 8
            length = head[0] + data[begin + 1] + head[1]
            if head[0] == 10 and data[begin + 2] & 1:
                length += _SIGNATURE
            if begin + length <= size:
                yield time, data[begin : begin + length]
                position = begin + length
                continue
        position += 1
