"""Columns that a map calls by their names without the unit in brackets."""

import numpy as np
import pytest

from run_bag import read_run
from run_bag.importers.cli_recording import main

TIME = np.arange(40) * 0.05


def imported(tmp_path, text, **tables):
    """Import tables (name, without suffix: text) by a map; return the exit status."""
    for name, content in tables.items():
        (tmp_path / f"{name}.csv").write_text(content)
    (tmp_path / "map.yaml").write_text(text)
    files = [str(tmp_path / f"{name}.csv") for name in tables]
    return main([*files, "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / "run")])


def wide(*names):
    return "\n".join([",".join(names), *(",".join([f"{t:g}", *("60" for _ in names[1:])]) for t in TIME)])


STATE = "thruster_0/state.n: {column: tacho, unit: rpm}\n"


def test_a_long_table_s_column_is_found_without_the_unit_that_its_rows_state(tmp_path):
    rows = [f"{t:g},{name},{value},{unit}" for t in TIME for name, value, unit in (("tacho", 60, "rpm"), ("u", 3, "V"))]
    text = "time: {column: time, unit: s}\n" + STATE + "thruster_0/throttle.commanded: {column: 'u [V]', unit: V}"
    assert imported(tmp_path, text, x="\n".join(["time,signal,value,unit", *rows])) == 0
    run = read_run(tmp_path / "run")
    np.testing.assert_allclose(run["thruster_0/state.n"].values, 2.0 * np.pi)
    np.testing.assert_allclose(run["thruster_0/throttle.commanded"].values, 3.0)


@pytest.mark.parametrize("name", ["tacho", "tacho [rpm]"])
def test_a_wide_table_s_columns_and_times_are_found_with_and_without_their_units(tmp_path, name):
    text = f"time: {{column: t, unit: s}}\nthruster_0/state.n: {{column: '{name}', unit: rpm}}"
    assert imported(tmp_path, text, x=wide("t [s]", "tacho [rpm]")) == 0
    np.testing.assert_allclose(read_run(tmp_path / "run")["thruster_0/state.n"].values, 2.0 * np.pi)


def test_a_whole_name_goes_before_one_without_its_unit(tmp_path, capsys):
    time = "time: {column: t, unit: s}\n"
    assert imported(tmp_path, time + STATE, x=wide("t", "tacho [rpm]", "tacho (Hz)")) == 1
    assert "found t, tacho [rpm], tacho (Hz) ('tacho' more than once)" in capsys.readouterr().err
    assert imported(tmp_path, time + STATE, x=wide("t", "tacho [rpm]", "tacho")) == 0
    assert "column 'tacho' at 't';" in str(read_run(tmp_path / "run").metadata)
    (tmp_path / "two").mkdir()
    assert imported(tmp_path / "two", time + STATE, a=wide("t", "tacho [Hz]"), b=wide("t", "tacho")) == 0
    assert "of b.csv" in str(read_run(tmp_path / "two" / "run").metadata)
