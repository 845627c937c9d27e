"""From runs to experiments: which channels mean what, tared, masked and averaged into cells.

Every decision is taken from the run alone, before any fit, and is written into the experiment's notes.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from run_bag import Run, RunError, read_run
from thruster_model.errors import UnfitDataError
from thruster_model.identification.experiment import CHANNELS, SIGNALS, Experiment, Measurement
from thruster_model.identification.flow_quality import FlowLimits, assess_flow
from thruster_model.identification.preparation import (
    cell_means,
    glitch_mask,
    noise_level,
    rest_window,
    ringing_mask,
    tare,
    tare_unsigned_speed,
)
from thruster_model.identification.speed_sign import (
    NEAR_REST,
    held,
    lacks_sign,
    on_lines,
    signed_speed,
    unsigned,
    with_known_sign,
)

__all__ = ["PreparationOptions", "prepare", "read_experiments", "throttle_channel"]

Array = NDArray[np.float64]
_LEAST_USABLE = 0.25  # of the samples of a channel, below which it is told of


@dataclass(frozen=True, kw_only=True)
class PreparationOptions:
    """How runs become experiments.

    Attributes:
        thruster: index of the thruster.
        dt: period of the simulation [s].
        cell: width of the cells over which measurements are averaged [s].
        ringing_jump, ringing_hold: thrust and torque are masked for `ringing_hold` [s] after the throttle changed
            by `ringing_jump` [V] within 20 ms, which sets the load cell ringing.
        glitch_peak, glitch_foot: see `preparation.glitch_mask`, for the tachometer [rad/s].
        flow: limits of `flow_quality.assess_flow`.
        air: accept runs that were recorded in air.
    """

    thruster: int = 0
    dt: float = 0.002
    cell: float = 0.04
    ringing_jump: float = 0.5
    ringing_hold: float = 1.2
    glitch_peak: float = 25.0
    glitch_foot: float = 4.0
    flow: FlowLimits = field(default_factory=FlowLimits)
    air: bool = False


def read_experiments(
    paths: Iterable[Path], options: PreparationOptions | None = None, progress: Callable[[str], None] = lambda _: None
) -> list[Experiment]:
    """Read runs and prepare them; all that is wrong with any of them is raised at once.

    Raises:
        UnfitDataError: with a sentence for each run that cannot be read or holds nothing to fit.
    """
    experiments, problems = [], []
    for path in paths:
        progress(f"read {path.name}")
        try:
            experiments.append(prepare(read_run(path), options))
        except (RunError, UnfitDataError, OSError) as error:
            problems.append(str(error))
    if problems:
        raise UnfitDataError(problems)
    return experiments


def throttle_channel(run: Run, prefix: str) -> str | None:
    """Return the channel of the throttle: what the device got at the instant it got it, else what was asked for."""
    names = (f"{prefix}/throttle_sent.sent", f"{prefix}/throttle.commanded", f"{prefix}/throttle.sent")
    return next(iter(_told(run, *names)), None)


def _told(run: Run, *names: str) -> list[str]:
    """Return those of these channels that told anything."""
    return [name for name in names if name in run and np.any(np.isfinite(run[name].values))]


def prepare(run: Run, options: PreparationOptions | None = None) -> Experiment:
    """Return a run as an experiment.

    Raises:
        UnfitDataError: no throttle, no signal that models predict, or a run in air.
        RunError: the run states a hold that there is not.
    """
    options = options or PreparationOptions()
    prefix = f"thruster_{options.thruster}"
    throttle_name = throttle_channel(run, prefix)
    if throttle_name is None:
        raise UnfitDataError([f"{run.name}: expected a channel {prefix}/throttle.commanded; found {', '.join(run)}"])
    if run.metadata.get("water") is False and not options.air:
        raise UnfitDataError([f"{run.name}: recorded in air; expected a thruster in water"])
    grid = np.arange(0.0, run.duration, options.dt)
    samples = run.time(throttle_name), run[throttle_name].values
    straight = run.hold("throttle") == "linear"
    throttle = on_lines(*samples, grid + options.dt) if straight else held(*samples, grid)
    rest = rest_window(grid, throttle)
    notes = []
    if rest[1] - rest[0] < 0.2:
        notes.append("no rest before the throttle: nothing was tared")
    else:
        notes.append(f"tared on the rest from {rest[0]:.2f} to {rest[1]:.2f} s")
    preparation = _Preparation(run=run, prefix=prefix, options=options, grid=grid, throttle=throttle, rest=rest)
    measurements = [m for m in (preparation.speed(), *preparation.loads(), *preparation.flows()) if m is not None]
    kept = [m for m in measurements if np.any(m.usable) and np.isfinite(m.noise)]
    notes += [f"{SIGNALS[m.signal].title.lower()}: {note}" for m in measurements for note in m.notes]
    warnings = [_poor(prefix, m, left_out=m not in kept) for m in measurements]
    told = [sentence for sentence in warnings if sentence]
    if not kept:
        found = "; ".join(told) or f"channels are {', '.join(run)}"
        raise UnfitDataError([f"{run.name}: nothing usable is measured; {found}"])
    return Experiment(
        name=run.name,
        dt=options.dt,
        throttle=throttle,
        straight=straight,
        measurements={m.signal: m for m in kept},
        throttle_shift_std=_stated_deviation(run, "throttle"),
        notes=tuple(notes),
        warnings=(*run.warnings, *told),
        supply=_supply(run, f"{prefix}/state.supply_voltage", grid),
    )


def _supply(run: Run, name: str, grid: Array) -> Array | None:
    """Return the measured supply voltage [V] on the grid; None where it was not measured."""
    if name not in run:
        return None
    known = np.isfinite(run[name].values)
    return np.interp(grid, run.time(name)[known], run[name].values[known]) if np.any(known) else None


def _poor(prefix: str, measurement: Measurement, *, left_out: bool) -> str:
    """Return a sentence on a channel of which little or nothing is usable; empty for a sound one."""
    usable, size = int(np.sum(measurement.usable)), measurement.values.size
    if not left_out and usable > _LEAST_USABLE * size:
        return ""
    period = float(np.median(np.diff(measurement.time))) if size > 1 else np.inf
    found = f"found {usable} of {size} usable, one every {period:.2g} s ({'; '.join(measurement.notes)})"
    return f"{prefix}/{CHANNELS[measurement.signal]}: expected readings; {found}" + ("; left out" if left_out else "")


def _stated_deviation(run: Run, what: str) -> float:
    """Return the standard deviation [s] that the run's record states for the clock of `what`; 0 where it is silent."""
    deviations = run.metadata.get("clock_deviation", {})
    return float(deviations.get(what, 0.0) or 0.0)


