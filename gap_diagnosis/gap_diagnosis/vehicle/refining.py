"""A hypothesis fitted without linearisation: its sizes anew at each step, nuisances by the columns that are known."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.gram import Gram
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.model import Key
from gap_diagnosis.vehicle.screening import Screen
from rov_sim.vehicle.effects.active import ActiveVehicleEffect

__all__ = ["Refined", "refined"]

Array = NDArray[np.float64]
_STEPS = 4
_GRIDS = {"throttle_rate_limit": (40.0, 20.0, 10.0, 5.0, 2.5), "throttle_saturation": (4.0, 3.0, 2.5, 2.0, 1.5, 1.0)}


@dataclass(frozen=True, kw_only=True)
class Refined:
    """A hypothesis at its most likely point.

    Attributes:
        hypothesis: which.
        sizes: of its parameters; deviations: of them.
        shifts: of the nuisances, in their deviations, beside the screen's point.
        log_evidence: as `gram.evidence` has it.
    """

    hypothesis: Hypothesis
    sizes: tuple[float, ...]
    deviations: tuple[float, ...]
    shifts: Array
    log_evidence: float

    @property
    def active(self) -> ActiveVehicleEffect:
        """The effect, switched on."""
        return self.hypothesis.active(self.sizes)


def refined(
    screen: Screen, gram: Gram, nuisances: dict[Key, float], h: Hypothesis, start: Sequence[float], moved: Array
) -> Refined:
    """Return a hypothesis fitted from these sizes.

    Args:
        screen: the point around which is fitted.
        gram: with the nuisances as its first, kept columns.
        nuisances: deviations by key, in the order of these columns.
        h, start: what is fitted, and from where.
        moved: where the screen's own point lies in the nuisances' deviations, (m,).
    """
    m = len(nuisances)
    sizes, shifts = _start(screen, h, start), np.zeros(m)
    scale = np.array(h.scale)
    off = np.array([0.0] * len(sizes))
    r, score = _scored(screen, nuisances, h, sizes, shifts, moved)
    H = np.eye(m + len(sizes))
    for _ in range(_STEPS):
        J = _columns(screen, nuisances, h, sizes, shifts, r)
        A, b = np.zeros((m + len(sizes),) * 2), np.zeros(m + len(sizes))
        for k, each in enumerate(r):
            full = np.concatenate((gram.kept[k], J[k]), axis=1)
            A += np.asarray(full.T @ full, dtype=np.float64)
            b -= np.asarray(full.T @ each.astype(np.float32), dtype=np.float64)
        H = A + np.eye(len(A))
        b[:m] -= moved + shifts
        if len(sizes):
            b[m:] -= (np.array(sizes) - off) / scale
        step = np.linalg.solve(H, b)
        better = False
        for share in (1.0, 0.5, 0.2):
            tried = tuple(np.clip(np.array(sizes) + share * step[m:] * scale, h.lower, h.upper)) if sizes else ()
            there = shifts + share * step[:m]
            r_new, new = _scored(screen, nuisances, h, tried, there, moved)
            if new > score + 1e-3:
                better = new > score + 0.1
                sizes, shifts, r, score = tried, there, r_new, new
                break
        if not better:
            break
    _, log_det = np.linalg.slogdet(H)
    spread = np.sqrt(np.diag(np.linalg.inv(H))[m:]) * scale if sizes else np.zeros(0)
    return Refined(
        hypothesis=h, sizes=tuple(map(float, sizes)), deviations=tuple(map(float, spread)), shifts=shifts,
        log_evidence=score - 0.5 * float(log_det),
    )  # fmt: skip


def _start(screen: Screen, h: Hypothesis, start: Sequence[float]) -> tuple[float, ...]:
    if h.effect in _GRIDS:

        def cost(size: float) -> float:
            at = [screen.at(k, screen.values, (*screen.effects, h.active((size,)))) for k in range(len(screen.runs))]
            return sum(float(np.sum(r**2)) for r in at)

        return (min(_GRIDS[h.effect], key=cost),)
    return tuple(float(np.clip(s, a, b)) for s, a, b in zip(start, h.lower, h.upper, strict=True))


def _values(screen: Screen, nuisances: dict[Key, float], shifts: Array) -> dict[Key, float]:
    return {k: screen.values.get(k, 0.0) + float(s) * d for (k, d), s in zip(nuisances.items(), shifts, strict=True)}


def _scored(
    screen: Screen, nuisances: dict[Key, float], h: Hypothesis, sizes: Any, shifts: Array, moved: Array
) -> tuple[list[Array], float]:  # fmt: skip
    values = _values(screen, nuisances, shifts)
    effects = (*screen.effects, h.active(tuple(sizes)))
    r = [np.clip(np.nan_to_num(screen.at(k, values, effects)), -50.0, 50.0).ravel() for k in range(len(screen.runs))]
    prior = float(np.sum((moved + shifts) ** 2))
    if h.effect not in _GRIDS:
        prior += float(np.sum((np.array(sizes) / np.array(h.scale)) ** 2)) if sizes else 0.0
    return r, -0.5 * sum(float(x @ x) for x in r) - 0.5 * prior


def _columns(
    screen: Screen, nuisances: dict[Key, float], h: Hypothesis, sizes: tuple[float, ...], shifts: Array, r: list[Array]
) -> list[NDArray[np.float32]]:  # fmt: skip
    values = _values(screen, nuisances, shifts)
    out = [np.zeros((x.size, len(sizes)), dtype=np.float32) for x in r]
    for j in range(len(sizes)):
        step = 0.5 * h.probe[j]
        if sizes[j] + step > h.upper[j]:
            step = -step
        there = tuple(s + step if i == j else s for i, s in enumerate(sizes))
        for k in range(len(r)):
            new = np.nan_to_num(screen.at(k, values, (*screen.effects, h.active(there)))).ravel()
            out[k][:, j] = (np.clip(new, -50.0, 50.0) - r[k]) * (h.scale[j] / step)
    return out
