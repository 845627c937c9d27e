"""Parameter sets: the published numbers, round trips, and a sentence for everything that can be wrong."""

import pytest

from thruster_model.errors import ParameterSetError
from thruster_model.models import MODELS
from thruster_model.parameter_set_io import (
    available_sets,
    dump_parameter_set,
    load_parameter_set,
    parse_parameter_set,
    write_parameter_set,
)


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [
        ("simplified", "c_T1", 9.548e-4),
        ("simplified", "k_Q", 67.66),
        ("hl", "k_Uv", 67.37),
        ("hl", "c_nv_T", 0.4146),
        ("hq", "c_v_T", 37.71),
        ("hq", "c_nv_Q", 9.948e-12),
        ("hl_bench", "k_Uv", 63.4361),
        ("hl_bench", "k_w", 1.0),
    ],
)
def test_the_sets_hold_the_published_numbers(name, parameter, value):
    assert load_parameter_set(name).values[parameter] == value


@pytest.mark.parametrize("name", available_sets())
def test_a_set_survives_being_written_and_read(name, tmp_path):
    original = load_parameter_set(name)
    write_parameter_set(original, tmp_path / "set.yaml")
    again = load_parameter_set(tmp_path / "set.yaml")
    assert again.parameters == original.parameters
    with pytest.raises(FileExistsError, match="is not overwritten"):
        write_parameter_set(original, tmp_path / "set.yaml")


def test_hl_is_hq_without_the_quadratic_terms():
    hl, hq = MODELS["hl"], MODELS["hq"]
    assert set(hq.parameter_names) - set(hl.parameter_names) == {"c_v_T", "c_v_Q"}


def edited(old, new):
    text = dump_parameter_set(load_parameter_set("hl"))
    assert old in text
    return text.replace(old, new, 1)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("- a list", "expected a mapping at the top; found list"),
        ("model: [", "expected YAML; found"),
        (edited("model: hl", "model: hx"), "found 'hx'"),
        (edited("name: ", "title: "), "key 'name': missing"),
        (edited("  k_n:", "  k_m:"), "'k_n' is missing; model 'hl' needs it: "),
        (edited("  k_n:", "  k_m:"), "model 'hl' has none such"),
        (edited("value: 13.66", "value: fast"), "key 'parameters.k_n.value': expected a number; found 'fast'"),
        (edited("value: 13.66", "value: -1.0"), "expected a number from 0 to 12000 1/s; found -1.0"),
        (edited("value: 13.66", "value: .nan"), "found nan"),
        (edited("unit: 1/s", "unit: 1/min"), "key 'parameters.k_n.unit': expected '1/s'; found '1/min'"),
        (edited("value: 13.66", "value: 13.66\n    sd: 1"), "key 'parameters.k_n.sd': unknown"),
        (
            edited("value: 13.66", "value: 13.66\n    standard_deviation: -1"),
            "standard_deviation': expected a number >= 0",
        ),
    ],
)
def test_what_is_wrong_with_a_set_is_said_with_file_key_expected_and_found(text, sentence):
    with pytest.raises(ParameterSetError) as error:
        parse_parameter_set(text, origin="mine.yaml")
    assert sentence in str(error.value)
    assert str(error.value).startswith("mine.yaml: ")


def test_a_unit_may_be_spelt_in_any_usual_way():
    text = edited("unit: 1/s\n", "unit: s^-1\n").replace("unit: N s^2\n", "unit: N·s²\n")
    again = parse_parameter_set(text, origin="mine.yaml")
    assert again.parameters == load_parameter_set("hl").parameters, "and is written as the model has it"


def test_all_that_is_wrong_is_said_at_once():
    text = edited("value: 13.66", "value: -1.0").replace("unit: 1/m\n", "unit: m\n")
    with pytest.raises(ParameterSetError) as error:
        parse_parameter_set(text, origin="mine.yaml")
    assert len(error.value.problems) >= 2


def test_a_set_that_is_neither_known_nor_a_file_is_refused_with_what_is_known():
    with pytest.raises(ParameterSetError, match=r"known sets .*hl_bench, hq"):
        load_parameter_set("nothing")


def test_yaml_1_1_numbers_without_a_dot_are_read():
    text = edited("value: 13.66", "value: 1e1")
    assert parse_parameter_set(text, origin="x").values["k_n"] == 10.0
