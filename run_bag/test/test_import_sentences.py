"""What an import by a map says: why it refuses, and what a diagnosis would miss."""

import subprocess
import sys

import numpy as np
import pytest
from foreign_recordings import autopilot_log, table
from map_import import SWEEP, attempted, entries, imported, wide

from run_bag.importers.cli_recording import main


@pytest.mark.parametrize(
    ("text", "sentences"),
    [
        ("thruster_0/state.n: {column: 3, unit: rpm}", ["no throttle: `fit` and `diagnose` refuse"]),
        (
            entries("column: 2", "column: 3").replace(", hold: previous", ""),
            ["nothing says what it does in the 0.04 s between two samples: a fit holds it, a diagnosis tries straight"],
        ),
        ("thruster_0/state.n: {column: 3, unit: rad/s}", ["rad/s: no thruster's; is `unit` that of the recording?"]),
        (
            entries("column: 2", "column: 3, sign: -1"),
            ["runs against the throttle", "say `sign: -1` here", "wired the wrong way round, leave both as they are"],
        ),
        (
            entries("column: 2", "column: 3") + "\nthruster_0/flow.ambient: {column: 2, unit: mm/s}",
            ["no negative reading while the throttle is negative", "in a stream that the thruster does not turn"],
        ),
        (
            "thruster_0/throttle.commanded: {column: 2, unit: V}",
            ["up to 1660 V: full command is 5 V", "nothing that a model", "does not begin at zero"],
        ),
        (
            entries("column: 2", "column: 3").replace("per_volt: 80", "per_volt: 8"),
            ["are `unit` and `per_volt` right?"],
        ),
        ("rov/depth.depth: {column: 3, unit: cm}", ["no thruster_<i>/... topic is in it"]),
    ],
)  # fmt: skip
def test_what_a_diagnosis_would_refuse_is_said_at_once(tmp_path, capsys, text, sentences):
    imported(tmp_path, "time: {column: 1, unit: ms}\n" + text, table(tmp_path / "x.csv"))
    told = capsys.readouterr().err
    assert all(s in told for s in sentences)


@pytest.mark.parametrize(("stop", "told"), [(0, True), (50, False)])
def test_a_command_of_one_sign_beside_a_speed_of_both_is_asked_for_its_stop(tmp_path, capsys, stop, told):
    columns = {"t": 0.02 * np.arange(SWEEP.size), "duty": 50 + 40 * SWEEP, "n": 90 * SWEEP}
    text = "time: {column: t}\nthruster_0/state.n: {column: n, unit: rad/s}\nthruster_0/throttle.commanded: "
    text += f"{{column: duty, unit: '%', stop: {stop}, per_volt: 20, hold: previous}}\n"
    imported(tmp_path, text, wide(tmp_path / "x.csv", columns))
    sentence = (
        "n: goes to both sides while the throttle has one sign, 0.5 to 4.5 V: expected 0 V at rest; is `stop` the"
    )
    assert (sentence in capsys.readouterr().err) is told


def test_samples_of_one_stamp_are_told_with_what_becomes_of_them(tmp_path, capsys):
    columns = {"t": 0.02 * np.floor(np.arange(SWEEP.size) / 2), "u": 4 * SWEEP, "n": 90 * SWEEP}
    text = "time: {column: t}\nthruster_0/state.n: {column: n, unit: rad/s}\n"
    text += "thruster_0/throttle.commanded: {column: u, unit: V, hold: previous}\n"
    run = imported(tmp_path, text, wide(tmp_path / "x.csv", columns))
    assert run["thruster_0/state.n"].values.size == SWEEP.size
    told = f"{SWEEP.size // 2} samples have the stamp of the one before and are kept: of such readings a fit and a"
    assert told in capsys.readouterr().err


@pytest.mark.parametrize(
    ("flow", "told"),
    [
        (0.15 + 0.1 * SWEEP, False),  # a stream that the thruster does not turn
        (np.abs(0.1 * SWEEP), True),
        (np.abs(0.15 + 0.16 * SWEEP), True),  # one that it turns, read without a sign
    ],
)
def test_a_flow_that_is_never_negative_is_asked_about_where_it_is_no_stream(tmp_path, capsys, flow, told):
    rest = np.zeros(100)
    throttle, flow = np.concatenate([rest, SWEEP]), np.concatenate([rest + flow[0], flow])
    columns = {"t": 0.02 * np.arange(throttle.size), "u": throttle, "v": flow}
    text = "time: {column: t, unit: s}\nthruster_0/throttle.commanded: {column: u, unit: V, hold: previous}\n"
    text += "thruster_0/flow.ambient: {column: v, unit: m/s}\n"
    imported(tmp_path, text, wide(tmp_path / "x.csv", columns))
    assert ("no negative reading while the throttle is negative" in capsys.readouterr().err) is told


