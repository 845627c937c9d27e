"""The navigation filter against truth from other code, filterpy, finite differences, and what goes missing."""

from types import SimpleNamespace

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from navigation_truth import GRAVITY, NOISE, STEP, errors_of, sailed
from scipy.spatial.transform import Rotation
from scipy.stats import chi2

from thruster_estimation.belief import Level
from thruster_estimation.navigation_belief import (
    Heard,
    NavigationBelief,
    NavigationSettings,
    NavigationStatus,
    checked_navigation,
    navigation_level,
    navigation_reason,
)
from thruster_estimation.navigation_measurements import attitude_rows, depth_row, velocity_rows
from thruster_estimation.navigation_output import compiled_begin, compiled_navigation, compiled_output, navigate

PLACES = {
    "imu": np.array([0.3, -0.1, -0.2]), "velocity": np.array([-0.4, 0.2, 0.3]), "depth": np.array([-0.5, 0.1, 0.1]),
    "imu_turn": Rotation.from_euler("ZYX", [0.5, -0.3, 1.2]),
    "velocity_turn": Rotation.from_euler("ZYX", [0.7, 0.0, 0.1]),
}  # fmt: skip


def wxyz(turn: Rotation) -> tuple[float, ...]:
    x, y, z, w = turn.as_quat()
    return w, x, y, z


MOUNTED = checked_navigation(
    NavigationSettings(
        imu_position=tuple(PLACES["imu"]), velocity_position=tuple(PLACES["velocity"]),
        depth_position=tuple(PLACES["depth"]), imu_rotation=wxyz(PLACES["imu_turn"]),  # type: ignore[arg-type]
        velocity_rotation=wxyz(PLACES["velocity_turn"]),  # type: ignore[arg-type]
        gyro_bias_deviation=0.001, force_bias_deviation=0.02,
    )
)  # fmt: skip
RUNS = 20


@pytest.fixture(scope="module")
def runs() -> list[tuple[SimpleNamespace, object]]:
    sailings = [sailed(seed, places=PLACES) for seed in range(RUNS)]
    return [(truth, navigate(truth.heard, truth.dt, MOUNTED)) for truth in sailings]


def test_errors_are_as_large_as_their_deviations_say(runs: list[tuple[SimpleNamespace, object]]) -> None:
    """Every quantity; many instants of one run count as few, so that the bound is that of its runs alone."""
    shares = [errors_of(truth, found)[500:] / found.deviations[500:] for truth, found in runs]  # type: ignore[attr-defined]
    mean_square = np.mean(np.square(shares), axis=(0, 1))
    low, high = chi2.ppf([0.0005, 0.9995], RUNS) / RUNS
    assert np.all((mean_square > low) & (mean_square < high)), mean_square


def test_the_whole_covariance_fits_the_errors_of_the_state(runs: list[tuple[SimpleNamespace, object]]) -> None:
    """NEES of the biases and of velocity with attitude at the end of each run."""
    nees = []
    for truth, found in runs:
        last: NavigationBelief = found.last  # type: ignore[attr-defined]
        e = np.concatenate((truth.gyro_bias - last.gyro_bias, truth.force_bias - last.force_bias))
        nees.append(e @ np.linalg.solve(last.P[9:, 9:], e))
    low, high = chi2.ppf([0.0005, 0.9995], 6 * RUNS) / RUNS
    assert low < np.mean(nees) < high


def test_innovations_are_as_large_as_they_say(runs: list[tuple[SimpleNamespace, object]]) -> None:
    nis = np.array([np.nanmean(found.nis[500:], axis=0) for _, found in runs])  # type: ignore[attr-defined]
    count = RUNS * np.array([2500, 125, 250])
    degrees = np.array([3, 3, 1])
    np.testing.assert_array_less(np.abs(nis.mean(axis=0) / degrees - 1.0), 5.0 * np.sqrt(2.0 / (degrees * count)))


def test_the_estimate_is_better_than_its_sensors(runs: list[tuple[SimpleNamespace, object]]) -> None:
    rms = np.sqrt(np.mean([np.mean(errors_of(truth, found)[500:] ** 2, axis=0) for truth, found in runs], axis=0))  # type: ignore[attr-defined]
    assert np.all(rms[3:6] < 0.25 * NOISE["attitude"])
    assert np.all(rms[6:9] < NOISE["velocity"]) and rms[2] < NOISE["depth"]
    assert np.all(rms[9:] < 1.05 * NOISE["gyro"])


