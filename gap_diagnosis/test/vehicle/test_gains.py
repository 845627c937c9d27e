"""Gains of the filter against the plain matrices of a Kalman filter."""

import numpy as np
import pytest

from gap_diagnosis.vehicle.gains import Noises, filter_gains, motion_of
from rov_sim.vehicle.innovations import CHANNELS, CORRECTED

K, PERIOD, TIME = 40, 0.05, 2.0
FIRST = 7
WRENCH = slice(9, 15)


def test_gains_whiteners_and_covariances_are_those_of_a_kalman_filter() -> None:
    rng = np.random.default_rng(0)
    A, H = rng.normal(0.0, 0.5, (K, CORRECTED, CORRECTED)), rng.normal(0.0, 1.0, (K, CHANNELS, CORRECTED))
    A[:, WRENCH], A[:, :, 15] = 0.0, 0.0
    there = rng.random((K, CHANNELS)) < 0.6
    there[3] = False
    spread = rng.normal(0.0, 0.1, (K, 6, 6))
    doubts = spread @ spread.transpose(0, 2, 1)
    noises = Noises(
        np.abs(rng.normal(0.0, 1.0, 6)) + 0.1, TIME, np.abs(rng.normal(0.0, 0.1, CHANNELS)) + 0.01, np.ones(6),
        np.ones(6), np.ones(2),
    )  # fmt: skip
    motion = motion_of(A, H, there, PERIOD, doubts)
    before = np.diag(rng.uniform(0.01, 1.0, CORRECTED))
    found = filter_gains(motion, noises, before, np.full(CHANNELS, FIRST))

    keep, P, log_determinant = np.exp(-PERIOD / TIME), before, 0.0
    F = np.eye(CORRECTED) + A * PERIOD + 0.5 * (A * PERIOD) @ (A * PERIOD)
    F[:, WRENCH, WRENCH] = keep * np.eye(6)
    R = noises.channels**2 + np.einsum("kij,kjl,kil->ki", H[:, :, WRENCH], doubts, H[:, :, WRENCH])
    drift = filter_gains(motion.part(0, 1)._replace(there=there[3:4]), noises, np.zeros((CORRECTED, CORRECTED))).last
    drift[3:9, 3:9] -= motion.pushed[0]
    assert np.diag(drift)[WRENCH] == pytest.approx(noises.wrench**2 * (1.0 - keep**2))
    for k in range(K):
        told = np.flatnonzero(there[k])
        h = H[k, told]
        S = h @ P @ h.T + np.diag(R[k, told])
        G = P @ h.T @ np.linalg.inv(S)
        assert found.gains[k][:, told] == pytest.approx(G, rel=1e-6, abs=1e-9)
        assert not found.gains[k][:, ~there[k]].any()
        W = found.whitener[k][np.ix_(told, told)]
        assert pytest.approx(np.eye(told.size), abs=1e-8) == W @ S @ W.T and not np.triu(W, 1).any()
        log_determinant += np.linalg.slogdet(S)[1] if k >= FIRST else 0.0
        P = (np.eye(CORRECTED) - G @ h) @ P
        assert found.wrench_variance[k] == pytest.approx(np.diag(P)[WRENCH], rel=1e-6)
        P = F[k] @ P @ F[k].T + drift
        P[3:9, 3:9] += motion.pushed[k]
    assert found.log_determinant == pytest.approx(log_determinant, rel=1e-9)
    assert found.last == pytest.approx(P, rel=1e-6, abs=1e-9)
