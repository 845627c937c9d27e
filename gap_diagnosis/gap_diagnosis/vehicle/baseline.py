"""What a recording of the healthy vehicle teaches: its numbers within their deviations, and the noises."""

from collections.abc import Sequence

from gap_diagnosis.vehicle.gains import Noises
from gap_diagnosis.vehicle.learning import learned_from, prepared
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import OF_RUN, Key, Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.settling import settled

__all__ = ["baseline"]


def baseline(model: Model, logs: Sequence[VehicleLog]) -> tuple[dict[Key, float], Noises]:
    """Return values of the nuisances, biases of single runs left out, and noises."""
    runs, fit = settled(model, logs, nuisances(model, logs), prepared(model, logs, {}, rounds=0), (), {})
    return {k: v for k, v in fit.values.items() if k[0] not in OF_RUN}, learned_from(runs)
