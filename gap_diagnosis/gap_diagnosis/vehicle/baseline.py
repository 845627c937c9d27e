"""What recordings of the healthy vehicle teach: its numbers within their deviations, noises, and its sensors."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gap_diagnosis.vehicle.conventions import Conventions, conventions_of
from gap_diagnosis.vehicle.fit import far_off, numbers_of
from gap_diagnosis.vehicle.gains import Noises
from gap_diagnosis.vehicle.learning import learned_from
from gap_diagnosis.vehicle.log import VehicleLog, told_in, wanting
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.settling import settled
from gap_diagnosis.vehicle.stretches import stretches_of
from gap_diagnosis.vehicle.stuck import longest_unchanged
from gap_diagnosis.vehicle.unknowns import OF_RUN, Key, acts_in

__all__ = ["Baseline", "baseline"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Baseline:
    """Conventions; values of the nuisances, those of single runs left out; number of the next run and deviations of
    what it may differ by; noises; which sensors told anything, and the longest time without a new reading [s] of each;
    doubt: what speaks against a healthy vehicle, in words, "": nothing."""

    conventions: Conventions
    values: Mapping[Key, float]
    run: int
    differing: Mapping[Key, float]
    noises: Noises
    there: Mapping[str, bool]
    unchanged: Mapping[str, float]
    doubt: str = ""


def baseline(model: Model, logs: Sequence[VehicleLog]) -> Baseline:
    """Return what these recordings of the healthy vehicle teach.

    Raises:
        ValueError: they are too short, or nothing moves in them.
    """
    if lacking := wanting(logs):
        raise ValueError(f"baseline: {lacking}")
    conventions = conventions_of(model, logs)
    logs = [conventions.read(log) for log in logs]
    used, _ = stretches_of(logs)
    free = nuisances(model, used)
    runs, fit = settled(model, used, free)
    far = far_off(numbers_of(fit, free))
    doubt = f"Baseline: {far} Was the vehicle healthy? What ailed it then is not found." if far else ""
    values = {k: v for k, v in fit.values.items() if k[0] not in OF_RUN}
    run = len(used)
    differing = {k: d for k, d in nuisances(model, [*used, used[-1]]).items() if k[0] in OF_RUN and acts_in(k, run)}
    return Baseline(
        conventions=conventions, values=values, run=run, differing=differing, noises=learned_from(runs),
        there=told_in(logs), unchanged=longest_unchanged(logs), doubt=doubt,
    )  # fmt: skip
