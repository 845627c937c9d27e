"""Tables that begin below lines of an instrument's own, and tables without names."""

import numpy as np
import pytest
from map_import import attempted, imported, proposal, proposed

from run_bag.importers.csv_source import CsvSource
from run_bag.importers.table_start import start_of

ROWS = [(0.01 * k, np.sin(0.1 * k), 40 * np.sin(0.1 * k)) for k in range(400)]
SCOPE = """Model,XY5
Firmware Version,7.0.3

Horizontal Units,s
Probe Attenuation,1,1
Vertical Units,V,V

TIME,CH1,CH2
"""
LAB = """Writer_Version\t2
Date\t2026/03/18
Time\t14:02:11,5812
***End***\t
\t
Channels\t2\t\t\t
Samples\t400\t\t400\t
X0\t0,0E+0\t\t0,0E+0\t
***End***\t\t\t\t
X_Value\tDrive\tX_Value\tThrust\tComment
"""
NAMES = "time: {column: t}\nthruster_0/state.n: {column: n, unit: rad/s}\n"


def text_of(rows, separator=",", decimal="."):
    return "\n".join(separator.join(f"{v:.6f}".replace(".", decimal) for v in row) for row in rows)


def test_a_table_begins_where_the_number_of_columns_is_constant_and_what_was_passed_over_is_said(tmp_path, capsys):
    (tmp_path / "x.csv").write_text(SCOPE + text_of(ROWS))
    told = proposal(capsys, tmp_path / "x.csv")
    assert "# x.csv: lines 1 to 6 before the rows of the table passed over: 'Model,XY5'" in told
    text = "time: {column: TIME}\nthruster_0/load.wrench.force.x: {column: CH2, unit: N}\n"
    run = imported(tmp_path, text, tmp_path / "x.csv")
    np.testing.assert_allclose(run["thruster_0/load.wrench.force.x"].values, np.array(ROWS)[:, 2], atol=1e-6)
    assert "x.csv: lines 1 to 6 before the rows of the table passed over: 'Model,XY5'" in capsys.readouterr().err


def test_columns_of_one_name_have_numbers_and_rising_ones_are_the_times_of_what_follows(tmp_path, capsys):
    rows = [(t, u, t + 0.003, f) for t, u, f in ROWS]
    (tmp_path / "x.lvm").write_text(LAB + "\n".join(line + "\t" for line in text_of(rows, "\t", ",").split("\n")))
    found, told = proposed(capsys, tmp_path / "x.lvm")
    assert found["time"].startswith("{column: 1, unit: s}")
    assert "{column: Thrust, unit: '?', time_column: 3, time_unit: s}" in found["thruster_0/load.wrench.force.x"]
    run = imported(tmp_path, told.replace("'?'", "N"), tmp_path / "x.lvm")
    thrust = run["thruster_0/load.wrench.force.x"]
    assert thrust.stamps[0] == 1_003_000_000
    np.testing.assert_allclose(thrust.values, np.array(ROWS)[:, 2], atol=1e-6)


@pytest.mark.parametrize(
    "text",
    [
        "t,n,u\n0,1,2\n1,2\n2,3,4\n3,4,5\n",
        "t,n\n0,1,2\n1,2,2\n2,3,4\n",
        "note\n0,1,9,9\nt,n,u\n0,1,2\n1,2,3\n",
        "n,t,name\n1\nt,n,u\n0,1,2\n1,2,3\n",
    ],
)
def test_nothing_that_has_readings_is_passed_over(tmp_path, capsys, text):
    (tmp_path / "x.csv").write_text(text)
    assert attempted(tmp_path, NAMES, tmp_path / "x.csv") == 1
    told = capsys.readouterr().err
    assert "columns as in line 1, found" in told and "lines before a table are passed over where they have no" in told


def test_an_odd_row_leaves_the_separator_as_the_first_line_has_it():
    for separator in ";\t,|":
        assert start_of([separator.join(row) for row in ("012", "123", "23", "345")]) == (separator, (), None)


@pytest.mark.parametrize(
    ("lines", "passed", "named"),
    [
        (["t,n", "0,1", "1,2"], (), True),
        (["0,1", "1,2"], (), False),
        (["wrz,0,1", "wrz,1,2", "wrz,2,3"], (), False),
        (["t,n,T", "0,bad,5", "1,2,6"], (), True),
        ([",,0,1", "0,1,,", "2,3,,", ",,2,4"], (), False),
        (["logger 5", "t,n", "s,rpm", "0,1", "1,2"], (0,), True),
        (["TOA5,x,1,2,3", "t,n", "s,rpm", "Smp,Smp", "0,1", "1,2"], (0, 3), True),
        (["a log", "", "of today", "", "0,1", "1,2"], (0, 1, 2, 3), False),
        (["time,1,2", "0,1,5", "1,2,6"], (), True),
    ],
)
def test_names_are_the_words_right_above_the_first_readings(lines, passed, named):
    assert start_of(lines) == (",", passed, named)


def test_the_separator_is_that_which_finds_the_most_columns_of_readings():
    assert start_of([f"wrz,{k},1,1;2;3,{k}.5,0*5{k}" for k in range(9)])[0] == ","
    assert start_of([f"{k},5;1,5;2,5" for k in range(9)])[0] == ";"
    assert start_of([f"{k},5\t1,5" for k in range(9)])[0] == "\t"


def test_the_first_row_of_a_table_without_names_is_read_and_its_columns_go_by_number(tmp_path, capsys):
    rows = [f"wrz,{u:.4f},{k * 10000 + 1780322400119303}" for k, (_, u, _) in enumerate(ROWS)]
    (tmp_path / "x.log").write_text("\n".join(rows))
    table = CsvSource(tmp_path / "x.log")
    assert table.names() == ["1", "2", "3"] and len(table.cells(0)) == 400
    found, told = proposed(capsys, tmp_path / "x.log")
    assert found["time"].startswith("{column: 3, unit: us}") and "# '2' -1 to 1, 400 samples" in told
    text = "time: {column: 3, unit: us}\nrov/depth.depth: {column: 2, unit: m}\n"
    assert imported(tmp_path, text, tmp_path / "x.log")["rov/depth.depth"].values.size == 400


@pytest.mark.parametrize(
    ("content", "what"),
    [
        (b'{"ts": 1.0, "src": "ctrl"}\n{"ts": 2.0}\n', "JSON: bring it to csv first (pandas' `read_json`"),
        (b'[{"t": 1}]', "JSON: bring it to csv first"),
        (b"CDF\x01\0\0\0\0\xbe", "a netCDF file: bring it to csv first (`scipy.io.netcdf_file`"),
        (b"FMT, 128, 89, FMT, BBnNZ, Type,Length\n", "ArduPilot's log as text: bring it to csv first (give the .BIN"),
    ],
)
@pytest.mark.parametrize("guess", [True, False])
def test_files_that_are_no_tables_are_known_by_their_first_bytes(tmp_path, capsys, content, what, guess):
    from run_bag.importers.cli_recording import main

    (tmp_path / "x.log").write_bytes(content)
    assert (
        main([str(tmp_path / "x.log"), "--guess"]) if guess else attempted(tmp_path, NAMES, tmp_path / "x.log")
    ) == 1
    assert f"expected a table of text, found {what}" in capsys.readouterr().err
