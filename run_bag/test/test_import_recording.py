"""Any recording: tables, bags of every storage, ROS 1, logs of vehicles, by one map."""

import re
import subprocess
import sys
import time

import numpy as np
import pytest
from foreign_recordings import (
    COUNT,
    autopilot_log,
    ros1_bag,
    ros2_bag,
    speed_rpm,
    table,
    telemetry_log,
    throttle_us,
)
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from run_bag import read_run
from run_bag.cli_info import main as info
from run_bag.importers.cli_recording import main
from run_bag.importers.csv_source import CsvSource

VOLTS = [(throttle_us(k) - 1500.0) / 80.0 for k in range(COUNT)]
SPEED = [speed_rpm(k) * 2.0 * np.pi / 60.0 for k in range(COUNT)]
COMMAND = "unit: us, stop: 1500, per_volt: 80, hold: previous"


def imported(tmp_path, file, text):
    (tmp_path / "map.yaml").write_text(text)
    assert main([str(file), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 0
    return read_run(tmp_path / "run")


def fields(command, speed):
    return f"thruster_0/throttle.commanded: {{{command}, {COMMAND}}}\nthruster_0/state.n: {{{speed}, unit: rpm}}\n"


RECORDINGS = {
    "ros1": (lambda p: ros1_bag(p / "x.bag"), "field: /motor/pwm.data", "field: motor/state.vector.x"),
    "mcap": (lambda p: ros2_bag(p / "x", StoragePlugin.MCAP), "field: motor/pwm.data", "field: motor/rpm.data"),
    "sqlite3": (lambda p: ros2_bag(p / "x", StoragePlugin.SQLITE3), "field: motor/pwm.data", "field: motor/rpm.data"),
    "sqlite3 in a file": (
        lambda p: ros2_bag(p / "x", StoragePlugin.SQLITE3, CompressionMode.FILE),
        "field: motor/pwm.data",
        "field: motor/rpm.data",
    ),
    "mcap by messages": (
        lambda p: ros2_bag(p / "x", StoragePlugin.MCAP, CompressionMode.MESSAGE),
        "field: motor/pwm.data",
        "field: motor/rpm.data",
    ),
    "sqlite3 by messages": (
        lambda p: ros2_bag(p / "x", StoragePlugin.SQLITE3, CompressionMode.MESSAGE),
        "field: motor/pwm.data",
        "field: motor/rpm.data",
    ),
    "BIN": (lambda p: autopilot_log(p / "0042.BIN"), "field: RCOU.C1", "field: 'ESC[0].RPM'"),
    "csv": (lambda p: table(p / "x.csv"), "column: PWM (us)", "column: rpm"),
    "csv with semicolons": (lambda p: table(p / "x.csv", separator=";"), "column: PWM (us)", "column: 3"),
    "csv with decimal commas": (
        lambda p: table(p / "x.csv", separator=";", comma=True),
        "column: PWM (us)",
        "column: rpm",
    ),
}


@pytest.mark.parametrize("kind", RECORDINGS)
def test_one_form_of_map_takes_every_kind_of_recording(tmp_path, kind):
    write, command, speed = RECORDINGS[kind]
    clock = "time: {column: 'time [ms]', unit: ms}\n" if kind.startswith("csv") else ""
    run = imported(tmp_path, write(tmp_path), clock + fields(command, speed))
    np.testing.assert_allclose(run["thruster_0/throttle.commanded"].values, VOLTS)
    np.testing.assert_allclose(run["thruster_0/state.n"].values, SPEED, rtol=1e-6)
    np.testing.assert_allclose(run.time("thruster_0/state.n"), 0.04 * np.arange(COUNT), atol=1e-6)
    assert run.start == 10**9
    assert run.metadata["hold"] == {"throttle": "previous"}


def test_the_instance_of_a_message_may_be_left_out_where_the_log_has_one_alone(tmp_path, capsys):
    log = autopilot_log(tmp_path / "x.BIN")
    text = fields("field: RCOU.C1", "field: ESC.RPM")
    (tmp_path / "map.yaml").write_text(text)
    given = ["--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "refused")]
    assert main([str(log), *given]) == 1
    assert "expected field 'ESC.RPM', found" in capsys.readouterr().err, "which of two?"
    alone = autopilot_log(tmp_path / "y.BIN", escs=1)
    run = imported(tmp_path, alone, text.replace("unit: rpm", "unit: rps"))
    np.testing.assert_allclose(run["thruster_0/state.n"].values, 60.0 * np.array(SPEED), rtol=1e-6)
    assert "field 'ESC.RPM' is in rpm, as the recording states; the map says rps" in capsys.readouterr().err


def test_all_that_a_recording_lacks_is_named_at_once(tmp_path, capsys):
    log = autopilot_log(tmp_path / "x.BIN")
    text = fields("field: RCOU.C9", "field: 'ESC[0].RPM'") + "rov/battery.voltage: {field: BAT.Vcc, unit: V}\n"
    (tmp_path / "map.yaml").write_text(text)
    assert main([str(log), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 1
    first, second = capsys.readouterr().err.splitlines()
    assert first == f"{log}: thruster_0/throttle.commanded: expected field 'RCOU.C9'"
    assert second.startswith(f"{log}: rov/battery.voltage: expected field 'BAT.Vcc', found UNIT.Id, ")


def test_a_log_s_speed_with_a_sign_is_not_proposed_as_one_without(tmp_path, capsys):
    assert main([str(autopilot_log(tmp_path / "x.BIN")), "--guess"]) == 0
    text = capsys.readouterr().out
    assert "thruster_0/state.n: {field: 'ESC[0].RPM', unit: rpm}" in text and "thruster_0/state.sign_source" not in text


def test_a_ground_station_s_log_tells_senders_apart(tmp_path):
    log = telemetry_log(tmp_path / "x.tlog")
    text = fields("field: SERVO_OUTPUT_RAW.servo1_raw", "field: 'ESC_TELEMETRY_1_TO_4.rpm[0]'")
    text += "thruster_0/state.sign_source: {value: 0}\nthruster_0/state.supply_voltage: "
    text += "{field: 'ESC_TELEMETRY_1_TO_4.voltage[0]', unit: cV}"
    run = imported(tmp_path, log, text)
    np.testing.assert_allclose(run["thruster_0/throttle.commanded"].values, VOLTS)
    np.testing.assert_allclose(run["thruster_0/state.n"].values, np.abs(SPEED), rtol=1e-6)
    np.testing.assert_allclose(run["thruster_0/state.supply_voltage"].values, 15.5)


@pytest.mark.parametrize("kind", [k for k in RECORDINGS if "sqlite3" in k or k in ("ros1", "mcap by messages")])
def test_bags_of_other_storages_are_read_as_runs(tmp_path, kind, capsys):
    bag = RECORDINGS[kind][0](tmp_path)
    run = read_run(bag)
    np.testing.assert_allclose(run["motor/pwm.data"].values, [throttle_us(k) for k in range(COUNT)])
    assert info([str(bag)]) == 0
    assert "/motor/pwm  std_msgs/msg/Float64  50" in capsys.readouterr().out


def test_sign_scale_and_offset_act_before_the_unit(tmp_path):
    text = "time: {column: 'time [ms]', unit: ms}\n"
    text += "thruster_0/load.wrench.force.x: {column: 'Thrust [kgf]', unit: kgf, sign: -1, scale: 2, offset: 1}"
    run = imported(tmp_path, table(tmp_path / "x.csv"), text)
    expected = -(2.0 * np.round(np.sin(np.arange(COUNT)), 4) + 1.0) * 9.80665
    np.testing.assert_allclose(run["thruster_0/load.wrench.force.x"].values, expected, atol=1e-9)
    decisions = {d["what"]: d["how"] for d in run.metadata["import"]["decisions"]}
    assert decisions["thruster_0/load.wrench.force.x"].endswith("value = -2 * cell + -1 in kgf, brought to N")


@pytest.mark.parametrize(
    ("unit", "volts"),
    [
        ("us, stop: 1500, per_volt: 80", "value = 1 * cell + 0 in us, brought to (value - 1500) / 80 V"),
        ("'%', stop: 0, per_volt: 20, sign: -1", "value = -1 * cell + 0 in %, brought to (value - 0) / 20 V"),
        ("mV", "value = 1 * cell + 0 in mV, brought to V"),
    ],
)
def test_info_tells_how_commands_became_volts(tmp_path, unit, volts, capsys):
    (tmp_path / "x.csv").write_text("t,u\n0,1500\n1,1600\n2,1700\n")
    imported(
        tmp_path, tmp_path / "x.csv", f"time: {{column: t}}\nthruster_0/throttle.commanded: {{column: u, unit: {unit}}}"
    )
    capsys.readouterr()
    assert info([str(tmp_path / "run")]) == 0
    assert volts in capsys.readouterr().out


@pytest.mark.parametrize("cell", ["nan", "NaN", "NAN", "-nan", "", " "])
def test_nan_in_any_case_is_not_measured(tmp_path, cell):
    (tmp_path / "x.csv").write_text(f"t,n\n0,1\n1,{cell}\n2,3\n")
    run = imported(tmp_path, tmp_path / "x.csv", "time: {column: t}\nthruster_0/state.n: {column: n, unit: rad/s}")
    np.testing.assert_array_equal(run["thruster_0/state.n"].values, [1, np.nan, 3])


def test_two_files_of_one_clock_become_one_run(tmp_path):
    (tmp_path / "a.csv").write_text("t,u\n10,0\n11,1\n12,2\n")
    (tmp_path / "b.csv").write_text("t,n\n10.5,3\n11.5,4\n")
    (tmp_path / "map.yaml").write_text(
        "time: {column: t}\nthruster_0/throttle.commanded: {column: u, unit: V}\n"
        "thruster_0/state.n: {column: n, unit: rad/s}"
    )
    files = [str(tmp_path / "a.csv"), str(tmp_path / "b.csv")]
    assert main([*files, "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 0
    run = read_run(tmp_path / "run")
    assert run["thruster_0/state.n"].stamps.tolist() == [1_500_000_000, 2_500_000_000]
    (tmp_path / "b.csv").write_text("t,u\n0,1\n")
    assert main([*files, "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "other")]) == 1


def test_a_million_rows_take_three_seconds_of_a_processor(tmp_path):
    rows = 1_000_000
    values = np.column_stack([np.arange(rows) * 1e-3, np.sin(np.arange(rows)), np.cos(np.arange(rows))])
    np.savetxt(tmp_path / "x.csv", values, fmt="%.6f", delimiter=",", header="t,u,n", comments="")
    begin = time.process_time()
    table = CsvSource(tmp_path / "x.csv")
    read = [table.numbers(i) for i in range(3)]
    assert time.process_time() - begin < 3.0
    np.testing.assert_allclose(np.column_stack(read), values, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "sentences"),
    [
        ("thruster_0/state.n: {column: 3, unit: rpm}", ["no throttle: `fit` and `diagnose` refuse"]),
        (
            fields("column: 2", "column: 3").replace(", hold: previous", ""),
            ["nothing says what it does in the 0.04 s between two samples: a fit holds it, a diagnosis tries straight"],
        ),
        ("thruster_0/state.n: {column: 3, unit: rad/s}", ["rad/s: no thruster's; is `unit` that of the recording?"]),
        (
            fields("column: 2", "column: 3, sign: -1"),
            ["runs against the throttle", "say `sign: -1` here", "wired the wrong way round, leave both as they are"],
        ),
        (
            fields("column: 2", "column: 3") + "\nthruster_0/flow.ambient: {column: 2, unit: mm/s}",
            ["no negative reading while the throttle is negative", "in a stream that the thruster does not turn"],
        ),
        (
            "thruster_0/throttle.commanded: {column: 2, unit: V}",
            ["up to 1660 V: full command is 5 V", "nothing that a model", "does not begin at zero"],
        ),
        (fields("column: 2", "column: 3").replace("per_volt: 80", "per_volt: 8"), ["are `unit` and `per_volt` right?"]),
        ("rov/depth.depth: {column: 3, unit: cm}", ["no thruster_<i>/... topic is in it"]),
    ],
)  # fmt: skip
def test_what_a_diagnosis_would_refuse_is_said_at_once(tmp_path, capsys, text, sentences):
    imported(tmp_path, table(tmp_path / "x.csv"), "time: {column: 1, unit: ms}\n" + text)
    told = capsys.readouterr().err
    assert all(s in told for s in sentences)


@pytest.mark.parametrize(("period", "told"), [(0.002, False), (0.01, True)])
def test_a_hold_is_asked_for_where_it_makes_a_difference_to_a_diagnosis(tmp_path, capsys, period, told):
    rows = [f"{period * k:.3f},{max(u, 0.0):.3f},{90 * u:.2f}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["t,u,n", *rows]))
    channels = "thruster_0/throttle.commanded: {column: u, unit: V}\nthruster_0/state.n: {column: n, unit: rad/s}"
    imported(tmp_path, tmp_path / "x.csv", "time: {column: t, unit: s}\n" + channels)
    assert (f"nothing says what it does in the {period:g} s" in capsys.readouterr().err) is told


def test_how_far_a_clock_may_be_off_is_in_the_run(tmp_path):
    channels = (
        "thruster_0/throttle.commanded: {column: 2, unit: V, clock_deviation: 0.02}\n"
        "thruster_0/flow.axial: {column: 3, unit: m/s, clock_deviation: 0.1}\n"
        "thruster_0/flow.ambient: {column: 3, unit: m/s, clock_deviation: 0.05}"
    )
    run = imported(tmp_path, table(tmp_path / "x.csv"), "time: {column: 1, unit: s}\n" + channels)
    assert run.metadata["clock_deviation"] == {"throttle": 0.02, "flow": 0.1}


def test_a_vehicle_s_thruster_needs_no_readings_of_its_own(tmp_path, capsys):
    channels = (
        "thruster_0/throttle.commanded: {column: 2, unit: mV, hold: previous}\nrov/depth.depth: {column: 3, unit: cm}"
    )
    imported(tmp_path, table(tmp_path / "x.csv"), "time: {column: 1, unit: ms}\n" + channels)
    assert "nothing that a model" not in capsys.readouterr().err


def test_rates_and_gaps_are_told(tmp_path, capsys):
    times = [*np.arange(0, 2, 0.02), *np.arange(5, 7, 0.02)]
    rows = [f"{t:.2f},{np.sin(t) if t > 0.5 else 0.0:.5f},{np.sin(t):.3f}" for t in times]
    (tmp_path / "x.csv").write_text("t,u,n\n" + "\n".join(rows) + "\n")
    (tmp_path / "y.csv").write_text("t2,f\n" + "".join(f"{t},{t * t}\n" for t in range(7)))
    (tmp_path / "map.yaml").write_text(
        "thruster_0/throttle.commanded: {column: u, time_column: t, unit: V, hold: linear}\n"
        "thruster_0/load.wrench.force.x: {column: f, time_column: t2, unit: N}"
    )
    files = [str(tmp_path / "x.csv"), str(tmp_path / "y.csv")]
    assert main([*files, "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 0
    told = capsys.readouterr().err
    assert "gaps without samples: 3.0 s from 2.0 s on" in told
    assert "7 samples: expected at least 20" in told
    assert read_run(tmp_path / "run").metadata["hold"] == {"throttle": "linear"}


@pytest.mark.parametrize(
    ("channel", "source", "warned"),
    [("state.n", "0", False), ("state.n", "1", True), ("load.wrench.force.x", None, True)],
)
def test_readings_without_a_sign_are_doubted_unless_that_is_stated(tmp_path, capsys, channel, source, warned):
    rows = [f"{k / 50:.2f},{3 * u:.3f},{abs(90 * u):.2f}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["t,u,y", *rows]))
    unit = "rad/s" if source else "N"
    (tmp_path / "map.yaml").write_text(
        "time: {column: t, unit: s}\nthruster_0/throttle.commanded: {column: u, unit: V, hold: previous}\n"
        f"thruster_0/{channel}: {{column: y, unit: {unit}}}\n"
        + (f"thruster_0/state.sign_source: {{value: {source}}}\n" if source else "")
    )
    given = [str(tmp_path / "x.csv"), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]
    assert main(given) == 0
    assert ("while the throttle is negative" in capsys.readouterr().err) is warned


@pytest.mark.parametrize(("hold", "gap"), [("previous", False), ("linear", True)])
def test_commands_that_are_written_as_they_change_have_no_gaps_where_they_are_held(tmp_path, capsys, hold, gap):
    times = [
        0.0,
        *np.arange(2.0, 6.0, 0.02),
        9.0,
        9.0 + 1.5,
    ]  # rest, a chirp, rest again, and a row that closes the log
    u = [0.0, *np.sin(np.arange(200)), 0.0, 0.0]
    (tmp_path / "u.csv").write_text("t,u\n" + "".join(f"{a:.2f},{b:.5f}\n" for a, b in zip(times, u, strict=True)))
    (tmp_path / "n.csv").write_text("t2,n\n" + "".join(f"{0.02 * k:.2f},{np.sin(k):.4f}\n" for k in range(525)))
    (tmp_path / "map.yaml").write_text(
        f"thruster_0/throttle.commanded: {{column: u, time_column: t, unit: V, hold: {hold}}}\n"
        "thruster_0/state.n: {column: n, time_column: t2, unit: rad/s}"
    )
    files = [str(tmp_path / "u.csv"), str(tmp_path / "n.csv")]
    assert main([*files, "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 0
    assert ("gaps without samples: 2.0 s from 0.0 s on" in capsys.readouterr().err) is gap


@pytest.mark.parametrize("kind", ["csv", "csv with decimal commas", "BIN", "tlog", "ros1"])
def test_a_guessed_map_is_read_back_and_imports(tmp_path, capsys, kind):
    file = telemetry_log(tmp_path / "x.tlog") if kind == "tlog" else RECORDINGS[kind][0](tmp_path)
    assert main([str(file), "--guess"]) == 0
    text = capsys.readouterr().out
    run = imported(tmp_path, file, text)
    np.testing.assert_allclose(run["thruster_0/throttle.commanded"].values, VOLTS)
    if kind != "ros1":
        np.testing.assert_allclose(np.abs(run["thruster_0/state.n"].values), np.abs(SPEED), rtol=1e-6)
    assert ("load.wrench.force.x" in text) == kind.startswith("csv")


def test_words_within_names_and_units_in_brackets_suggest_too(tmp_path, capsys):
    (tmp_path / "x.csv").write_text(
        "Zeit [ms];Welle rpm;ESC pwm_us;motor current;Zug (kgf)\n0;900;1500;1;0,5\n1;900;1500;1;0,5\n"
    )
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    text = capsys.readouterr().out
    assert "time: {column: 'Zeit [ms]', unit: ms}" in text
    assert "thruster_0/state.n: {column: Welle rpm, unit: rpm}" in text
    assert (
        "thruster_0/throttle.commanded: {column: ESC pwm_us, unit: us, stop: 1500, per_volt: 80, hold: previous}"
        in text
    )
    assert "thruster_0/state.current: {column: motor current, unit: A}" in text
    assert (
        "load.wrench.force.x: {column: 'Zug (kgf)', unit: kgf}   # always 0.5 kgf, 2 samples; by its unit alone" in text
    )


SWEEP = np.sin(np.arange(0.0, 12.0, 0.02))


def guessed(tmp_path, capsys, header, values, times=None):
    """Return the entry that is proposed for the second column, and what is said beside it."""
    times = np.arange(values.size) * 0.02 if times is None else times
    rows = "".join(f"{t!r},{v!r}\n" for t, v in zip(times.tolist(), values.tolist(), strict=True))
    (tmp_path / "x.csv").write_text(f"{header}\n{rows}")
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    return capsys.readouterr()


def test_a_unit_is_that_of_the_name_the_header_or_the_values_and_else_asked_about(tmp_path, capsys):
    asked = "'?'"
    slow, fast = 300.0 * SWEEP, 3000.0 * SWEEP
    for header, values, unit in [
        # what 300 may be: rad/s or rpm
        ("rpm", slow, "rpm"), ("RPM", slow, "rpm"), ("n_rpm", slow, "rpm"), ("n_RPM", slow, "rpm"),
        ("motorRPM", slow, "rpm"),
        ("MotorRPM", slow, "rpm"), ("rpm1", slow, "rpm"), ("motor_rpm_1", slow, "rpm"), ("krpm", SWEEP, "krpm"),
        ("n [rpm]", slow, "rpm"), ("n (rpm)", slow, "rpm"), ("n [U/min]", slow, "rpm"),
        ("n [1/min]", slow, "'1/min'"),
        ("Speed (rev/min)", slow, "rev/min"), ("n [rad/s]", slow, "rad/s"), ("speed_rad_s", slow, "rad/s"),
        ("n", slow, asked), ("speed", slow, asked), ("n [furlong]", slow, asked), ("n", fast, asked),
        ("speed", 3 * fast, asked),
        # forces, torques and milli-units
        ("thrust", 30 * SWEEP, asked), ("thrust_N", 30 * SWEEP, "N"), ("thrust_kgf", SWEEP, "kgf"),
        ("thrust_kg", SWEEP, "kgf"),
        ("Thrust [gf]", fast, "gf"), ("thrust_g", fast, "gf"), ("force_mN", fast, "mN"), ("load", fast, asked),
        ("torque", SWEEP, asked), ("torque_mNm", fast, "mN m"), ("Torque (Nm)", SWEEP, "Nm"),
        ("Torque [N.m]", SWEEP, "N m"), ("torque [N mm]", fast, "N mm"), ("Thrust [g]", fast, "g"),
        ("n [rad s^-1]", slow, "rad/s"), ("n [rad·s⁻¹]", slow, "rad/s"), ("n [min⁻¹]", slow, "rpm"),
        ("battery", 16000 + slow, asked), ("battery", 48000 + slow, "mV"),
        ("VOLT", 1600 + SWEEP, "cV"), ("voltage_mV", fast, "mV"), ("voltage", 16 + SWEEP, "V"),
        ("current", fast, asked), ("current", 20 * fast, "mA"),
        ("current_ma", SWEEP, "mA"), ("current", 3 + SWEEP, "A"), ("flow", SWEEP, "m/s"),
        ("flow_cm_s", SWEEP, "cm/s"),
        ("flow", slow, asked), ("flow", 9 * SWEEP, asked), ("flow", 20 * SWEEP, "cm/s"),
        # commands
        ("pwm", 1500 + slow, "us"), ("cmd", 1500 + slow, "us"), ("pwm", 128 + 100 * SWEEP, asked),
        ("throttle", SWEEP, "'1'"),
        ("throttle", 90 * SWEEP, asked), ("esc_percent", 90 * SWEEP, "'%'"), ("u", 3 * SWEEP, "V"),
        ("u_mV", fast, "mV"),
    ]:  # fmt: skip
        told = guessed(tmp_path, capsys, f"time,{header}", values)
        entry = re.search(r"^thruster_0/\S+: \{column: .*?, unit: ([^,}]*)", told.out, re.MULTILINE)
        assert entry is not None, f"{header}: nothing proposed:\n{told.out}"
        assert entry[1] == unit, header
        assert ("write the unit: " in told.out) == (unit == asked)
        assert told.err == (
            "note: units to be written by you, where neither name nor values tell: 1\n" * (unit == asked)
        )


def test_the_unit_of_a_time_is_that_of_its_name_or_its_steps_and_else_asked_about(tmp_path, capsys):
    at = np.arange(SWEEP.size) * 0.02
    name, values, asked = "unit by its name", "unit by its values", "write the unit: "
    for header, times, unit, whence in [
        ("t", at, "s", values), ("t", 1e3 * at, "ms", values), ("t", 1e6 * at, "us", values),
        ("t", 1e9 * at, "ns", values), ("t", 1.7e12 + 1e3 * at, "ms", values),
        ("time_ms", at, "ms", name), ("t_ms", at, "ms", name), ("t_s", 100 * at, "s", name),
        ("time [ms]", at, "ms", ""), ("time_s", 100 * at, "s", name), ("t", 50 * at, "'?'", asked),
        ("timestamp", 5e4 * at, "'?'", asked), ("stamp", 1.7e9 + 50 * at, "s", values),
    ]:  # fmt: skip
        told = guessed(tmp_path, capsys, f"{header},rpm", 300 * SWEEP, times)
        found = re.search(r"^time: \{column: .*, unit: (.*?)\}(.*)", told.out, re.MULTILINE)
        assert found[1] == unit, (header, times[1])
        assert found[2].startswith(f"   # {whence}") if whence else found[2] == "", (header, times[1])


def test_a_line_of_units_below_the_names_is_read(tmp_path, capsys):
    rows = "".join(f"{20 * k},{300 * value!r},{value!r}\n" for k, value in enumerate(SWEEP.tolist()))
    (tmp_path / "x.csv").write_text("t,n,thrust\n[ms],[rpm],kgf\n" + rows)
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    text = capsys.readouterr().out
    assert "time: {column: t, unit: ms}" in text
    run = imported(tmp_path, tmp_path / "x.csv", text)
    np.testing.assert_allclose(run["thruster_0/state.n"].values, 300 * SWEEP * 2 * np.pi / 60, rtol=1e-6)
    np.testing.assert_allclose(run["thruster_0/load.wrench.force.x"].values, 9.80665 * SWEEP, rtol=1e-6)
    # names in two lines are no units
    (tmp_path / "x.csv").write_text("t,n\nfront,left\n0,1\n")
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    assert "no numbers" in capsys.readouterr().out


def test_what_is_asked_about_is_refused_until_it_is_written(tmp_path, capsys):
    text = guessed(tmp_path, capsys, "t,n", 300.0 * SWEEP, np.arange(SWEEP.size) * 1.0).out
    (tmp_path / "map.yaml").write_text(text)
    arguments = [str(tmp_path / "x.csv"), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]
    assert main(arguments) == 1
    told = capsys.readouterr().err
    assert "time: unit is still '?': expected that of the recording, which nothing in it tells: one of s, ms" in told
    assert "thruster_0/state.n: unit is still '?': expected that of the recording" in told
    assert "rad/s, rpm" in told
    assert not (tmp_path / "run").exists()
    (tmp_path / "map.yaml").write_text(
        text.replace("t, unit: '?'", "t, unit: s").replace("n, unit: '?'", "n, unit: rpm")
    )
    assert main(arguments) == 0


def test_of_several_times_of_a_map_a_file_has_the_first_that_it_has_and_an_entry_may_have_its_own(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("t_cmd,u,t_slow,v\n10,0,9.5,0\n11,1,10.5,0\n12,2,11.5,0\n")
    (tmp_path / "b.csv").write_text("ms,n\n10500,3\n11500,4\n")
    state = "thruster_0/state.n: {column: n, unit: rad/s}"
    told = (
        "time: [{column: t_cmd}, {column: ms, unit: ms}]\nthruster_0/throttle.commanded: {column: u, unit: V}\n"
        "thruster_0/flow.axial: {column: v, unit: m/s, time_column: t_slow}\n"
    )
    files = [str(tmp_path / "a.csv"), str(tmp_path / "b.csv"), "--map", str(tmp_path / "map.yaml"), "--out"]
    (tmp_path / "map.yaml").write_text(told + state)
    assert main([*files, str(tmp_path / "run")]) == 0
    run = read_run(tmp_path / "run")
    assert run["thruster_0/throttle.commanded"].stamps.tolist() == [1_500_000_000, 2_500_000_000, 3_500_000_000]
    assert run["thruster_0/state.n"].stamps.tolist() == [2_000_000_000, 3_000_000_000]
    assert run["thruster_0/flow.axial"].stamps.tolist() == [1_000_000_000, 2_000_000_000, 3_000_000_000]
    capsys.readouterr()
    (tmp_path / "map.yaml").write_text(told + state.replace("}", ", time_unit: us}"))
    assert main([*files, str(tmp_path / "other")]) == 1
    assert "time_unit: expected beside time_column, as `time` has several" in capsys.readouterr().err
    (tmp_path / "map.yaml").write_text(told.replace("column: ms", "column: us") + state)
    assert main([*files, str(tmp_path / "third")]) == 1
    assert "its time: expected column 't_cmd', found ms, n" in capsys.readouterr().err


def test_files_on_clocks_of_their_own_are_refused(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("t,u\n10,0\n11,1\n12,2\n")
    (tmp_path / "b.csv").write_text("t,n\n100010,5\n100011,6\n100012,7\n")
    channels = ["throttle.commanded: {column: u, unit: V}", "state.n: {column: n, unit: rad/s}"]
    told = "\n".join(["time: {column: t, unit: s}", *(f"thruster_0/{channel}" for channel in channels)])
    (tmp_path / "map.yaml").write_text(told)
    files = [str(tmp_path / "a.csv"), str(tmp_path / "b.csv")]
    assert main([*files, "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 1
    expected = (
        "a.csv: expected times on the clock of the other files, 100010.000 to 100012.000 s; found 10.000 to 12.000 s"
    )
    assert expected in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_columns_whose_names_no_rule_knows_are_guessed_by_their_units(tmp_path, capsys):
    rows = [f"{10 * (k - k % 2)},{u:g},{300 * u:g},{4 * u:g}" for k, u in enumerate(SWEEP)]  # two rows have one stamp
    (tmp_path / "x.csv").write_text("\n".join(["Zeit (ms),Stellung (%),Welle (rpm),Zug (N)", *rows]))
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    text = capsys.readouterr().out
    assert "time: {column: 'Zeit (ms)', unit: ms}" in text and "Not recognised" not in text
    for channel, unit in (("throttle.commanded", "'%'"), ("state.n", "rpm"), ("load.wrench.force.x", "N")):
        (line,) = (line for line in text.splitlines() if line.startswith(f"thruster_0/{channel}"))
        assert f"unit: {unit}" in line and "by its unit alone: is it?" in line


def test_two_columns_of_one_unit_without_a_known_name_are_left_to_the_reader(tmp_path, capsys):
    rows = [f"{0.01 * k},{u:g},{u:g}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["t,Druck (N),Zug (N)", *rows]))
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    assert "wrench" not in capsys.readouterr().out


@pytest.mark.parametrize(("first", "second"), [("t u", "t n"), ("cmd_ms", "enc_ms")])
def test_each_sensor_of_a_table_may_have_a_time_of_its_own(tmp_path, capsys, first, second):
    rows = [f"{20 * k},{u:g},{20 * k + 4},{60 * u:g}" for k, u in enumerate(SWEEP)]
    rows += [f"{20 * k},0,," for k in range(len(rows), len(rows) + 50)]  # the shorter columns end in empty cells
    (tmp_path / "x.csv").write_text("\n".join([f"{first},u_V,{second},omega (rad/s)", *rows]))
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    text = capsys.readouterr().out
    assert f"time: {{column: {first}, unit: ms}}" in text and "Not recognised" not in text
    entry = next(line for line in text.splitlines() if line.startswith("thruster_0/state.n"))
    assert f"time_column: {second}, time_unit: ms" in entry
    run = imported(tmp_path, tmp_path / "x.csv", text)
    assert run.time("thruster_0/state.n")[[0, -1]] == pytest.approx([0.004, 0.02 * SWEEP.size - 0.016])


@pytest.mark.parametrize(
    ("time", "own"),
    [("time: {column: t u, unit: ms}\n", ""), ("", ", time_column: t u, time_unit: ms"), ("", ", time_column: t u")],
)
def test_a_time_of_its_own_has_the_unit_of_time_where_it_states_none(tmp_path, time, own):
    rows = [f"{20 * k},{u:g},{20 * k + 4},{60 * u:g}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["t u,u,t n,n", *rows]))
    throttle = f"thruster_0/throttle.commanded: {{column: u, unit: V{own}}}\n"
    unit = ", time_unit: ms" if own.endswith("ms") else ""
    speed = f"thruster_0/state.n: {{column: n, unit: rad/s, time_column: t n{unit}}}"
    run = imported(tmp_path, tmp_path / "x.csv", time + throttle + speed)
    seconds = 0.02 if "ms" in time + own else 20.0
    assert run.time("thruster_0/state.n")[-1] == pytest.approx(seconds * (SWEEP.size - 0.8))


@pytest.mark.parametrize("own", ["time_unit: ms", "time_scale: 0.001"])
def test_an_entry_may_count_the_time_column_of_all_in_another_unit(tmp_path, own):
    (tmp_path / "a.csv").write_text("t,u\n0,1\n0.5,2\n2,3\n")
    (tmp_path / "b.csv").write_text("t,n\n500,10\n1500,20\n")
    (tmp_path / "map.yaml").write_text(
        "time: {column: t, unit: s}\nthruster_0/throttle.commanded: {column: u, unit: V, hold: previous}\n"
        f"thruster_0/state.n: {{column: n, unit: rad/s, {own}}}"
    )
    given = [str(tmp_path / "a.csv"), str(tmp_path / "b.csv"), "--map", str(tmp_path / "map.yaml")]
    assert main([*given, "--out", str(tmp_path / "run")]) == 0
    run = read_run(tmp_path / "run")
    assert run.time("thruster_0/throttle.commanded").tolist() == [0.0, 0.5, 2.0]
    assert run.time("thruster_0/state.n").tolist() == [0.5, 1.5]


def test_a_reader_that_has_enough_is_no_error():
    program = "import sys; from run_bag.command_line import exit_status as e; sys.exit(e('p', lambda: print('x') or 0))"
    told = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    told.stdout.close()
    assert told.stderr.read() == b"" and told.wait() == 141


def test_names_with_a_number_inside_are_thrusters_and_units_at_their_end_tell_what_they_are(tmp_path, capsys):
    names = [f"{kind}{i}{end}" for kind, end in (("M", "_cmd [%]"), ("esc", "_rpm")) for i in (1, 2, 3)]
    rows = [",".join(f"{30 * np.sin(k / 9 + j):.3f}" for j in range(9)) for k in range(60)]
    header = ",".join(["t_ms", *names, "gx_dps", "gy_dps", "gz_dps"])
    (tmp_path / "dive.csv").write_text("\n".join([header, *(f"{20 * k},{row}" for k, row in enumerate(rows))]))
    assert main([str(tmp_path / "dive.csv"), "--guess"]) == 0
    text = capsys.readouterr().out
    for i in range(3):
        assert f"thruster_{i}/throttle.commanded: {{column: 'M{i + 1}_cmd [%]', unit: '%'" in text
        assert f"thruster_{i}/state.n: {{column: esc{i + 1}_rpm, unit: rpm}}" in text
    assert "rov/imu.angular_velocity.x: {column: gx_dps" in text and "Not recognised" not in text
    bench = [f"{k / 50:.2f},{3 * u:.3f},{90 * u:.2f},{9 * u:.3f},{u:.3f}" for k, u in enumerate(SWEEP)]
    (tmp_path / "bench.csv").write_text("\n".join(["t_s,Stellwert_pct,Drehzahl_rpm,Schub_N,U_mps", *bench]))
    assert main([str(tmp_path / "bench.csv"), "--guess"]) == 0
    text = capsys.readouterr().out
    assert "throttle.commanded: {column: Stellwert_pct" in text and "force.x: {column: Schub_N, unit: N}" in text
    assert "# U_mps" in text, "a speed is no command"


def test_a_first_column_that_rises_is_proposed_as_the_time_whatever_it_is_called(tmp_path, capsys):
    rows = [f"{0.01 * k},{300 * u:g}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["Zeit_s,rpm", *rows]))
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    text = capsys.readouterr().out
    assert "time: {column: Zeit_s, unit: s}   # unit by its name; its values rise: is it the time?" in text
    assert "Not recognised" not in text


def test_a_pulse_s_scale_is_marked_as_a_guess(tmp_path, capsys):
    text = guessed(tmp_path, capsys, "t,pwm_us", 1500.0 + 400.0 * SWEEP).out
    (line,) = (line for line in text.splitlines() if "throttle.commanded" in line)
    assert "stop: 1500, per_volt: 80" in line and "stop and per_volt are guesses: write yours" in line


@pytest.mark.parametrize("header", ["t,u_V", "t,pwm_us"])
def test_a_hold_that_no_recording_tells_is_marked_as_a_guess(tmp_path, capsys, header):
    text = guessed(tmp_path, capsys, header, 1500.0 + 400.0 * SWEEP).out
    (line,) = (line for line in text.splitlines() if "throttle.commanded" in line)
    assert "hold: previous" in line and "hold is a guess: previous or linear?" in line


def long_table(path, header, line, order=lambda row: row[0]):
    """Write a table with a row for each reading: throttles, speeds at half their rate, thrusts."""
    rows = [(0.01 * k, "throttle_V", "V", u) for k, u in enumerate(SWEEP)]
    rows += [(0.01 * k + 0.004, "motor_rpm", "rpm", 300.0 * u) for k, u in list(enumerate(SWEEP))[::2]]
    rows += [(0.01 * k, "thrust_N", "N", 4.0 * u) for k, u in enumerate(SWEEP)]
    path.write_text("\n".join([header, *(line(*row) for row in sorted(rows, key=order))]))


@pytest.mark.parametrize(
    ("header", "line", "order"),
    [
        ("time,signal,unit,value", lambda t, n, unit, v: f"{t:.3f},{n},{unit},{v:.6g}", lambda row: row[0]),
        (
            "Zeit;Kanal;Wert;Einheit",
            lambda t, n, unit, v: f"{t:.3f};{n};{v:.6g};{unit}".replace(".", ","),
            lambda row: row[0],
        ),
        ("name;value;t", lambda t, n, _, v: f'"{n}";{v:.6g};{t:.3f}'.replace(".", ","), lambda row: row[1]),
    ],
)
def test_a_long_table_becomes_the_run_of_a_wide_one(tmp_path, capsys, header, line, order):
    long_table(tmp_path / "x.csv", header, line, order)
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    told = capsys.readouterr().out
    assert "Not recognised" not in told and "?'" not in told
    (tmp_path / "map.yaml").write_text(told)
    given = [str(tmp_path / "x.csv"), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]
    assert main(given) == 0
    told = capsys.readouterr().out
    assert f"thruster_0/throttle: commanded: {SWEEP.size} readings" in told
    assert f"thruster_0/state: n: {SWEEP[::2].size} readings" in told
    run = read_run(tmp_path / "run")
    speed, thrust = run["thruster_0/state.n"], run["thruster_0/load.wrench.force.x"]
    np.testing.assert_allclose(speed.values, 300.0 * SWEEP[::2] * np.pi / 30.0, rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(thrust.values, 4.0 * SWEEP, rtol=1e-5, atol=1e-9)
    assert speed.stamps[0] - thrust.stamps[0] == 4_000_000


def test_a_long_table_s_wrong_cell_is_named_by_its_line_and_name(tmp_path, capsys):
    long_table(
        tmp_path / "x.csv", "t,sensor,v", lambda t, n, _, v: f"{t:.3f},{n},{v:.6g}" if t < 1.0 else f"{t:.3f},{n},x"
    )
    (tmp_path / "map.yaml").write_text("time: {column: t, unit: s}\nthruster_0/state.n: {column: motor_rpm, unit: rpm}")
    given = [str(tmp_path / "x.csv"), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]
    assert main(given) == 1
    assert "x.csv, line 254, value of 'motor_rpm': expected a finite number" in capsys.readouterr().err


def test_a_long_table_of_a_name_for_each_row_is_not_made_wide(tmp_path):
    rows = [f"{0.001 * k},s{k if k > 200 else k % 4},1" for k in range(20_000)]
    (tmp_path / "x.csv").write_text("\n".join(["t,name,value", *rows]))
    assert CsvSource(tmp_path / "x.csv").names() == ["t", "name", "value"]


@pytest.mark.parametrize(
    ("header", "line"),
    [("t,mode,throttle_V,rpm", "{t},manual,{u:g},{n:g}"), ("t,mode,throttle_V", "{t},manual,{u:g}")],
)
def test_a_table_with_a_column_of_modes_is_no_long_one(tmp_path, capsys, header, line):
    rows = [line.format(t=0.01 * k, u=u, n=300 * u) for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join([header, *rows]))
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    assert "thruster_0/throttle.commanded: {column: throttle_V" in capsys.readouterr().out


def test_a_column_called_t_is_no_time_where_its_unit_is_a_force(tmp_path, capsys):
    rows = [f"{0.01 * k},{u:g},{4 * u:g}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["clock,u,T", "s,V,N", *rows]))
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    text = capsys.readouterr().out
    assert "time: {column: clock, unit: s}" in text
    assert "thruster_0/load.wrench.force.x: {column: T, unit: N}" in text


@pytest.mark.parametrize("header", ["# bench 3\n# t in s\nt,n_rpm", "# bench 3\n# t,n_rpm"])
def test_comments_before_a_table_are_no_rows_and_the_last_one_may_name_the_columns(tmp_path, capsys, header):
    rows = [f"{0.01 * k},{300 * u:g}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join([header, *rows]))
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    text = capsys.readouterr().out
    assert "time: {column: t, unit: s}" in text
    assert f"thruster_0/state.n: {{column: n_rpm, unit: rpm}}   # -300 to 300, {SWEEP.size} samples" in text


def test_what_a_map_makes_the_same_in_all_messages_is_told_as_that_and_not_as_readings(tmp_path, capsys):
    state = "{column: 3, time_column: 1, unit: rpm}\nthruster_0/state.sign_source: {value: 1}"
    imported(tmp_path, table(tmp_path / "x.csv"), f"thruster_0/state.n: {state}")
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "thruster_0/state" in line]
    assert line.count("readings") == 1 and line.endswith("; sign_source: 1 in all of them")


def test_channels_of_our_own_runs_are_guessed_as_they_are(tmp_path, capsys):
    run = imported(tmp_path, table(tmp_path / "x.csv"), "thruster_0/state.n: {column: 3, time_column: 1, unit: rpm}")
    assert main([str(tmp_path / "run"), "--guess"]) == 0
    assert "thruster_0/state.n: {field: thruster_0/state.n, unit: rad/s}" in capsys.readouterr().out
    assert run.metadata["import"]["importer"] == "recording"


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("thruster_0/throttle.commanded: {column: 2, unit: us}", "'us' is no voltage: expected stop"),
        ("thruster_0/throttle.commanded: {column: 2, unit: V, stop: 3}", "stop: expected beside a voltage given in us"),
        ("thruster_0/state.n: {column: 2, field: x.y, unit: rpm}", "expected column (of a table) or field"),
        ("thruster_0/state.n: {field: x.y, unit: rpm}", "expected column, found field 'x.y'; it is a table"),
        ("thruster_0/state.n: {column: 2, unit: rpm, sign: 2}", "sign: expected 1 or -1, found 2"),
        (
            "thruster_0/state.n: {column: 2, unit: rpm, hold: next}",
            "hold: expected one of previous, linear, found 'next'",
        ),
        (
            "thruster_0/state.n: {column: 2, unit: rpm, clock_deviation: 0.1}",
            "clock_deviation: expected of topics throttle or flow alone",
        ),
        (
            "thruster_0/flow.axial: {column: 2, unit: m/s, clock_deviation: 0}",
            "clock_deviation: expected a positive number, found 0",
        ),
        ("thruster_0/state.n: {column: 2, unit: rpm, file: b.csv}", "expected file 'b.csv', found x.csv"),
        ("thruster_0/state.n: {column: 2, unit: rpm, time_unit: V}", "time_unit: expected a unit of time"),
        (
            "thruster_0/state.n: {field: x.y, unit: rpm, time_unit: ms}",
            "time_unit: expected beside column alone (a bag or log brings its times)",
        ),
        ("csv: {separator: x}\nthruster_0/state.n: {column: 2, unit: rpm}", "separator: expected one of"),
        ("thruster_0/state.n: {column: 2, unit: null}", "expected unit 'rad/s'"),
        ("thruster_0/state.n: {column: 1.5, unit: rpm}", "column: expected a name or a number from 1, found 1.5"),
        ("thruster_0/state.n: {column: &a [*a], unit: rpm}", "expected the value itself, found the alias"),
    ],
)
def test_a_wrong_map_is_refused_with_a_sentence_and_nothing_is_written(tmp_path, capsys, text, sentence):
    (tmp_path / "map.yaml").write_text("time: {column: 1, unit: ms}\n" + text)
    file = table(tmp_path / "x.csv")
    assert main([str(file), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 1
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_what_is_wrong_with_a_map_is_a_line_for_each_sentence_with_its_channels(tmp_path, capsys):
    throttles = [f"thruster_{k}/throttle.commanded: {{column: {k + 2}, unit: '%'}}" for k in range(3)]
    lines = ["time: {column: 1}", *throttles, "thruster_0/state.n: {column: 2}"]
    (tmp_path / "map.yaml").write_text("\n".join(lines))
    given = [str(table(tmp_path / "x.csv")), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]
    assert main(given) == 1
    first, second = capsys.readouterr().err.splitlines()
    names = ", ".join(f"thruster_{k}/throttle.commanded" for k in range(3))
    assert first.startswith(f"{tmp_path / 'map.yaml'}: {names}: '%' is no voltage: expected stop")
    assert second == f"{tmp_path / 'map.yaml'}: thruster_0/state.n: key 'unit' is missing"


@pytest.mark.parametrize(
    ("name", "content", "sentence"),
    [
        ("x.BIN", b"", "x.BIN: cannot be read as a log of a vehicle"),
        ("x.BIN", b"\xa3\x95\x80" * 400, "x.BIN:"),
        ("x.BIN", bytes(range(256)) * 50, "x.BIN:"),
        ("x.tlog", b"\xfd" * 5000, "x.tlog: expected messages of a vehicle's log with times, found none"),
        ("x.bag", b"#ROSBAG V2.0\n" + b"\xff" * 500, "x.bag: cannot be read"),
        ("x.bag", b"nothing", "x.bag: expected an MCAP file"),
        ("x.db3", b"SQLite format 3\0" + b"\xff" * 500, "ros2 bag convert -i"),
        ("x.csv", b"t,\0n\n0,1\n", "x.csv:"),
        ("x.csv", b"t;n\n0;1,5\n1;2.5\n", "line 3, column 2: expected a finite number"),
        ("x.csv", "t,n\n0,1\n".encode("utf-16"), "x.csv: cannot be read as csv"),
        ("csv.mat", b"MATLAB 5.0 MAT-file" + bytes(200), "found a MATLAB file: bring it to csv first (in MATLAB"),
        ("csv.mat", bytes(200), "found a MATLAB file: bring it to csv first (in MATLAB"),
        ("csv.xlsx", b"PK\x03\x04" + bytes(50), "found a packed file, such as a spreadsheet or npz"),
        ("x.csv", "t,n\n0,1\n".encode("utf-16"), "found text in UTF-16: bring it to csv first (an editor"),
    ],
)
def test_a_broken_recording_is_refused_with_its_name(tmp_path, capsys, name, content, sentence):
    (tmp_path / name).write_bytes(content)
    place = "column: n, time_column: t" if "csv" in name else "field: a.b"
    (tmp_path / "map.yaml").write_text(f"thruster_0/state.n: {{{place}, unit: rpm}}")
    assert main([str(tmp_path / name), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 1
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_a_log_whose_messages_have_no_length_is_refused_and_not_read_for_ever(tmp_path, capsys):
    log = autopilot_log(tmp_path / "x.BIN")
    log.write_bytes(log.read_bytes().replace(b"\xa3\x95\x80\x0a\x0f", b"\xa3\x95\x80\x0a\0"))
    assert main([str(log), "--guess"]) == 1
    assert "format of message RCOU: expected at least 3 bytes, found 0" in capsys.readouterr().err


def test_wrong_usage_says_what_is_expected(tmp_path, capsys):
    assert main([str(tmp_path / "x.csv")]) == 2
    assert "expected --map MAP.yaml and --out RUN, or --guess alone" in capsys.readouterr().err
