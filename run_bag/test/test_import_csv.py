"""A csv with a map of its columns."""

import numpy as np
import pytest
from map_import import attempted, imported

from run_bag import read_run
from run_bag.cli_info import main as info
from run_bag.importers.cli_recording import main

CSV = "t,rpm,u,t2,force\n0.0,0,0.5,0.05,1\n0.1,60,0.6,0.15,\n0.2,bad,0.7,0.25,3\n"
MAP = """
thruster_0/state.n: {column: rpm, time_column: t, unit: rad/s, scale: 0.10471975511965977, nan: [bad]}
thruster_0/throttle.commanded: {column: 3, time_column: 1, unit: V, offset: 1}
thruster_0/load.wrench.force.x: {column: force, time_column: t2, unit: N}
"""
STATE = "{column: 2, time_column: 1, unit: rad/s}"
MAP_TWO = """
thruster_0/state.n: {column: n, time_column: t, unit: rad/s}
thruster_0/load.wrench.force.x: {column: f, time_column: t2, unit: N}
"""


def files(tmp_path, text=CSV, columns=MAP):
    (tmp_path / "x.csv").write_text(text)
    (tmp_path / "map.yaml").write_text(columns)
    return [str(tmp_path / "x.csv"), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "out")]


def written(path, text):
    path.write_text(text)
    return path


