"""On the real bench: refitted models describe it at least as well as the published parameters, seen and unseen."""

from pathlib import Path

import pytest

from run_bag.importers.bench import find, import_recording
from run_bag.importers.options import BenchOptions
from thruster_model.identification.experiment_io import read_experiments
from thruster_model.identification.study import run_study
from thruster_model.parameter_set_io import load_parameter_set

OPEN_LOOP = ("2statep2V", "2statep3V", "2statem2V", "2statem3V", "Ambientp3V", "Ambientm3V")


@pytest.fixture(scope="module")
def experiments(thruster_bench_data, tmp_path_factory):
    out = tmp_path_factory.mktemp("runs")
    folders = [thruster_bench_data / "open_loop", thruster_bench_data / "ambient"]
    groups = [g for g in find(folders).groups if g.stem in OPEN_LOOP]
    assert len(groups) == len(OPEN_LOOP)
    return read_experiments([Path(import_recording(g, out, BenchOptions()).directory) for g in groups])


@pytest.fixture(
    scope="module",
    params=[
        ("hl", False),
        pytest.param(("simplified", True), marks=pytest.mark.long),
        pytest.param(("hl", True), marks=pytest.mark.long),
    ],
    ids=["hl", "simplified, runs left out", "hl, runs left out"],
)
def model(request, experiments):
    """A model fitted to all runs, and to all but one in turn where that is said: six fits more, of hl a minute each."""
    name, hold_out = request.param
    start = load_parameter_set(name)
    return run_study([(start, start)], experiments, hold_out=hold_out).models[0]


def test_refitted_models_lose_to_the_published_ones_in_no_channel(model):
    assert model.comparison[-1].signal == "total"
    assert model.comparison[-1].error <= model.comparison[-1].reference
    assert not [c for c in model.comparison if c.worse]


def test_they_do_not_lose_on_runs_left_out_of_the_fit_either(model):
    if model.held_out is None:
        pytest.skip("a fit to all runs alone")
    _, comparison = model.held_out
    assert comparison[-1].error <= comparison[-1].reference
    assert not [c for c in comparison if c.worse]


def test_the_unusable_axial_recordings_are_left_out_and_the_usable_ones_kept(experiments):
    axial = {e.name for e in experiments if "axial" in e.measurements}
    assert axial == {"2statem2V", "2statem3V"}
    assert {e.name for e in experiments if "ambient" in e.measurements} == {"Ambientp3V", "Ambientm3V"}


def test_the_fit_is_physical(model):
    found = model.result.parameter_set.values
    assert 0.7 < found["delta_u2"] < 0.95
    assert 600 < found["c_u2"] < 800
    assert 10 < found["k_n"] < 16
