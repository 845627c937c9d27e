"""The map from a recording of anyone's to channels: one YAML form for tables, bags and logs.

    time: {column: t, unit: ms}          # of tables, or a list of them; bags and logs bring their own
    thruster_0/throttle.commanded: {field: RCOU.C1, unit: us, stop: 1500, per_volt: 80, hold: previous}
    thruster_0/state.n: {column: rpm, unit: rpm, sign: -1}
    thruster_0/state.sign_source: {value: 1}                           # one value in all messages

`column` is a name of the header line or a number from 1, `field` a topic.field of a bag or a MESSAGE.field of a log.
value = sign * (scale * cell + offset), in `unit`, which is then brought to the channel's own; a throttle in µs, % or
1 is (value - stop) / per_volt volts. Cells equal to one of `nan`, empty ones and `nan` in any case are not measured.
Of rows with several senders `where: {name: cell}` takes those whose column `name` has that cell.
`hold` says what a signal does between its samples, `clock_deviation` by how much the clock of a thruster's topic may be
off [s] (standard deviation); both go into the run's metadata. `time_offset` [s] is added to the times of an entry. An
attitude is a quaternion (`rov/imu.orientation.w`, x, y, z) or angles (`rov/imu.orientation.roll`, pitch, yaw).

    axes: {rov/imu: rep103}                                            # topics in REP 103's axes: ENU, FLU
"""

from __future__ import annotations

from dataclasses import dataclass, field

from .conversions import COMMANDS, Conversion

SAME = Conversion(1.0)
ASKED = "?"
"""The unit of a proposal where neither the name nor the values say it: to be written by a person."""


@dataclass(frozen=True, kw_only=True)
class Entry:
    """What every entry of the map says: the channel as written, and its topic, type, field and unit."""

    channel: str
    topic: str
    type: str
    path: str
    unit: str

    @property
    def kind(self) -> str:
        """Its topic without the thruster: "throttle"."""
        return self.topic.rsplit("/", 1)[-1]


@dataclass(frozen=True, kw_only=True)
class Mapped(Entry):
    """A channel out of a column or field.

    Attributes:
        column: its name in the recording, or its number from 1; `is_field` where the map calls it `field`.
        file: name of the file it is in, "" where one file alone has it.
        where: columns of a table and the cells they have in the rows that count; none: all rows count.
        time_column: of a table; None where the entry has none of its own.
        time_scale: brings the time column to seconds; 0 where the entry does not say.
        nan: cells that mean "not measured".
        hold: what the signal does between its samples, "" where the map does not say.
        clock_deviation: by how much its clock may be off [s], 0 where the map does not say.
        time_offset: what is added to its times [s], of a bag or log too.
    """

    column: str | int
    is_field: bool = False
    file: str = ""
    where: tuple[tuple[str | int, str], ...] = ()
    time_column: str | int | None = None
    time_scale: float = 0.0
    scale: float = 1.0
    offset: float = 0.0
    convert: Conversion = SAME
    given_unit: str = ""
    nan: frozenset[str] = field(default_factory=frozenset)
    hold: str = ""
    clock_deviation: float = 0.0
    time_offset: float = 0.0

    @property
    def topic_of_field(self) -> str:
        """The topic of a bag that its field is of."""
        return str(self.column).strip("/").partition(".")[0]

    @property
    def place(self) -> str:
        """Which column or field it is, and of which rows, for a sentence."""
        rows = " and ".join(f"{column} is {cell!r}" for column, cell in self.where)
        return f"{'field' if self.is_field else 'column'} {self.column!r}" + (f" where {rows}" if rows else "")

    @property
    def how(self) -> str:
        """How cells become values, for the run's metadata."""
        text = f"value = {self.scale:g} * cell + {self.offset:g}"
        if self.unit == "V" and self.given_unit in COMMANDS:  # the map's own numbers, as no table of units has them
            volts = f"(value - {-self.convert.offset:g}) / {1.0 / self.convert.factor:g} {self.unit}"
            return f"{text} in {self.given_unit}, brought to {volts}"
        return text if self.convert == (1.0, 0.0) else f"{text} in {self.given_unit}, brought to {self.unit}"


@dataclass(frozen=True, kw_only=True)
class Constant(Entry):
    """A channel that has one value in all messages of its topic."""

    value: float


@dataclass(frozen=True, kw_only=True)
class RecordingMap:
    """A whole map, checked: its entries, and what it says about tables of text ("" where it does not).

    Attributes:
        rep103: topics that are recorded in REP 103's axes.
        times: column and what brings it to seconds, of each `time`; of several a table's is the first that it has.
    """

    entries: tuple[Mapped | Constant, ...]
    times: tuple[tuple[str | int, float], ...] = ()
    rep103: frozenset[str] = frozenset()
    separator: str = ""
    decimal: str = ""

    @property
    def mapped(self) -> tuple[Mapped, ...]:
        """The entries that come out of a column or field."""
        return tuple(e for e in self.entries if isinstance(e, Mapped))

    def holds(self) -> dict[str, str]:
        """Return what each kind of topic ("throttle") does between its samples, as far as the map says."""
        return {e.kind: e.hold for e in self.mapped if e.hold}

    def clock_deviations(self) -> dict[str, float]:
        """Return by how much the clocks of each kind of topic ("flow") may be off [s], as far as the map says."""
        own = [e for e in self.mapped if e.clock_deviation]
        return {kind: max(e.clock_deviation for e in own if e.kind == kind) for kind in {e.kind for e in own}}
