"""What is proposed for the names, units and values of a vehicle's tables."""

import re

import numpy as np

from run_bag import read_run
from run_bag.importers.cli_recording import main

TIME = 5.0 + 0.02 * np.arange(400)
WAVE = np.sin(TIME)
FORCE = {"ax": 0.5 * WAVE, "ay": 0.3 * WAVE, "az": -9.8 + 0 * WAVE}
GYRO = {f"g{a}": 40.0 * np.sin(TIME + k) for k, a in enumerate("xyz")}


def wide(path, columns):
    np.savetxt(path, np.column_stack(list(columns.values())), "%.6g", ",", header=",".join(columns), comments="")
    return path


def guessed(capsys, *files):
    """Return the entries that are proposed, by channel, and all that is printed."""
    assert main([*map(str, files), "--guess"]) == 0
    text = capsys.readouterr().out
    return dict(re.findall(r"^([^#:\s]+): (.*)", text, re.MULTILINE)), text


def imported(tmp_path, text, *files):
    (tmp_path / "map.yaml").write_text(text)
    assert main([*map(str, files), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 0
    return read_run(tmp_path / "run")


def test_dotted_names_of_a_long_table_with_units_are_a_vehicle_s(tmp_path, capsys):
    angles = {"roll": 10 * WAVE, "pitch": 5 * WAVE, "yaw": 170 * WAVE}
    readings = [(f"thr{k}.cmd", "V", 2.0 * np.sin(TIME + k)) for k in range(3)] + [("depth", "m", 5.0 + WAVE)]
    readings += [(f"imu.{name}", "deg/s", values) for name, values in GYRO.items()]
    readings += [(f"imu.{name}", "m/s^2", values) for name, values in FORCE.items()]
    readings += [(f"att.{name}", "deg", values) for name, values in angles.items()]
    rows = [f"{t:.3f},{name},{v[k]:.6g},{unit}" for k, t in enumerate(TIME) for name, unit, v in readings]
    (tmp_path / "x.csv").write_text("\n".join(["time,signal,value,unit", *rows]))
    found, text = guessed(capsys, tmp_path / "x.csv")
    assert "Not recognised" not in text and "'?'" not in text
    for k in range(3):
        assert f"thr{k}.cmd [V]" in found[f"thruster_{k}/throttle.commanded"]
    assert "depth [m]" in found["rov/depth.depth"]
    assert "imu.gz [deg/s]" in found["rov/imu.angular_velocity.z"]
    assert "imu.ax [m/s^2]" in found["rov/imu.linear_acceleration.x"]
    assert "att.roll [deg]" in found["rov/imu.orientation.roll"], "only a log's own ATT.Roll is an autopilot's"
    run = imported(tmp_path, text, tmp_path / "x.csv")
    np.testing.assert_allclose(run["rov/imu.angular_velocity.x"].values, np.radians(GYRO["gx"]), rtol=1e-4, atol=1e-6)


def test_a_number_before_or_behind_the_dot_is_the_thruster_s(tmp_path, capsys):
    columns = {f"thr{k}.n [rpm]": 900 * WAVE for k in (1, 2)} | {f"cmd.u{k}": 2 * WAVE for k in (1, 2)}
    found, _ = guessed(capsys, wide(tmp_path / "x.csv", {"t": TIME, **columns}))
    for k in (1, 2):
        assert f"'thr{k}.n [rpm]'" in found[f"thruster_{k - 1}/state.n"]
        assert f"cmd.u{k}" in found[f"thruster_{k - 1}/throttle.commanded"]
