"""What gravity and a gyro say of an attitude that comes at times of its own: its unit, its sign, the gyro's unit."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from run_bag import read_run
from run_bag.importers.cli_recording import main
from run_bag.importers.turning import heading_ratio, turning_ratio

FAST, SLOW = 0.02 * np.arange(3000), 0.013 + 0.07 * np.arange(855)
"""[s] Times of the IMU and of the attitude: none is in both."""
GYRO, ATTITUDE = "rov/imu.angular_velocity", "rov/imu.orientation"
FACTORS = {"rad/s": 1.0, "deg/s": np.pi / 180, "mrad/s": 1e-3, "rpm": np.pi / 30, "rad": 1.0, "deg": np.pi / 180}
FACTORS |= {"cdeg": np.pi / 18000, "mrad": 1e-3}


def angles(time):
    """Return roll, pitch, yaw [rad] of a vehicle that turns, and passes north."""
    return np.column_stack((0.2 * np.sin(1.1 * time), 0.25 * np.cos(0.7 * time), 3.0 + 0.6 * np.sin(0.4 * time)))


def body(time):
    return Rotation.from_euler("ZYX", angles(time)[:, ::-1])


def rates(time, step=1e-4):
    return (body(time - step).inv() * body(time + step)).as_rotvec() / (2 * step)


def tables(tmp_path, *, gyro="deg/s", attitude="deg", force=None, names="roll,pitch,yaw"):
    """Write files of an IMU and of an attitude, in units that they do not state; force: that of the IMU [m/s^2]."""
    draw = np.random.default_rng(7)
    force = (
        body(FAST).inv().apply([0.0, 0.0, -9.81]) + draw.normal(0.0, 0.1, (FAST.size, 3)) if force is None else force
    )
    imu = np.column_stack((FAST, (rates(FAST) + draw.normal(0.0, 0.005, force.shape)) / FACTORS[gyro], force))
    np.savetxt(tmp_path / "imu.csv", imu, "%.8g", ",", header="t,gx,gy,gz,ax,ay,az", comments="")
    told = angles(SLOW)
    told[:, 2] = (told[:, 2] + np.pi) % (2 * np.pi) - np.pi
    rows = np.column_stack((SLOW, told / FACTORS[attitude]))
    np.savetxt(tmp_path / "attitude.csv", rows, "%.8g", ",", header=f"t,{names}", comments="")
    return [str(tmp_path / name) for name in ("imu.csv", "attitude.csv")]


def told_by(tmp_path, capsys, files, *, gyro="deg/s", attitude="deg", changed=""):
    """Return the warnings of an import by a map that says these units; changed: keys of the roll and the pitch."""
    lines = ["time: {column: t, unit: s}"]
    lines += [f"{GYRO}.{a}: {{column: g{a}, unit: {gyro}}}" for a in "xyz"]
    lines += [f"rov/imu.linear_acceleration.{a}: {{column: a{a}, unit: m/s^2}}" for a in "xyz"]
    lines += [f"{ATTITUDE}.{a}: {{column: {a}, unit: {attitude}{changed}}}" for a in ("roll", "pitch")]
    lines += [f"{ATTITUDE}.yaw: {{column: yaw, unit: {attitude}}}"]
    (tmp_path / "map.yaml").write_text("\n".join(lines))
    assert main([*files, "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 0
    return [line for line in capsys.readouterr().err.splitlines() if "rov/" in line]


def test_sensors_that_agree_are_not_warned_of(tmp_path, capsys):
    assert told_by(tmp_path, capsys, tables(tmp_path)) == []


@pytest.mark.parametrize(
    ("true", "said", "changed", "sentences"),
    [
        ("cdeg", "deg", "", ["orientation.roll: up to 1146 degrees: expected -180 to 180", "orientation.pitch: up to",
                             "specific force disagree about where down is"]),
        ("rad", "mrad", "", ["roll moves 0.001", "pitch moves 0.001"]),
        ("cdeg", "mrad", "", ["specific force disagree about where down is"]),
        ("deg", "deg", ", sign: -1", ["roll and specific force tilt opposite ways (correlation -1.00)", "pitch and"]),
    ],
)  # fmt: skip
def test_an_attitude_in_another_unit_or_sign_is_found_at_times_of_its_own(
    tmp_path, capsys, true, said, changed, sentences
):
    told = told_by(tmp_path, capsys, tables(tmp_path, attitude=true), attitude=said, changed=changed)
    assert len(told) == len(sentences), told
    assert all(sentence in line for line, sentence in zip(told, sentences, strict=True)), told


@pytest.mark.parametrize(
    ("true", "said", "sentence"),
    [
        ("mrad/s", "deg/s", "turns 17.5 times as fast as the attitude of rov/imu does, as mrad/s read as deg/s would"),
        ("deg/s", "rad/s", "turns 57.3 times as fast as the attitude of rov/imu does, as deg/s read as rad/s would"),
        ("rad/s", "deg/s", "turns 0.0175 times as fast as the attitude of rov/imu does, as rad/s read as deg/s would"),
    ],
)
def test_a_gyro_in_another_unit_is_found_by_the_attitude_and_the_factor_named(tmp_path, capsys, true, said, sentence):
    told = told_by(tmp_path, capsys, tables(tmp_path, gyro=true), gyro=said)
    assert sum(sentence in line for line in told) == 1
    assert all(sentence in line or "up to" in line for line in told)


def test_a_gyro_beside_an_attitude_that_does_not_turn_is_not_judged():
    time, draw = 0.02 * np.arange(3000), np.random.default_rng(1)
    q = Rotation.from_rotvec(draw.normal(0.0, 0.01, (time.size, 3))).as_quat()[:, [3, 0, 1, 2]]
    assert turning_ratio((time, draw.normal(0.0, 0.5, (time.size, 3))), (time, q)) is None
    assert turning_ratio((time[:10], q[:10, 1:]), (time[:10], q[:10])) is None


def test_turns_are_compared_past_north_and_past_gaps_of_either_sensor():
    q = body(SLOW).as_quat()[:, [3, 0, 1, 2]]
    q *= np.where(np.sin(3.0 * SLOW) < 0.0, -1.0, 1.0)[:, None]  # q and -q are one attitude
    kept = (FAST < 20.0) | (FAST > 25.0)
    assert turning_ratio((FAST[kept], 6.0 * rates(FAST)[kept]), (SLOW, q)) == pytest.approx(6.0, rel=0.02)


@pytest.mark.parametrize(
    ("yaw", "factor", "sentence"),
    [
        ({"unit": "rad"}, 1.0, "yaw turns 57.3 times as fast as the gyro does, as deg read as rad would: expected 1"),
        ({"unit": "deg"}, np.pi / 180, "yaw turns 0.0175 times as fast as the gyro does, as rad read as deg would"),
        ({"unit": "deg"}, 100.0, "yaw turns 100 times as fast as the gyro does, as cdeg read as deg would"),
        ({"unit": "deg", "sign": -1}, 1.0, "yaw turns the other way than the gyro: expected one way; is its `sign`"),
        ({"unit": "deg"}, 1.0, ""),
    ],
)
def test_a_yaw_in_another_unit_or_sign_is_found_by_the_gyro_beside_right_roll_and_pitch(
    tmp_path, capsys, yaw, factor, sentence
):
    imu, attitude = tables(tmp_path)
    rows = np.loadtxt(attitude, delimiter=",", skiprows=1)
    rows[:, 3] *= factor
    np.savetxt(attitude, rows, "%.8g", ",", header="t,roll,pitch,yaw", comments="")
    keys = ", ".join(f"{key}: {value}" for key, value in yaw.items())
    lines = ["time: {column: t, unit: s}", f"{ATTITUDE}.yaw: {{column: yaw, {keys}}}"]
    lines += [f"{GYRO}.{a}: {{column: g{a}, unit: deg/s}}" for a in "xyz"]
    lines += [f"rov/imu.linear_acceleration.{a}: {{column: a{a}, unit: m/s^2}}" for a in "xyz"]
    lines += [f"{ATTITUDE}.{a}: {{column: {a}, unit: deg}}" for a in ("roll", "pitch")]
    (tmp_path / "map.yaml").write_text("\n".join(lines))
    assert main([imu, attitude, "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 0
    told = [line for line in capsys.readouterr().err.splitlines() if "rov/" in line]
    assert len(told) == bool(sentence) and all(sentence in line for line in told), told


def test_a_heading_that_does_not_turn_or_a_gyro_about_another_axis_tells_no_unit():
    draw, others = np.random.default_rng(3), [-1.0, 0.0175, 57.3]
    q = body(FAST).as_quat()[:, [3, 0, 1, 2]]
    assert heading_ratio((FAST, rates(FAST)), (FAST, q), others) is None
    assert heading_ratio((FAST, rates(FAST)[:, [0, 2, 1]]), (FAST, q), others) is None
    still = Rotation.from_rotvec(draw.normal(0.0, 0.01, (FAST.size, 3))).as_quat()[:, [3, 0, 1, 2]]
    assert heading_ratio((FAST, rates(FAST)), (FAST, still), others) is None
    assert heading_ratio((FAST[:10], rates(FAST)[:10]), (FAST, q), others) is None


def test_an_attitude_that_never_changes_while_the_gyro_turns_is_warned_of(tmp_path, capsys):
    imu, attitude = tables(tmp_path)
    rows = np.loadtxt(attitude, delimiter=",", skiprows=1)
    np.savetxt(attitude, rows * [1, 0, 0, 0], "%.8g", ",", header="t,roll,pitch,yaw", comments="")
    told = told_by(tmp_path, capsys, [imu, attitude])
    assert len(told) == 1 and "rov/imu.orientation: never changes while the gyro turns: nobody measured it" in told[0]
    rows = np.loadtxt(imu, delimiter=",", skiprows=1)
    rows[:, 1:4] = 0.1
    np.savetxt(imu, rows, "%.8g", ",", header="t,gx,gy,gz,ax,ay,az", comments="")
    (tmp_path / "still").mkdir()
    assert told_by(tmp_path / "still", capsys, [imu, attitude]) == [], "a vehicle on its stand"


def proposed(capsys, files):
    assert main([*files, "--guess"]) == 0
    return dict(re.findall(r"^([^#:\s]+): \{.*?unit: ([^,}]+)", capsys.readouterr().out, re.MULTILINE))


@pytest.mark.parametrize("attitude", ["rad", "deg", "mrad", "cdeg"])
@pytest.mark.parametrize("gyro", ["rad/s", "deg/s", "mrad/s", "rpm"])
def test_gravity_tells_an_attitude_s_unit_and_the_attitude_the_gyro_s(tmp_path, capsys, attitude, gyro):
    files = tables(tmp_path, attitude=attitude, gyro=gyro)
    units = proposed(capsys, files)
    assert {units[f"{ATTITUDE}.{angle}"] for angle in ("roll", "pitch", "yaw")} == {attitude}
    assert {units[f"{GYRO}.{a}"] for a in "xyz"} == {gyro}


def test_however_the_imu_is_mounted_gravity_tells_how_far_an_attitude_tilts(tmp_path, capsys):
    turned = Rotation.from_euler("ZYX", [40.0, 90.0, 15.0], degrees=True)
    force = turned.apply(body(FAST).inv().apply([0.0, 0.0, -9.81]))
    units = proposed(capsys, tables(tmp_path, attitude="cdeg", force=force))
    assert units[f"{ATTITUDE}.roll"] == "cdeg"
    assert units[f"{GYRO}.x"] == "deg/s", "of the vehicle, whose gyro is not turned here"


def test_an_attitude_and_a_gyro_in_units_that_nothing_tells_are_asked_about(tmp_path, capsys):
    files = tables(tmp_path, attitude="mrad", gyro="mrad/s", force=0.0 * rates(FAST))
    assert main([*files, "--guess"]) == 0
    text = capsys.readouterr().out
    assert text.count("write the unit: mrad or cdeg? nothing says which") == 3, "no vehicle tilts by 250 degrees"
    assert text.count("write the unit: deg/s or mrad/s? no other sensor says which") == 3


def test_small_angles_of_a_vehicle_that_heads_north_are_no_radians(tmp_path, capsys):
    calm = np.column_stack((SLOW, 3.0 * np.sin(SLOW), 2.0 * np.cos(SLOW), 8.0 * np.sin(0.3 * SLOW)))  # degrees
    np.savetxt(tmp_path / "a.csv", calm, "%.6g", ",", header="t,roll,pitch,yaw", comments="")
    (tmp_path / "b.csv").write_text("t,gx\n" + "\n".join(f"{t:.3f},{np.sin(t):.4f}" for t in SLOW))
    assert proposed(capsys, [str(tmp_path / "a.csv"), str(tmp_path / "b.csv")])[f"{ATTITUDE}.roll"] == "'?'"


def test_what_is_proposed_comes_out_as_it_was(tmp_path, capsys):
    files = tables(tmp_path, attitude="cdeg", gyro="mrad/s")
    assert main([*files, "--guess"]) == 0
    (tmp_path / "map.yaml").write_text(capsys.readouterr().out)
    assert main([*files, "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 0
    assert not [line for line in capsys.readouterr().err.splitlines() if "rov/imu" in line]
    told = read_run(tmp_path / "run")[f"{GYRO}.z"].values
    np.testing.assert_allclose(told[np.isfinite(told)], rates(FAST)[:, 2], atol=0.03)
