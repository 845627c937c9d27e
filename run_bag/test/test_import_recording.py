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
from map_import import SWEEP, attempted, entries, imported, proposal, wide
from rosbags.rosbag2 import CompressionMode, StoragePlugin

from run_bag import read_run
from run_bag.cli_info import main as info
from run_bag.importers.csv_source import CsvSource

VOLTS = [(throttle_us(k) - 1500.0) / 80.0 for k in range(COUNT)]
SPEED = [speed_rpm(k) * 2.0 * np.pi / 60.0 for k in range(COUNT)]


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
    run = imported(tmp_path, clock + entries(command, speed), write(tmp_path))
    np.testing.assert_allclose(run["thruster_0/throttle.commanded"].values, VOLTS)
    np.testing.assert_allclose(run["thruster_0/state.n"].values, SPEED, rtol=1e-6)
    np.testing.assert_allclose(run.time("thruster_0/state.n"), 0.04 * np.arange(COUNT), atol=1e-6)
    assert run.start == 10**9
    assert run.metadata["hold"] == {"throttle": "previous"}


def test_the_instance_of_a_message_may_be_left_out_where_the_log_has_one_alone(tmp_path, capsys):
    log = autopilot_log(tmp_path / "x.BIN")
    text = entries("field: RCOU.C1", "field: ESC.RPM")
    assert attempted(tmp_path, text, log, out="refused") == 1
    assert "expected field 'ESC.RPM', found" in capsys.readouterr().err, "which of two?"
    alone = autopilot_log(tmp_path / "y.BIN", escs=1)
    run = imported(tmp_path, text.replace("unit: rpm", "unit: rps"), alone)
    np.testing.assert_allclose(run["thruster_0/state.n"].values, 60.0 * np.array(SPEED), rtol=1e-6)
    assert "field 'ESC.RPM' is in rpm, as the recording states; the map says rps" in capsys.readouterr().err


def test_all_that_a_recording_lacks_is_named_at_once(tmp_path, capsys):
    log = autopilot_log(tmp_path / "x.BIN")
    text = entries("field: RCOU.C9", "field: 'ESC[0].RPM'") + "rov/battery.voltage: {field: BAT.Vcc, unit: V}\n"
    assert attempted(tmp_path, text, log) == 1
    first, second = capsys.readouterr().err.splitlines()
    assert first == f"{log}: thruster_0/throttle.commanded: expected field 'RCOU.C9'"
    assert second.startswith(f"{log}: rov/battery.voltage: expected field 'BAT.Vcc', found UNIT.Id, ")


def test_a_ground_station_s_log_tells_senders_apart(tmp_path):
    log = telemetry_log(tmp_path / "x.tlog")
    text = entries("field: SERVO_OUTPUT_RAW.servo1_raw", "field: 'ESC_TELEMETRY_1_TO_4.rpm[0]'")
    text += "thruster_0/state.sign_source: {value: 0}\nthruster_0/state.supply_voltage: "
    text += "{field: 'ESC_TELEMETRY_1_TO_4.voltage[0]', unit: cV}"
    run = imported(tmp_path, text, log)
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


@pytest.mark.parametrize("kind", ["csv", "csv with decimal commas", "BIN", "tlog", "ros1"])
def test_a_guessed_map_is_read_back_and_imports(tmp_path, capsys, kind):
    file = telemetry_log(tmp_path / "x.tlog") if kind == "tlog" else RECORDINGS[kind][0](tmp_path)
    text = proposal(capsys, file)
    run = imported(tmp_path, text, file)
    np.testing.assert_allclose(run["thruster_0/throttle.commanded"].values, VOLTS)
    if kind != "ros1":
        np.testing.assert_allclose(np.abs(run["thruster_0/state.n"].values), np.abs(SPEED), rtol=1e-6)
    assert ("load.wrench.force.x" in text) == kind.startswith("csv")


def test_columns_that_a_table_lacks_are_told_with_all_of_its_own_whatever_they_are_called(tmp_path, capsys):
    text = entries("column: 'PWM, found here'", "column: revs")
    assert attempted(tmp_path, "time: {column: 1, unit: ms}\n" + text, table(tmp_path / "x.csv")) == 1
    first, second = capsys.readouterr().err.splitlines()
    assert first.endswith("x.csv: thruster_0/throttle.commanded: expected column 'PWM, found here'")
    assert second.endswith("thruster_0/state.n: expected column 'revs', found time [ms], PWM (us), rpm, Thrust [kgf]")


def test_a_log_s_speed_with_a_sign_is_not_proposed_as_one_without(tmp_path, capsys):
    text = proposal(capsys, autopilot_log(tmp_path / "x.BIN"))
    assert "thruster_0/state.n: {field: 'ESC[0].RPM', unit: rpm}" in text and "thruster_0/state.sign_source" not in text


