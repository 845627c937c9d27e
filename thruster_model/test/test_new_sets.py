"""Sets that stand on others, and the texts of new ones: what is read back, and a sentence for what is wrong."""

import re

import numpy as np
import pytest

from thruster_model.cli_new_set import main
from thruster_model.cli_new_vehicle import main as new_vehicle_main
from thruster_model.errors import ParameterSetError
from thruster_model.models import MODELS
from thruster_model.new_set_io import new_set
from thruster_model.new_vehicle_io import new_vehicle
from thruster_model.parameter_set_io import dump_parameter_set, load_parameter_set, parse_parameter_set
from thruster_model.vehicle_set_io import available_vehicles, load_vehicle_set, parse_vehicle_set


@pytest.fixture
def folder(tmp_path):
    def written(**texts):
        for name, text in texts.items():
            (tmp_path / f"{name}.yaml").write_text(text, "utf-8")
        return tmp_path

    return written


# ---- sets on a base


def test_what_is_not_named_is_the_bases_and_three_numbers_are_changed():
    text = "base: hl\nsource: May\nparameters:\n  k_n: 12\n  k_v: {value: 1.5, source: June}\n  k_w: 0.9\n"
    found, base = parse_parameter_set(text, origin="mine.yaml"), load_parameter_set("hl")
    assert found.values == {**base.values, "k_n": 12.0, "k_v": 1.5, "k_w": 0.9}
    assert found.parameters["k_n"].source == "May"
    assert found.parameters["k_v"].source == "June"
    assert found.parameters["k_Q"] == base.parameters["k_Q"]
    assert found.model_name == "hl"


def test_a_new_value_has_not_the_bases_deviation_and_a_new_deviation_keeps_the_value(folder):
    own = folder(
        one="base: hl\nparameters:\n  k_n: {value: 12, standard_deviation: 0.5}\n  k_v: {standard_deviation: 0.1}\n",
        two="base: one.yaml\nparameters:\n  k_n: 11\n",
    )
    one, two = load_parameter_set(own / "one.yaml").parameters, load_parameter_set(own / "two.yaml").parameters
    assert (one["k_n"].standard_deviation, two["k_n"].standard_deviation) == (0.5, None)
    assert (two["k_n"].value, two["k_v"].value, two["k_v"].standard_deviation) == (11.0, 1.102, 0.1)


def test_effects_command_and_table_are_the_bases_unless_they_are_given():
    effect = "effects:\n  viscous_friction: {share: {value: 0.2, unit: '1'}}\n"
    base = load_parameter_set("force_table")
    kept = parse_parameter_set("base: force_table\nparameters: {rate: 5.0}\n", origin="x")
    assert (kept.command, kept.values["rate"]) == (base.command, 5.0)
    assert (
        dump_parameter_set(kept).partition("force_table:\n")[2]
        == dump_parameter_set(base).partition("force_table:\n")[2]
    )
    changed = parse_parameter_set(f"base: hl\n{effect}", origin="x")
    assert changed.effects.sizes == {"viscous_friction": {"share": 0.2}}


def test_a_base_is_looked_for_beside_the_set_that_names_it(folder, monkeypatch):
    own = folder(first="base: hl\nparameters: {k_n: 12}\n", second="base: first.yaml\n")
    monkeypatch.chdir("/")
    assert load_parameter_set(own / "second.yaml").values["k_n"] == 12.0


def test_a_set_on_a_base_is_written_complete():
    found = parse_parameter_set("base: hl\nparameters: {k_n: 12}\n", origin="x")
    again = parse_parameter_set(dump_parameter_set(found), origin="y")
    assert again.parameters == found.parameters


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("base: nothing\n", "key 'base': expected one of the known sets (airfoil"),
        ("base: nothing\n", "found 'nothing', and no file"),
        ("base: [hl]\n", "key 'base': expected the name or the file of a set; found ['hl']"),
        ("base: hl\nparamters: {}\n", "key 'paramters': unknown; known are base, command"),
        ("base: hl\nmodel: hq\n", "key 'model': expected 'hl', its base's; found 'hq'"),
        ("base: hl\nparameters: {k_m: 1}\n", "key 'parameters.k_m': model 'hl' has none such; it has c_n_Q"),
        ("base: hl\nparameters: {k_n: fast}\n", "key 'parameters.k_n': expected a number, or value and what goes"),
        ("base: hl\nparameters: {k_n: -1}\n", "key 'parameters.k_n.value': expected a number from 0 to 12000 1/s"),
        ("base: hl\nparameters: {k_n: {value: 1, unit: rpm}}\n", "'parameters.k_n.unit': expected '1/s'; found 'rpm'"),
        ("base: hl\nparameters: {k_n: {valeu: 1}}\n", "key 'parameters.k_n.valeu': unknown"),
        ("base: hl\nparameters: [1]\n", "key 'parameters': expected a mapping; found list"),
    ],
)
def test_what_is_wrong_with_a_set_on_a_base_is_a_sentence(text, sentence):
    with pytest.raises(ParameterSetError) as error:
        parse_parameter_set(text, origin="mine.yaml")
    assert sentence in str(error.value)
    assert str(error.value).startswith("mine.yaml: ")


