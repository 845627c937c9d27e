"""A throttle programme from a file, recorded by the synthetic bench."""

import numpy as np
import pytest

from rov_sim.cli_bench_campaign import main
from run_bag import read_run


def written(path, rows):
    path.write_text("\n".join(["time_s,throttle_V", *rows]) + "\n")
    return path


def test_a_programme_is_recorded_with_rest_around_it_by_both_flow_meters(tmp_path):
    time = np.arange(100) * 0.05
    file = written(tmp_path / "next.csv", [f"{t:g},{2.0 * np.sin(t):.6g}" for t in time])
    assert main(["--programme", str(file), "--out", str(tmp_path / "runs"), "--parameters", "hl"]) == 0
    for flow in ("axial", "ambient"):
        run = read_run(tmp_path / "runs" / f"programme_{flow}")
        throttle = run["thruster_0/throttle.commanded"].values
        assert throttle.size == 100 + 2 * 40 and not np.any(throttle[:40])
        assert throttle[40:140] == pytest.approx(2.0 * np.sin(time), abs=1e-5)
        assert f"thruster_0/flow.{flow}" in run and np.ptp(run["thruster_0/state.n"].values) > 20.0


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        ([], "expected a header time_s,throttle_V and rows; found 'time_s,throttle_V' and 0 rows"),
        (["0,1", "0.05,x"], "row 2: expected two numbers; found '0.05,x'"),
        (["0,1", "0.05,nan"], "expected finite numbers; found others in 1 cells"),
        (["0,1", "0.05,1", "0.2,1"], "expected commands a whole number of milliseconds apart, all alike"),
    ],
)
def test_a_file_that_is_no_programme_is_refused_and_nothing_is_written(tmp_path, capsys, rows, sentence):
    file = written(tmp_path / "next.csv", rows)
    assert main(["--programme", str(file), "--out", str(tmp_path / "runs")]) == 1
    assert sentence in capsys.readouterr().err and not (tmp_path / "runs").exists()