def test_channels_of_our_own_runs_are_guessed_as_they_are(tmp_path, capsys):
    run = imported(tmp_path, "thruster_0/state.n: {column: 3, time_column: 1, unit: rpm}", table(tmp_path / "x.csv"))
    assert "thruster_0/state.n: {field: thruster_0/state.n, unit: rad/s}" in proposal(capsys, tmp_path / "run")
    assert run.metadata["import"]["importer"] == "recording"


def test_sign_scale_and_offset_act_before_the_unit(tmp_path):
    text = "time: {column: 'time [ms]', unit: ms}\n"
    text += "thruster_0/load.wrench.force.x: {column: 'Thrust [kgf]', unit: kgf, sign: -1, scale: 2, offset: 1}"
    run = imported(tmp_path, text, table(tmp_path / "x.csv"))
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
    text = f"time: {{column: t}}\nthruster_0/throttle.commanded: {{column: u, unit: {unit}}}"
    imported(tmp_path, text, tmp_path / "x.csv")
    capsys.readouterr()
    assert info([str(tmp_path / "run")]) == 0
    assert volts in capsys.readouterr().out


@pytest.mark.parametrize("cell", ["nan", "NaN", "NAN", "-nan", "", " "])
def test_nan_in_any_case_is_not_measured(tmp_path, cell):
    (tmp_path / "x.csv").write_text(f"t,n\n0,1\n1,{cell}\n2,3\n")
    run = imported(tmp_path, "time: {column: t}\nthruster_0/state.n: {column: n, unit: rad/s}", tmp_path / "x.csv")
    np.testing.assert_array_equal(run["thruster_0/state.n"].values, [1, np.nan, 3])


def test_a_million_rows_take_three_seconds_of_a_processor(tmp_path):
    rows = 1_000_000
    values = np.column_stack([np.arange(rows) * 1e-3, np.sin(np.arange(rows)), np.cos(np.arange(rows))])
    np.savetxt(tmp_path / "x.csv", values, fmt="%.6f", delimiter=",", header="t,u,n", comments="")
    begin = time.process_time()
    table = CsvSource(tmp_path / "x.csv")
    read = [table.numbers(i) for i in range(3)]
    assert time.process_time() - begin < 3.0
    np.testing.assert_allclose(np.column_stack(read), values, atol=1e-6)


