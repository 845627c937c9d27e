"""What recordings of a vehicle could tell at best: which numbers, and which effects from which size on.

Columns are made where the model is as stated, with the noises of the sensors and water that is calm, so nothing is
fitted. A diagnosis that learns a larger random wrench, or moves the numbers, tells less.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.gram import gathered
from gap_diagnosis.vehicle.hypotheses import Hypothesis, hypotheses
from gap_diagnosis.vehicle.learning import unlearned
from gap_diagnosis.vehicle.log import VehicleLog, told_in
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.nuisances import nuisances
from gap_diagnosis.vehicle.screening import Screen
from gap_diagnosis.vehicle.stage import least_shown
from gap_diagnosis.vehicle.unknowns import OF_RUN, Key

__all__ = ["Foreseen", "foreseen"]


@dataclass(frozen=True, kw_only=True)
class Foreseen:
    """Numbers with the share of their deviations that recordings leave, and effects with the least size that would be
    claimed, in its own unit."""

    numbers: tuple[tuple[Key, float], ...]
    effects: tuple[tuple[Hypothesis, float], ...]

    @property
    def told(self) -> list[Key]:
        """The numbers that a fit would determine."""
        return [key for key, left in self.numbers if left < rules.UNDETERMINED]

    @property
    def untold(self) -> list[Key]:
        """Those that it would leave as they are."""
        return [key for key, left in self.numbers if left >= rules.UNDETERMINED]

    @property
    def hidden(self) -> list[Hypothesis]:
        """The effects that would not show at any size."""
        return [h for h, least in self.effects if least > h.most]


def foreseen(model: Model, logs: Sequence[VehicleLog]) -> Foreseen:
    """Return what these recordings could tell at best of effects on one part of the vehicle, and of its numbers."""
    there = told_in(logs)
    tried = [h for h in hypotheses(model, there) if h.of_one_size and h.other is None]
    free = nuisances(model, logs)
    runs = unlearned(model, logs, {})
    screen = Screen(model=model, runs=runs, values={})
    columns = [screen.of_nuisance(key, deviation) for key, deviation in free.items()]
    columns += [column for h in tried for column in screen.of_hypothesis(h)]
    width = round(rules.BLOCK / runs[0].log.period) * screen.residual(0).shape[1]
    gram = gathered(screen.residuals(), columns, base=len(free), block=width)
    own = range(len(free))
    left = np.sqrt(np.diag(np.linalg.inv(gram.A[np.ix_(own, own)] + np.eye(len(free)))))
    numbers = tuple((key, float(share)) for key, share in zip(free, left, strict=True) if key[0] not in OF_RUN)
    return Foreseen(numbers=numbers, effects=least_shown(gram, own))