@dataclass(frozen=True, kw_only=True)
class _Preparation:
    run: Run
    prefix: str
    options: PreparationOptions
    grid: Array
    throttle: Array
    rest: tuple[float, float]

    def _samples(self, name: str, *beside: str) -> tuple[Array, ...]:
        """Return when a channel was read [s], what it told, and what others of its topic did then, if they are there.

        In a table of several sensors most rows are those of others.
        """
        values = self.run[name].values
        read = np.isfinite(values)
        told = (self.run[other].values if other in self.run else np.empty(0) for other in beside)
        return (
            self.run.time(name)[read],
            values[read],
            *(each[read] if each.size == read.size else each for each in told),
        )

    def speed(self) -> Measurement | None:
        names = (f"daq/{self.prefix}/state.n", f"{self.prefix}/state.n")
        present = _told(self.run, *names)
        if not present:
            return None
        name = max(present, key=lambda n: np.count_nonzero(np.isfinite(self.run[n].values)))
        time, values, sources = self._samples(name, name.replace("state.n", "state.sign_source"))
        # Without any throttle there is no sign to infer, and nothing but rest to read.
        signless = bool(np.any(self.throttle)) and lacks_sign(sources, values)
        taring = tare_unsigned_speed if unsigned(sources, values) else tare
        if signless:
            values = signed_speed(time, values, (self.grid, self.throttle))
        elif unsigned(sources, values) and np.any(self.throttle):
            # An importer's sign is inferred from the throttle too: about a reversal nothing tells it.
            told = signed_speed(time, np.abs(values), (self.grid, self.throttle))
            values = np.where(np.isfinite(told), values, np.nan)
        values, offset, offset_std = taring(time, values, self.rest)
        values = values if signless else with_known_sign(sources, values)
        fine = 0.005
        if float(np.median(np.diff(time))) < fine:
            first = float(time[0]) - 0.5 * float(np.median(np.diff(time)))
            cells = int((time[-1] - first) / fine)
            time, values = cell_means(time, values, start=first, width=fine, cells=cells)
            half_width = round(0.25 / fine)
        else:
            half_width = max(2, round(0.25 / float(np.median(np.diff(time)))))
        limits = {"peak": self.options.glitch_peak, "foot": self.options.glitch_foot}
        glitches = glitch_mask(values, half_width=half_width, **limits)
        notes = [f"rest value {offset:.2f} rad/s taken off"]
        if signless:
            # Near rest a magnitude is that of its noise.
            glitches |= np.abs(values) < NEAR_REST * noise_level(values)
            notes.append("sign inferred from the throttle, readings near rest left out: the tachometer is unsigned")
        if np.any(glitches):
            notes.append(f"{100 * glitches.mean():.1f} % masked: glitches of the tachometer, or rest")
        shift = _stated_deviation(self.run, "state")
        values = np.where(glitches, np.nan, values)
        return self._measurement("speed", time, values, notes, shift_std=shift, offset_std=offset_std)

    def loads(self) -> list[Measurement]:
        result = []
        for signal, component in (("thrust", "force.x"), ("torque", "torque.x")):
            names = (f"{self.prefix}/load.wrench.{component}", f"daq/{self.prefix}/load.wrench.{component}")
            name = next(iter(_told(self.run, *names)), None)
            if name is None:
                continue
            time, values = self._samples(name)
            values, offset, offset_std = tare(time, values, self.rest)
            ringing = ringing_mask(
                time,
                self.grid,
                self.throttle,
                jump=self.options.ringing_jump,
                span=0.02,
                hold=self.options.ringing_hold,
            )
            notes = [f"rest value {offset:.3g} {SIGNALS[signal].unit} taken off"]
            if np.any(ringing):
                notes.append(f"{100 * ringing.mean():.0f} % masked: the load cell rings after jumps of the throttle")
            values, shift = np.where(ringing, np.nan, values), _stated_deviation(self.run, "load")
            result.append(self._measurement(signal, time, values, notes, shift_std=shift, offset_std=offset_std))
        return result

    def flows(self) -> list[Measurement]:
        result = []
        for signal in ("axial", "ambient"):
            name = f"{self.prefix}/flow.{signal}"
            if not _told(self.run, name):
                continue
            time, values, flagged = self._samples(name, name.replace(f"flow.{signal}", "flow.spike"))
            if flagged.size == values.size:
                values = np.where(flagged != 0.0, np.nan, values)
            rate = 1.0 / float(np.median(np.diff(time))) if time.size > 1 else 25.0
            quality = assess_flow(values, rate, self.options.flow)
            kept = np.where(quality.usable, values, np.nan)
            shift = _stated_deviation(self.run, "flow")
            result.append(self._measurement(signal, time, kept, [quality.sentence], shift_std=shift))
        return result

    def _measurement(
        self,
        signal: str,
        time: Array,
        values: Array,
        notes: list[str],
        *,
        shift_std: float = 0.0,
        offset_std: float = 0.0,
    ) -> Measurement:
        """Average into cells; samples that come no faster than the cells keep their own instants.

        A sample stands for the period around it: cells begin half a period before their first sample, or everything
        would come half a period late.
        """
        period = float(np.median(np.diff(time))) if time.size > 1 else self.options.cell
        width = max(self.options.cell, period)
        start = float(time[0]) - 0.5 * (period if period < 0.75 * width else width)
        cells = max(1, int((self.run.duration - start) / width))
        centres, means = cell_means(time, values, start=start, width=width, cells=cells)
        return Measurement(
            signal=signal,
            time=centres,
            values=means,
            width=width,
            noise=noise_level(means),
            shift_std=shift_std,
            offset_std=offset_std,
            notes=tuple(notes),
        )
