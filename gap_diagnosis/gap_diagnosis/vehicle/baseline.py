"""What a recording of the healthy vehicle teaches: its numbers within their deviations, and the noises."""

from collections.abc import Sequence

from gap_diagnosis.vehicle.filtering import learned_from
from gap_diagnosis.vehicle.gains import Noises
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Key, Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.search import started

__all__ = ["baseline"]


def baseline(model: Model, logs: Sequence[VehicleLog]) -> tuple[dict[Key, float], Noises]:
    """Return values of the nuisances, biases of single runs left out, and noises."""
    runs, values = started(model, logs, nuisances(model, logs))
    return {k: v for k, v in values.items() if k[0] not in ("gyro", "force")}, learned_from(runs)
