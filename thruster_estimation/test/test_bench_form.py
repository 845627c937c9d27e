"""The bench's form reproduces, to rounding, what the bench recorded and what another writing of it computes."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.io import loadmat
from thruster_truth import BENCH_HL, DT, Array, drive, rate

from thruster_estimation.belief import Belief, initial_belief
from thruster_estimation.observers import observer_step
from thruster_estimation.offline import observe
from thruster_estimation.settings import BENCH, bench_settings

START = initial_belief(deviation_n=3**0.5, deviation_v=0.005**0.5, deviation_U=0.005**0.5)
RECORDINGS = {
    "ekf": "CL2stateKF1Sine",
    "kfnlo": "CL2stateKFNLO1Step",
    "nlo": "CL2stateNLO1Ramp",
    "speed-ekf": "CL1stateStep",
}
UPPER = np.triu_indices(3)


class Recording:
    """One controller's recording: y_n, y_U, u (N,), estimates x (N + 1, 3), covariances P (N + 1, 3, 3)."""

    def __init__(self, folder: Path, observer: str) -> None:
        mat = loadmat(folder / "closed_loop" / f"{RECORDINGS[observer]}.mat")
        self.u = mat["u"].ravel()
        self.three = mat["P"].ndim == 3
        y = mat["y"] if mat["y"].shape[0] == 2 else np.array([mat["y"].ravel(), np.full(self.u.size, np.nan)])
        self.y_n, self.y_U = y
        hats = [mat[name].ravel() if name in mat else np.zeros(self.u.size + 1) for name in ("nhat", "vhat", "vahat")]
        self.x = np.transpose(hats)
        self.P = np.zeros((self.u.size + 1, 3, 3))
        if self.three:
            self.P[:] = np.moveaxis(mat["P"], 2, 0)
        else:
            self.P[:, 0, 0] = mat["P"].ravel()

    def identified(self):  # type: ignore[no-untyped-def]
        """Return the bench's coefficients with k_n and c_Q read off P_nn, and the input map off n̂: both are linear."""
        n, v, P = self.x[:-1, 0], self.x[:-1, 1], self.P[:-1]
        e_U = np.nan_to_num(self.y_U) - self.x[:-1, 2]
        gone = (np.sign(n) ** 2 if self.three else 1.0) * P[:, 0, 0] ** 2 / 3.0 + P[:, 0, 2] ** 2 / 0.005
        left = np.diff(self.P[:, 0, 0]) / DT - 300.0 + gone
        k_n, k_c = np.linalg.lstsq(np.transpose([-2 * P[:, 0, 0], -4 * P[:, 0, 0] * abs(n)]), left, rcond=None)[0]
        injected = P[:, 0, 0] * np.sign(n) / 3.0 * (self.y_n - abs(n)) + P[:, 0, 2] / 0.005 * e_U
        drives = np.diff(self.x[:, 0]) / DT + k_n * n + k_c * n * abs(n) - injected
        drives -= BENCH_HL.k_Q * BENCH_HL.c_nv_Q * abs(n) * v
        found = {}
        for side, chosen in (("1", self.u < -1.0), ("2", self.u > 1.0)):
            if np.count_nonzero(chosen) > 5:
                slope, offset = np.polyfit(self.u[chosen], drives[chosen], 1)
                found |= {f"c_u{side}": slope, f"delta_u{side}": -offset / slope}
        c_Q = k_c / BENCH_HL.k_Q
        return BENCH_HL._replace(k_n=k_n, c_Q1=c_Q, c_Q2=c_Q, **found)


@pytest.mark.parametrize("observer", RECORDINGS)
def test_given_the_input_map_the_whole_recorded_estimate_follows_from_throttle_and_measurements(
    thruster_bench_data: Path, observer: str
) -> None:
    recorded = Recording(thruster_bench_data, observer)
    settings = bench_settings(observer, form=BENCH)
    h = observe(recorded.y_n, recorded.y_U, recorded.u, DT, START, settings, recorded.identified())
    # the digits of the coefficients that were handed down leave 1e-8
    np.testing.assert_allclose(h.n, recorded.x[1:, 0], atol=1e-7, rtol=0)
    np.testing.assert_allclose(h.P_nn, recorded.P[1:, 0, 0], atol=1e-7, rtol=0)
    if observer != "speed-ekf":
        np.testing.assert_allclose(h.v, recorded.x[1:, 1], atol=2e-8, rtol=0)
        np.testing.assert_allclose(h.U, recorded.x[1:, 2], atol=2e-8, rtol=0)
    if recorded.three:
        for name, (i, j) in zip(
            ("P_nv", "P_nU", "P_vv", "P_vU", "P_UU"), list(zip(*UPPER, strict=True))[1:], strict=True
        ):
            np.testing.assert_allclose(getattr(h, name), recorded.P[1:, i, j], atol=1e-8, rtol=0)


