"""The bench's own recordings, where they are at hand."""

import numpy as np
import pytest

from run_bag import read_run
from run_bag.importers.bench import find, import_recording
from run_bag.importers.options import BenchOptions

START_ROWS = {
    "CLLookupStep": 560, "CLLookupSine": 550, "CLLookupRamp": 560, "CL1stateStep": 400,
    "CL2stateKF1Sine": 430, "CL2stateNLO1Ramp": 300, "CL2stateKFNLO1Step": 390,
}  # fmt: skip
RAMP = {"2statep2V": 1.2, "2statem2V": 1.2, "2statem3V": 1.5, "2statep3V": 1.6}
WINDOWS = {
    "2statep3V": ((4300, 13500), (109, 339)), "2statep2V": ((3450, 12500), (87, 314)),
    "2statem2V": ((4550, 13500), (115, 339)), "2statem3V": ((4500, 14000), (114, 352)),
}  # fmt: skip


@pytest.fixture(scope="module")
def runs(thruster_bench_data, tmp_path_factory):
    """Import everything there once: name -> (imported, run)."""
    out = tmp_path_factory.mktemp("bench")
    imported = [import_recording(g, out, BenchOptions()) for g in find([thruster_bench_data]).groups]
    return {i.directory.name: (i, read_run(i.directory)) for i in imported}


def value(runs, name, what):
    return runs[name][0].decisions.value(what)


def test_every_recording_becomes_a_run_without_warning(runs):
    assert len(runs) >= 18 and all(not run.warnings for _, run in runs.values())


def test_ramps_are_those_that_were_published(runs):
    for name, duration in RAMP.items():
        assert value(runs, name, "duration of the ramp") == pytest.approx(duration, abs=0.15)


def test_published_windows_begin_before_the_ramp_and_agree_on_both_clocks(runs):
    for name, ((first, last), (dat_first, dat_last)) in WINDOWS.items():
        assert abs((first - 1) * 0.001 - (dat_first - 1) * 0.04) < 0.025
        assert abs((last - 1) * 0.001 - (dat_last - 1) * 0.04) < 0.045
        assert (first - 1) * 0.001 - 0.1 < value(runs, name, "start of the ramp") < (first - 1) * 0.001 + 0.3


def test_controller_recordings_start_where_it_was_published(runs):
    for name, row in START_ROWS.items():
        assert value(runs, name, "start of the controller's recording") == pytest.approx((row - 1) * 0.001, abs=0.07)


def test_only_one_fixture_was_turned_round_and_one_run_was_in_air(runs):
    assert [n for n in runs if value(runs, n, "load cell turned round")] == ["Ambientp3V"]
    assert [n for n in runs if value(runs, n, "water") is False] == ["201808061450_3V"]


def test_thrust_has_the_sign_of_the_rotation_in_every_run_in_water(runs):
    for name, (_, run) in runs.items():
        state = "daq/thruster_0/state.n" if "daq/thruster_0/state.n" in run else "thruster_0/state.n"
        if state not in run or value(runs, name, "water") is False:
            continue
        n = run[state].values
        thrust = run["thruster_0/load.wrench.force.x"].values
        fast = np.abs(n) > 50
        if fast.sum() > 1000:
            assert np.mean((thrust * np.sign(n))[fast]) > 0.5, name


def test_a_measured_throttle_keeps_its_plateaus(runs):
    for name in ("Fwd_Rvrs_Set1", "Fwd_Rvrs_Set2"):
        u = runs[name][1]["thruster_0/throttle.commanded"].values
        assert np.percentile(u, 99) == pytest.approx(3.0, abs=0.1)
        assert np.percentile(u, 1) == pytest.approx(-3.0, abs=0.1)