def test_columns_become_channels_with_their_own_stamps_and_units(tmp_path, capsys):
    assert main(files(tmp_path)) == 0
    run = read_run(tmp_path / "out")
    np.testing.assert_allclose(run["thruster_0/state.n"].values, [0, 2 * np.pi, np.nan])
    assert run["thruster_0/throttle.commanded"].values.tolist() == [1.5, 1.6, 1.7]
    force = run["thruster_0/load.wrench.force.x"]
    np.testing.assert_equal(force.values, [1, np.nan, 3])
    assert force.stamps.tolist() == [1_050_000_000, 1_150_000_000, 1_250_000_000] and force.unit == "N"
    decisions = run.metadata["import"]["decisions"]
    assert [d["what"] for d in decisions[3:]] == ["shift of the clock", "thruster_0/state.sign_source"]
    assert main(files(tmp_path)) == 1
    assert "nothing is overwritten" in capsys.readouterr().err
    assert info([str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "/thruster_0/state  thruster_msgs/msg/ThrusterState  3" in printed and "[rad/s]" in printed
    assert "sha256" in printed and "column 'rpm'" in printed
    assert info([str(tmp_path / "none")]) == 1


@pytest.mark.parametrize("first", [-5, 0, 12.5, 1.7e9 + 0.25, 1778901719.472647])
def test_the_clock_starts_at_one_second_and_the_metadata_say_so(tmp_path, first):
    assert main(files(tmp_path, f"{first!r},1\n{first + 1!r},2\n", "thruster_0/state.n: " + STATE)) == 0
    run = read_run(tmp_path / "out")
    assert run["thruster_0/state.n"].stamps.tolist() == [10**9, 2 * 10**9]
    (shift,) = [d for d in run.metadata["import"]["decisions"] if d["what"] == "shift of the clock"]
    assert shift["unit"] == "s" and shift["how"].startswith(f"{1.0 - first!r} s was added to all times")
    assert shift["value"] == 1.0 - first


def test_a_constant_fills_every_message_of_its_topic(tmp_path, capsys):
    columns = f"thruster_0/state.n: {STATE}\nthruster_0/state.sign_source: {{value: 2}}\n"
    columns += "thruster_0/state.supply_voltage: {value: 14.8, unit: V}"
    assert main(files(tmp_path, "0,1\n1,2\n", columns)) == 0
    run = read_run(tmp_path / "out")
    assert run["thruster_0/state.sign_source"].values.tolist() == [2, 2]
    assert run["thruster_0/state.supply_voltage"].values.tolist() == [14.8, 14.8]
    assert "sign_source" not in capsys.readouterr().err
    assert run.metadata["import"]["decisions"][-1]["value"] == 14.8


@pytest.mark.parametrize(("speed", "source", "said"), [(-2, 1, False), (2, 0, True)])
def test_a_sign_source_that_is_not_told_follows_from_the_speed(tmp_path, capsys, speed, source, said):
    assert main(files(tmp_path, f"0,1\n1,{speed}\n", "thruster_0/state.n: " + STATE)) == 0
    assert read_run(tmp_path / "out")["thruster_0/state.sign_source"].values.tolist() == [source] * 2
    assert ("0 is written, n counts as a magnitude" in capsys.readouterr().err) == said


@pytest.mark.parametrize(
    ("lowest", "state", "asked"), [(-0.5, "", True), (-40, "", False), (-0.5, "{value: 0}", False), (0, "", False)]
)
def test_a_speed_that_is_negative_by_next_to_nothing_is_asked_about(tmp_path, capsys, lowest, state, asked):
    told = f"thruster_0/state.n: {STATE}\n" + (f"thruster_0/state.sign_source: {state}\n" if state else "")
    assert main(files(tmp_path, f"0,{lowest}\n1,100\n", told)) == 0
    assert ("n is never below -0.5 rad/s, up to 100: 1 is written" in capsys.readouterr().err) is asked


@pytest.mark.parametrize(
    ("head", "cells", "unit", "told"),
    [
        ("date", "2026-05-04T12:00:0{}Z", "ms", "time column 'date' has dates or times of day, read as seconds"),
        ("date", "2026-05-04T12:00:0{}Z", "s", ""),
        ("t [ms]", "{}", "s", "time column 't [ms]' is in ms, as the recording states; the map makes 1 s of each"),
        ("t [ms]", "{}", "ms", ""),
        ("t", "{}", "ms", ""),
    ],
)
def test_a_time_in_another_unit_than_the_recording_states_is_warned_of_once(tmp_path, capsys, head, cells, unit, told):
    rows = "".join(f"{cells.format(k)},{k},{k}\n" for k in range(4))
    text = f"time: {{column: '{head}', unit: {unit}}}\nthruster_0/state.n: {{column: n, unit: rad/s}}\n"
    text += "thruster_0/throttle.commanded: {column: u, unit: V, hold: previous}\n"
    imported(tmp_path, text, written(tmp_path / "x.csv", f"{head},n,u\n{rows}"))
    found = capsys.readouterr().err
    assert found.count("time column") == bool(told) and told in found


@pytest.mark.parametrize(
    ("text", "more"),
    [
        ("t n T\n0 1 5\n1 2 6\n", ""),
        ("  t  n\n  0  1\n1     2\n", ""),
        ("      t      n\n      s     Hz\n    0.0    1.0\n   1.00    2.0\n", ""),
        ("t   n\n0   1\n1   2\n", "csv: {separator: ' '}\n"),
    ],
)
def test_single_blanks_and_runs_of_them_separate(tmp_path, text, more):
    told = f"time: {{column: t}}\n{more}thruster_0/state.n: {{column: n, unit: rad/s}}\n"
    run = imported(tmp_path, told, written(tmp_path / "x.txt", text))
    assert run["thruster_0/state.n"].values.tolist() == [1, 2]


def test_a_table_in_one_column_is_told_what_separates_in_a_proposal_and_an_import(tmp_path, capsys):
    told = "time: {column: t}\nthruster_0/state.n: {column: n, unit: rad/s}\n"
    table = written(tmp_path / "y.txt", "t&n\n0&1\n10&2\n")
    assert attempted(tmp_path, told, table) == 1
    assert "expected column 'n', found t&n in one column; what separates them? `;`, tabs" in capsys.readouterr().err
    assert main([str(table), "--guess"]) == 1
    told = capsys.readouterr()
    assert "found t&n in one column; what separates them? `;`, tabs" in told.err and not told.out


@pytest.mark.parametrize(
    ("name", "entry", "told"),
    [
        ("shaft_rpm", "unit: deg/s", "column 'shaft_rpm' is in rpm, by its name; the map says deg/s"),
        ("shaft_rpm", "unit: U/min", ""),
        ("shaft_rpm", "unit: rad/s, scale: 0.1047", ""),
        ("shaft_rpm [deg/s]", "unit: deg/s", ""),
        ("n", "unit: deg/s", ""),
    ],
)
def test_another_unit_than_the_name_of_a_column_ends_in_is_warned_of(tmp_path, capsys, name, entry, told):
    table = written(tmp_path / "x.csv", f"t,{name}\n0,-60\n1,60\n")
    imported(tmp_path, f"time: {{column: t}}\nthruster_0/state.n: {{column: '{name}', {entry}}}\n", table)
    found = capsys.readouterr().err
    assert ("the map says" in found) is bool(told) and told in found


def test_a_time_scale_that_corrects_a_clock_is_not_warned_of(tmp_path, capsys):
    told = "thruster_0/state.n: {column: n, unit: rad/s, time_column: 't [ms]', time_scale: 0.001001}\n"
    imported(tmp_path, told, written(tmp_path / "x.csv", "t [ms],n\n0,1\n1,2\n"))
    assert "time column" not in capsys.readouterr().err


def test_speeds_without_a_sign_are_warned_of_once_with_the_line_that_says_so(tmp_path, capsys):
    speeds = "".join(f"thruster_{i}/state.n: {STATE}\n" for i in range(3))
    assert main(files(tmp_path, "0,1\n1,2\n", speeds)) == 0
    (line,) = (line for line in capsys.readouterr().err.splitlines() if "sign_source" in line)
    assert "thruster_0/state.sign_source and those of thruster_1/state, thruster_2/state are not in the map" in line
    assert "`thruster_0/state.sign_source: {value: 0}` says so" in line
    speeds += "".join(f"thruster_{i}/state.sign_source: {{value: 0}}\n" for i in range(3))
    (tmp_path / "silent").mkdir()
    assert main(files(tmp_path / "silent", "0,1\n1,2\n", speeds)) == 0
    assert "sign_source" not in capsys.readouterr().err


def test_rows_without_time_and_value_are_not_measured(tmp_path):
    assert main(files(tmp_path, "t,n,t2,f\n0,1,0,5\n1,2,,\n", MAP_TWO)) == 0
    assert read_run(tmp_path / "out")["thruster_0/load.wrench.force.x"].values.tolist() == [5]


@pytest.mark.parametrize(
    ("text", "columns", "sentence"),
    [
        (CSV, "a/b.c: {column: 1, time_column: 1, unit: V}", "unknown topic 'a/b'; known are thruster_<i>/"),
        (CSV, MAP.replace("rad/s", "kgf"), "expected unit 'rad/s' or one that becomes it (rad/s, rpm, rps,"),
        (CSV, MAP.replace("state.n", "state.m"), "no numeric field 'm'"),
        (
            CSV,
            MAP.replace("column: rpm", "column: speed"),
            "expected column 'speed', found t, rpm, u, t2, force",
        ),
        (CSV, MAP.replace("column: t,", "column: clock,"), ", its time: expected column 'clock', found t, rpm, u"),
        (CSV, MAP.replace("column: 3", "column: 9"), "expected column 9, found 5 columns"),
        (CSV, MAP.replace(", nan: [bad]", ""), "line 4, column 2: expected a finite number, or this text in"),
        (CSV, MAP.replace("offset: 1", "ofset: 1"), "unknown key 'ofset'"),
        (CSV, MAP.replace(", unit: V", ""), "key 'unit' is missing"),
        (CSV, MAP.replace("offset: 1", "offset: one"), "offset: expected a number, found 'one'"),
        (CSV, "", "expected a mapping at the top; found nothing"),
        (CSV, "time: {column: t}", "expected entries"),
        (CSV, "[: x", "line 1: expected YAML; found what is none"),
        (CSV.replace("0.2,bad", "0.05,bad"), MAP, "line 4: rows out of order: 0.05 s after 0.1 s"),
        (CSV.replace("0.2,bad", "0.05,bad"), MAP, "expected that 't', the time of thruster_0/state.n, never falls"),
        (CSV.replace("0.6,0.15,", "0.6,0.15"), MAP, "x.csv, line 3: expected 5 columns as in line 1, found 4"),
        (CSV.replace("0.6,0.15,", "0.6,0.15,1,2"), MAP, "x.csv, line 3: expected 5 columns as in line 1, found 6"),
        (CSV.replace("0.6", "inf"), MAP, "x.csv, line 3, column 3: expected a finite number"),
        (CSV.replace("0.6", "1e400"), MAP, "the map's `nan`, found '1e400'"),
        (CSV.replace("0.6", "1e308"), MAP.replace("offset: 1", "scale: 100"), "line 3, column 3: expected a finite"),
        (CSV.replace("\n0.1,", "\nnan,"), MAP, "line 3, column 1: expected the time of the value in column 2"),
        (CSV.replace("\n0.1,", "\n-inf,"), MAP, "x.csv, line 3, column 1: expected a finite number"),
        (CSV.replace("\n0.1,", "\n,"), MAP, "line 3, column 1: expected the time of the value in column 2, found ''"),
        (CSV.replace("\n0.2,", "\n1e300,"), MAP, "line 4, column 1: expected a time at most 2.14748e+09 s after"),
        (CSV, MAP + MAP.splitlines()[1], "line 5: expected each key once, found 'thruster_0/state.n' again"),
        (CSV, MAP.replace("column: 3", "column: 3, column: 4"), "line 3: expected each key once, found 'column' again"),
        (CSV, MAP + "/thruster_0/state.n: {value: 1}", "each channel once, found it as thruster_0/state.n too"),
        (CSV, MAP + "thruster_1/state.sign_source: {value: 1}", "expected a column of the same topic"),
        (CSV, MAP + "thruster_0/state.sign_source: {value: .inf}", "value: expected a number, found inf"),
        (CSV, MAP + "thruster_0/state.sign_source: {value: 1.5}", "expected whole numbers from 0 to 255"),
        (CSV, MAP + "thruster_0/state.current: {value: 1, column: 2}", "unknown key 'column' beside value"),
        (CSV, MAP.replace("unit: V", "unit: V, time_scale: 0"), "time_scale: expected a positive number, found 0"),
        (CSV, MAP.replace("offset: 1", "offset: 1" + "0" * 400), "line 3: expected a number of at most 400 digits"),
        ("t,rpm,u,t2,force\n", MAP, "expected rows of numbers, found none"),
    ],
)
def test_what_does_not_fit_is_refused_with_a_sentence(tmp_path, capsys, text, columns, sentence):
    assert main(files(tmp_path, text, columns)) == 1
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("first", "second", "third", "origin"),
    [
        ("2026-05-04T12:00:00.250Z", "2026-05-04T12:00:01.250Z", "2026-05-04T12:00:02.750Z", 1777896000.25),
        ("2026-05-04 14:00:00.25+02:00", "2026-05-04 14:00:01.25+0200", "2026-05-04 14:00:02.75+02", 1777896000.25),
        ("04.05.2026 12:00:00.25", "4.5.2026 12:00:01.25", "04.05.2026  12:00:02.75", 1777896000.25),
        ("09:59:59.5", "10:00:00.5", "10:00:02.0", 35999.5),
        ("23:59:59.5", "00:00:00.5", "00:00:02.0", 86399.5),
    ],
)
def test_dates_and_times_of_day_are_seconds(tmp_path, first, second, third, origin):
    table = f"when,rpm\n{first},0\n{second},60\n{third},120\n"
    assert main(files(tmp_path, table, "thruster_0/state.n: {column: rpm, time_column: when, unit: rpm}")) == 0
    run = read_run(tmp_path / "out")
    assert (run["thruster_0/state.n"].stamps - 10**9).tolist() == [0, 10**9, 2_500_000_000]
    (shift,) = [d for d in run.metadata["import"]["decisions"] if d["what"] == "shift of the clock"]
    assert shift["how"].startswith(f"{1.0 - origin!r} s was added to all times")


@pytest.mark.parametrize("day", ["", "04.05.2026 ", "2026-05-04 "])
def test_dates_and_times_of_day_may_have_a_decimal_comma(tmp_path, day):
    table = f"Zeit;Drehzahl\n{day}13:53:20,000;0,0\n{day}13:53:20,500;60,5\n{day}13:53:22,125;1,0\n"
    assert main(files(tmp_path, table, "thruster_0/state.n: {column: Drehzahl, time_column: Zeit, unit: rpm}")) == 0
    assert read_run(tmp_path / "out").time("thruster_0/state.n").tolist() == [0.0, 0.5, 2.125]


@pytest.mark.parametrize(
    "form", ["05/04/2026 13:53:2{},000", "4. Mai 2026 13:53:2{},0", "01:53:2{},000 PM", "04.05.26 13:53:2{},000"]
)
def test_a_date_in_another_form_is_refused_with_those_that_are_read(tmp_path, capsys, form):
    table = "Zeit;Drehzahl\n" + "".join(f"{form.format(k)};{k},0\n" for k in range(5))
    assert main(files(tmp_path, table, "thruster_0/state.n: {column: Drehzahl, time_column: Zeit, unit: rpm}")) == 1
    told = capsys.readouterr().err
    assert "is it a date? those are read as 2026-05-04T12:00:00.25, 04.05.2026 12:00:00,25 or 12:00:00,25" in told
    assert "decimal" not in told


def test_times_of_day_of_all_columns_are_of_one_night(tmp_path):
    table = "when,rpm,t2,f\n23:59:59,0,00:00:01,1\n00:00:01,60,00:00:02,2\n"
    speed = "thruster_0/state.n: {column: rpm, time_column: when, unit: rpm}\n"
    force = "thruster_0/load.wrench.force.x: {column: f, time_column: t2, unit: N}"
    assert main(files(tmp_path, table, speed + force)) == 0
    run = read_run(tmp_path / "out")
    assert run.time("thruster_0/state.n").tolist() == [0.0, 2.0]
    assert run.time("thruster_0/load.wrench.force.x").tolist() == [2.0, 3.0]


@pytest.mark.parametrize(
    "times",
    [
        ("12:30:00", "12:29:59", "12:30:01"),  # out of order by a second
        ("20:00:00", "08:00:00", "13:00:00"),  # more than a night
        ("10:00:00", "23:00:00", "00:00:00"),
        ("14:00:00", "00:00:00", "14:00:01"),  # a clock that was lost for one row
    ],
)
def test_times_of_day_of_no_one_night_are_refused_as_out_of_order(tmp_path, capsys, times):
    table = "when,rpm\n" + "".join(f"{time},0\n" for time in times)
    assert main(files(tmp_path, table, "thruster_0/state.n: {column: rpm, time_column: when, unit: rpm}")) == 1
    assert "rows out of order" in capsys.readouterr().err


def test_a_date_that_is_none_is_named_by_its_line(tmp_path, capsys):
    table = "when,rpm\n2026-05-04T12:00:00Z,0\n2026-05-04T12:00:01Z,1\n2026-13-04T12:00:02Z,2\n"
    assert main(files(tmp_path, table, "thruster_0/state.n: {column: rpm, time_column: when, unit: rpm}")) == 1
    told = capsys.readouterr().err
    assert "line 4, column 1: expected a finite number" in told and "'2026-13-04T12:00:02Z'" in told
    assert not (tmp_path / "out").exists()


VECTORS = "timestamp,name,x,y\n" + "".join(f"{20 * k},{'cell' if k % 2 else 'flow'},{k},0\n" for k in range(40))
CELL = "thruster_0/load.wrench.force.x: {column: x, unit: N, where: {name: cell}}\n"
OF_NAME = "time: {column: timestamp, unit: ms}\n" + CELL


def test_rows_of_one_name_are_a_channel_and_those_of_another_are_another_one(tmp_path):
    told = OF_NAME + "thruster_0/flow.axial: {column: x, unit: m/s, where: {name: flow}}\n"
    run = imported(tmp_path, told, written(tmp_path / "v.csv", VECTORS))
    force, flow = run["thruster_0/load.wrench.force.x"], run["thruster_0/flow.axial"]
    assert force.values.tolist() == [*range(1, 40, 2)] and flow.values.tolist() == [*range(0, 40, 2)]
    assert force.stamps[0] - flow.stamps[0] == 20_000_000
    assert "column 'x' where name is 'cell' at 'timestamp'" in run.metadata["import"]["decisions"][0]["how"]


def test_of_two_files_with_one_column_the_one_with_the_rows_of_a_name_is_taken(tmp_path):
    first = written(tmp_path / "v_0.csv", "timestamp,name,x,y\n0,flow,1,0\n20,flow,2,0\n")
    second = written(tmp_path / "v_1.csv", "timestamp,name,x,y\n0,cell,3,0\n20,cell,4,0\n")
    for files in ([first, second], [second, first]):
        run = imported(tmp_path, OF_NAME, *files, out=files[0].stem)
        assert run["thruster_0/load.wrench.force.x"].values.tolist() == [3, 4]


def test_rows_of_an_instance_are_told_by_its_number_and_a_cell_of_others_may_be_no_number(tmp_path):
    told = "thruster_0/state.n: {column: n, unit: rad/s, time_column: t, where: {i: 1}}\n"
    run = imported(tmp_path, told, written(tmp_path / "n.csv", "t,i,n\n0,0,5\n0,1.0,6\n1,0,7\n,0,7\n1,1.0,8\n"))
    assert run["thruster_0/state.n"].values.tolist() == [6, 8]


@pytest.mark.parametrize(
    ("where", "sentence"),
    [
        ("{name: cel}", "expected column 'x' where name is 'cel', found name: flow, cell"),
        ("{sender: cell}", "expected column 'sender', found timestamp, name, x, y"),
        ("cell", "where: expected {column: text or number of its cells}, found 'cell'"),
        ("{}", "where: expected {column: text or number of its cells}, found {}"),
        ("{0: 1}", "where: expected {column: text or number of its cells}, found {0: 1}"),
        ("{name: [cell]}", "where: expected {column: text or number of its cells}"),
    ],
)
def test_rows_that_are_not_there_are_refused_with_those_that_are(tmp_path, capsys, where, sentence):
    told = OF_NAME.replace("{name: cell}", where)
    assert attempted(tmp_path, told, written(tmp_path / "v.csv", VECTORS)) == 1
    assert sentence in capsys.readouterr().err


def test_rows_are_chosen_in_tables_alone(tmp_path, capsys):
    told = "thruster_0/state.n: {field: a.b, unit: rad/s, where: {name: cell}}\n"
    assert attempted(tmp_path, told, written(tmp_path / "v.csv", VECTORS)) == 1
    assert "where: expected beside column alone" in capsys.readouterr().err
