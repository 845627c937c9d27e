"""The generators: the same case each time, what they hide is in what they record, and their physics is right."""

from dataclasses import replace

import numpy as np
import pytest

from gap_diagnosis.scoreboard.case import KINDS
from gap_diagnosis.scoreboard.generators import GENERATORS
from gap_diagnosis.scoreboard.generators.lab_plant import Coefficients, simulated
from gap_diagnosis.scoreboard.generators.propeller import _FIELDS as FIELDS
from gap_diagnosis.scoreboard.generators.propeller_plant import SKIP, STEP, go
from thruster_model.flow_tank import simulate
from thruster_model.parameter_set_io import load_parameter_set

COMMANDS = np.repeat([0.0, 2.5, -1.8, 3.4, 0.6, -3.0], 50)
PERIOD = 0.02


@pytest.mark.parametrize("name", GENERATORS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_case_is_the_same_each_time_and_holds_what_its_class_says(name, kind):
    generator = GENERATORS[name]
    truth = generator.draw(kind, 5, False)
    expected = {"none": (0, 0), "one": (1, 1), "two": (2, 2), "many": (3, 6), "outside": (0, 0)}[kind]
    assert expected[0] <= len(truth.effects) <= expected[1]
    assert len(truth.outside) == (kind == "outside")
    first, second = generator.record(truth), generator.record(generator.draw(kind, 5, False))
    for one, other in zip(first, second, strict=True):
        np.testing.assert_array_equal(one.throttle.values, other.throttle.values)
        for signal, samples in one.signals.items():
            np.testing.assert_array_equal(samples.values, other.signals[signal].values)
            assert np.all(np.isfinite(samples.values))
            assert np.all(np.diff(samples.time) >= 0.0)


QUIET = {
    "tank": {"push": (0.0, 0.0), "varying": 0.0, "outliers": 0.0},
    "lab": {"push": (0.0, 0.0), "varying": 0.0, "outliers": 0.0, "tails": False},
    "propeller": {"pushes": (0.0, 0.0), "daily": 0.0, "rough": 0.0},
}


@pytest.mark.parametrize("name", GENERATORS)
def test_recordings_without_push_are_clean_readings_and_noise(name):
    generator = GENERATORS[name]
    drawn = generator.draw("none", 4, False)
    truth = replace(drawn, drawn=drawn.drawn._replace(**QUIET[name]))
    clean = generator.clean(truth, {}, {}, truth.factors, None)
    signals = ("speed", "ambient", "thrust", "torque")
    pairs = [
        (run.signals[s].values, d)
        for run in generator.record(truth)
        for s, d in zip(signals, _noise(truth), strict=True)
    ]
    read = np.concatenate([values / deviation for values, deviation in pairs])
    assert abs(np.std(read - clean.ravel()) - 1.0) < 0.05


@pytest.mark.parametrize("name", ["tank", "lab"])
def test_a_drift_begins_with_the_recording_even_if_the_thruster_turned_before(name):
    generator = GENERATORS[name]
    drawn = generator.draw("none", 4, False)
    truth = replace(drawn, drawn=drawn.drawn._replace(**QUIET[name], moving=True))
    drifting = replace(truth, effects={"load_cell_drift": {"rate": 0.5}})
    pairs = zip(generator.record(truth), generator.record(drifting), strict=True)
    for still, moved in pairs:
        time = still.signals["thrust"].time
        drift = moved.signals["thrust"].values - still.signals["thrust"].values
        assert drift == pytest.approx(0.5 * time, abs=0.5 * 0.03)


def _noise(truth):
    noise = truth.drawn.noise
    return list(noise.values()) if isinstance(noise, dict) else list(noise)


@pytest.mark.parametrize("model", ["hl", "hq"])
def test_the_laboratory_s_plant_is_that_of_the_simulator(model):
    g = load_parameter_set(model).values
    p = Coefficients(
        g["c_u1"], g["c_u2"], g["delta_u1"], g["delta_u2"], g["u_dot_max"], g["k_n"], g["k_Q"], g["c_n_T"], g["c_nv_T"],
        g.get("c_v_T", 0.0), g["c_n_Q"], g["c_nv_Q"], g.get("c_v_Q", 0.0), g["k_v"], g["k_Uv"], g["k_w"], g["k_Tv"],
        g["k_U"], g["k_UU"], g["k_TU"],
    )  # fmt: skip
    at = PERIOD * np.arange(COMMANDS.size)
    steps = round(COMMANDS.size * PERIOD / 5e-4)
    out = np.zeros((4, COMMANDS.size + 1))
    simulated(at, COMMANDS, False, 0.0, steps, np.zeros((2, steps + 1)), 40, p, out)
    expected = simulate(load_parameter_set(model).coefficients, COMMANDS, PERIOD, largest_step=5e-4)
    np.testing.assert_allclose(out[0], expected.n, atol=0.05)
    np.testing.assert_allclose(out[1], expected.ambient, atol=1e-4)
    np.testing.assert_allclose(out[2], expected.thrust, atol=0.02)


def test_the_propeller_s_plant_is_that_of_the_simulator():
    airfoil = load_parameter_set("airfoil")
    c = np.array([airfoil.values[name] for name in FIELDS])
    e = np.zeros(24)
    e[2], e[3], e[20], e[21] = 1e9, 1e9, 1e9, 30.0
    forms = np.concatenate(([10.0, 0.3, 1.0], np.zeros(5)))
    at = PERIOD * np.arange(COMMANDS.size)
    steps = round(COMMANDS.size * PERIOD / STEP)
    keep = np.zeros((4, steps // SKIP + 1))
    go(c, e, forms, at, COMMANDS, False, 0.0, steps, np.zeros((2, steps + 1)), np.zeros(steps + 1), keep)
    expected = simulate(airfoil.coefficients, COMMANDS, PERIOD, largest_step=4e-4)
    every = round(PERIOD / (STEP * SKIP))
    np.testing.assert_allclose(keep[0, ::every], expected.n, atol=0.08)
    np.testing.assert_allclose(keep[1, ::every], expected.ambient, atol=2e-4)
    np.testing.assert_allclose(keep[2, ::every], expected.thrust, atol=0.03)
