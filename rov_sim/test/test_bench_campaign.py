"""The synthetic campaign: reproducible, complete, readable, its truth beside it, nothing overwritten."""

from pathlib import Path

import numpy as np
import pytest

from rov_sim.bench_campaign import altered, run_campaign
from rov_sim.cli_bench_campaign import main
from run_bag import read_run
from thruster_model.parameter_set_io import load_parameter_set

NAMES = [
    "multisine_ambient",
    "ramp_forward_ambient",
    "ramp_forward_axial",
    "ramp_reverse_axial",
    "steps_axial",
]


def campaign(seed):
    rng = np.random.default_rng(seed)
    truth = altered(load_parameter_set("hq"), 0.1, rng)
    return truth, run_campaign(truth, rng)


@pytest.fixture(scope="module")
def first():
    return campaign(1)


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Folder of the campaign of seed 1, as the command line writes it."""
    folder = tmp_path_factory.mktemp("campaign") / "out"
    assert main(["--out", str(folder), "--seed", "1"]) == 0
    return folder


def test_a_seed_reproduces_its_campaign_bit_for_bit(first):
    truth, runs = campaign(1)
    assert truth.values == first[0].values
    for run, again in zip(runs, first[1], strict=True):
        assert run.name == again.name
        assert run.signals.keys() == again.signals.keys()
        for name, recorded in run.signals.items():
            np.testing.assert_array_equal(recorded.time, again.signals[name].time)
            np.testing.assert_array_equal(recorded.values, again.signals[name].values)


def test_another_seed_is_another_thruster_and_other_noise(first):
    truth, runs = campaign(2)
    published = load_parameter_set("hq").values
    for name, value in truth.values.items():
        same = name == "u_dot_max" or published[name] == 0.0
        assert (value == first[0].values[name]) is same, name
    for run, other in zip(runs, first[1], strict=True):
        assert not np.array_equal(run.signals["thrust"].values, other.signals["thrust"].values)


def test_parameters_are_altered_by_about_the_spread_and_keep_their_signs():
    published = load_parameter_set("hq")
    rng = np.random.default_rng(3)
    logs = []
    for _ in range(50):
        values = altered(published, 0.1, rng).values
        assert values["u_dot_max"] == published.values["u_dot_max"]
        logs += [np.log(values[n] / p) for n, p in published.values.items() if p != 0.0 and n != "u_dot_max"]
    assert np.std(logs) == pytest.approx(0.1, rel=0.06)
    assert abs(np.mean(logs)) < 4 * 0.1 / np.sqrt(len(logs))


def test_no_spread_leaves_the_set_as_it_is():
    published = load_parameter_set("hl")
    assert altered(published, 0.0, np.random.default_rng(1)).values == published.values


def test_every_recording_rests_then_excites_and_sees_one_flow(first):
    _, runs = first
    assert sorted(run.name for run in runs) == NAMES
    for run in runs:
        throttle = run.signals["throttle"]
        assert not np.any(throttle.values[throttle.time < 2.0]), run.name
        assert np.max(np.abs(throttle.values)) <= 3.0
        flow = set(run.signals) - {"throttle", "speed", "thrust", "torque"}
        assert flow == {run.name.rsplit("_", 1)[1]}
    highest = max(float(r.signals["throttle"].values.max()) for r in runs)
    lowest = min(float(r.signals["throttle"].values.min()) for r in runs)
    assert (highest, lowest) == (3.0, -3.0)


def test_the_speed_carries_the_sign_of_the_rotation_and_the_offset_of_the_tachometer(first):
    _, runs = first
    speed = {r.name: r.signals["speed"] for r in runs}
    assert np.median(speed["ramp_forward_axial"].values[6000:9000]) > 80.0
    assert np.median(speed["ramp_reverse_axial"].values[6000:9000]) < -80.0
    rest = speed["steps_axial"].values[:1900]
    assert np.median(rest) == pytest.approx(0.023 * 49.9723, abs=0.2)


def test_the_command_line_writes_runs_that_can_be_read_and_the_truth(written, first):
    assert sorted(p.name for p in written.iterdir()) == [*NAMES, "truth.yaml"]
    truth, runs = first
    assert load_parameter_set(str(written / "truth.yaml")).values == truth.values
    by_name = {run.name: run for run in runs}
    for name in NAMES:
        run = read_run(written / name)
        assert run.warnings == ()
        assert run.metadata["seed"] == 1
        assert run.metadata["parameter_set"] == truth.source
        signals = by_name[name].signals
        flow = name.rsplit("_", 1)[1]
        for channel, signal in {
            "throttle.commanded": "throttle",
            "state.n": "speed",
            "load.wrench.force.x": "thrust",
            "load.wrench.torque.x": "torque",
            f"flow.{flow}": flow,
        }.items():
            read = run[f"thruster_0/{channel}"].values
            np.testing.assert_array_equal(read, signals[signal].values)
            np.testing.assert_allclose(run.time(f"thruster_0/{channel}"), signals[signal].time, atol=1e-9)
        np.testing.assert_array_equal(run["thruster_0/state.sign_source"].values, 2)
        assert run["thruster_0/state.n"].unit == "rad/s"


def test_the_command_line_names_what_it_wrote(tmp_path, capsys):
    assert main(["--out", str(tmp_path / "out"), "--seed", "3", "--spread", "0"]) == 0
    listed = [Path(line) for line in capsys.readouterr().out.splitlines()]
    assert sorted(p.name for p in listed) == NAMES
    assert all(p.is_dir() for p in listed)
    published = load_parameter_set("hq").values
    assert load_parameter_set(str(tmp_path / "out" / "truth.yaml")).values == published


def test_a_folder_with_files_in_it_is_not_written_to(tmp_path, capsys):
    (tmp_path / "mine").write_text("keep")
    assert main(["--out", str(tmp_path)]) == 1
    assert capsys.readouterr().err == f"{tmp_path}: expected a new or empty folder; found files in it\n"
    assert [p.name for p in tmp_path.iterdir()] == ["mine"]


def test_a_set_that_does_not_exist_is_refused_with_what_is_known(tmp_path, capsys):
    assert main(["--out", str(tmp_path / "out"), "--parameters", "none"]) == 1
    assert "hl, hl_bench, hq, hq_bench, kim_chung" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_file_in_the_place_of_the_folder_is_refused_with_a_sentence(tmp_path, capsys):
    (tmp_path / "file").write_text("keep")
    assert main(["--out", str(tmp_path / "file")]) == 1
    assert str(tmp_path / "file") in capsys.readouterr().err


def test_an_alteration_beyond_what_is_admissible_is_refused_with_a_sentence(tmp_path, capsys):
    assert main(["--out", str(tmp_path / "out"), "--spread", "20", "--seed", "1"]) == 1
    assert "expected a number from" in capsys.readouterr().err


def test_effects_are_recorded_and_written_with_the_truth(tmp_path):
    words = ["--effect", "coulomb_friction.deceleration=200", "--effect", "command_delay.time=0.1"]
    assert main(["--out", str(tmp_path / "plain"), "--seed", "5"]) == 0
    assert main(["--out", str(tmp_path / "altered"), "--seed", "5", *words]) == 0
    truth = load_parameter_set(tmp_path / "altered" / "truth.yaml")
    assert truth.effects.sizes["command_delay"]["time"] == 0.1
    plain, slowed = (read_run(tmp_path / k / "ramp_forward_axial") for k in ("plain", "altered"))
    name = "thruster_0/state.n"
    at_speed = (plain.time(name) > 6) & (plain.time(name) < 9)
    loss = np.mean(plain[name].values[at_speed]) - np.mean(slowed[name].values[at_speed])
    assert 5 < loss < 200 / truth.values["k_n"] + 1
    assert (
        plain["thruster_0/throttle.commanded"].values.tolist()
        == slowed["thruster_0/throttle.commanded"].values.tolist()
    )


@pytest.mark.parametrize(
    ("word", "sentence"),
    [
        ("friction.x=1", "expected one of"),
        ("coulomb_friction=1", "expected EFFECT.PARAMETER=SIZE"),
        ("coulomb_friction.deceleration=much", "with a number as size"),
        ("coulomb_friction.deceleration=9000", "expected 0 or 0 to 500 rad/s^2"),
    ],
)
def test_a_wrong_effect_is_refused_with_a_sentence(tmp_path, capsys, word, sentence):
    assert main(["--out", str(tmp_path / "x"), "--effect", word]) == 1
    assert sentence in capsys.readouterr().err
    assert not (tmp_path / "x").exists()
