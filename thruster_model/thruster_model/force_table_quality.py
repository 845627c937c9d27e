"""How good a measured table of forces is: where it is not monotone, and how far it misses a supply between its own."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from thruster_model.force_table import ForceTable

__all__ = ["Drop", "LeftOut", "drops", "falls", "left_out", "monotone"]


class Drop(NamedTuple):
    """Two neighbouring commands of which the larger gives less force [N]."""

    supply: float
    command: float
    next_command: float
    force: float
    next_force: float


class LeftOut(NamedTuple):
    """How far interpolation between its neighbours misses a measured supply [V]: errors [N], the worst at `command`."""

    supply: float
    rmse: float
    largest: float
    command: float


def drops(table: ForceTable) -> tuple[Drop, ...]:
    """Return where the force falls though the command rises."""
    F, V, c = table.force, table.supply, table.command
    found = np.argwhere(np.diff(F, axis=1) < 0.0)
    return tuple(Drop(*map(float, (V[m], c[k], c[k + 1], F[m, k], F[m, k + 1]))) for m, k in found)


def falls(table: ForceTable) -> bool:
    """Return whether force or speed falls anywhere though the command rises."""
    return any(np.any(np.diff(rows, axis=1) < 0.0) for rows in (table.force, table.speed) if rows is not None)


def monotone(table: ForceTable) -> ForceTable:
    """Return the nearest table (least squares, each voltage and direction alone) whose force and speed never fall."""
    stop = int(np.flatnonzero(table.command == table.stop)[0])
    rising = {name: _rising(getattr(table, name), stop) for name in ("force", "speed") if name in table.quantities}
    return replace(table, **rising, source=f"{table.source}; made monotone by isotonic regression")  # type: ignore[arg-type]


def _rising(values: NDArray[np.float64], stop: int) -> NDArray[np.float64]:
    from scipy.optimize import isotonic_regression

    made = values.copy()
    for row in made:
        # what rises and is bounded on one side is what rises, clipped there
        if stop + 1 < row.size:
            row[stop + 1 :] = np.maximum(isotonic_regression(row[stop + 1 :]).x, 0.0)
        if stop > 0:
            row[:stop] = np.minimum(isotonic_regression(row[:stop]).x, 0.0)
    return made


def left_out(table: ForceTable) -> tuple[LeftOut, ...]:
    """Return, for each supply voltage with one on either side, how well those two predict its forces."""
    found = []
    for m in range(1, table.supply.size - 1):
        sides = [m - 1, m + 1]
        rows = {name: getattr(table, name)[sides] for name in table.quantities}
        error = replace(table, supply=table.supply[sides], **rows).force_at(table.command, table.supply[m])
        error -= table.force[m]
        k = int(np.argmax(np.abs(error)))
        rmse = float(np.sqrt(np.mean(error**2)))
        found.append(LeftOut(float(table.supply[m]), rmse, float(error[k]), float(table.command[k])))
    return tuple(found)
