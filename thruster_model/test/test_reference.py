"""The reference in docs is what the definitions say."""

import re
from pathlib import Path

import numpy as np

from thruster_model.cli_reference import effects, reference
from thruster_model.effect_signatures_io import typical_sizes
from thruster_model.effects.stages import LIBRARY, effect_values
from thruster_model.models import MODELS
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.stepper import ROWS
from thruster_model.unmoved import moved_by_effects, moved_by_parameter, unmoved
from thruster_model.whole_run import simulated_rows

DOCS = Path(__file__).parents[2] / "docs"


def test_the_reference_in_docs_is_up_to_date():
    assert (DOCS / "models.md").read_text("utf-8") == reference()
    assert (DOCS / "effects.md").read_text("utf-8") == effects()


def test_every_effect_stands_in_the_reference_with_all_its_sizes():
    of_each, _, _ = effects().partition("## Which model")
    rows = {line.split("`")[1]: line for line in of_each.splitlines() if line.startswith("| `")}
    assert set(rows) == set(LIBRARY)
    for name, effect in LIBRARY.items():
        assert all(f"{p.name} [{p.unit}]" in rows[name] for p in effect.parameters) and effect.title in rows[name]


def test_what_an_effect_s_row_leaves_open_stands_below_the_table():
    text = effects()
    assert all(f"- `{name}`: {effect.note}." in text for name, effect in LIBRARY.items() if effect.note)
    assert "time_constant [s], of warming up: 5 to 200, else 60" in text, "no effect without a share"
    assert "speed [s], of the stamps of the tachometer: ±0 to 0.12, none at 0" in text, "each channel is one of its own"


def test_the_order_in_which_effects_act_is_that_of_their_chains():
    text = effects()
    assert "Order: `thruster_polarity`, `command_quantization`, `throttle_saturation`, `command_delay`; then" in text
    for e in LIBRARY.values():
        if e.sample is not None:
            assert text.count(f"`{e.id}`") > 1, f"{e.id} stands in no order"


def test_what_changes_nothing_in_a_model_changes_no_simulated_run_of_it_and_all_else_does():
    dt = 0.01
    throttle = 4.5 * np.sin(2.0 * np.pi * dt * np.arange(1000) / 5.0)
    sets = {name: load_parameter_set(name) for name in ("simplified", "hl")}
    told = unmoved(sets.values())
    of_the_plant = [e for e in LIBRARY.values() if set(e.hooks) - {"ramp", "lag", "late"}]
    for name, each in sets.items():

        def simulated(sizes, each=each):
            rows = simulated_rows(each.coefficients, throttle, dt, effects=effect_values(sizes), gates=np.zeros(1000))
            return {s: rows[ROWS.index(s)] for s in each.model.signals}

        plain = simulated({})
        for effect in of_the_plant:
            there = simulated({effect.id: typical_sizes(effect)})
            alike = all(np.array_equal(there[signal], plain[signal]) for signal in plain)
            assert alike == (name in told.get(effect.id, ())), (name, effect.id)


def test_a_parameter_shows_in_the_signals_that_its_equations_move():
    bessa, hl = load_parameter_set("bessa"), load_parameter_set("hl")
    assert moved_by_parameter(bessa, "c_T1") == {"thrust"} and moved_by_parameter(bessa, "c_Q") == {"torque"}
    assert moved_by_parameter(hl, "k_w") == {"axial", "thrust"}, "v' has it, and T has v"
    assert "speed" in moved_by_parameter(hl, "c_n_Q")
    assert moved_by_effects(bessa)["thrust_loss"] == {"thrust"} and not moved_by_effects(bessa)["flow_lag"]


def test_every_model_and_each_of_its_parameters_stands_in_the_reference():
    text = reference()
    for model in MODELS.values():
        section = text.split(f"## `{model.name}`")[1].split("\n## ")[0]
        assert all(f"| {name} |" in section for name in model.parameter_names)


def test_numbers_next_to_0_are_told_as_no_diagnosis_moves_them():
    sets = dict(re.findall(r"^Set `(\w+)`: (.*)", reference(), re.MULTILINE))
    exact = "A diagnosis that begins here takes what is 0 or next to it as exact: "
    assert f"{exact}c_nv_Q is moved by a `fit` alone" in sets["hl"]
    assert f"{exact}delta_T1, delta_T2, delta_Q1 and delta_Q2 are moved" in sets["simplified"]
    assert "exact: " not in sets["airfoil"]


def test_the_printed_equations_of_a_model_hold_its_parameters_and_no_others():
    def names(text: str) -> set[str]:
        return set(re.findall(r"\b(?:[a-zA-Z]\w*_\w+|radius|density|pitch|lift|drag|rate)\b", text))

    for model in MODELS.values():
        if not model.knots:
            used = names(" ".join(model.equations)) - {"n_s", "F_s"}  # curves of a table
            assert used == set(model.parameter_names) - {"u_dot_max"}, model.name
