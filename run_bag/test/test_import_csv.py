"""A csv with a map of its columns."""

import numpy as np
import pytest

from run_bag import read_run
from run_bag.cli_info import main as info
from run_bag.importers.cli_csv import main

CSV = "t,rpm,u,t2,force\n0.0,0,0.5,0.05,1\n0.1,60,0.6,0.15,\n0.2,bad,0.7,0.25,3\n"
MAP = """
thruster_0/state.n: {column: rpm, time_column: t, unit: rad/s, scale: 0.10471975511965977, nan: [bad]}
thruster_0/throttle.commanded: {column: 3, time_column: 1, unit: V, offset: 1}
thruster_0/load.wrench.force.x: {column: force, time_column: t2, unit: N}
"""


def files(tmp_path, text=CSV, columns=MAP):
    (tmp_path / "x.csv").write_text(text)
    (tmp_path / "map.yaml").write_text(columns)
    return [str(tmp_path / "x.csv"), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "out")]


def test_columns_become_channels_with_their_own_stamps_and_units(tmp_path, capsys):
    assert main(files(tmp_path)) == 0
    run = read_run(tmp_path / "out")
    np.testing.assert_allclose(run["thruster_0/state.n"].values, [0, 2 * np.pi, np.nan])
    assert run["thruster_0/throttle.commanded"].values.tolist() == [1.5, 1.6, 1.7]
    force = run["thruster_0/load.wrench.force.x"]
    np.testing.assert_equal(force.values, [1, np.nan, 3])
    assert force.stamps.tolist() == [50_000_000, 150_000_000, 250_000_000] and force.unit == "N"
    assert len(run.metadata["import"]["decisions"]) == 3
    assert main(files(tmp_path)) == 1
    assert "nothing is overwritten" in capsys.readouterr().err
    assert info([str(tmp_path / "out")]) == 0
    printed = capsys.readouterr().out
    assert "/thruster_0/state  thruster_msgs/msg/ThrusterState  3" in printed and "[rad/s]" in printed
    assert "sha256" in printed and "column 'rpm'" in printed
    assert info([str(tmp_path / "none")]) == 1


def test_negative_times_are_moved_to_the_start_of_the_clock(tmp_path):
    columns = "thruster_0/state.n: {column: 2, time_column: 1, unit: rad/s}"
    assert main(files(tmp_path, "-5,1\n-4,2\n", columns)) == 0
    assert read_run(tmp_path / "out")["thruster_0/state.n"].stamps.tolist() == [10**9, 2 * 10**9]


@pytest.mark.parametrize(
    ("text", "columns", "sentence"),
    [
        (CSV, "a/b.c: {column: 1, time_column: 1, unit: V}", "unknown topic 'a/b'; known are thruster_<i>/"),
        (CSV, MAP.replace("rad/s", "rpm"), "expected unit 'rad/s', found 'rpm'"),
        (CSV, MAP.replace("state.n", "state.m"), "no numeric field 'm'"),
        (
            CSV,
            MAP.replace("column: rpm", "column: speed"),
            "expected column 'speed', found t, rpm, u, t2, force",
        ),
        (CSV, MAP.replace("column: 3", "column: 9"), "expected column 9, found 5 columns"),
        (CSV, MAP.replace(", nan: [bad]", ""), "line 4, column 2: expected a number, found 'bad'"),
        (CSV, MAP.replace("offset: 1", "ofset: 1"), "unknown key 'ofset'"),
        (CSV, MAP.replace(", unit: V", ""), "key 'unit' is missing"),
        (CSV, MAP.replace("offset: 1", "offset: one"), "offset: expected a number, found 'one'"),
        (CSV, "", "expected entries"),
        (CSV, "[: x", "cannot be read as YAML"),
        (CSV.replace("0.2,bad", "0.05,bad"), MAP, "line 4: rows out of order: 0.05 s after 0.1 s"),
        ("t,rpm,u,t2,force\n", MAP, "expected rows of numbers, found none"),
    ],
)
def test_what_does_not_fit_is_refused_with_a_sentence(tmp_path, capsys, text, columns, sentence):
    assert main(files(tmp_path, text, columns)) == 1
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
