"""From samples to a recording: the throttle on the grid of the simulation, noise levels, what the log shows."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.log_check import (
    hole_around_zero,
    lattice_step,
    lone_samples,
    regular_stamps,
    repeated_samples,
    spikes,
)
from gap_diagnosis.recording import LogFindings, Recording, initial_state
from run_bag.alignment import moves_between
from thruster_model.identification.experiment import PARTS, Experiment, Measurement
from thruster_model.identification.preparation import cell_means, noise_level
from thruster_model.identification.speed_sign import held, on_lines

__all__ = ["DT", "held_on_grid", "recording_of", "with_log_findings"]

Array = NDArray[np.float64]
DT = 0.01
"""Period of the simulation [s]; RK4 is exact to a millionth at this step."""
_PUNCTUAL = 5e-4  # [s]
LEAST_SCATTER = 5e-4
"""Scatter of stamps [s] from which on it is asked whether it is the log's."""
CELL = 0.04
"""Samples that come much faster are averaged over this [s]."""
FAST = 8e-3
"""Period [s] below which they are: what the log shows of single samples counts for more than fewer rows."""
MANY = 20
"""Samples from which on the mean of a cell's samples is the mean over the cell."""


def held_on_grid(time: Array, values: Array, dt: float, count: int) -> Array:
    """Return the means over the `count` periods of `dt` [s] of samples held until the next one; 0 before the first."""
    known = np.isfinite(values)
    time, values = time[known], values[known]
    edges = dt * np.arange(count + 1)
    integral = np.concatenate(([0.0], np.cumsum(values[:-1] * np.diff(time)))) if time.size else np.zeros(1)
    place = np.searchsorted(time, edges + 1e-9, side="right") - 1
    inside = np.maximum(place, 0)
    total = np.where(place >= 0, integral[inside] + values[inside] * np.maximum(edges - time[inside], 0.0), 0.0)
    means = np.diff(total) / dt
    # Where no sample falls inside a period the mean is the held value itself, without rounding.
    quiet = (place[1:] == place[:-1]) & (place[1:] >= 0)
    return np.asarray(np.where(quiet, values[inside[1:]], means))


def _step_for(time: Array, values: Array) -> tuple[float, bool]:
    """Return the step [s] of a simulation, `DT` or a little less, and whether held commands change within steps."""
    changes = time[1:][np.diff(values) != 0.0] - time[0]
    period = float(time[-1] - time[0]) / max(time.size - 1, 1)
    for step in (DT, period / max(np.ceil(period / DT - 1e-9), 1.0)):
        if np.all(np.abs(changes - step * np.round(changes / step)) < _PUNCTUAL):
            return float(step), False
    return DT, True


_TOPICS = {"speed": "state", "thrust": "load", "torque": "load", "axial": "flow", "ambient": "flow"}
"""Of each signal, what a run calls its topic."""