@pytest.mark.parametrize(("period", "told"), [(0.002, False), (0.01, True)])
def test_a_hold_is_asked_for_where_it_makes_a_difference_to_a_diagnosis(tmp_path, capsys, period, told):
    rows = [f"{period * k:.3f},{max(u, 0.0):.3f},{90 * u:.2f}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["t,u,n", *rows]))
    channels = "thruster_0/throttle.commanded: {column: u, unit: V}\nthruster_0/state.n: {column: n, unit: rad/s}"
    imported(tmp_path, "time: {column: t, unit: s}\n" + channels, tmp_path / "x.csv")
    assert (f"nothing says what it does in the {period:g} s" in capsys.readouterr().err) is told


def test_a_vehicle_s_thruster_needs_no_readings_of_its_own(tmp_path, capsys):
    channels = (
        "thruster_0/throttle.commanded: {column: 2, unit: mV, hold: previous}\nrov/depth.depth: {column: 3, unit: cm}"
    )
    imported(tmp_path, "time: {column: 1, unit: ms}\n" + channels, table(tmp_path / "x.csv"))
    assert "nothing that a model" not in capsys.readouterr().err


def test_rates_and_gaps_are_told(tmp_path, capsys):
    times = [*np.arange(0, 2, 0.02), *np.arange(5, 7, 0.02)]
    rows = [f"{t:.2f},{np.sin(t) if t > 0.5 else 0.0:.5f},{np.sin(t):.3f}" for t in times]
    (tmp_path / "x.csv").write_text("t,u,n\n" + "\n".join(rows) + "\n")
    (tmp_path / "y.csv").write_text("t2,f\n" + "".join(f"{t},{t * t}\n" for t in range(7)))
    text = (
        "thruster_0/throttle.commanded: {column: u, time_column: t, unit: V, hold: linear}\n"
        "thruster_0/load.wrench.force.x: {column: f, time_column: t2, unit: N}"
    )
    run = imported(tmp_path, text, tmp_path / "x.csv", tmp_path / "y.csv")
    told = capsys.readouterr().err
    assert "gaps without samples: 3.0 s from 2.0 s on" in told
    assert "7 samples: expected at least 20" in told
    assert run.metadata["hold"] == {"throttle": "linear"}


@pytest.mark.parametrize(
    ("channel", "source", "warned"),
    [("state.n", "0", False), ("state.n", "1", True), ("load.wrench.force.x", None, True)],
)
def test_readings_without_a_sign_are_doubted_unless_that_is_stated(tmp_path, capsys, channel, source, warned):
    rows = [f"{k / 50:.2f},{3 * u:.3f},{abs(90 * u):.2f}" for k, u in enumerate(SWEEP)]
    (tmp_path / "x.csv").write_text("\n".join(["t,u,y", *rows]))
    unit = "rad/s" if source else "N"
    text = (
        "time: {column: t, unit: s}\nthruster_0/throttle.commanded: {column: u, unit: V, hold: previous}\n"
        f"thruster_0/{channel}: {{column: y, unit: {unit}}}\n"
        + (f"thruster_0/state.sign_source: {{value: {source}}}\n" if source else "")
    )
    imported(tmp_path, text, tmp_path / "x.csv")
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
    text = (
        f"thruster_0/throttle.commanded: {{column: u, time_column: t, unit: V, hold: {hold}}}\n"
        "thruster_0/state.n: {column: n, time_column: t2, unit: rad/s}"
    )
    imported(tmp_path, text, tmp_path / "u.csv", tmp_path / "n.csv")
    assert ("gaps without samples: 2.0 s from 0.0 s on" in capsys.readouterr().err) is gap


def test_files_on_clocks_of_their_own_are_refused(tmp_path, capsys):
    (tmp_path / "a.csv").write_text("t,u\n10,0\n11,1\n12,2\n")
    (tmp_path / "b.csv").write_text("t,n\n100010,5\n100011,6\n100012,7\n")
    channels = ["throttle.commanded: {column: u, unit: V}", "state.n: {column: n, unit: rad/s}"]
    told = "\n".join(["time: {column: t, unit: s}", *(f"thruster_0/{channel}" for channel in channels)])
    assert attempted(tmp_path, told, tmp_path / "a.csv", tmp_path / "b.csv") == 1
    expected = (
        "a.csv: expected times on the clock of the other files, 100010.000 to 100012.000 s; found 10.000 to 12.000 s"
    )
    assert expected in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "controller: {gain: 2}",
            "controller: unknown key: expected a channel, such as thruster_0/state.n, or one of axes, csv, time",
        ),
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
            "rov/depth.depth: {column: 2, unit: m, clock_deviation: 0.1}",
            "clock_deviation: expected of topics throttle, state, load, flow of a thruster alone",
        ),
        ("thruster_0/state.n: {column: 2, unit: rpm, time_offset: 1e300}", "time_offset: expected at most 1e+10 s"),
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
    assert attempted(tmp_path, "time: {column: 1, unit: ms}\n" + text, table(tmp_path / "x.csv")) == 1
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "run").exists()


def test_what_is_wrong_with_a_map_is_a_line_for_each_sentence_with_its_channels(tmp_path, capsys):
    throttles = [f"thruster_{k}/throttle.commanded: {{column: {k + 2}, unit: '%'}}" for k in range(3)]
    lines = ["time: {column: 1}", *throttles, "thruster_0/state.n: {column: 2}"]
    assert attempted(tmp_path, "\n".join(lines), table(tmp_path / "x.csv")) == 1
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
    assert attempted(tmp_path, f"thruster_0/state.n: {{{place}, unit: rpm}}", tmp_path / name) == 1
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


def test_a_reader_that_has_enough_is_no_error():
    program = "import sys; from run_bag.command_line import exit_status as e; sys.exit(e('p', lambda: print('x') or 0))"
    told = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    told.stdout.close()
    assert told.stderr.read() == b"" and told.wait() == 141