def test_along_the_vertical_it_is_filterpys_kalman_filter() -> None:
    """Level and not turning, the vertical motion is linear: depth, velocity, bias of the specific force."""
    rng = np.random.default_rng(3)
    s = checked_navigation(NavigationSettings(stale=1e9, gate=1e9))
    kalman = KalmanFilter(dim_x=3, dim_z=1, dim_u=1)
    h = STEP
    kalman.F = np.array([[1, h, -h * h / 2], [0, 1, -h], [0, 0, 1]])
    kalman.B = np.array([[h * h / 2], [h], [0]])
    kalman.Q = np.diag([0.0, (h * s.force_noise) ** 2, s.force_walk**2 * h])
    force = -GRAVITY + 0.3 * np.sin(0.05 * np.arange(300)) + 0.05 * rng.standard_normal(300)
    depth = 5.0 + 0.006 * rng.standard_normal(300)
    flat = Heard(w=1.0, x=0.0, y=0.0, z=0.0, rate_x=0.0, rate_y=0.0, rate_z=0.0, force_x=0.0, force_y=0.0)
    belief = compiled_begin(flat._replace(force_z=force[0], depth=depth[0]), s)
    kalman.x = np.array([[depth[0]], [0.0], [0.0]])
    kalman.P = np.diag([s.depth_noise, s.velocity_deviation, s.force_bias_deviation]) ** 2
    for k in range(1, 300):
        told = flat._replace(force_z=force[k])
        kalman.predict(u=np.array([[0.5 * (force[k - 1] + force[k]) + GRAVITY]]))
        if k % 10 == 0:
            told = told._replace(depth=depth[k])
            kalman.update(depth[k], R=s.depth_noise**2, H=np.array([[1.0, 0.0, 0.0]]))
        if k % 20 == 0:
            told = told._replace(velocity_x=0.0, velocity_y=0.0, velocity_z=0.01)
            kalman.update(0.01, R=s.velocity_noise**2, H=np.array([[0.0, 1.0, 0.0]]))
        belief, _ = compiled_navigation(belief, told, h, s)
        mine = [belief.position[2], belief.velocity[2], belief.force_bias[2]]
        np.testing.assert_allclose(mine, kalman.x[:, 0], rtol=1e-9, atol=1e-12)
        rows = np.ix_([2, 5, 14], [2, 5, 14])
        np.testing.assert_allclose(belief.P[rows], kalman.P, rtol=1e-8, atol=1e-15)


def displaced(b: NavigationBelief, error: np.ndarray) -> NavigationBelief:
    """Return the belief whose truth lies `error` (15,) away from `b`."""
    w, x, y, z = b.attitude
    turned = Rotation.from_rotvec(error[6:9]) * Rotation.from_quat([x, y, z, w])
    add = [tuple(np.add(old, error[i : i + 3])) for old, i in
           ((b.position, 0), (b.velocity, 3), (b.gyro_bias, 9), (b.force_bias, 12))]  # fmt: skip
    return b._replace(position=add[0], velocity=add[1], attitude=wxyz(turned), gyro_bias=add[2], force_bias=add[3])  # type: ignore[arg-type]


def between(a: NavigationBelief, b: NavigationBelief) -> np.ndarray:
    """Return the errors of belief `a` where `b` is the truth."""
    (w, x, y, z), (v, i, j, k) = a.attitude, b.attitude
    turn = (Rotation.from_quat([i, j, k, v]) * Rotation.from_quat([x, y, z, w]).inv()).as_rotvec()
    parts = [np.subtract(getattr(b, n), getattr(a, n)) for n in ("position", "velocity", "gyro_bias", "force_bias")]
    return np.concatenate((parts[0], parts[1], turn, parts[2], parts[3]))