def recording_of(
    name: str,
    throttle: tuple[Array, Array],
    signals: Mapping[str, tuple[Array, Array]],
    *,
    thruster: int = 0,
    clock_deviations: Mapping[str, float] | None = None,
    supply: tuple[Array, Array] | None = None,
    regular: bool = False,
    hold: str | None = "previous",
) -> Recording:
    """Return a recording of point samples (or means over cells, where samples come fast).

    Args:
        name: of the run.
        throttle: stamps [s] from the start of the run and commands [V].
        signals: stamps [s] and values by signal.
        thruster: its index.
        clock_deviations: how far the clocks of "throttle", "state", "load" and "flow" may be off [s].
        supply: stamps [s] and voltage of the supply [V]; None: not measured.
        regular: put all samples at regular instants, as if the scatter of their stamps were the log's.
        hold: how commands act between their samples, "previous" or "linear"; None: not known, "previous" is taken and
            the other one kept beside.

    The simulation's clock starts with the throttle's, so that commands begin with its steps.
    """
    stamps = {name: time for name, (time, _) in {"throttle": throttle, **signals}.items()}
    scatter = {name: regular_stamps(time)[1] for name, time in stamps.items()}
    periods = {name: float(np.mean(np.diff(time))) if time.size > 1 else CELL for name, time in stamps.items()}
    given = (throttle, dict(signals))
    if regular:
        throttle = (regular_stamps(throttle[0])[0], throttle[1])
        signals = {name: (regular_stamps(time)[0], values) for name, (time, values) in signals.items()}
    straight = hold == "linear"
    step, within = (DT / 3.0, False) if straight else _step_for(*throttle)  # corners of lines are cut within a step
    begins = float(throttle[0][0]) % step
    begins -= step if begins > step - 1e-6 else 0.0
    throttle = (throttle[0] - begins, throttle[1])
    signals = {name: (time - begins, values) for name, (time, values) in signals.items()}
    clocks = dict(clock_deviations or {})
    end = max([float(throttle[0][-1]), *(float(time[-1]) for time, _ in signals.values())])
    count = max(1, int(np.ceil(end / step)) + 1)
    commands = (
        on_lines(*throttle, step * np.arange(1.0, count + 1)) if straight else held_on_grid(*throttle, step, count)
    )
    parts = None
    if within:
        middles = np.asarray(step / PARTS * (np.arange(commands.size * PARTS) + 0.5), dtype=np.float64)
        parts = held(*throttle, middles.reshape(-1, PARTS))
    volts = None if supply is None else np.interp(step * np.arange(commands.size), supply[0] - begins, supply[1])
    measurements, lost = {}, {}
    for signal, (time, values) in signals.items():
        period = float(np.median(np.diff(regular_stamps(time)[0]))) if time.size > 1 else CELL
        width, readings = 0.0, 0
        if period < FAST:
            together = round(CELL / period)
            width = together * period
            # By the stamps in the log, so that the same readings are taken together with regular ones, too.
            stamped = given[1][signal][0] - begins
            start = float(stamped[0]) - 0.5 * period
            cells = int((stamped[-1] - start) / width)
            again_read = repeated_samples(values)
            lost[signal] = int(np.count_nonzero(again_read)), values.size
            values = np.where(again_read, np.nan, values)
            # A cell is when its readings were taken, on the average: where stamps scatter it has one more or less.
            read_at = np.where(np.isfinite(values), time, np.nan)
            (centres, values), (_, taken) = (
                cell_means(stamped, each, start=start, width=width, cells=cells) for each in (values, read_at)
            )
            time = np.where(np.isfinite(taken), taken, centres)
            readings = together if together < MANY else 0
        # Readings of a coarse converter stand still for a while and look free of noise.
        noise = max(noise_level(values), lattice_step(values) / np.sqrt(12.0))
        if not np.isfinite(noise) or noise <= 0.0:
            continue
        shift = clocks.get(_TOPICS[signal], 0.0)
        if regular:
            # The line through scattered stamps is as uncertain as their mean.
            shift = float(np.hypot(shift, 2.0 * scatter[signal] / np.sqrt(time.size)))
        measurements[signal] = Measurement(
            signal=signal, time=time, values=values, width=width, readings=readings, noise=noise, shift_std=shift
        )
    experiment = Experiment(
        name=name,
        dt=step,
        throttle=commands,
        straight=straight,
        parts=parts,
        measurements=measurements,
        supply=volts,
        throttle_shift_std=float(
            np.hypot(clocks.get("throttle", 0.0), regular * 2.0 * scatter["throttle"] / np.sqrt(throttle[0].size))
        ),
    )
    found = with_log_findings(experiment, thruster, scatter, periods, lost)

    def again(**other: Any) -> Recording:
        settings = {"thruster": thruster, "clock_deviations": clock_deviations, "supply": supply, "hold": hold}
        return recording_of(name, *given, **{**settings, **other})

    if not regular and max(scatter.values()) >= LEAST_SCATTER:
        found = replace(found, regular=again(regular=True))
    if hold is None and moves_between(*given[0]):
        found = replace(found, straight=again(regular=regular, hold="linear"))
    return found


def with_log_findings(
    experiment: Experiment,
    thruster: int = 0,
    scatter: Mapping[str, float] | None = None,
    period: Mapping[str, float] | None = None,
    lost: Mapping[str, tuple[int, int]] | None = None,
) -> Recording:
    """Return an experiment as a recording, with what its log shows and the state at its start; arguments: see
    `LogFindings`."""
    repeated, standing_out, lone, lattice = {}, {}, {}, {}
    log = LogFindings(scatter=dict(scatter or {}), period=dict(period or {}), lost=dict(lost or {}))
    for name, m in experiment.measurements.items():
        if m.width == 0.0:
            repeated[name] = repeated_samples(m.values)
            lattice[name] = lattice_step(m.values[~repeated[name]])
        if name in ("axial", "ambient"):
            standing_out[name] = spikes(m.values, m.noise)
        else:
            lone[name] = lone_samples(m.values, m.noise, together=log.together(name, m.width))
    hole = {}
    if "speed" in experiment.measurements and experiment.measurements["speed"].width == 0.0:
        hole["speed"] = hole_around_zero(experiment.measurements["speed"].values)
    start, deviations = initial_state(experiment, standing_out)
    log = replace(log, hole=hole, repeated=repeated, spikes=standing_out, lone=lone, lattice=lattice)
    return Recording(experiment=experiment, start=start, start_std=deviations, log=log, thruster=thruster)
