"""Tables of steady states: what they say, what they cannot, and what is wrong with a table."""

import re

import numpy as np
import pytest

from gap_diagnosis.blind_check.generator import Truth, generate
from gap_diagnosis.cli_steady_states import main
from gap_diagnosis.steady_states import diagnose_steady_states
from thruster_model.errors import UnfitDataError
from thruster_model.parameter_set_io import load_parameter_set

THROTTLES = np.array([-3.0, -2.5, -2.0, -1.5, -1.0, 1.0, 1.5, 2.0, 2.5, 3.0])
DEVIATIONS = {"speed": 0.5, "thrust": 0.05, "ambient": 0.003}
SIGNALS = {"n": "speed", "ambient": "ambient", "thrust": "thrust"}


@pytest.fixture(scope="module")
def tables():
    """Readings of the blind check's own generator after 40 s at each throttle, by what is hidden."""
    stated = load_parameter_set("hl")
    cases = {
        "none": ({}, {}),
        "thrust_asymmetry": ({"thrust_asymmetry": {"share": 0.4}}, {}),
        "load_cell_bias": ({"load_cell_bias": {"offset": 2.0}}, {}),
        "k_n": ({}, {"k_n": 1.06}),
    }
    rng = np.random.default_rng(0)
    found = {}
    for name, (effects, factors) in cases.items():
        true = {key: value * factors.get(key, 1.0) for key, value in stated.values.items()}
        programme = {f"{u:g}": np.full(1000, u) for u in THROTTLES}
        runs = generate(Truth(model="hl", parameters=true, effects=effects), programme, closed_loop=False, seed=1)
        found[name] = {
            signal: np.array([float(np.mean(run.recorded[own].values[-250:])) for run in runs])
            + 0.3 * DEVIATIONS[signal] * rng.standard_normal(THROTTLES.size)
            for own, signal in SIGNALS.items()
        }
    return found


@pytest.fixture(scope="module")
def diagnosed(tables):
    stated = load_parameter_set("hl")
    names = ("none", "thrust_asymmetry", "k_n")  # the bias is the command's
    return {name: diagnose_steady_states(THROTTLES, tables[name], DEVIATIONS, stated) for name in names}


def test_where_the_parameters_are_right_there_is_no_gap(diagnosed):
    found = diagnosed["none"]
    assert found.verdict == "no_gap"
    assert found.count == 30


def test_an_effect_that_shows_at_rest_is_the_most_likely_with_its_size(diagnosed):
    found = diagnosed["thrust_asymmetry"]
    assert found.verdict in ("effect", "cannot_tell")
    best = {each.effect: each for each in found.equals}["thrust_asymmetry"]
    value, std = best.sizes["share"]
    assert abs(value - 0.4) < 4.0 * std + 0.02


def test_a_parameter_that_is_off_is_re_tuned_and_no_effect(diagnosed):
    found = diagnosed["k_n"]
    assert found.verdict == "parameters"
    assert found.costs[1] < 40.0 < found.costs[0]


def test_readings_in_another_unit_are_refused(tables):
    rpm = {**tables["none"], "speed": tables["none"]["speed"] * 30.0 / np.pi}
    with pytest.raises(UnfitDataError, match="as if in rev/min; expected rad/s"):
        diagnose_steady_states(THROTTLES, rpm, DEVIATIONS, load_parameter_set("hl"))


def test_a_handful_of_readings_claims_nothing(tables):
    few = {"speed": tables["none"]["speed"][:5] * np.linspace(0.8, 1.2, 5)}
    found = diagnose_steady_states(THROTTLES[:5], few, {"speed": 0.5}, load_parameter_set("hl"))
    assert found.count == 5 and found.verdict in ("cannot_tell", "unknown")


def test_effects_that_need_time_are_not_considered(diagnosed):
    names = {each.effect for each in diagnosed["thrust_asymmetry"].explanations}
    assert not names & {"log_alignment", "load_cell_resonance", "load_cell_drift", "thermal_fade", "tank_recirculation"}


@pytest.mark.parametrize(
    ("throttle", "readings", "deviations", "sentence"),
    [
        ([1.0, 2.0], {"speed": [1.0, 2.0]}, {"speed": 1.0}, "at least three finite values"),
        ([1.0, np.nan, 2.0], {"speed": [1.0, 2.0, 3.0]}, {"speed": 1.0}, "at least three finite values"),
        ([1.0, 2.0, 3.0], {"speed": [1.0, 2.0]}, {"speed": 1.0}, "expected 3 readings"),
        ([1.0, 2.0, 3.0], {"rpm": [1.0, 2.0, 3.0]}, {"rpm": 1.0}, "rpm: expected one of speed"),
        ([1.0, 2.0, 3.0], {"speed": [1.0, 2.0, 3.0]}, {}, "deviation of speed: expected a number above zero"),
        ([1.0, 2.0, 3.0], {}, {}, "at least one signal"),
    ],
)
def test_a_table_that_cannot_be_used_gets_a_sentence(throttle, readings, deviations, sentence):
    with pytest.raises(UnfitDataError, match=sentence):
        diagnose_steady_states(throttle, readings, deviations, load_parameter_set("hl"))


def test_the_command_prints_the_table_the_verdict_and_the_candidates(tmp_path, tables, capsys):
    readings = tables["load_cell_bias"]
    rows = np.column_stack((THROTTLES, readings["speed"] * 30.0 / np.pi, readings["thrust"], np.zeros(THROTTLES.size)))
    np.savetxt(tmp_path / "t.csv", rows, delimiter=",")
    given = [
        "--model",
        "hl",
        "--columns",
        "throttle,rpm,thrust,-",
        "--deviation",
        "speed=0.5",
        "--deviation",
        "thrust=0.05",
    ]
    assert main([str(tmp_path / "t.csv"), *given]) == 0
    printed = capsys.readouterr().out
    assert "| -3 | " in printed and "readings" in printed
    (found,) = re.findall(r"`load_cell_bias`.*?offset ([\d.]+) ± ([\d.]+)", printed)
    assert abs(float(found[0]) - 2.0) < 4.0 * float(found[1]) + 0.1


@pytest.mark.parametrize(
    ("columns", "more", "sentence"),
    [
        ("throttle,speed", [], "expected 3 names"),
        ("throttle,speed,rpm", ["--deviation", "speed=1"], "speed is given more than once"),
        ("throttle,speed,torqe", [], "found 'torqe'"),
        ("speed,-,thrust", [], "expected a column throttle"),
        ("throttle,speed,thrust", ["--deviation", "speed"], "expected SIGNAL=STD"),
        (
            "throttle,speed,thrust",
            ["--deviation", "speed=1"],
            "deviation of thrust: expected a number above zero; found none given",
        ),
    ],
)
def test_bad_words_on_the_command_line_get_a_sentence(tmp_path, capsys, columns, more, sentence):
    (tmp_path / "t.csv").write_text("1,10,1\n2,20,2\n3,30,3\n", encoding="utf-8")
    assert main([str(tmp_path / "t.csv"), "--model", "hl", "--columns", columns, *more]) == 1
    assert sentence in capsys.readouterr().err


def test_a_table_with_words_gets_a_sentence(tmp_path, capsys):
    (tmp_path / "t.csv").write_text("throttle,speed\n1,2\n", encoding="utf-8")
    assert main([str(tmp_path / "t.csv"), "--model", "hl", "--columns", "throttle,speed"]) == 1
    assert "expected rows of numbers" in capsys.readouterr().err
