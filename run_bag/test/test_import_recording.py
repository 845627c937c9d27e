"""Any recording: tables, bags of every storage, ROS 1, logs of vehicles, by one map."""

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
    from run_bag.importers.csv_source import CsvSource

    begin = time.process_time()
    table = CsvSource(tmp_path / "x.csv")
    read = [table.numbers(i) for i in range(3)]
    assert time.process_time() - begin < 3.0
    np.testing.assert_allclose(np.column_stack(read), values, atol=1e-6)


@pytest.mark.parametrize(
    ("text", "sentences"),
    [
        ("thruster_0/state.n: {column: 3, unit: rpm}", ["no throttle: `fit` and `diagnose` refuse"]),
        (fields("column: 2", "column: 3").replace(", hold: previous", ""), ["nothing says what it does in the 0.04 s"]),
        (fields("column: 2", "column: 3, sign: -1"), ["runs against the throttle", "`sign: -1`"]),
        ("thruster_0/throttle.commanded: {column: 2, unit: V}", ["up to 1660 V: no thruster's", "nothing that a model",
                                                               "begins with 1.5e+03 V"]),
        ("rov/depth.depth: {column: 3, unit: cm}", ["no thruster_<i>/... topic is in it"]),
    ],
)  # fmt: skip
def test_what_a_diagnosis_would_refuse_is_said_at_once(tmp_path, capsys, text, sentences):
    imported(tmp_path, table(tmp_path / "x.csv"), "time: {column: 1, unit: ms}\n" + text)
    told = capsys.readouterr().err
    assert all(s in told for s in sentences)


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
        "Zeit [ms];Drehzahl rpm;ESC pwm_us;motor current;Schub (kgf)\n0;900;1500;1;0,5\n1;900;1500;1;0,5\n"
    )
    assert main([str(tmp_path / "x.csv"), "--guess"]) == 0
    text = capsys.readouterr().out
    assert "time: {column: 'Zeit [ms]', unit: ms}" in text
    assert "thruster_0/state.n: {column: Drehzahl rpm, unit: rpm}" in text
    assert (
        "thruster_0/throttle.commanded: {column: ESC pwm_us, unit: us, stop: 1500, per_volt: 80, hold: previous}"
        in text
    )
    assert "thruster_0/state.current: {column: motor current, unit: A}" in text
    assert "# 'Schub (kgf)' 0.5 to 0.5 kgf, 2 samples" in text


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
        ("thruster_0/state.n: {column: 2, unit: rpm, file: b.csv}", "expected file 'b.csv', found x.csv"),
        ("thruster_0/state.n: {column: 2, unit: rpm, time_unit: V}", "time_unit: expected a unit of time"),
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
    ],
)
def test_a_broken_recording_is_refused_with_its_name(tmp_path, capsys, name, content, sentence):
    (tmp_path / name).write_bytes(content)
    place = "column: n, time_column: t" if name.endswith("csv") else "field: a.b"
    (tmp_path / "map.yaml").write_text(f"thruster_0/state.n: {{{place}, unit: rpm}}")
    assert main([str(tmp_path / name), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")]) == 1
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_wrong_usage_says_what_is_expected(tmp_path, capsys):
    assert main([str(tmp_path / "x.csv")]) == 2
    assert "expected --map MAP.yaml and --out RUN, or --guess alone" in capsys.readouterr().err
