"""On the real bench: the matrix from the gauges, the mode from the steps, and thrust instead of a cut window."""

from pathlib import Path

import numpy as np
import pytest

from run_bag import read_run
from run_bag.importers.bench import find, import_recording
from run_bag.importers.options import BenchOptions
from run_bag.report.browser_check import check_report, missing_browser
from thruster_model.cli_load_cell import main
from thruster_model.load_cell.recordings_io import read_recordings
from thruster_model.load_cell.study import calibrate_recordings

RUNS = ("CLLookupStep", "CL1stateStep", "CL2stateNLO1Ramp", "2statem3V", "2statep3V", "Ambientp3V", "2statep1V")
AIR = "201808061450_3V"


@pytest.fixture(scope="module")
def folder(thruster_bench_data, tmp_path_factory) -> Path:
    out = tmp_path_factory.mktemp("bench")
    for group in find([thruster_bench_data]).groups:
        if group.stem in (*RUNS, AIR):
            import_recording(group, out, BenchOptions())
    return out


@pytest.fixture(scope="module")
def calibrated(folder):
    return calibrate_recordings([r for _, r in read_recordings(sorted(folder.iterdir()))])


@pytest.fixture(scope="module")
def results(folder, tmp_path_factory):
    out = tmp_path_factory.mktemp("results") / "out"
    # The fits see what they need: the hardest steps, one ramp, two stops.
    runs = [str(folder / name) for name in RUNS[:5]]
    assert main([*runs, "--out", str(out)]) == 0
    return out


def test_every_recording_is_reproduced_by_the_matrix_of_the_others_to_1e_3_newton_and_newton_metre(calibrated):
    assert set(calibrated.reproduced) == set(RUNS)
    for name, r in calibrated.reproduced.items():
        assert np.all(r.residual < 1e-3), name
        assert np.all(r.residual < 1.15 * r.rounding), name  # nothing is left but the rounding of the record


def test_relative_to_the_loads_it_is_1e_3_wherever_rounding_allows(calibrated):
    for name in set(RUNS) - {"2statep1V"}:
        assert calibrated.reproduced[name].force < 1e-3
        assert calibrated.reproduced[name].moment < 1e-3


def test_a_population_search_finds_the_same_matrix(calibrated):
    assert calibrated.calibration.complete
    np.testing.assert_allclose(calibrated.searched, calibrated.calibration.matrix, atol=1e-6)


def test_the_recording_in_air_has_another_matrix_and_is_left_out(calibrated):
    assert set(calibrated.other) == {AIR}


def test_most_of_the_windows_that_the_thesis_cuts_are_recovered(results, folder):
    for name, least in (("CLLookupStep", 0.7), ("CL1stateStep", 0.6), ("CL2stateNLO1Ramp", 0.8)):
        run, recorded = read_run(results / "recovered" / name), read_run(folder / name)
        start = recorded.time("thruster_0/thrust_setpoint.thrust")[0]
        time = run.time("thruster_0/load_recovered.wrench.force.x") + (run.start - recorded.start) * 1e-9
        deviation = run["thruster_0/load_recovered_deviation.wrench.force.x"].values
        late = 4.8 if "Ramp" in name else 5.0
        first = 0.6 if "Ramp" in name else 1.2
        cut = ((time >= start) & (time < start + first)) | ((time >= start + late) & (time < start + late + 1.2))
        assert np.mean(deviation[cut] < 1.0) > least


def test_recovered_thrust_agrees_with_the_reading_where_nothing_rings_and_not_where_it_does(results, folder):
    run, recorded = read_run(results / "recovered/CLLookupStep"), read_run(folder / "CLLookupStep")
    name = "thruster_0/load_recovered.wrench.force.x"
    time = run.time(name) + (run.start - recorded.start) * 1e-9
    reading = recorded.align(["thruster_0/load.wrench.force.x"], time, "mean")["thruster_0/load.wrench.force.x"]
    calm = (time > 2.0) & (time < 5.2)
    ringing = (time > 0.56) & (time < 0.85)
    assert np.sqrt(np.mean((reading - run[name].values)[calm] ** 2)) < 1.0
    assert np.sqrt(np.mean((reading - run[name].values)[ringing] ** 2)) > 5.0
    after = (time > 0.75) & (time < 1.2)
    assert np.ptp(run[name].values[after]) < 3.0 < np.ptp(reading[after])


def test_the_mode_is_where_the_spectra_show_it(results):
    text = (results / "load_cell.yaml").read_text()
    frequency = float(text.split("frequency:")[1].split("value:")[1].split()[0])
    assert 13.5 < frequency < 16.5


def test_the_report_draws_in_a_browser(results):
    if missing := missing_browser():
        pytest.skip(missing)
    assert check_report(results / "report.html").ok


def test_bad_input_is_refused_in_sentences(folder, results, tmp_path, capsys):
    assert main([str(folder / "CLLookupStep"), "--out", str(results)]) == 1
    assert "expected a new or empty folder" in capsys.readouterr().err
    assert main([str(tmp_path / "nowhere"), "--out", str(tmp_path / "a")]) == 1
    assert "nowhere" in capsys.readouterr().err
    assert main([str(folder / AIR), str(folder / AIR), "--out", str(tmp_path / "b")]) == 1
    assert "given more than once" in capsys.readouterr().err
    assert not (tmp_path / "b").exists()


def test_a_run_that_hardly_turns_is_calibrated_and_says_why_no_thrust_was_recovered(folder, tmp_path):
    assert main([str(folder / "2statep1V"), "--out", str(tmp_path / "out")]) == 0
    page = (tmp_path / "out/report.html").read_text()
    assert "No thrust was recovered." in page and "expected steady thrust" in page
    assert not (tmp_path / "out/recovered").exists()