def test_covariances_spread_as_finite_differences_of_the_motion_do() -> None:
    truth = sailed(0, seconds=1.0, places=PLACES)
    begin = compiled_begin(Heard(*truth.heard[0].tolist()), MOUNTED)
    now = Heard(*truth.heard[1].tolist())._replace(w=np.nan)
    h, eps = 1e-3, 1e-5
    quiet = MOUNTED._replace(gyro_noise=0.0, force_noise=0.0, gyro_walk=0.0, force_walk=0.0)
    after = compiled_navigation(begin, now, h, quiet)[0]
    columns = []
    for j in range(15):
        steps = [
            compiled_navigation(displaced(begin, sign * eps * np.eye(15)[j]), now, h, quiet)[0] for sign in (1, -1)
        ]
        columns.append((between(after, steps[0]) - between(after, steps[1])) / (2 * eps))
    Phi = np.array(columns).T
    P = np.diag(np.linspace(0.5, 2.0, 15)) + 0.1
    spread = compiled_navigation(begin._replace(P=P), now, h, quiet)[0].P
    np.testing.assert_allclose(spread, Phi @ P @ Phi.T, atol=2e-5)  # the rest: second order in h


def rows_at(b: NavigationBelief, now: Heard) -> tuple[np.ndarray, np.ndarray]:
    y, H, r = np.full(7, np.nan), np.zeros((7, 15)), np.zeros(7)
    attitude_rows(now, b.attitude, MOUNTED, y, H, r)
    velocity_rows(now, b.velocity, b.attitude, b.rate, b.gyro_bias, MOUNTED, y, H, r)
    depth_row(now, b.position, b.attitude, MOUNTED, y, H, r)
    return y, H


def test_innovations_hang_on_the_errors_as_finite_differences_say() -> None:
    truth = sailed(1, seconds=2.0, places=PLACES)
    belief = navigate(truth.heard, truth.dt, MOUNTED).last
    w, x, y, z = wxyz(Rotation.from_quat([*belief.attitude[1:], belief.attitude[0]]) * PLACES["imu_turn"])
    now = Heard(w=w, x=x, y=y, z=z, velocity_x=0.3, velocity_y=-0.2, velocity_z=0.1, depth=5.0)
    _, H = rows_at(belief, now)
    eps, columns = 1e-5, []
    for e in eps * np.eye(15):
        columns.append((rows_at(displaced(belief, -e), now)[0] - rows_at(displaced(belief, e), now)[0]) / (2 * eps))
    np.testing.assert_allclose(H, np.array(columns).T, atol=1e-8)


def without(truth: SimpleNamespace, columns: slice, begin: float, end: float) -> np.ndarray:
    heard = truth.heard.copy()
    heard[round(begin / STEP) : round(end / STEP), columns] = np.nan
    return heard


def test_without_velocity_log_it_goes_on_degraded_says_so_and_recovers() -> None:
    truth = sailed(5, places=PLACES)
    found = navigate(without(truth, slice(10, 13), 10.0, 20.0), truth.dt, MOUNTED)
    assert navigation_level(found.status[900]) == Level.OK
    assert navigation_level(found.status[1500]) == Level.DEGRADED
    assert "no velocity log for too long" in navigation_reason(found.status[1500])
    assert navigation_level(found.status[2100]) == Level.OK
    error, deviation = np.abs(errors_of(truth, found)[:, 6:9]), found.deviations[:, 6:9]
    assert np.all(deviation[1900] > 2.0 * deviation[900]) and np.all(error[1000:2000] < 5.0 * deviation[1000:2000])
    assert np.all(error[2200:] < 0.05)


def test_without_depth_it_goes_on_degraded_and_without_any_velocity_log_it_does_not_run_away() -> None:
    truth = sailed(6, places=PLACES)
    found = navigate(without(truth, slice(13, 14), 5.0, 30.1), truth.dt, MOUNTED)
    assert "no depth for too long" in navigation_reason(found.status[-1])
    assert np.all(np.abs(errors_of(truth, found)[:, 2]) < 5.0 * found.deviations[:, 2] + 0.03)
    never = navigate(without(sailed(6, 120.0, PLACES), slice(10, 13), 0.0, 121.0), np.full(12001, STEP), MOUNTED)
    assert np.max(np.abs(never.velocity[:, :3])) < 1.5 and np.max(never.deviations[:, 6:9]) < 1.0


