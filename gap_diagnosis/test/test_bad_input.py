"""Damaged runs through the command line: a sentence that says what is wrong, never a confident physical effect."""

import json
import pickle
import re
from types import SimpleNamespace

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from gap_diagnosis.blind_check.generator import Truth, generate
from gap_diagnosis.cli_diagnose import main
from gap_diagnosis.diagnosis import Unfit
from run_bag import Topic, write_run
from thruster_model.parameter_set_io import load_parameter_set

HL = dict(load_parameter_set("hl").values)
FIELDS = {
    "throttle": ("throttle", "thruster_msgs/msg/Throttle", "commanded"),
    "n": ("state", "thruster_msgs/msg/ThrusterState", "n"),
    "ambient": ("flow", "thruster_msgs/msg/FlowVelocity", "ambient"),
    "thrust": ("load", "geometry_msgs/msg/WrenchStamped", "wrench.force.x"),
    "torque": ("load", "geometry_msgs/msg/WrenchStamped", "wrench.torque.x"),
}
NAMES = {channel: f"thruster_0/{topic}.{field}" for channel, (topic, _, field) in FIELDS.items()}
LEVELS = [0.0, 2.4, -1.8, 3.1, -2.6, 1.5, -3.2, 2.0, 2.8, 0.0]
PROGRAMME = {
    "steps": np.repeat(LEVELS, 25),
    "ramps": np.interp(np.arange(250), [0, 25, 70, 125, 180, 225, 250], [0.0, 0.0, 3.0, -2.8, 2.2, 0.0, 0.0]),
}
HONEST = ("no_gap", "parameters", "cannot_tell", "unknown", "not_enough_data")


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    with threadpool_limits(1):
        yield


def healthy(parameters=None, programme=None):
    """Return runs as {name: {channel: (stamps, values)}}."""
    rng = np.random.default_rng(3)
    spread = {name: value * (1.0 + 0.02 * rng.standard_normal()) for name, value in HL.items()}
    runs = generate(
        Truth(model="hl", parameters=parameters or spread), programme or PROGRAMME, closed_loop=False, seed=2
    )
    return {run.name: {c: (s.time.copy(), s.values.copy()) for c, s in run.recorded.items()} for run in runs}


def scaled(factor, *channels):
    return changed(lambda time, values: (time, factor * values), *channels)


def changed(change, *channels):
    def damage(runs):
        return {
            name: {c: change(*s) if c in (channels or FIELDS) else s for c, s in run.items()}
            for name, run in runs.items()
        }

    return damage


def without(*channels):
    return lambda runs: {name: {c: s for c, s in run.items() if c not in channels} for name, run in runs.items()}


def pinned(time, values):
    return time, np.where(values > np.median(values), 9.0, -9.0)


def silent(time, values):
    kept = (time < 3.0) | (time > 8.0)
    return time[kept], values[kept]


def clipped(time, values):
    most = 0.6 * np.max(np.abs(values))
    return time, np.clip(values, -most, most)


def every(count):
    return lambda time, values: (time[::count], values[::count])


def asleep(time, values):
    return time, 0.2 * np.random.default_rng(1).standard_normal(time.size)


def written(runs, folder):
    paths = []
    for name, run in runs.items():
        topics = {}
        for channel, (time, values) in run.items():
            topic, kind, field = FIELDS[channel]
            stamps = 10**9 + np.round(time * 1e9).astype(np.int64)
            fields = topics.setdefault(topic, {"type": kind, "stamps": stamps, "fields": {}})["fields"]
            fields |= {field: values} | ({"sign_source": np.full(values.size, 1)} if channel == "n" else {})
        made = [Topic(name=f"thruster_0/{topic}", frame="thruster_0", **each) for topic, each in topics.items()]
        paths.append(write_run(folder / name, made, {"run": name}))
    return paths


@pytest.fixture
def diagnosed(tmp_path, capsys):
    def run(runs, *options, model="hl"):
        paths = written(runs, tmp_path / "runs")
        status = main([*map(str, paths), "--model", model, "--out", str(tmp_path / "out"), *options])
        said = capsys.readouterr()
        file = tmp_path / "out/diagnosis.json"
        content = json.loads(file.read_text()) if file.exists() else None
        return SimpleNamespace(status=status, error=said.err, output=said.out, content=content)

    return run


