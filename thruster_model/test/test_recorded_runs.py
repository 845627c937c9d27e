"""Effects of the log on a finished run: what they leave in it, and that a fit's prediction undoes it."""

import numpy as np
import pytest

from run_bag import Topic, read_run, write_run
from thruster_model.cli_log_effects import main
from thruster_model.effects.active import ActiveEffects
from thruster_model.effects.recorded_runs_io import with_log_effects

TIME = 0.01 * np.arange(300)
SIGNALS = {
    "throttle": "throttle.commanded",
    "speed": "state.n",
    "ambient": "flow.ambient",
    "thrust": "load.wrench.force.x",
}


@pytest.fixture
def run(tmp_path):
    topics = [
        Topic.of_thruster(0, "throttle", TIME, {"commanded": np.sin(TIME)}),
        Topic.of_thruster(0, "state", TIME, {"n": np.cos(TIME)}),
        Topic.of_thruster(0, "flow", TIME, {"ambient": TIME**2}),
        Topic.of_thruster(0, "load", TIME, {"wrench.force.x": TIME}),
        Topic.of_thruster(0, "truth", TIME, {"n": np.cos(TIME)}),
    ]
    return write_run(tmp_path / "run", topics)


def times(run):
    """Return the stamps [s] of each signal since the first one of the truth, which no effect touches."""
    begin = run["thruster_0/truth.n"].stamps[0]
    return {signal: 1e-9 * (run[f"thruster_0/{channel}"].stamps - begin) for signal, channel in SIGNALS.items()}


@pytest.mark.parametrize(
    "sizes",
    [
        {"log_alignment": {"throttle": 0.05, "speed": -0.03, "load": 0.1}},
        {"clock_drift": {"rate": -0.008}},
        {"log_alignment": {"flow": 0.07}, "clock_drift": {"rate": 0.005}},
    ],
)
def test_stamps_are_moved_as_the_effect_says_and_predictions_move_them_back(run, tmp_path, sizes):
    effects = ActiveEffects(sizes={**sizes, "tach_scale": {"share": 0.1}})
    copy = read_run(with_log_effects(run, tmp_path / "copy", effects, seed=1))
    assert set(copy.metadata["log_effects"]) == set(sizes)
    for signal, stamps in times(copy).items():
        np.testing.assert_allclose(stamps, effects.stamped(signal, TIME), atol=2e-9)
        np.testing.assert_allclose(effects.taken(signal, stamps), TIME, atol=3e-9)
        original = read_run(run)[f"thruster_0/{SIGNALS[signal]}"]
        np.testing.assert_array_equal(copy[f"thruster_0/{SIGNALS[signal]}"].values, original.values)
    np.testing.assert_array_equal(copy["thruster_0/truth.n"].values, np.cos(TIME))


def test_samples_are_lost_and_stamps_scatter_by_the_seed(run, tmp_path):
    effects = ActiveEffects(sizes={"dropped_samples": {"share": 0.3}, "timestamp_jitter": {"deviation": 0.004}})
    copies = [read_run(with_log_effects(run, tmp_path / f"{k}", effects, seed)) for k, seed in enumerate((1, 1, 2))]
    thrust = [copy["thruster_0/load.wrench.force.x"] for copy in copies]
    assert np.mean(np.diff(thrust[0].values) == 0.0) == pytest.approx(0.3, abs=0.1)
    assert np.std(times(copies[0])["thrust"] - TIME) == pytest.approx(0.004, rel=0.3)
    assert np.array_equal(thrust[0].values, thrust[1].values) and np.array_equal(thrust[0].stamps, thrust[1].stamps)
    assert not np.array_equal(thrust[0].values, thrust[2].values)


def test_without_effects_of_the_log_the_run_is_its_own_copy(run, tmp_path, capsys):
    assert main([str(run), "--effects", "tach_lag.time=0.1", "--out", str(tmp_path / "copy")]) == 0
    assert capsys.readouterr().out.strip() == str(run)
    assert not (tmp_path / "copy").exists()
    assert main([str(run), "--effects", "clock_drift.rate=0.001", "--out", str(tmp_path / "copy")]) == 0
    assert capsys.readouterr().out.strip() == str(tmp_path / "copy")


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (["--effects", "clock_drift.rate=1"], "expected 0 or -0.01 to 0.01 s/s; found 1.0"),
        (["--effects", "clock_drift.rate=0.001", "--out", "{run}"], "nothing is overwritten"),
        (["--parameters", "none"], "none"),
    ],
)
def test_what_cannot_be_is_refused_with_a_sentence(run, tmp_path, capsys, more, sentence):
    assert main([str(run), "--out", str(tmp_path / "copy"), *(word.format(run=run) for word in more)]) == 1
    assert sentence in capsys.readouterr().err
