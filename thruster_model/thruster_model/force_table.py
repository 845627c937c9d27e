r"""Force over command and supply voltage as makers measure it at a standstill: a table, interpolated both ways.

Nodes c_k (the command, in the table's unit), V_m [V], F_mk [N], positive forward; bilinear between them:

    F(c, V) = (1 - w) [(1 - r) F_m,k + r F_m,k+1] + w [(1 - r) F_m+1,k + r F_m+1,k+1]
    r = (c - c_k) / (c_k+1 - c_k),  w = (V - V_m) / (V_m+1 - V_m)

Static and without flow. Outside the nodes the answer is NaN unless clamping is asked for: a table knows nothing of a
supply that nobody measured, and a clamped number looks like a measured one. NaN gives NaN.

Measured curves are not quite monotone (noise at full command). The inverse needs no correction for that: it is the
command nearest the stop that gives the force, so a dip is skipped. `force_table_quality` reports dips and removes them.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.errors import ForceTableError

__all__ = ["QUANTITIES", "ForceTable", "Outside"]

Array = NDArray[np.float64]
Outside = Literal["nan", "clamp"]
QUANTITIES = {"force": "N", "speed": "rad/s", "current": "A", "power": "W"}
"""What a table may hold, with its unit; force always."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ForceTable:
    """A measured table, checked when constructed.

    Attributes:
        command: (K,) ascending, in `command_unit`.
        command_unit: such as µs.
        stop: command of no thrust, one of the nodes.
        supply: (M,) supply voltage [V], ascending.
        force: (M, K) [N], exactly zero at the stop.
        speed: (M, K) rotor speed [rad/s], signed as the force.
        current: (M, K) [A].
        power: (M, K) [W].
        source: where the numbers come from.
        origin: what errors call the table.

    Raises:
        ForceTableError: all that is wrong with it.
    """

    command: Array
    command_unit: str
    stop: float
    supply: Array
    force: Array
    source: str
    speed: Array | None = None
    current: Array | None = None
    power: Array | None = None
    name: str = "force table"
    origin: str = "force table"

    def __post_init__(self) -> None:
        problems = []
        for name in ("command", "supply", *QUANTITIES):
            given = getattr(self, name)
            if given is None and name not in ("command", "supply", "force"):
                continue
            try:
                array = np.array(given, dtype=np.float64)
            except (TypeError, ValueError):
                problems.append(f"{name}: expected numbers in rows of one length; found {type(given).__name__}")
                continue
            array.setflags(write=False)
            object.__setattr__(self, name, array)
        problems = problems or self._problems()
        if problems:
            raise ForceTableError(self.origin, problems)

    def _problems(self) -> list[str]:
        problems = [f"{n}: expected a text; found none" for n in ("command_unit", "source") if not getattr(self, n)]
        for name, least in (("command", 2), ("supply", 1)):
            nodes = getattr(self, name)
            if nodes.ndim != 1 or nodes.size < least:
                problems.append(f"{name}: expected at least {least} numbers in one row; found shape {nodes.shape}")
            elif not np.all(np.isfinite(nodes)):
                problems.append(f"{name}: expected finite numbers; found {nodes[~np.isfinite(nodes)][0]:g}")
            elif np.any(np.diff(nodes) <= 0):
                i = int(np.flatnonzero(np.diff(nodes) <= 0)[0])
                problems.append(f"{name}: expected ascending numbers; found {nodes[i + 1]:g} after {nodes[i]:g}")
        expected = (self.supply.size, self.command.size)
        for name in self.quantities:
            values = getattr(self, name)
            if values.shape != expected:
                problems.append(f"{name}: expected shape {expected}, supply by command; found {values.shape}")
            elif not np.all(np.isfinite(values)):
                m, k = np.argwhere(~np.isfinite(values))[0]
                problems.append(f"{name}: expected finite numbers; found {values[m, k]:g} {self._where(m, k)}")
        if problems:
            return problems
        if self.supply[0] <= 0.0:
            problems.append(f"supply: expected voltages above 0 V; found {self.supply[0]:g} V")
        if not np.any(self.command == self.stop):
            unit = self.command_unit
            return [*problems, f"stop: expected one of the commands; found {self.stop:g} {unit}, which is none of them"]
        s = self._stop_index
        for m in range(self.supply.size):
            if (at_stop := self.force[m, s]) != 0.0:
                problems.append(f"force: expected 0 N at the stop; found {at_stop:g} N {self._where(m, s)}")
            for k, sign, word in ((-1, 1.0, "positive"), (0, -1.0, "negative")):
                if self.command[k] != self.stop and sign * self.force[m, k] <= 0.0:
                    where = self._where(m, k)
                    problems.append(f"force: expected a {word} force {where}; found {self.force[m, k]:g} N")
        return problems

    def _where(self, m: int, k: int) -> str:
        return f"at {self.supply[m]:g} V, {self.command[k]:g} {self.command_unit}"

    @property
    def quantities(self) -> tuple[str, ...]:
        """What the table holds, of `QUANTITIES`."""
        return tuple(name for name in QUANTITIES if getattr(self, name) is not None)

    @property
    def _stop_index(self) -> int:
        return int(np.searchsorted(self.command, self.stop))

    def value(self, quantity: str, command: ArrayLike, supply: ArrayLike, *, outside: Outside = "nan") -> Array:
        """Return a quantity of the table by bilinear interpolation; command and supply [V] broadcast."""
        if quantity not in self.quantities:
            found = ", ".join(self.quantities)
            raise ForceTableError(self.origin, [f"expected a table with '{quantity}'; it holds {found}"])
        table = getattr(self, quantity)
        k, k1, r = _locate(self.command, command, outside)
        m, m1, w = _locate(self.supply, supply, outside)
        lower = (1.0 - r) * table[m, k] + r * table[m, k1]
        upper = (1.0 - r) * table[m1, k] + r * table[m1, k1]
        return (1.0 - w) * lower + w * upper

    def force_at(self, command: ArrayLike, supply: ArrayLike, *, outside: Outside = "nan") -> Array:
        """Return the force [N]; see `value`."""
        return self.value("force", command, supply, outside=outside)

    def command_for(self, force: ArrayLike, supply: ArrayLike, *, outside: Outside = "nan") -> Array:
        """Return the command nearest the stop that gives `force` [N] at `supply` [V]; the stop for no force.

        A force beyond the largest is outside the table: NaN, or clamped the command of the largest force.
        Holds one curve of K numbers in memory for each element.
        """
        F, V = np.broadcast_arrays(np.asarray(force, dtype=np.float64), np.asarray(supply, dtype=np.float64))
        curves, s = self._curves(self.force, V, outside), self._stop_index
        forward = _first_reached(F, curves[..., s:], self.command[s:], outside)
        reverse = _first_reached(-F, -curves[..., s::-1], self.command[s::-1], outside)
        found = np.where(F > 0.0, forward, np.where(F < 0.0, reverse, self.stop))
        return np.where(np.isnan(F) | np.isnan(curves[..., s]), np.nan, found)

    def zero_band(self, supply: ArrayLike, *, outside: Outside = "nan") -> tuple[Array, Array]:
        """Return the smallest and largest command around the stop without any force.

        Exact for the interpolated table; the thruster's own edge lies up to one node further out. Between two measured
        voltages the table has force where either of them has: its band is what both have in common.
        """
        curves, s = self._curves(self.force, supply, outside), self._stop_index
        ends = []
        for side, nodes in ((curves[..., s::-1], self.command[s::-1]), (curves[..., s:], self.command[s:])):
            zeros = np.cumprod(side == 0.0, axis=-1).sum(axis=-1)
            ends.append(np.where(zeros > 0, nodes[zeros - 1], np.nan))
        return ends[0], ends[1]

    def largest_forces(self, supply: ArrayLike, *, outside: Outside = "nan") -> tuple[Array, Array]:
        """Return the largest force in reverse (negative) and forward [N]."""
        curves = self._curves(self.force, supply, outside)
        return curves.min(axis=-1), curves.max(axis=-1)

    def at_supply(self, supply: float, *, outside: Outside = "nan") -> "ForceTable":
        """Return the table of one voltage [V]; ForceTableError where it is outside and not clamped."""
        _, _, w = _locate(self.supply, supply, outside)
        if np.isnan(w):
            low, high = self.supply[[0, -1]]
            raise ForceTableError(self.origin, [f"supply: expected {low:g} to {high:g} V; found {supply:g} V"])
        made = {name: self._curves(getattr(self, name), [supply], outside) for name in self.quantities}
        return replace(self, supply=np.array([supply], dtype=np.float64), **made)  # type: ignore[arg-type]

    def _curves(self, table: Array, supply: ArrayLike, outside: Outside) -> Array:
        """Return (..., K): the table's curve at each supply."""
        m, m1, w = _locate(self.supply, supply, outside)
        return (1.0 - w)[..., None] * table[m] + w[..., None] * table[m1]


