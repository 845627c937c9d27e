"""The generator against the simulator's plant, two implementations of the same equations."""

import time

import numpy as np
import pytest

from gap_diagnosis.blind_check import generator
from gap_diagnosis.blind_check.catalogue import EFFECTS, OUTSIDE
from gap_diagnosis.blind_check.generator import NOISE, Truth, generate
from gap_diagnosis.blind_check.recording import Colour
from gap_diagnosis.blind_check.signals import PERIOD, closed_loop_campaign, rich_campaign
from thruster_model.effects.active import ActiveEffects
from thruster_model.effects.chains import SENSED
from thruster_model.effects.stages import LIBRARY
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.whole_run import readings, simulated_rows

MODELS = ("hl", "hq", "simplified")
SIGNALS = {"n": "speed", "ambient": "ambient", "thrust": "thrust", "torque": "torque"}
DT = 0.001
EVERY = round(PERIOD / DT)
AT_RANDOM = ("log_alignment", "clock_drift", "timestamp_jitter", "dropped_samples", "flow_spikes")
PARAMETERS = {model: dict(load_parameter_set(model).values) for model in MODELS}


def programme(seed=7):
    campaign = rich_campaign(np.random.default_rng(seed), duration=16.0)
    return {name: campaign[name] for name in ("steps", "ramps")}


def generated(model="hl", throttle=None, seed=1, closed_loop=False, **more):
    truth = Truth(model=model, parameters=PARAMETERS[model], **more)
    return generate(truth, programme() if throttle is None else throttle, closed_loop=closed_loop, seed=seed)


def simulated(model, throttle, sizes, gates):
    effects = ActiveEffects(sizes=sizes)
    commands = np.repeat(throttle, EVERY)
    coefficients = load_parameter_set(model).coefficients
    rows = simulated_rows(coefficients, commands, DT, effects=effects.plant, gates=gates)
    read = dict(zip(SENSED, readings(rows, DT, effects.sensors), strict=True))
    return {name: read[signal][:-1:EVERY] for name, signal in SIGNALS.items()}


def middle(name, sign):
    size, more = EFFECTS[name].size, EFFECTS[name].more
    largest = size.upper if sign > 0 else -(size.most_negative or size.upper)
    value = 0.5 * (size.lower + size.upper) if size.falls else 0.5 * largest
    return {name: {size.name: value, **{s.name: float(np.sqrt(s.lower * s.upper)) for s in more}}}


def rms(first, second):
    return np.sqrt(np.mean([((first[c] - second[c]) / NOISE[c]) ** 2 for c in NOISE]))


@pytest.mark.parametrize("model", MODELS)
def test_without_effects_it_agrees_with_the_simulators_plant_to_a_hundredth_of_the_noise(model):
    for run in generated(model):
        plant = simulated(model, run.recorded["throttle"].values, {}, ())
        for channel, std in NOISE.items():
            assert np.max(np.abs(run.clean[channel] - plant[channel])) < 0.05 * std, channel
        assert rms(run.clean, plant) < 0.01


def test_it_knows_every_effect_of_the_library_by_the_same_parameters():
    sizes = {name: (kind.size.name, *(s.name for s in kind.more)) for name, kind in EFFECTS.items()}
    del sizes["log_alignment"]  # its size is named after the channel
    library = {name: tuple(p.name for p in effect.parameters) for name, effect in LIBRARY.items()}
    assert sizes == {name: names for name, names in library.items() if name != "log_alignment"}
    assert {name: kind.block for name, kind in EFFECTS.items()} == {n: effect.block for n, effect in LIBRARY.items()}


@pytest.mark.parametrize(
    ("name", "sign"),
    [(n, s) for n, kind in EFFECTS.items() if n not in AT_RANDOM for s in ((1, -1) if kind.size.signed else (1,))],
)
def test_each_effect_means_what_it_means_in_the_library(name, sign, monkeypatch):
    drawn = []
    draw_gates = generator._gates
    monkeypatch.setattr(generator, "_gates", lambda *given: drawn.append(draw_gates(*given)) or drawn[-1])
    sizes = middle(name, sign) if name != "thruster_polarity" else {name: {"reversed": 1.0}}
    runs, without = generated(effects=sizes), generated()
    felt = np.sqrt(np.mean([rms(a.clean, b.clean) ** 2 for a, b in zip(runs, without, strict=True)]))
    assert felt > 0.1
    for k, run in enumerate(runs):
        gates = np.repeat(drawn[k], round(0.01 / DT)) if drawn else ()
        plant = simulated("hl", run.recorded["throttle"].values, sizes, gates)
        # what is left: the library's commands are held for DT, and its dry friction creeps where ours sticks
        assert rms(run.clean, plant) < 0.01 + 0.02 * felt


def test_a_rotor_held_by_dry_friction_does_not_move_at_all():
    drive = 280.0
    throttle = {"held": np.full(100, 0.86 + drive / 737.2)}
    held = generated(throttle=throttle, effects={"coulomb_friction": {"deceleration": 300.0}})[0]
    assert np.all(held.states["n"] == 0.0)
    turning = generated(throttle=throttle, effects={"coulomb_friction": {"deceleration": 100.0}})[0]
    assert turning.states["n"][-1] > 10.0


def test_the_sensors_noise_is_white_and_as_large_as_stated():
    for run in generated():
        for channel, std in NOISE.items():
            noise = run.recorded[channel].values - run.clean[channel]
            assert np.std(noise) == pytest.approx(std, rel=0.2)
            assert abs(np.mean(noise[1:] * noise[:-1])) < 0.25 * std**2


