"""What is proposed, and said, of times that have nothing to do with each other, and of rows of several instances."""

import numpy as np
import pytest
from map_import import attempted, imported, proposal, proposed, wide
from turning_vehicle import TIME

WAVE = np.sin(TIME)
PULSES = np.round(1500 + 300 * WAVE)


def loggers(tmp_path, *starts):
    """Write a file for each channel of a bench, with times from a start of its own [s]."""
    columns = {"pwm_us": PULSES, "motor_rpm": 900 * WAVE, "thrust_N": 9 * WAVE}
    names = ("stamp_s", "clock_s", "sec")
    named = zip(starts, columns.items(), names, strict=False)
    made = [(tmp_path / f"{name}.csv", {time: at + TIME, name: values}) for at, (name, values), time in named]
    for path, table in made:
        rows = zip(*table.values(), strict=True)
        path.write_text(",".join(table) + "\n" + "\n".join(f"{t:.4f},{v:.6g}" for t, v in rows))
    return [path for path, _ in made]


def test_a_proposal_says_which_loggers_share_no_time_and_that_an_offset_does(tmp_path, capsys):
    text = proposal(capsys, *loggers(tmp_path, 1.7e9, 5.0, 1.7e9 + 1.0))
    assert "# No common clock: motor_rpm.csv (clock_s: 5.000 to " in text and "time_offset" in text
    assert "s); pwm_us.csv (stamp_s: 1700000000.000 to" in text and "thrust_N.csv (sec: 1700000001.000" in text
    assert "No common clock" not in proposal(capsys, *loggers(tmp_path, 1.7e9, 1.7e9, 1.7e9 + 1.0))


def test_an_import_names_all_files_whose_times_are_apart_and_the_offset_that_brings_them_together(tmp_path, capsys):
    files = loggers(tmp_path, 1.7e9, 5.0, 500.0)
    text = "thruster_0/throttle.commanded: {column: pwm_us, unit: us, stop: 1500, per_volt: 80, time_column: stamp_s}\n"
    text += "thruster_0/state.n: {column: motor_rpm, unit: rpm, time_column: clock_s}\n"
    text += "thruster_0/load.wrench.force.x: {column: thrust_N, unit: N, time_column: sec}\n"
    assert attempted(tmp_path, text, *files) == 1
    told = capsys.readouterr().err
    assert "s of motor_rpm.csv, " in told and "time_offset" in told
    assert "apart from all others are pwm_us.csv, motor_rpm.csv, thrust_N.csv" in told


def test_a_signal_whose_times_are_not_the_throttle_s_is_warned_of_with_what_brings_them_together(tmp_path, capsys):
    files = loggers(tmp_path, 1.7e9, 5.0, 6.0)
    files.append(exact(tmp_path / "amps.csv", {"at": 1.7e9 + TIME, "amps": WAVE}))
    text = "thruster_0/throttle.commanded: {column: pwm_us, unit: us, stop: 1500, per_volt: 80, time_column: stamp_s}\n"
    text += "thruster_0/flow.axial: {column: motor_rpm, unit: mm/s, time_column: clock_s}\n"
    text += "thruster_0/load.wrench.force.x: {column: thrust_N, unit: N, time_column: sec}\n"
    text += "thruster_0/state.current: {column: amps, unit: A, time_column: at}\n"
    assert attempted(tmp_path, text, *files) == 0
    told = [line for line in capsys.readouterr().err.splitlines() if "stamps on one clock" in line]
    assert len(told) == 2 and all("`time_offset` of its entry brings its times to the throttle's" in e for e in told)


def test_messages_own_times_go_before_those_of_their_arrival(tmp_path, capsys):
    at = 1.7e9 + TIME
    imu = {"timestamp": at, "time_boot_ms": 1e3 * TIME} | {f"{a}gyro": np.round(400 * WAVE) for a in "xyz"}
    servo = {
        "timestamp": at,
        "time_usec": 1e6 * TIME,
        "servo1_raw": PULSES,
        "servo2_raw": PULSES,
        "servo3_raw": 0 * TIME,
    }
    files = [
        exact(tmp_path / "SCALED_IMU2.csv", imu | {f"{a}acc": 1e3 * (a == "z") + WAVE for a in "xyz"}),
        exact(tmp_path / "SERVO_OUTPUT_RAW.csv", servo),
        exact(tmp_path / "dvl.csv", {"boot_s": TIME, "v_fwd": WAVE, "v_stb": WAVE, "v_down": WAVE}),
    ]
    found, text = proposed(capsys, *files)
    assert found["time"].startswith("{column: time_boot_ms, unit: ms}") and "No common clock" not in text
    assert "time_column: time_usec, time_unit: us" in found["thruster_1/throttle.commanded"]
    assert "thruster_2/throttle.commanded" not in found and "# servo3_raw always 0" in text, "MAVLink's unused output"


def exact(path, columns):
    """Write a csv without loss."""
    rows = zip(*columns.values(), strict=True)
    path.write_text(",".join(columns) + "\n" + "\n".join(",".join(f"{v:.10g}" for v in row) for row in rows))
    return path


def test_a_column_that_numbers_instances_tells_their_rows_apart_and_is_no_current(tmp_path, capsys):
    times, number = np.repeat(1e6 * TIME, 2), np.tile([0.0, 1.0], TIME.size)
    depth = 4 + 0.1 * np.repeat(WAVE, 2)
    columns = {"TimeUS": times, "I": number, "Alt": np.where(number == 1, -depth, 0.1), "Temp": 20 - 9 * number}
    baro = exact(tmp_path / "BARO.csv", columns)
    rcou = exact(tmp_path / "RCOU.csv", {"TimeUS": 1e6 * TIME, "C1": PULSES, "C2": PULSES})
    found, text = proposed(capsys, baro, rcou)
    assert found["rov/depth.depth"].startswith("{column: Alt, unit: m, sign: -1, where: {I: 1}}")
    assert "state.current" not in text and text.count("# Temp") == 1
    run = imported(tmp_path, text, baro, rcou)
    np.testing.assert_allclose(run["rov/depth.depth"].values, depth[1::2], rtol=1e-6)


def test_electrical_turns_are_brought_to_the_rotor_s_by_a_scale_that_is_asked_for(tmp_path, capsys):
    table = wide(tmp_path / "x.csv", {"t": TIME, "pwm": PULSES, "eRPM": 9000 * WAVE})
    found, text = proposed(capsys, table)
    assert found["thruster_0/state.n"].startswith("{column: eRPM, unit: rpm, scale: '?'}")
    assert "1 / pole pairs" in found["thruster_0/state.n"]
    assert attempted(tmp_path, text, table) == 1
    assert (
        "thruster_0/state.n: scale is still '?': expected a number, of an eRPM 1 / pole pairs"
        in capsys.readouterr().err
    )


@pytest.mark.parametrize("name", ["rpm", "motor_rpm", "esc_rpm"])
def test_turns_of_a_rotor_need_no_scale(tmp_path, capsys, name):
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", {"t": TIME, "pwm": PULSES, name: 900 * WAVE}))
    assert "scale" not in found["thruster_0/state.n"]


def test_no_line_of_a_common_time_is_proposed_where_all_entries_have_their_own(tmp_path, capsys):
    columns = {"t_what": TIME, "what": WAVE, "t_cmd": TIME, "cmd_us": PULSES, "t_n": TIME, "n_rpm": 900 * WAVE}
    found, _ = proposed(capsys, wide(tmp_path / "x.csv", columns))
    assert "time" not in found and "time_column: t_cmd" in found["thruster_0/throttle.commanded"]
