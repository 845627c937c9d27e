"""A whole run by the stepper in one call: what happens in the plant, and what sensors read of it."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from thruster_model.effects.chains import SENSED
from thruster_model.effects.stages import NO_EFFECTS
from thruster_model.stepper import (
    AT_REST,
    NO_GATES,
    NOMINAL_SUPPLY,
    ROWS,
    PlantState,
    fill,
    new_memory,
    new_sensors,
    sense,
    substeps_of,
)

__all__ = ["readings", "simulated_rows"]

Array = NDArray[np.float64]


def simulated_rows(
    coefficients: Any,
    u_commanded: ArrayLike,
    dt: float,
    *,
    start: PlantState = AT_REST,
    largest_step: float = 1e-3,
    effects: Any = NO_EFFECTS,
    gates: ArrayLike = NO_GATES,
    supply: ArrayLike = NOMINAL_SUPPLY,
    straight: bool = False,
) -> Array:
    """Return `stepper.ROWS` at the N + 1 instants 0, dt, ..., N dt, shape (6, N + 1).

    Args:
        coefficients: of any class.
        u_commanded: throttle commands [V], shape (N,), each held for `dt`; or (N, parts), for an equal part of it.
        dt: period of the commands [s].
        start: state at the first command.
        largest_step: upper bound of the integration step [s]; effects that act more abruptly take shorter ones.
        effects: `EffectValues` of unmodelled effects on the command and in the plant, or none.
        gates: 0 in periods in which the propeller may draw air, else 1, shape (N,); empty: never.
        supply: voltage of the supply over the nominal one in each period, shape (N,); empty: 1.
        straight: the command goes on straight lines, and is at each of these as its part of a period ends.
    """
    commands = np.ascontiguousarray(u_commanded, dtype=np.float64)
    commands = commands[:, None] if commands.ndim == 1 else commands
    if commands.ndim != 2 or commands.shape[1] < 1 or not np.all(np.isfinite(commands)):
        raise ValueError(f"u_commanded: expected finite values of shape (N,) or (N, parts), got {commands.shape}")
    if not (dt > 0 and largest_step > 0):
        raise ValueError(f"dt and largest_step: expected positive times, got {dt} s and {largest_step} s")
    begin = PlantState(*map(float, start))
    substeps = substeps_of(dt, largest_step, effects)
    memory = new_memory(dt, substeps, effects, begin.u, commands.shape[1], straight=straight)
    opened = np.ascontiguousarray(gates, dtype=np.float64)
    volts = np.ascontiguousarray(supply, dtype=np.float64)
    if volts.size not in (0, len(commands)) or not np.all(np.isfinite(volts) & (volts >= 0.0)):
        raise ValueError(f"supply: expected finite values from 0 of the commands' shape, got shape {volts.shape}")
    rows = np.empty((len(ROWS), len(commands) + 1))
    fill(begin, commands, float(dt), substeps, coefficients, effects, opened, volts, memory, rows)
    return rows


def readings(rows: Array, dt: float, effects: Any = NO_EFFECTS, seed: int = 0) -> Array:
    """Return what the sensors read, by signal of `SENSED`, shape (5, M).

    Args:
        rows: true values every `dt` [s], (5 or more, M).
        dt: period [s].
        effects: `EffectValues` of the sensors, or none.
        seed: of effects that scatter; 0: they do nothing.
    """
    read = np.array(rows[: len(SENSED)])
    if effects is not NO_EFFECTS:
        sense(rows, 0, rows.shape[1], float(dt), effects, new_sensors(dt, effects, seed), read)
    return read