def test_sets_that_stand_on_each_other_in_a_circle_are_named(folder):
    own = folder(a="base: b.yaml\n", b="base: c.yaml\n", c="base: b.yaml\n")
    with pytest.raises(ParameterSetError, match=re.escape("in a circle; found b.yaml -> c.yaml -> b.yaml")):
        load_parameter_set(own / "a.yaml")


def test_what_is_wrong_with_the_base_is_said_of_its_file(folder):
    own = folder(a="base: b.yaml\n", b="model: hl\n")
    with pytest.raises(ParameterSetError, match=r"b\.yaml: key 'name': missing"):
        load_parameter_set(own / "a.yaml")


# ---- new ones


@pytest.mark.parametrize("model", MODELS)
def test_a_new_set_is_read_as_it_is_and_tells_of_each_parameter(model):
    text, published = new_set(model), load_parameter_set(model)
    found = parse_parameter_set(text, origin="x")
    assert (found.parameters, found.command) == (published.parameters, published.command)
    lines = text.split("\n")
    assert "one sigma, half of what a data sheet calls its tolerance" in " ".join(line.strip("# ") for line in lines)
    for definition in MODELS[model].parameters:
        above = lines[lines.index(f"  {definition.name}:") - 1]
        assert above.startswith(f"  # {definition.meaning} [{definition.unit}], ")


def test_a_new_set_on_a_base_is_the_base_until_a_line_is_uncommented():
    text, base = new_set("hl", "hl_bench"), load_parameter_set("hl_bench")
    assert parse_parameter_set(text, origin="x").values == base.values
    changed = text.replace(f"  # k_n: {base.values['k_n']!r}", "  k_n: 12.5")
    assert parse_parameter_set(changed, origin="x").values == {**base.values, "k_n": 12.5}


def test_the_command_writes_beside_its_base_and_never_over_a_file(folder, capsys):
    own = folder(first=new_set("hq"))
    new = own / "second.yaml"
    assert main(["hq", "--base", "first.yaml", "-o", str(new)]) == 0
    assert load_parameter_set(new).values == load_parameter_set("hq").values
    before = new.read_bytes()
    assert main(["hq", "-o", str(new)]) == 1
    assert "exists and is not overwritten" in capsys.readouterr().err
    assert new.read_bytes() == before


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["hx"], "expected a model, one of simplified, hl"),
        (["hq", "--base", "hl"], "hl: expected a set of model 'hq'; found 'hl'"),
        (["hl", "--base", "lost.yaml"], "lost.yaml: expected a YAML file or one of the known sets"),
    ],
)
def test_what_is_wrong_is_said_and_nothing_is_written(arguments, sentence, tmp_path, capsys):
    assert main([*arguments, "-o", str(tmp_path / "new.yaml")]) == 1
    assert sentence in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", available_vehicles())
def test_a_new_vehicle_is_read_as_the_one_it_was_written_from_and_says_what_each_number_is(name: str) -> None:
    text, base = new_vehicle(name), load_vehicle_set(name)
    again = parse_vehicle_set(text, origin="mine")
    assert (again.parameters, again.model) == (base.parameters, base.model)
    assert np.allclose(again.configuration, base.configuration, atol=1e-12)
    assert [(t.name, t.hand, t.model) for t in again.layout] == [(t.name, t.hand, t.model) for t in base.layout]
    unstated = base.parameters["mass"].standard_deviation is None
    more = f"; standard_deviation as long as none is stated: {0.05 * base.values['mass']:.3g}" if unstated else ""
    assert f"  # mass [kg]{more}\n  mass: {{value:" in text
    assert "one sigma, half of a tolerance" in text
    assert "  # density of the water [kg/m^3]\n  # density: {value: 1000.0, unit: kg/m^3" in text
    salty = parse_vehicle_set(text.replace("  # density: {value: 1000.0", "  density: {value: 1025.0"), origin="mine")
    assert salty.parameters["density"].value == 1025.0


def test_the_command_writes_a_new_vehicle_and_overwrites_none(tmp_path, capsys):
    file = tmp_path / "mine.yaml"
    assert new_vehicle_main(["--vehicle", "bluerov2_heavy", "-o", str(file)]) == 0
    assert load_vehicle_set(file).name == load_vehicle_set("bluerov2_heavy").name
    assert new_vehicle_main(["--vehicle", "bluerov2_heavy", "-o", str(file)]) == 1
    assert "mine.yaml" in capsys.readouterr().err
    assert new_vehicle_main(["--vehicle", "none", "-o", str(tmp_path / "other.yaml")]) == 1
    assert "none" in capsys.readouterr().err and not (tmp_path / "other.yaml").exists()
