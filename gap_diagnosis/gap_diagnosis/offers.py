"""Which suspects are tried beside a hypothesis: the library's, with sizes that these recordings make likely."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from gap_diagnosis.converter_steps import SPACING, TURN, likely_speed_steps, likely_steps
from gap_diagnosis.reversal import REVERSAL, turns_beside
from gap_diagnosis.suspects import suspects
from gap_diagnosis.ventilation import AIR, air_beside
from system_identification.hypothesis import Hypothesis
from system_identification.suspects import Suspect
from thruster_model.effects.stages import LIBRARY

__all__ = ["offers_of"]

_STEPS = {"command_lattice": likely_steps, "reading_lattice": likely_speed_steps}
_TRIED = 16
_COARSE = 0.2
"""Share of a threshold by which it is searched about one of the grid."""
_SEARCHED = 7.0
"""What a converter's step pays for having been searched among some thousand."""
_BELOW = np.array([0.99, 0.975, 0.95, 0.9, 0.83, 0.75, 0.65, 0.55, 0.45, 0.36, 0.29, 0.2])
"""Shares of the largest command at which a limit is tried."""


def offers_of(signals: set[str], excluded: Sequence[str] = ()) -> Callable[[Hypothesis], list[Suspect]]:
    """Return what is offered beside a hypothesis, for recordings of these signals."""
    return partial(_offered, suspects(signals, tuple(excluded)), AIR not in excluded)


def _offered(listed: Sequence[Suspect], air: bool, beside: Hypothesis) -> list[Suspect]:
    found = [_with_likely_sizes(each, beside) for each in listed]
    if beside.system.gates:
        return found  # there can be one effect in stretches
    if REVERSAL not in beside.keys:
        found = [(turns_beside(beside) or each) if each.key == REVERSAL else each for each in found]
    drawn = air_beside(beside) if air else None
    return found if drawn is None else [*found, drawn]


def _with_likely_sizes(suspect: Suspect, beside: Hypothesis) -> Suspect:
    search = LIBRARY[suspect.effect].search
    if search == "limit":
        (slot,) = suspect.slots
        largest = max(float(np.max(np.abs(each.experiment.throttle))) for each in beside.system.recordings)
        limits = largest * _BELOW[largest * _BELOW >= slot.lower]
        return replace(suspect, grid=limits[:, None] / slot.width) if limits.size else suspect
    if search in _STEPS:
        (slot,) = suspect.slots
        steps = _STEPS[search](beside.fitted, beside.noise, slot.upper, _TRIED)
        grid = steps[:, None] / slot.width if steps.size else suspect.grid[:1]
        spacing = SPACING * float(grid[0, 0]) * slot.width if search == "command_lattice" else TURN * 0.02
        return replace(suspect, grid=grid, price=_SEARCHED, spacing=spacing)
    if search in ("fine", "stairs"):
        return replace(suspect, spacing=_COARSE)
    return suspect