def _locate(nodes: Array, x: ArrayLike, outside: Outside) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Return the indices of the neighbouring nodes and the weight of the upper one; NaN for what is outside."""
    if outside not in ("nan", "clamp"):
        raise ValueError(f"outside: expected 'nan' or 'clamp'; found {outside!r}")
    given = np.asarray(x, dtype=np.float64)
    inside = np.clip(given, nodes[0], nodes[-1])
    lower = np.clip(np.searchsorted(nodes, inside, side="right") - 1, 0, max(nodes.size - 2, 0))
    upper = np.minimum(lower + 1, nodes.size - 1)
    weight = (inside - nodes[lower]) / np.where(upper > lower, nodes[upper] - nodes[lower], 1.0)
    if outside == "nan":
        weight = np.where(inside == given, weight, np.nan)
    return lower, upper, np.asarray(weight, dtype=np.float64)


def _first_reached(F: Array, curves: Array, command: Array, outside: Outside) -> Array:
    """Return where along curves (..., k) from the stop outwards the force F is first reached: F_k-1 < F <= F_k."""
    if outside == "clamp":
        F = np.minimum(F, curves.max(axis=-1))
    reached = curves >= F[..., None]
    k = np.argmax(reached, axis=-1)
    before = np.maximum(k - 1, 0)
    f, f1 = (np.take_along_axis(curves, i[..., None], axis=-1)[..., 0] for i in (before, k))
    r = (F - f) / np.where(f1 > f, f1 - f, 1.0)
    found = np.clip((1.0 - r) * command[before] + r * command[k], command.min(), command.max())
    return np.where(reached.any(axis=-1), found, np.nan)