def test_without_attitude_the_gyro_carries_it_on() -> None:
    truth = sailed(7, places=PLACES)
    found = navigate(without(truth, slice(0, 4), 10.0, 20.0), truth.dt, MOUNTED)
    assert "no attitude for too long" in navigation_reason(found.status[1900])
    assert np.all(np.abs(errors_of(truth, found)[1000:2000, 3:6]) < 5.0 * found.deviations[1000:2000, 3:6])


def test_a_wild_reading_is_refused_and_one_that_lasts_is_believed_in_the_end() -> None:
    truth = sailed(8, places=PLACES)
    heard = truth.heard.copy()
    heard[1000, 10] += 1.0
    heard[1500:, 13] += 2.0
    found = navigate(heard, truth.dt, MOUNTED)
    assert found.status[1000] & NavigationStatus.GATED_VELOCITY
    assert "refused" in navigation_reason(found.status[1000])
    assert np.all(np.abs(errors_of(truth, found)[1000:1500, 6:9]) < 0.04)
    assert np.any(found.status[1500:] & NavigationStatus.REOPENED)
    assert errors_of(truth, found)[-1, 2] == pytest.approx(-2.0, abs=0.05)


def test_bad_periods_and_broken_beliefs_have_a_defined_answer() -> None:
    truth = sailed(9, seconds=1.0)
    settings = checked_navigation(NavigationSettings())
    belief = compiled_begin(Heard(*truth.heard[0].tolist()), settings)
    assert navigation_reason(belief.status) == "no step taken yet"
    for dt in (-1.0, np.nan, np.inf):
        after, _ = compiled_navigation(belief, Heard(*truth.heard[1].tolist()), dt, settings)
        assert after.status & NavigationStatus.BAD_PERIOD and navigation_level(after.status) == Level.INVALID
    broken = belief._replace(velocity=(np.nan, 0.0, 0.0))
    after, _ = compiled_navigation(broken, Heard(*truth.heard[1].tolist()), 0.01, settings)
    assert after.status & NavigationStatus.RESTARTED and np.isfinite(after.velocity).all()
    silent, _ = compiled_navigation(belief, Heard(), 0.01, settings)
    assert silent.status & NavigationStatus.NO_RATES and np.isfinite(silent.position).all()


def test_a_step_changes_no_belief_given_to_it() -> None:
    truth = sailed(10, seconds=1.0)
    settings = checked_navigation(NavigationSettings())
    belief = compiled_begin(Heard(*truth.heard[0].tolist()), settings)
    before = belief.P.copy()
    compiled_navigation(belief, Heard(*truth.heard[20].tolist()), 0.01, settings)
    np.testing.assert_array_equal(belief.P, before)


def test_the_covariance_of_the_output_is_that_of_displaced_beliefs() -> None:
    truth = sailed(11, seconds=2.0, places=PLACES)
    quiet = MOUNTED._replace(gyro_noise=0.0)
    belief = navigate(truth.heard, truth.dt, MOUNTED).last
    rng = np.random.default_rng(0)
    draws = 1e-3 * rng.standard_normal((4000, 15)) * np.linspace(1.0, 2.0, 15)
    out = compiled_output(belief._replace(P=np.diag((1e-3 * np.linspace(1.0, 2.0, 15)) ** 2)), quiet)
    others = [compiled_output(displaced(belief, e), quiet) for e in draws]
    motion = np.array([np.concatenate((o.position, o.velocity)) for o in others])
    expected = np.concatenate((np.diag(out.pose_covariance)[:3], np.diag(out.velocity_covariance)))
    np.testing.assert_allclose(motion.var(axis=0), expected, rtol=6 * np.sqrt(2 / 4000))


@pytest.mark.parametrize(
    ("values", "sentence"),
    [
        ({"gate": 0.0}, "gate: expected a finite number above 0; found 0.0"),
        ({"gyro_noise": -1.0}, "gyro_noise: expected a finite number above 0; found -1.0"),
        ({"imu_rotation": (1.0, 1.0, 0.0, 0.0)}, "imu_rotation: expected a unit quaternion"),
        ({"depth_position": (0.0, float("nan"), 0.0)}, "depth_position: expected finite numbers"),
    ],
)
def test_wrong_settings_are_refused(values: dict[str, object], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        checked_navigation(NavigationSettings(**values))  # type: ignore[arg-type]
