"""The attitude fit recovers a vehicle integrated by other code, in Euler angles, and says what it cannot tell."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from run_bag import Topic, write_run
from run_bag.importers.cli_pool import import_pool
from thruster_model.attitude_fit.fit import FitOptions, fit_attitude
from thruster_model.attitude_fit.model import DEFINITIONS, NAMES, centre, lagged, simulate
from thruster_model.attitude_fit.recording import Recording
from thruster_model.attitude_fit.recordings_io import read_recording
from thruster_model.attitude_fit.scores import shares
from thruster_model.attitude_fit.study import run_study
from thruster_model.attitude_fit.tables import markdown
from thruster_model.cli_attitude_fit import main
from thruster_model.equations.attitude import quaternion_from_euler
from thruster_model.errors import UnfitDataError
from thruster_model.force_table import ForceTable
from thruster_model.force_table_set import parameter_set_of
from thruster_model.parameter_set_io import load_parameter_set, write_parameter_set
from thruster_model.vehicle_layout import LayoutEntry
from thruster_model.vehicle_set_io import dump_vehicle_set, load_vehicle_set

DT = 0.01
X = np.array([2.5, 2.0, 1.2, 0.8, 1.0, 2.0, 2.2, 2.5, 1.5, 0.08, 0.1, 0.15, 0.2, -0.3, 0.1, 6.0, 5.0, 1.3, 0.8])
TRUTH = dict(zip(NAMES, X, strict=True))


def dive(name, seed, duration=25.0, axes=(1, 1, 1), noise=0.02):
    """Moments that jump every half second; equations and Euler angles written anew, integrated by scipy."""
    rng = np.random.default_rng(seed)
    count = round(duration / DT)
    moments = np.repeat(rng.choice([-3.0, 0.0, 3.0], (count // 50 + 1, 3)), 50, axis=0)[:count] * np.array(axes)
    v = TRUTH

    def rhs(t, y, u):
        p, q, r, l1, l2, l3, phi, theta = y[:8]
        I_y, I_z = v["inertia_pitch"], v["inertia_yaw"]
        dp = -v["damping_roll"] * p - v["quadratic_roll"] * p * abs(p) + v["effectiveness_roll"] * l1 + v["bias_roll"]
        dp += (I_y - I_z) * q * r - v["righting_roll"] * np.cos(theta) * np.sin(phi)
        dq = -v["damping_pitch"] * q - v["quadratic_pitch"] * q * abs(q) + v["effectiveness_pitch"] * l2
        dq += v["bias_pitch"] + (I_z - 1.0) * p * r / I_y - v["righting_pitch"] * np.sin(theta)
        dr = -v["damping_yaw"] * r - v["quadratic_yaw"] * r * abs(r) + v["effectiveness_yaw"] * l3 + v["bias_yaw"]
        dr += (1.0 - I_y) * p * q / I_z
        lags = [(m - x) / v[f"lag_{a}"] for m, x, a in zip(u, (l1, l2, l3), ("roll", "pitch", "yaw"), strict=True)]
        turn = q * np.sin(phi) + r * np.cos(phi)
        angles = [p + turn * np.tan(theta), q * np.cos(phi) - r * np.sin(phi), turn / np.cos(theta)]
        return [dp, dq, dr, *lags, *angles]

    state, states = np.array([0.1, 0.0, -0.1, 0.0, 0.0, 0.0, 0.2, -0.1, 0.5]), []
    for first in range(0, count, 50):
        t = DT * np.arange(51)
        found = solve_ivp(
            rhs, (0.0, t[-1]), state, t_eval=t, args=(moments[first],), rtol=1e-9, atol=1e-11, max_step=0.02
        )
        states.append(found.y[:, :-1].T)
        state = found.y[:, -1]
    y = np.concatenate(states)[:count]
    phi, theta = y[:, 6], y[:, 7]
    gravity = np.stack((-np.sin(theta), np.cos(theta) * np.sin(phi), np.cos(theta) * np.cos(phi)), axis=1)
    rates = y[:, :3] + rng.normal(0.0, noise, (count, 3))
    return Recording(name=name, dt=DT, rates=rates, gravity=gravity, moments=moments), y


@pytest.fixture(scope="module")
def dives():
    """Three dives, all axes pushed."""
    return [dive(f"dive {k}", k)[0] for k in range(3)]


def test_the_free_run_is_what_scipy_makes_in_euler_angles():
    recording, y = dive("clean", 5, noise=0.0)
    made = simulate(recording.rates, recording.gravity, recording.moments, DT, X)
    np.testing.assert_allclose(made, y[:, :3], atol=2e-6)


def test_the_lag_is_exact_for_moments_that_are_held():
    moments = np.array([[1.0, 2.0, 3.0], [0.0, 2.0, -3.0]])
    tau = lagged(moments, 0.1, X)
    assert tau[1] == pytest.approx(moments[0] * (1.0 - np.exp(-0.1 / X[9:12])))
    assert tau[2, 0] == pytest.approx(tau[1, 0] * np.exp(-0.1 / X[9]))


def test_a_fit_that_starts_wrong_recovers_the_vehicle_within_its_stated_deviations(dives):
    found = fit_attitude(dives)
    scores = (found.values - X) / found.deviations
    assert np.sum(np.isfinite(scores)) >= 17
    assert np.nanmax(np.abs(scores)) < 4.5, dict(zip(NAMES, scores, strict=True))
    for name in ("effectiveness_roll", "effectiveness_yaw", "righting_roll", "lag_yaw", "inertia_pitch"):
        assert found.values[NAMES.index(name)] == pytest.approx(TRUTH[name], rel=0.08), name


def test_a_dive_left_out_is_predicted_as_well_as_the_noise_allows(dives):
    study = run_study(dives[:2], FitOptions(), 1, only_predicted=dives[2:])
    assert [fit.recordings for fit in study.held] == [("dive 1",), ("dive 0",), ("dive 0", "dive 1")]
    assert (len(study.fitted), len(study.predicted), len(study.matrix)) == (2, 3, 2)
    share = study.predicted[2]
    assert np.all(share.value > 0.98)
    assert np.all((share.low <= share.value) & (share.value <= share.high + 1e-9))
    assert "| dive 2 | roll |" in markdown(study)
    assert "| – |" in next(line for line in markdown(study).splitlines() if line.startswith("| dive 2 | roll"))


def test_an_axis_that_nothing_pushed_is_not_claimed():
    found = fit_attitude([dive("yaw only", 7, axes=(0, 0, 1))[0]])
    deviations = dict(zip(NAMES, found.deviations, strict=True))
    assert np.isnan(deviations["effectiveness_roll"])
    assert np.isnan(deviations["lag_pitch"])


def test_the_mean_explains_nothing_and_the_measurement_all():
    recording, _ = dive("clean", 5, duration=8.0, noise=0.0)
    still = X.copy()
    still[6:9] = 0.0
    share = shares(recording, X, piece=None, rng=np.random.default_rng(1))
    assert share.value == pytest.approx([1.0, 1.0, 1.0], abs=1e-9)
    assert np.all(shares(recording, still, piece=None, rng=np.random.default_rng(1)).value < 0.6)


def test_recordings_shorter_than_a_piece_are_refused():
    with pytest.raises(UnfitDataError, match=r"longer than a piece of 2 s; found short \(1.0 s\)"):
        fit_attitude([dive("short", 1, duration=1.0)[0]])


def test_the_start_lies_within_the_bounds_and_names_are_unique():
    assert all(d.lower <= d.centre <= d.upper for d in DEFINITIONS)
    assert len(set(NAMES)) == len(NAMES) == centre().size


def test_a_run_s_throttles_become_moments_by_the_table_and_k_t(tmp_path: Path):
    thruster = load_parameter_set("force_table")
    at = 10**9 + np.arange(200) * 10_000_000
    half = np.full(200, np.sqrt(0.5))
    fields = {
        "pose.pose.orientation.w": half,
        "pose.pose.orientation.x": half,
        "twist.twist.angular.z": 0.001 * at / 1e7,
    }
    for name in (
        "pose.pose.orientation.y",
        "pose.pose.orientation.z",
        "twist.twist.angular.x",
        "twist.twist.angular.y",
    ):
        fields[name] = np.zeros(200)
    push = {"commanded": np.array([2.5])}
    write_run(
        tmp_path / "run",
        [
            Topic(name="rov/odometry", type="nav_msgs/Odometry", stamps=at, fields=fields),
            Topic(name="thruster_0/throttle", type="thruster_msgs/Throttle", stamps=[at[0] + 500_000_000], fields=push),
        ],
    )
    K_t = np.array([[1.0], [0.0], [0.0], [0.0], [0.0], [-0.1]])
    found = read_recording(tmp_path / "run", thruster, K_t)
    assert found.gravity[0] == pytest.approx([0.0, 1.0, 0.0])  # rolled by 90 degrees to starboard
    assert found.moments[49, 2] == 0.0
    assert found.moments[60, 2] == pytest.approx(-0.1 * float(thruster.force_table.force_at(1700.0, 14.0)))
    assert found.pushed == (False, False, True)
    with pytest.raises(UnfitDataError, match=r"expected the channels thruster_1/throttle\.commanded"):
        read_recording(tmp_path / "run", thruster, np.zeros((6, 2)))
    with pytest.raises(UnfitDataError, match="expected a parameter set of the model 'force_table'; found model 'hl'"):
        read_recording(tmp_path / "run", load_parameter_set("hl"), K_t)


def run_of(recording, folder):
    """The dive as a run with one thruster for each axis, whose table has the moments as forces."""
    at = 10**9 + np.round(recording.time * 1e9).astype(np.int64)
    g, yaw = recording.gravity, np.zeros(recording.time.size)
    pitch, roll = np.arcsin(-g[:, 0]), np.arctan2(g[:, 1], g[:, 2])
    w, x, y, z = quaternion_from_euler((roll, pitch, yaw))
    fields = {f"pose.pose.orientation.{name}": value for name, value in zip("wxyz", (w, x, y, z), strict=True)}
    fields |= {f"twist.twist.angular.{axis}": recording.rates[:, k] for k, axis in enumerate("xyz")}
    topics = [Topic(name="rov/odometry", type="nav_msgs/Odometry", stamps=at, fields=fields)]
    for k in range(3):
        throttle = {"commanded": recording.moments[:, k]}
        topics.append(Topic(name=f"thruster_{k}/throttle", type="thruster_msgs/Throttle", stamps=at, fields=throttle))
    return write_run(folder / recording.name.replace(" ", "_"), topics)


LAYOUT = [([0, 1, 0], [0, 0, 1]), ([0, 0, 1], [1, 0, 0]), ([1, 0, 0], [0, 1, 0])]  # 1 N: roll, pitch, yaw by 1 N m


def vehicle_file(folder):
    """A vehicle whose thrusters turn it about one axis each; its hull does not matter here."""
    vehicle = load_vehicle_set("bluerov2_heavy")
    layout = tuple(
        LayoutEntry(name=f"T{k + 1}", position=tuple(map(float, p)), axis=tuple(map(float, a)))
        for k, (p, a) in enumerate(LAYOUT)
    )
    path = folder / "vehicle.yaml"
    path.write_text(dump_vehicle_set(replace(vehicle, layout=layout, effects=())), "utf-8")
    return path


def test_the_command_fits_predicts_and_writes_what_it_found(dives, tmp_path, capsys):
    linear = ForceTable(
        command=[-5.0, 0.0, 5.0], command_unit="V", stop=0.0, supply=[12.0], force=[[-5.0, 0.0, 5.0]], source="by hand"
    )
    write_parameter_set(parameter_set_of(linear), tmp_path / "thruster.yaml")
    runs = [str(run_of(each, tmp_path)) for each in dives]
    given = ["--vehicle", str(vehicle_file(tmp_path)), "--thruster", str(tmp_path / "thruster.yaml")]
    out = tmp_path / "fit"
    assert main([*runs[:2], "--validate", runs[2], *given, "--out", str(out)]) == 0
    told = capsys.readouterr().out
    assert told.startswith((out / "tables.md").read_text("utf-8"))
    found = json.loads((out / "attitude_fit.json").read_text("utf-8"))
    assert found["together"]["effectiveness_yaw"]["value"] == pytest.approx(1.5, rel=0.08)
    assert min(found["shares"]["left_out"]["dive_2"][axis][0] for axis in ("roll", "pitch", "yaw")) > 0.97
    assert "left_out" in found and "dive_2" not in found["shares"]["together"]
    assert "free runs explain this share" in (out / "report.html").read_text("utf-8")
    assert main([*runs[:1], *given, "--out", str(out)]) == 1
    assert "exists and is not overwritten" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--vehicle", "submarine"], "expected a YAML file or one of the known vehicles"),
        (["--thruster", "hq"], "expected a parameter set of the model 'force_table'; found model 'hq'"),
        (["--piece", "0"], "--piece: expected a time from 0.1 to 1000 s; found 0"),
    ],
)
def test_what_it_cannot_use_is_refused_with_a_sentence_and_nothing_is_written(tmp_path, capsys, more, said):
    still = Recording(name="a", dt=DT, rates=np.zeros((99, 3)), gravity=np.eye(3)[[2] * 99], moments=np.zeros((99, 3)))
    run = run_of(still, tmp_path)
    given = ["--vehicle", str(vehicle_file(tmp_path)), "--thruster", "force_table", *more]
    assert main([str(run), *given, "--out", str(tmp_path / "fit")]) == 1
    assert said in capsys.readouterr().err
    assert not (tmp_path / "fit").exists()


def test_the_pool_vehicle_s_k_t_is_that_of_its_drawing():
    moments = load_vehicle_set("pool_rov").configuration[3:]
    drawn = [[0.11, -0.11, 0, 0, 0, 0.11], [0.19, 0.19, 0, 0, -0.17, 0], [0, 0, 0.11, -0.11, 0, 0]]
    np.testing.assert_allclose(moments, drawn, atol=1e-12)


def test_one_yaw_recording_of_a_real_vehicle_predicts_the_other(pool_data, tmp_path):
    table = np.loadtxt(pool_data / "measuredthrust_T200.txt", skiprows=2)
    curve = ForceTable(
        command=table[:, 1], command_unit="1", stop=0.0, supply=[12.0], force=[table[:, 0]], source="the pool's"
    )
    thruster, configuration = parameter_set_of(curve), load_vehicle_set("pool_rov").configuration
    recordings = []
    for name in ("yaw_1", "yaw_2"):
        (file,) = pool_data.glob(f"{name}_*.npz")
        import_pool(file, tmp_path / name)
        recordings.append(read_recording(tmp_path / name, thruster, configuration))
    for fitted, other in (recordings, recordings[::-1]):
        share = shares(other, fit_attitude([fitted]).values, piece=None, rng=np.random.default_rng(1))
        assert share.value[2] > 0.9
