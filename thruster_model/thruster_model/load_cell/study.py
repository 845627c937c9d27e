"""One study: calibrate on recordings, identify the mode, recover the thrust of each, and say how sure."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from thruster_model.errors import UnfitDataError
from thruster_model.load_cell.calibration import Calibration, LoadData, calibrate
from thruster_model.load_cell.population_search import searched
from thruster_model.load_cell.preparation import (
    Recording,
    around_jumps,
    jumps,
    lever_arm,
    plateau,
    segments,
    stretch_of,
    thesis_windows,
)
from thruster_model.load_cell.recovery import Recovered, Saved, recover, saved_share
from thruster_model.load_cell.resonance import Resonance, identify
from thruster_model.load_cell.ringdown import RingDown, ring_down
from thruster_model.load_cell.structure import Stretch

__all__ = ["CalibrationStudy", "RecoveryStudy", "Reproduced", "calibrate_recordings", "recover_recordings"]

Array = NDArray[np.float64]
HALF_TURN = np.array([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0])
_WORSE = 5.0
"""A recording whose residual exceeds that of its own best matrix by this factor has another matrix."""


@dataclass(frozen=True, kw_only=True)
class Reproduced:
    """How the matrix of all other recordings reproduces one.

    Attributes:
        force, moment: root-mean-square error over root-mean-square size.
        residual: root-mean-square error by component [N, N m] (6,).
        rounding: what rounding of gauge forces and wrench as recorded would give of it [N, N m] (6,).
    """

    force: float
    moment: float
    residual: Array
    rounding: Array


@dataclass(frozen=True, kw_only=True)
class CalibrationStudy:
    """H_A of recordings with one matrix; what each of the others would give; names of those with another matrix."""

    calibration: Calibration
    searched: Array
    reproduced: Mapping[str, Reproduced]
    other: Mapping[str, Reproduced]


@dataclass(frozen=True, kw_only=True)
class RecoveryStudy:
    """Mode, and the recovered thrust of each recording with the windows that a ringing load cell costs.

    Attributes:
        arm: lever arm of the moment [m].
        windows: by recording, (start, end) [s]: those of the thesis, else 1.2 s after each jump.
        of_thesis: recordings whose windows are those of the thesis.
    """

    arm: float
    ring: RingDown
    resonance: Resonance
    stretches: Mapping[str, Stretch]
    recovered: Mapping[str, Recovered]
    windows: Mapping[str, list[tuple[float, float]]]
    of_thesis: tuple[str, ...]
    saved: Mapping[str, Saved]


def calibrate_recordings(recordings: Sequence[Recording]) -> CalibrationStudy | None:
    """Calibrate on all recordings with gauges that obey one matrix; None where there are none."""
    data, size, steps = {}, {}, {}
    for r in recordings:
        if r.legs is not None:
            wrench = r.wrench * HALF_TURN if r.turned else r.wrench
            data[r.name] = LoadData.of(r.legs, wrench)
            size[r.name] = np.sqrt(np.nanmean(wrench**2, axis=0))
            steps[r.name] = (_step(r.legs), _step(wrench))
    if not data:
        return None
    own = {name: d.residual(calibrate(d).matrix) for name, d in data.items()}
    kept, other = dict(data), {}
    while len(kept) > 2:
        residuals = {n: kept[n].residual(_without(kept, n)) for n in kept}
        excess = {n: float(np.max(r / np.maximum(own[n], 1e-9))) for n, r in residuals.items()}
        # A recording with another matrix spoils the matrix that the others are judged by, so it goes alone first.
        spoilt = {n: _total(kept, n, own) for n in kept} if max(excess.values()) > _WORSE else {}
        if not spoilt:
            break
        guilty = min(spoilt, key=lambda n: spoilt[n])
        other[guilty] = _reproduced(residuals[guilty], size[guilty], steps[guilty], _without(kept, guilty))
        del kept[guilty]
    pooled = LoadData.pooled(list(kept.values()))
    judged = {}
    for name in kept:
        matrix = _without(kept, name) if len(kept) > 1 else calibrate(kept[name]).matrix
        judged[name] = _reproduced(kept[name].residual(matrix), size[name], steps[name], matrix)
    return CalibrationStudy(calibration=calibrate(pooled), searched=searched(pooled), reproduced=judged, other=other)


def _without(data: Mapping[str, LoadData], name: str) -> Array:
    return calibrate(LoadData.pooled([d for n, d in data.items() if n != name])).matrix


def _total(data: Mapping[str, LoadData], name: str, own: Mapping[str, Array]) -> float:
    """Return the worst excess that is left among the others when `name` is taken out."""
    left = {n: d for n, d in data.items() if n != name}
    matrix = calibrate(LoadData.pooled(list(left.values()))).matrix
    return max(float(np.max(d.residual(matrix) / np.maximum(own[n], 1e-9))) for n, d in left.items())


def _reproduced(residual: Array, size: Array, steps: tuple[float, float], matrix: Array) -> Reproduced:
    parts = [float(np.linalg.norm(residual[k]) / np.linalg.norm(size[k])) for k in (slice(0, 3), slice(3, 6))]
    rounding = np.sqrt((steps[0] ** 2 * np.sum(matrix**2, axis=1) + steps[1] ** 2) / 12.0)
    return Reproduced(force=parts[0], moment=parts[1], residual=residual, rounding=rounding)


def _step(values: Array) -> float:
    """Return the smallest step between recorded numbers: 10 to a whole power, or less than a nano-unit if unrounded."""
    different = np.diff(np.unique(values[np.isfinite(values)][:20000]))
    return float(10.0 ** np.round(np.log10(max(1e-9, float(np.min(different[different > 1e-9], initial=1.0))))))


def recover_recordings(
    recordings: Sequence[Recording], progress: Callable[[str], None] = lambda _: None
) -> RecoveryStudy:
    """Identify the mode on all recordings that have rotor speed and throttle, and recover their thrust.

    Raises:
        UnfitDataError: none of them rings, or there is no steady thrust.
    """
    usable = [r for r in recordings if r.speed is not None and r.throttle is not None]
    if not usable:
        names = ", ".join(r.name for r in recordings)
        raise UnfitDataError([f"load cell: expected runs with rotor speed and throttle; found none among {names}"])
    arm = lever_arm(np.concatenate([plateau(r) for r in usable]))
    stretches = {r.name: stretch_of(r, arm) for r in usable}
    progress("free ringing")
    ring = ring_down([s for stretch in stretches.values() for s in segments(stretch)])
    progress("noise and shares of the mode")
    resonance = identify([part for s in stretches.values() for part in around_jumps(s)], ring)
    recovered, windows, of_thesis = {}, {}, []
    for r in usable:
        progress(f"thrust of {r.name}")
        recovered[r.name] = recover(stretches[r.name], resonance)
        found = thesis_windows(*r.setpoint) if r.setpoint is not None else []
        if found:
            of_thesis.append(r.name)
        windows[r.name] = found or [(t, t + 1.2) for t in jumps(stretches[r.name])]
    return RecoveryStudy(
        arm=arm,
        ring=ring,
        resonance=resonance,
        stretches=stretches,
        recovered=recovered,
        windows=windows,
        of_thesis=tuple(of_thesis),
        saved={name: saved_share(recovered[name], windows[name]) for name in recovered},
    )
