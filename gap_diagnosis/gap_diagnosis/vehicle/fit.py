"""A vehicle's numbers fitted to its recordings, how sure they are, and what the recordings do not determine.

The fit is that of the diagnosis before any effect is on (`search.settled`): the plant as a filter, a wandering wrench,
all numbers with their stated deviations as what is known before. With H = J^T J + 1 in these deviations, a number keeps
the share sqrt((H^-1)_jj) of its deviation: near 1, the recordings told nothing of it.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.conventions import conventions_of
from gap_diagnosis.vehicle.how_far import Point, free_runs, rms, without_run
from gap_diagnosis.vehicle.log import VehicleLog, wanting
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.refining import Fit
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.settling import settled
from gap_diagnosis.vehicle.stretches import stretches_of
from gap_diagnosis.vehicle.unknowns import OF_RUN, Key, words_of

__all__ = ["FittedNumber", "LeftOut", "VehicleFit", "far_off", "fitted_vehicle", "numbers_of"]

Array = NDArray[np.float64]
_NAMED = 5
"""Numbers that are named of those which moved too far."""


@dataclass(frozen=True, kw_only=True)
class FittedNumber:
    """One number: by how much it moved from what was stated, in its unit or as a share, its deviation before and after;
    together: the number that moves most with it, and their correlation."""

    key: Key
    moved: float
    before: float
    after: float
    together: tuple[Key, float] | None

    @property
    def told(self) -> bool:
        """Whether the recordings determine it: they took off a fifth of its deviation or more."""
        return self.after < rules.UNDETERMINED * self.before

    @property
    def shifted(self) -> bool:
        """Whether it moved farther than its stated deviation allows."""
        return abs(self.moved) > rules.SHIFTED * self.before


@dataclass(frozen=True, kw_only=True)
class LeftOut:
    """Root mean square errors of free runs by channel group at a horizon [s], each recording with the numbers of the
    others: as stated and fitted."""

    horizon: float
    as_stated: dict[str, float]
    fitted: dict[str, float]


@dataclass(frozen=True, kw_only=True, eq=False)
class VehicleFit:
    """The numbers, errors of free runs, the wrench (6,) [N, N m] that remains, whether recordings were left out, a
    sentence for each sensor that is mounted turned, and about what was used of long dives."""

    numbers: tuple[FittedNumber, ...]
    errors: tuple[LeftOut, ...]
    wrench: Array
    left_out: bool
    decided: tuple[str, ...] = ()

    def values(self) -> dict[Key, float]:
        """Return by how much each number moved."""
        return {n.key: n.moved for n in self.numbers}


def numbers_of(fit: Fit, free: Mapping[Key, float]) -> tuple[FittedNumber, ...]:
    """Return where a fit has led the numbers of these deviations, sizes of effects beside them."""
    wide = [J.astype(np.float64) for J in fit.columns]
    covariance = np.linalg.inv(sum((J.T @ J for J in wide), np.eye(wide[0].shape[1])))[: len(free), : len(free)]
    share = np.sqrt(np.diag(covariance))
    correlation = covariance / np.outer(share, share) - np.eye(len(free))
    keys, numbers = list(free), []
    for j, (key, deviation) in enumerate(free.items()):
        other = int(np.argmax(np.abs(correlation[j])))
        together = (keys[other], float(correlation[j, other])) if abs(correlation[j, other]) > 0.5 else None
        numbers.append(
            FittedNumber(
                key=key, moved=float(fit.moved[j]) * deviation, before=deviation, after=float(share[j]) * deviation,
                together=together,
            )
        )  # fmt: skip
    return tuple(numbers)


def far_off(numbers: Sequence[FittedNumber]) -> str:
    """Return in words which of the vehicle's numbers moved farther than their deviations allow, "": none did."""
    far = sorted(
        (n for n in numbers if n.shifted and n.key[0] not in OF_RUN), key=lambda n: -abs(n.moved / n.before)
    )[:_NAMED]  # fmt: skip
    named = ", ".join(f"{words_of(n.key)} by {n.moved / n.before:+.1f} stated deviations" for n in far)
    return f"Farther from what was stated than its deviation allows: {named}." if named else ""


def fitted_vehicle(
    model: Model, logs: Sequence[VehicleLog], told: Callable[[str], None] = lambda text: None,
    longest: float | None = None,
) -> VehicleFit:  # fmt: skip
    """Return the fit of a vehicle's numbers to recordings; longest: see `stretches_of`.

    Raises:
        ValueError: recordings that are too short or in which no thruster is driven.
    """
    if lacking := wanting(logs):
        raise ValueError(lacking)
    conventions = conventions_of(model, logs)
    for sentence in conventions.turned:
        told(sentence)
    logs, thinned = stretches_of([conventions.read(log) for log in logs], longest)
    for sentence in thinned:
        told(sentence)
    free = nuisances(model, logs)
    told(f"{len(free)} numbers, {sum(log.duration for log in logs):.0f} s")
    runs, fit = settled(model, logs, free)
    told("free runs")
    screen = Screen(model=model, runs=runs, values=fit.values)
    points = [without_run(screen, fit, free, k) for k in range(len(runs))]
    errors = []
    for horizon in (h for h in rules.HORIZONS if h + 4.0 < max(log.duration for log in logs)):
        before, after = (rms(free_runs(model, runs, at, horizon)) for at in ([Point({}, ()) for _ in runs], points))
        errors.append(LeftOut(horizon=horizon, as_stated=before, fitted=after))
    return VehicleFit(
        numbers=numbers_of(fit, free),
        errors=tuple(errors),
        wrench=np.asarray(runs[0].noises.wrench),
        left_out=len(runs) > 1,
        decided=(*conventions.turned, *thinned),
    )
