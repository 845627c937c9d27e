"""Tables with a row for each reading."""

import numpy as np
import pytest
from map_import import SWEEP, attempted, imported, proposal, proposed

from run_bag.importers.csv_source import CsvSource


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
        (
            "Zeit;Kanal;Wert;Bemerkung;Einheit;Ort",
            lambda t, n, unit, v: f"{t:.3f};{n};{v:.6g};".replace(".", ",") + f"{'' if v < 2 else 'viel 7'};{unit};",
            lambda row: row[0],
        ),
        ("name;value;t", lambda t, n, _, v: f'"{n}";{v:.6g};{t:.3f}'.replace(".", ","), lambda row: row[1]),
    ],
)
def test_a_long_table_becomes_the_run_of_a_wide_one(tmp_path, capsys, header, line, order):
    long_table(tmp_path / "x.csv", header, line, order)
    told = proposal(capsys, tmp_path / "x.csv")
    assert "Not recognised" not in told and "?'" not in told
    assert ("# Beside the readings, left out: Bemerkung, Ort" in told) is ("Bemerkung" in header)
    run = imported(tmp_path, told, tmp_path / "x.csv")
    told = capsys.readouterr().out
    assert f"thruster_0/throttle: commanded: {SWEEP.size} readings" in told
    assert f"thruster_0/state: n: {SWEEP[::2].size} readings" in told
    speed, thrust = run["thruster_0/state.n"], run["thruster_0/load.wrench.force.x"]
    np.testing.assert_allclose(speed.values, 300.0 * SWEEP[::2] * np.pi / 30.0, rtol=1e-5, atol=1e-9)
    np.testing.assert_allclose(thrust.values, 4.0 * SWEEP, rtol=1e-5, atol=1e-9)
    assert speed.stamps[0] - thrust.stamps[0] == 4_000_000


def test_a_name_in_a_table_that_is_no_long_one_is_refused_with_what_a_long_one_has(tmp_path, capsys):
    long_table(tmp_path / "x.csv", "id,t,sensor,v", lambda t, n, _, v: f"7,{t:.3f},{n},{v:.6g}")
    text = "time: {column: t, unit: s}\nthruster_0/state.n: {column: motor_rpm, unit: rpm}"
    assert attempted(tmp_path, text, tmp_path / "x.csv") == 1
    told = capsys.readouterr().err
    assert "'motor_rpm' is in 'sensor': a long table has two columns of numbers alone, time and value" in told


def test_a_long_table_s_wrong_cell_is_named_by_its_line_and_name(tmp_path, capsys):
    long_table(
        tmp_path / "x.csv", "t,sensor,v", lambda t, n, _, v: f"{t:.3f},{n},{v:.6g}" if t < 1.0 else f"{t:.3f},{n},x"
    )
    text = "time: {column: t, unit: s}\nthruster_0/state.n: {column: motor_rpm, unit: rpm}"
    assert attempted(tmp_path, text, tmp_path / "x.csv") == 1
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
    assert "thruster_0/throttle.commanded: {column: throttle_V" in proposal(capsys, tmp_path / "x.csv")


def test_an_unknown_unit_in_a_long_table_is_unknown_for_its_name_alone_and_is_named(tmp_path, capsys):
    long_table(tmp_path / "x.csv", "t,sensor,v,unit", lambda t, n, unit, v: f"{t:.3f},{n},{v:.6g},{unit}")
    text = (tmp_path / "x.csv").read_text()
    (tmp_path / "x.csv").write_text(text.replace(",N", ",Pfund"))
    found, told = proposed(capsys, tmp_path / "x.csv")
    assert "{column: 'motor_rpm [rpm]', unit: rpm}" in found["thruster_0/state.n"] and "left out" not in told
    assert "unit: '?'}" in found["thruster_0/load.wrench.force.x"]
    assert "'Pfund' is not known as a unit of it" in found["thruster_0/load.wrench.force.x"]


def test_a_word_that_changes_from_row_to_row_is_no_unit(tmp_path):
    long_table(tmp_path / "y.csv", "t,sensor,v,mode", lambda t, n, unit, v: f"{t:.3f},{n},{v:.6g},{'AX'[int(v > 0)]}")
    assert CsvSource(tmp_path / "y.csv").left_out == ("mode",)


@pytest.mark.parametrize("word", ["Digit", "LSB", "raw", "ADC", "counts"])
def test_counts_rest_at_their_commonest_value_whatever_word_says_counts(tmp_path, capsys, word):
    rows = [f"{0.01 * k},cmd,{2048 + (round(1000 * u) if k > 300 else 0)},{word}" for k, u in enumerate(SWEEP)]
    rows = [row for k, each in enumerate(rows) for row in (each, f"{0.01 * k},tacho,{k % 7},rpm")]
    (tmp_path / "x.csv").write_text("\n".join(["t,sensor,v,unit", *rows]))
    found, _ = proposed(capsys, tmp_path / "x.csv")
    assert "unit: counts, stop: 2048, per_volt: 200," in found["thruster_0/throttle.commanded"]