REFUSED = {
    "speed in rev/s": (scaled(1.0 / (2.0 * np.pi), "n"), "n", "as if in rev/s or in Hz; expected rad/s"),
    "speed in rev/min": (scaled(30.0 / np.pi, "n"), "n", "as if in rev/min; expected rad/s"),
    "speed in deg/s": (scaled(180.0 / np.pi, "n"), "n", "as if in deg/s; expected rad/s"),
    "speed times 1000": (scaled(1000.0, "n"), "n", "as if in thousandths of its unit; expected rad/s"),
    "thrust over 1000": (scaled(0.001, "thrust"), "thrust", "as if in thousands of its unit; expected N"),
    "thrust in kgf": (scaled(1.0 / 9.80665, "thrust"), "thrust", "as if in kilogram-force; expected N"),
    "thrust in lbf": (scaled(1.0 / 4.44822, "thrust"), "thrust", "as if in pound-force; expected N"),
    "torque times 1000": (scaled(1000.0, "torque"), "torque", "as if in thousandths of its unit; expected N m"),
    "flow in cm/s": (scaled(100.0, "ambient"), "ambient", "as if in hundredths of its unit; expected m/s"),
    "throttle in mV": (scaled(1000.0, "throttle"), "throttle", r"readings of up to 3200 are about .* expected V"),
    "throttle in mV beside a torque of noise": (
        lambda runs: scaled(1000.0, "throttle")(changed(asleep, "torque")(runs)),
        "throttle",
        r"readings of up to 3200 are 3.72e\+03 times the dead zone's edge \(0.86 V\); expected V",
    ),
    "throttle in per cent": (scaled(20.0, "throttle"), "throttle", r"readings of up to 64 are about .* expected V"),
    "speed's sign": (scaled(-1.0, "n"), "n", "its sign is opposite .* expected positive for forward thrust"),
    "thrust's sign": (scaled(-1.0, "thrust"), "thrust", "its sign is opposite .* expected positive"),
    "flow's sign": (scaled(-1.0, "ambient"), "ambient", "its sign is opposite .* expected positive"),
    "speed without sign": (
        changed(lambda time, n: (time, np.abs(n)), "n"),
        "n",
        "readings stay positive while the throttle reverses, as if of a sensor without sign; expected negative ones",
    ),
    "a tachometer that only scatters": (
        changed(lambda time, n: (time, 6.0 * asleep(time, n)[1]), "n"),
        "n",
        r"readings scatter by 1.\d+ rad/s about .* do not follow the throttle; expected them to move by \d+",
    ),
    "a load cell that only scatters": (changed(asleep, "thrust"), "thrust", "do not follow the throttle"),
    "another clock": (
        changed(lambda time, n: (time + 3.0, n), "n"),
        "n",
        "readings come 3.0 s later than the model says; expected stamps on the clock of the throttle",
    ),
    "a constant throttle": (
        changed(lambda time, u: (time, np.full(u.size, 1.0)), "throttle"),
        "throttle",
        "constant at 1 V while state.n runs from -",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_no_effect_explains_is_refused_by_channel_with_what_was_found_and_expected(name, diagnosed):
    damage, channel, sentence = REFUSED[name]
    found = diagnosed(damage(healthy()))
    assert found.status == 1
    assert found.content is None
    wrong = [line for line in found.error.splitlines() if not line.startswith("  ")]
    assert len(wrong) == 1 and wrong[0].startswith(NAMES[channel])
    assert re.search(sentence, wrong[0]), wrong[0]


NOT_ENOUGH = {
    "1 Hz": (
        changed(every(25)),
        "steps: thruster_0/state.n: expected at least 20 samples, found 10, one every 1 s; left out",
    ),
    "4 Hz": (changed(every(6)), "thruster_0/state.n: expected samples at least every 0.2 s, found one every 0.24 s"),
    "2 s": (changed(lambda t, v: (t[50:75] - t[50], v[50:75])), "expected at least 5 s of recordings, found 1.9 s"),
    "idle": (changed(lambda t, u: (t, 0.0 * u), "throttle"), "the throttle never leaves the dead zone (-0.83 to"),
    "throttle over 1000": (scaled(0.001, "throttle"), "found at most 0.0032 V; expected steps beyond it, in volts"),
}


@pytest.mark.parametrize("name", NOT_ENOUGH)
def test_runs_that_say_too_little_end_in_not_enough_data_with_what_is_missing(name, diagnosed):
    damage, sentence = NOT_ENOUGH[name]
    found = diagnosed(damage(healthy()))
    assert found.status == 0
    assert found.content["verdict"] == "not_enough_data" and not found.content["effects"]
    assert sentence in found.error
    assert any(sentence in warning for warning in found.content["warnings"])


def test_a_flipped_throttle_is_called_the_polarity_and_nothing_else(diagnosed):
    found = diagnosed(scaled(-1.0, "throttle")(healthy()))
    assert (found.status, found.content["verdict"]) == (0, "effect")
    assert [effect["id"] for effect in found.content["effects"]] == ["thruster_polarity"]


@pytest.mark.long
@pytest.mark.parametrize("offset", (-0.19, 0.19))
def test_a_flow_meter_off_its_zero_does_not_make_a_flipped_throttle_a_matter_of_signs(diagnosed, offset):
    runs = changed(lambda time, flow: (time, flow + offset), "ambient")(scaled(-1.0, "throttle")(healthy()))
    found = diagnosed(runs)
    assert found.status == 0
    named = {effect["id"] for effect in found.content["effects"]}
    assert named == {"thruster_polarity", "flow_bias"} or (not named and found.content["verdict"] in HONEST)


def test_sentences_come_back_from_another_process_as_they_were():
    broken = pickle.loads(pickle.dumps(Unfit(["speed: in rev/s", "thrust: in kgf"])))
    assert str(broken) == "speed: in rev/s\nthrust: in kgf" and broken.problems == ["speed: in rev/s", "thrust: in kgf"]


def test_constant_clipped_and_interrupted_channels_are_named_and_no_effect_is_claimed_for_them(diagnosed):
    runs = changed(lambda time, u: (time, 0.0 * u), "ambient")(healthy())
    runs = changed(clipped, "thrust")(changed(silent, "n")(runs))
    found = diagnosed(runs)
    assert found.status == 0
    assert found.content["verdict"] in HONEST and not found.content["effects"]
    for sentence in (
        r"steps: thruster_0/flow.ambient: expected readings that move, found 0 throughout; left out",
        r"steps: thruster_0/load.wrench.force.x: \d+ % of the samples stand at a limit of \d+.*; masked",
        r"steps: thruster_0/state.n: no samples for 5.1 s from 3.0 s on",
    ):
        assert re.search(sentence, found.error), found.error


def test_a_channel_that_only_knows_its_two_limits_is_left_out(diagnosed):
    found = diagnosed(changed(pinned, "torque")(healthy()))
    assert found.content["verdict"] in HONEST and not found.content["effects"]
    assert "steps: thruster_0/load.wrench.torque.x: expected at least 20 samples between its limits" in found.error


def test_where_the_throttle_was_silent_nothing_is_made_of_what_was_measured_meanwhile(diagnosed):
    found = diagnosed(changed(silent, "throttle")(healthy()))
    assert found.status == 0
    assert found.content["verdict"] in HONEST and not found.content["effects"]
    sentence = (
        "steps: thruster_0/throttle: no commands for 5.1 s from 3.0 s on; what was measured meanwhile is left out"
    )
    assert sentence in found.error.replace("steps from 0.0 s", "steps")


def test_samples_that_are_no_numbers_are_passed_over_and_infinite_ones_named(diagnosed):
    runs = changed(lambda time, n: (time, np.where(np.arange(n.size) % 3 == 0, n, np.nan)), "n")(healthy())
    runs = changed(lambda time, q: (time, np.where(np.arange(q.size) == 50, np.inf, q)), "torque")(runs)
    found = diagnosed(runs)
    assert found.content["verdict"] in HONEST and not found.content["effects"]
    assert "thruster_0/state.n" in found.content["gap"]["channels"]
    assert "steps: thruster_0/load.wrench.torque.x: expected numbers, found 1 infinite ones; left out" in found.error


@pytest.mark.long
def test_runs_of_another_thruster_are_no_confident_effect(diagnosed):
    kept = ("u_dot_max", "delta_u1", "delta_u2")
    factors = {name: (1.0 if name in kept else (3.0, 1.0 / 3.0, 1.0)[k % 3]) for k, name in enumerate(HL)}
    steps = {"steps": PROGRAMME["steps"]}
    found = diagnosed(healthy({name: value * factors[name] for name, value in HL.items()}, steps))
    assert found.status == 1 or (found.content["verdict"] in HONEST and not found.content["effects"])


@pytest.mark.parametrize(
    ("lost", "sentence"),
    [
        (("throttle",), "steps: expected a channel thruster_0/throttle.commanded with values; found thruster_0/flow"),
        (("n", "ambient", "thrust", "torque"), "steps: expected one of thruster_0/state.n, thruster_0/flow.axial"),
    ],
)
def test_a_run_without_throttle_or_without_readings_is_refused_with_the_channels_it_has(lost, sentence, diagnosed):
    found = diagnosed(without(*lost)(healthy()))
    assert (found.status, found.content) == (1, None)
    assert sentence in found.error