def test_noise_is_in_front_of_the_converter_of_the_tachometer():
    for run in generated(effects={"tach_quantization": {"step": 5.0}}):
        steps = run.recorded["n"].values / 5.0
        assert steps == pytest.approx(np.round(steps), abs=1e-9)
    for run in generated(effects={"tach_dropout": {"threshold": 20.0}}):
        assert not np.any((np.abs(run.recorded["n"].values) < 20.0) & (run.recorded["n"].values != 0.0))


def test_a_late_channel_has_late_stamps_and_no_other_channel_has():
    run, plain = (generated(effects=e)[0] for e in ({"log_alignment": {"load": 0.1}}, {}))
    for channel in ("throttle", *NOISE):
        late = 0.1 if channel in ("thrust", "torque") else 0.0
        assert run.recorded[channel].time == pytest.approx(plain.recorded[channel].time + late)
        assert np.array_equal(run.recorded[channel].values, plain.recorded[channel].values)


def test_a_drifting_clock_stretches_the_sensors_stamps_alone():
    run = generated(effects={"clock_drift": {"rate": 0.01}})[0]
    assert run.recorded["throttle"].time[-1] == pytest.approx(399 * PERIOD)
    assert run.recorded["n"].time[-1] == pytest.approx(1.01 * 399 * PERIOD)


def test_scattered_stamps_stay_in_order():
    run = generated(effects={"timestamp_jitter": {"deviation": 0.03}})[0]
    at = PERIOD * np.arange(400)
    for samples in run.recorded.values():
        assert np.all(np.diff(samples.time) >= 0.0)
        assert 0.01 < np.std(samples.time - at) < 0.04


def test_dropped_samples_repeat_the_last_one_in_that_topic():
    run = generated(effects={"dropped_samples": {"share": 0.4}})[0]
    repeats = {c: np.diff(run.recorded[c].values) == 0.0 for c in NOISE}
    assert np.array_equal(repeats["thrust"], repeats["torque"]), "one topic, one loss"
    assert not np.array_equal(repeats["n"], repeats["thrust"])
    assert np.mean(repeats["n"]) == pytest.approx(0.4, abs=0.08)
    assert np.all(np.diff(run.recorded["throttle"].time) > 0.0)


def test_spikes_hit_the_stated_share_of_the_flow_and_are_no_part_of_what_is_clean():
    run, plain = (generated(effects=e)[0] for e in ({"flow_spikes": {"share": 0.2}}, {}))
    difference = run.recorded["ambient"].values - plain.recorded["ambient"].values
    assert np.mean(difference != 0.0) == pytest.approx(0.2, abs=0.07)
    assert np.std(difference[difference != 0.0]) == pytest.approx(0.3, rel=0.3)
    assert np.array_equal(run.clean["ambient"], plain.clean["ambient"])


def test_a_reversed_thruster_is_one_driven_by_reversed_commands():
    reversed_ = generated(effects={"thruster_polarity": {"reversed": 1.0}})
    mirrored = generated(throttle={name: -u for name, u in programme().items()})
    for first, second in zip(reversed_, mirrored, strict=True):
        assert np.array_equal(first.clean["n"], second.clean["n"])
        assert np.array_equal(first.recorded["throttle"].values, -second.recorded["throttle"].values)


@pytest.mark.parametrize("name", OUTSIDE)
def test_each_effect_that_no_library_knows_shows_in_the_channels_or_stamps(name):
    kind = OUTSIDE[name]
    sizes = {name: {s.name: s.upper for s in (kind.size, *kind.more)}}
    throttle = rich_campaign(np.random.default_rng(3))
    changed = max(
        rms(a.clean, b.clean) + np.max(np.abs(a.recorded["n"].time - b.recorded["n"].time)) / PERIOD
        for a, b in zip(generated(throttle=throttle, outside=sizes), generated(throttle=throttle), strict=True)
    )
    assert changed > 0.5


@pytest.mark.parametrize("model", MODELS)
def test_the_speed_loop_follows_and_records_the_throttle_that_it_made(model):
    desired = closed_loop_campaign(np.random.default_rng(2))
    for run in generated(model, desired, closed_loop=True):
        error = np.sqrt(np.mean((run.states["n"] - desired[run.name]) ** 2))
        assert error < 0.35 * np.std(desired[run.name]) + 1.0
        assert np.max(np.abs(run.recorded["throttle"].values)) <= 4.5


def test_coloured_disturbances_remember_and_shake_the_rotor():
    plain = generated()
    for run, quiet in zip(generated(colour=Colour(outputs=2.0, rotor=40.0, memory=0.6)), plain, strict=True):
        noise = run.recorded["ambient"].values - run.clean["ambient"]
        assert np.std(noise) == pytest.approx(NOISE["ambient"] * np.sqrt(5.0), rel=0.3)
        assert np.mean(noise[1:] * noise[:-1]) > 0.5 * np.var(noise)
        assert np.std(run.states["n"] - quiet.states["n"]) > 0.3


def test_the_same_seed_gives_the_same_recordings_and_another_seed_other_noise():
    first, second, third = (generated(seed=seed)[0] for seed in (5, 5, 6))
    assert np.array_equal(first.recorded["n"].values, second.recorded["n"].values)
    assert not np.array_equal(first.recorded["n"].values, third.recorded["n"].values)


def test_a_standard_campaign_takes_less_than_half_a_second_once_compiled():
    throttle = rich_campaign(np.random.default_rng(1))
    generated(throttle=throttle)
    begin = time.perf_counter()
    generated(throttle=throttle)
    assert time.perf_counter() - begin < 0.5