def test_two_files_of_one_clock_become_one_run(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("t,u\n10,0\n11,1\n12,2\n")
    (tmp_path / "b.csv").write_text("t,n\n10.5,3\n11.5,4\n")
    text = (
        "time: {column: t}\nthruster_0/throttle.commanded: {column: u, unit: V}\n"
        "thruster_0/state.n: {column: n, unit: rad/s}"
    )
    files = [tmp_path / "a.csv", tmp_path / "b.csv"]
    run = imported(tmp_path, text, *files)
    assert run["thruster_0/state.n"].stamps.tolist() == [1_500_000_000, 2_500_000_000]
    (tmp_path / "b.csv").write_text("t,u\n0,1\n")
    assert attempted(tmp_path, text, *files, out="other") == 1
    where = "thruster_0/throttle.commanded: expected column 'u' in one file (say which by `file: NAME`)"
    assert f"{where}, found it in a.csv, b.csv\n" in capsys.readouterr().err


def test_two_recordings_in_one_call_are_told_as_that(tmp_path, capsys):
    columns = {"t": np.arange(SWEEP.size) * 0.02, "pwm": 1500 + 400 * SWEEP, "rpm": 900 * SWEEP}
    files = [wide(tmp_path / f"log_{k}.csv", columns) for k in (1, 2)]
    assert attempted(tmp_path, "time: {column: t}\n" + entries("column: pwm", "column: rpm"), *files) == 1
    told = "log_1.csv, log_2.csv: expected all files of one recording, found all that the map names in each"
    assert told in capsys.readouterr().err


def test_a_name_that_no_row_has_is_told_of_the_file_that_has_its_column(tmp_path, capsys):
    time = {"t": np.arange(SWEEP.size) * 0.02}
    pulses = wide(tmp_path / "a.csv", time | {"pwm": 1500 + 400 * SWEEP, "i": 0 * SWEEP})
    speeds = wide(tmp_path / "b.csv", time | {"rpm": 900 * SWEEP, "i": 0 * SWEEP})
    text = "time: {column: t}\n" + entries("column: pwm", "column: rpm, where: {i: 3}")
    assert attempted(tmp_path, text, pulses, speeds) == 1
    assert "b.csv: thruster_0/state.n: expected column 'rpm' where i is '3', found i: 0" in capsys.readouterr().err


def test_of_several_times_of_a_map_a_file_has_the_first_that_it_has_and_an_entry_may_have_its_own(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("t_cmd,u,t_slow,v\n10,0,9.5,0\n11,1,10.5,0\n12,2,11.5,0\n")
    (tmp_path / "b.csv").write_text("ms,n\n10500,3\n11500,4\n")
    state = "thruster_0/state.n: {column: n, unit: rad/s}"
    told = (
        "time: [{column: t_cmd}, {column: ms, unit: ms}]\nthruster_0/throttle.commanded: {column: u, unit: V}\n"
        "thruster_0/flow.axial: {column: v, unit: m/s, time_column: t_slow}\n"
    )
    files = [tmp_path / "a.csv", tmp_path / "b.csv"]
    run = imported(tmp_path, told + state, *files)
    assert run["thruster_0/throttle.commanded"].stamps.tolist() == [1_500_000_000, 2_500_000_000, 3_500_000_000]
    assert run["thruster_0/state.n"].stamps.tolist() == [2_000_000_000, 3_000_000_000]
    assert run["thruster_0/flow.axial"].stamps.tolist() == [1_000_000_000, 2_000_000_000, 3_000_000_000]
    capsys.readouterr()
    assert attempted(tmp_path, told + state.replace("}", ", time_unit: us}"), *files, out="other") == 1
    assert "time_unit: expected beside time_column, as `time` has several" in capsys.readouterr().err
    assert attempted(tmp_path, told.replace("column: ms", "column: us") + state, *files, out="third") == 1
    assert "its time: expected column 't_cmd', found ms, n" in capsys.readouterr().err


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
    run = imported(tmp_path, time + throttle + speed, tmp_path / "x.csv")
    seconds = 0.02 if "ms" in time + own else 20.0
    assert run.time("thruster_0/state.n")[-1] == pytest.approx(seconds * (SWEEP.size - 0.8))


@pytest.mark.parametrize("own", ["time_unit: ms", "time_scale: 0.001"])
def test_an_entry_may_count_the_time_column_of_all_in_another_unit(tmp_path, own):
    (tmp_path / "a.csv").write_text("t,u\n0,1\n0.5,2\n2,3\n")
    (tmp_path / "b.csv").write_text("t,n\n500,10\n1500,20\n")
    text = (
        "time: {column: t, unit: s}\nthruster_0/throttle.commanded: {column: u, unit: V, hold: previous}\n"
        f"thruster_0/state.n: {{column: n, unit: rad/s, {own}}}"
    )
    run = imported(tmp_path, text, tmp_path / "a.csv", tmp_path / "b.csv")
    assert run.time("thruster_0/throttle.commanded").tolist() == [0.0, 0.5, 2.0]
    assert run.time("thruster_0/state.n").tolist() == [0.5, 1.5]


def test_an_offset_is_added_to_the_times_of_an_entry_whose_file_has_another_clock(tmp_path):
    (tmp_path / "a.csv").write_text("t,u\n1700000000.0,0\n1700000000.5,1\n1700000002.0,0\n")
    (tmp_path / "b.csv").write_text("ms,f\n500,0\n1500,3\n")
    text = (
        "time: [{column: t, unit: s}, {column: ms, unit: ms}]\n"
        "thruster_0/throttle.commanded: {column: u, unit: V, hold: previous}\n"
        "thruster_0/load.wrench.force.x: {column: f, unit: N, time_offset: 1.70000000025e9}"
    )
    run = imported(tmp_path, text, tmp_path / "a.csv", tmp_path / "b.csv")
    assert run.time("thruster_0/throttle.commanded").tolist() == [0.0, 0.5, 2.0]
    assert run.time("thruster_0/load.wrench.force.x").tolist() == [0.75, 1.75]
    (how,) = [d["how"] for d in run.metadata["import"]["decisions"] if d["what"].startswith("thruster_0/load")]
    assert "column 'f' at 'ms' and +1700000000.25 s" in how


def test_how_far_a_clock_may_be_off_is_in_the_run(tmp_path):
    channels = (
        "thruster_0/throttle.commanded: {column: 2, unit: V, clock_deviation: 0.02}\n"
        "thruster_0/flow.axial: {column: 3, unit: m/s, clock_deviation: 0.1}\n"
        "thruster_0/state.n: {column: 3, unit: rpm, clock_deviation: 0.01}\n"
        "thruster_0/load.wrench.force.x: {column: 3, unit: N, clock_deviation: 0.07}\n"
        "thruster_0/flow.ambient: {column: 3, unit: m/s, clock_deviation: 0.05}"
    )
    run = imported(tmp_path, "time: {column: 1, unit: s}\n" + channels, table(tmp_path / "x.csv"))
    assert run.metadata["clock_deviation"] == {"throttle": 0.02, "flow": 0.1, "state": 0.01, "load": 0.07}


def test_what_a_map_makes_the_same_in_all_messages_is_told_as_that_and_not_as_readings(tmp_path, capsys):
    state = "{column: 3, time_column: 1, unit: rpm}\nthruster_0/state.sign_source: {value: 1}"
    imported(tmp_path, f"thruster_0/state.n: {state}", table(tmp_path / "x.csv"))
    (line,) = [line for line in capsys.readouterr().out.splitlines() if "thruster_0/state" in line]
    assert line.count("readings") == 1 and line.endswith("; sign_source: 1 in all of them")
