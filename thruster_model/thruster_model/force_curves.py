"""A maker's table as the curves of `equations.force_map`: over the drive beyond the dead zone, at each supply.

The dead zone is the band of commands that move nothing at any measured supply; where a supply has a wider one, its
curve begins with nodes without speed and force. The drive is the command beyond that edge times a gain that makes its
largest value the table's largest speed.

Without measured speeds the speed is that of T = c n|n| with c = `ASSUMED_C_T`: it serves the lag alone and is no
prediction.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from run_bag.unit_spelling import same_unit
from thruster_model.command_scale import FULL_THROTTLE, CommandScale
from thruster_model.equations.force_map import CURVES
from thruster_model.errors import ForceTableError
from thruster_model.force_table import ForceTable

__all__ = ["ASSUMED_C_T", "ForceCurves", "scale_of"]

Array = NDArray[np.float64]
ASSUMED_C_T = 3.5e-4
"""[N s^2], of thrusters of some 50 N at 350 rad/s."""
_TILT = 1e-6


def scale_of(table: ForceTable) -> CommandScale:
    """Return the scale under which the table's furthest command is the full throttle."""
    low, high = float(table.command[0]), float(table.command[-1])
    per_volt = max(high - table.stop, table.stop - low) / FULL_THROTTLE
    return CommandScale(unit=table.command_unit, stop=table.stop, per_volt=per_volt, lowest=low, highest=high)


@dataclass(frozen=True, kw_only=True, eq=False)
class ForceCurves:
    """The curves of one table under one scale of its commands.

    Raises:
        ForceTableError: forces or speeds that fall though the command rises, force without speed, another unit.
    """

    table: ForceTable
    scale: CommandScale

    def __post_init__(self) -> None:
        table, problems = self.table, []
        if not same_unit(table.command_unit, self.scale.unit):
            problems.append(f"command: expected the scale's unit {self.scale.unit}; found {table.command_unit}")
        if table.stop != self.scale.stop:
            problems.append(f"command: expected the scale's stop {self.scale.stop:g}; found {table.stop:g}")
        for name in ("force", "speed"):
            values = getattr(table, name)
            if values is not None and np.any(np.diff(values, axis=1) < 0.0):
                m, k = (int(i[0]) for i in np.nonzero(np.diff(values, axis=1) < 0.0))
                at = f"{table.supply[m]:g} V, {table.command[k + 1]:g} {table.command_unit}"
                problems.append(
                    f"{name}: expected values that never fall, as --monotone makes them; found a fall at {at}"
                )
        if table.speed is not None and np.any(lost := (table.speed == 0.0) & (table.force != 0.0)):
            m, k = (int(i[0]) for i in np.nonzero(lost))
            at = f"{table.supply[m]:g} V, {table.command[k]:g} {table.command_unit}"
            problems.append(f"speed: expected a speed where there is a force; found none at {at}")
        if problems:
            raise ForceTableError(table.origin, problems)

    @property
    def speed_measured(self) -> bool:
        """Whether rotor speeds were measured."""
        return self.table.speed is not None

    @cached_property
    def speed(self) -> Array:
        """Rotor speed [rad/s] at the table's nodes (M, K), measured or of `ASSUMED_C_T`."""
        if self.table.speed is not None:
            return self.table.speed
        return np.asarray(np.sign(self.table.force) * np.sqrt(np.abs(self.table.force) / ASSUMED_C_T))

    @cached_property
    def edges(self) -> tuple[float, float]:
        """Edges of the dead zone common to all supplies [V]."""
        still = np.all((self.table.force == 0.0) & (self.speed == 0.0), axis=0)
        stop = int(np.searchsorted(self.table.command, self.table.stop))
        ends = []
        for side in (np.arange(stop, -1, -1), np.arange(stop, still.size)):
            count = int(np.cumprod(still[side]).sum())
            ends.append(float(self._throttle[side[count - 1]]))
        return ends[0], ends[1]

    @cached_property
    def gain(self) -> float:
        """Drive per volt beyond the dead zone [rad/s/V]."""
        beyond = np.abs(self._beyond)
        return float(np.max(np.abs(self.speed)) / np.max(beyond))

    @cached_property
    def _throttle(self) -> Array:
        return (self.table.command - self.scale.stop) / self.scale.per_volt

    @cached_property
    def _beyond(self) -> Array:
        (low, high), u = self.edges, self._throttle
        return np.minimum(u - low, 0.0) + np.maximum(u - high, 0.0)

    @cached_property
    def supplies(self) -> Array:
        """Measured supplies [V], (M,)."""
        return np.array(self.table.supply)

    @cached_property
    def curves(self) -> Array:
        """The curves (4, M, K') in the order of `CURVES`; the dead zone is one node."""
        table = self.table
        kept = np.flatnonzero((self._beyond != 0.0) | (table.command == table.stop))
        drive = np.broadcast_to(self.gain * self._beyond[kept], (table.supply.size, kept.size))
        speed = self.speed[:, kept]
        # a plateau would leave open which of its forces belongs to its speed
        speed = speed + np.where(speed != 0.0, _TILT * drive, 0.0)
        unknown = np.full(table.force.shape, np.nan)
        current = table.current if table.current is not None else unknown
        made = {"drive": drive, "speed": speed, "force": table.force[:, kept], "current": current[:, kept]}
        return np.ascontiguousarray([made[name] for name in CURVES])
