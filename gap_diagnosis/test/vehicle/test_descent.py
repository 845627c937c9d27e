"""Fits end where unknowns are most likely, also beside one whose range ends before that."""

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.optimize import minimize

from gap_diagnosis.vehicle.descent import descended

Array = NDArray[np.float64]


class Bent:
    """Rows that depend on three unknowns by a product too; the last one may be 0.5 at most."""

    def __init__(self) -> None:
        rng = np.random.default_rng(3)
        self.A = 30.0 * rng.standard_normal((60, 3))
        self.A[:, 2] += self.A[:, 0]
        self.y = self.rows(np.array([0.4, -0.3, 1.1])) + rng.standard_normal(60)
        self.weight = np.ones(3)

    def rows(self, x: Array) -> Array:
        return np.asarray(self.A @ x + 3.0 * x[0] * x[2] * self.A[:, 1])

    def held(self, x: Array) -> Array:
        return np.array([*x[:2], min(x[2], 0.5)])

    def scored(self, x: Array) -> tuple[list[Array], float]:
        r = self.rows(x) - self.y
        return [r], -0.5 * float(r @ r) - 0.5 * float(x @ x)

    def made(self, x: Array, r: list[Array], known: Sequence[NDArray[np.float32]]) -> list[NDArray[np.float32]]:
        J = self.A.copy()
        J[:, 0] += 3.0 * x[2] * self.A[:, 1]
        J[:, 2] += 3.0 * x[0] * self.A[:, 1]
        return [J.astype(np.float32)]


def test_what_is_free_is_best_beside_what_is_held_at_an_end() -> None:
    target = Bent()
    score, x, _ = descended(target, np.zeros(3)).end
    best = minimize(lambda x: -target.scored(x)[1], np.zeros(3), bounds=[(None, None)] * 2 + [(None, 0.5)])
    assert x[2] == 0.5
    assert score == pytest.approx(-best.fun, abs=0.5)