@pytest.mark.parametrize("observer", ["ekf", "kfnlo", "nlo"])
def test_the_recorded_v_and_U_follow_from_the_recorded_n_without_any_input_map(
    thruster_bench_data: Path, observer: str
) -> None:
    recorded = Recording(thruster_bench_data, observer)
    settings = bench_settings(observer, form=BENCH)
    for k in range(recorded.u.size):
        belief = Belief(*map(float, recorded.x[k]), *map(float, recorded.P[k][UPPER]))
        after, _ = observer_step(belief, recorded.y_n[k], recorded.y_U[k], DT, recorded.u[k], settings, BENCH_HL)
        assert after.v == pytest.approx(recorded.x[k + 1, 1], abs=3e-9)
        assert pytest.approx(recorded.x[k + 1, 2], abs=1e-9) == after.U
        if recorded.three:
            np.testing.assert_allclose(after[4:9], recorded.P[k + 1][UPPER][1:], atol=1e-9, rtol=0)
        # k_n and k_Q c_Q are known to seven digits
        assert after.P_nn == pytest.approx(recorded.P[k + 1, 0, 0], abs=3e-6)


def euler(observer: str, y_n: Array, y_U: Array, u: Array) -> NDArray[np.float64]:
    """Step the bench's observers with NumPy's matrices, order n, v, U; return the states (N, 3)."""
    p, out = BENCH_HL, []
    x, P = np.zeros(3), np.diag([3.0, 0.005, 0.005])
    Q, R_inverse = np.diag([300.0, 0.002, 0.002]), np.diag([1 / 3.0, 1 / 0.005])
    for k in range(u.size):
        n = x[0]
        e = np.array([y_n[k] - abs(n), y_U[k] - x[2]])
        step = 1e-6 * np.array([100.0, 0.1, 0.1])
        F = np.transpose([(rate(x + d, u[k], p) - rate(x - d, u[k], p)) / (2 * d.sum()) for d in np.diag(step)])
        dx = rate(x, u[k], p)
        if observer in ("ekf", "kfnlo"):
            H = np.array([[np.sign(n), 0.0, 0.0], [0.0, 0.0, 1.0]])
            K = P @ H.T @ R_inverse
            dx += K @ e
            dP = F @ P + P @ F.T + Q - P @ H.T @ R_inverse @ H @ P
        else:
            dx[0] += P[0, 0] / 3.0 * np.sign(n) * e[0]
            dP = np.zeros((3, 3))
            dP[0, 0] = 2 * F[0, 0] * P[0, 0] + 300.0 - P[0, 0] ** 2 / 3.0
        if observer in ("nlo", "kfnlo"):
            dx[1] += (0.1 + 0.2395923 + 0.1 * abs(n)) * e[1]
            dx[2] += (0.6 + 0.1 * abs(n)) * e[1]
        if observer == "speed-ekf":
            dx[1:] = 0.0
        x, P = x + DT * dx, P + DT * dP
        out.append(x)
    return np.array(out)


@pytest.mark.parametrize("observer", RECORDINGS)
def test_a_synthetic_run_is_what_another_writing_of_the_bench_form_computes(observer: str) -> None:
    rng = np.random.default_rng(4)
    u = 2.5 * np.sin(0.1 * np.arange(200) + 0.5)
    y_n = abs(np.array([drive(x, BENCH_HL) for x in u]) / 17.0 + rng.normal(0, 3, 200))
    y_U = 0.1 * np.sin(0.1 * np.arange(200) - 0.5) + rng.normal(0, 0.03, 200)
    h = observe(y_n, y_U, u, DT, START, bench_settings(observer, form=BENCH), BENCH_HL)
    expected = euler(observer, y_n, y_U, u)
    # the oracle's Jacobian is made of finite differences: 1e-9 relative in n
    np.testing.assert_allclose(h.n, expected[:, 0], atol=2e-7, rtol=0)
    np.testing.assert_allclose(h.v, expected[:, 1], atol=2e-9, rtol=0)
    np.testing.assert_allclose(h.U, expected[:, 2], atol=2e-9, rtol=0)


@pytest.mark.parametrize("observer", RECORDINGS)
def test_missing_measurements_leave_the_bench_form_with_its_prediction(observer: str) -> None:
    settings = bench_settings(observer, form=BENCH)
    belief = START._replace(n=50.0, v=0.05, U=0.05)
    after, innovation = observer_step(belief, np.nan, np.nan, DT, 2.0, settings, BENCH_HL)
    expected = np.array(belief[:3]) + DT * rate(np.array(belief[:3]), 2.0, BENCH_HL)
    states = 1 if observer == "speed-ekf" else 3
    np.testing.assert_allclose(after[:states], expected[:states], rtol=1e-12)
    assert after.P_nn > START.P_nn and np.isnan(innovation.nis)
