"""The library of effects: its definitions, no trace at neutral, and what each effect changes at one instant."""

from pathlib import Path
from typing import get_args

import numpy as np
import pytest

from thruster_model.effects import library
from thruster_model.effects.active import problems_of
from thruster_model.effects.effect import STAGES, Block, Search, Trace
from thruster_model.effects.stages import LIBRARY, NEUTRAL, NO_EFFECTS, EffectValues, effect_values
from thruster_model.flow_tank import PlantState, simulate
from thruster_model.models import MODELS
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.pipeline import drawn, pipeline
from thruster_model.stepper import plant_step

IN_PLANT = {name: effect for name, effect in LIBRARY.items() if effect.hooks and effect.sample is None}
OUTPUTS = ("n_dot", "v_dot", "u_dot", "speed", "axial", "water", "thrust", "torque")
HQ = load_parameter_set("hq").coefficients
FULL = 737.2 * (5.0 - 0.86)


def outputs(p, effects, n=100.0, v=0.1, ambient=0.12, u=3.0, heat=0.0, past=0.0, gate=1.0):
    return dict(zip(OUTPUTS, pipeline(n, v, ambient, u, heat, past, gate, 1.0, p, effects), strict=True))


def test_each_file_is_the_effect_of_its_name():
    files = {file.stem for file in Path(library.__file__).parent.glob("*.py")} - {"__init__"}
    assert files == set(LIBRARY)


@pytest.mark.parametrize("effect", LIBRARY.values(), ids=lambda effect: effect.id)
def test_a_definition_is_complete(effect):
    assert effect.title and effect.equation
    assert effect.block in get_args(Block)
    assert {twin.partition(":")[0] for twin in effect.twins} | set(effect.entails) <= set(LIBRARY)
    assert effect.search in get_args(Search) and effect.trace in get_args(Trace)
    assert (effect.search == "log") <= bool(effect.trace) and len(effect.tries) <= len(effect.parameters)
    for d in effect.parameters:
        assert d.name.isidentifier() and d.unit and d.meaning
        assert d.lower <= d.upper and (d.lower >= 0.0 or not d.both_signs)
    for stage, hook in effect.hooks.items():
        assert hook.__code__.co_varnames[: hook.__code__.co_argcount] == STAGES[stage]


@pytest.mark.parametrize("effect", IN_PLANT.values(), ids=lambda effect: effect.id)
def test_the_neutral_size_of_an_effect_in_the_plant_lies_in_its_range(effect):
    assert effect.parameters[0].neutral in (0.0, np.inf)
    for d in effect.parameters:
        assert d.lower <= d.neutral <= d.upper or d.neutral == np.inf
        assert not problems_of({effect.id: {d.name: d.upper}})


@pytest.mark.parametrize(
    "model",
    [
        "hq", "table", "force_table",
        *(pytest.param(each, marks=pytest.mark.long) for each in (
            "simplified", "hl", "kim_chung", "two_state", "first_order", "yoerger", "static_dead_band"
        )),
    ],
)  # fmt: skip
def test_at_neutral_a_run_is_the_same_bit_for_bit(model):
    p = load_parameter_set(model).coefficients
    commands = np.repeat([2.0, -4.0, 0.6, 5.0, -1.0, 0.0], 30) + 0.1 * np.sin(np.arange(180))
    start = PlantState(3.0, -0.02, 0.03, 0.5)
    plain, neutral = (simulate(p, commands, 0.02, initial=start, effects=e) for e in (NO_EFFECTS, NEUTRAL))
    for name, expected in plain._asdict().items():
        assert getattr(neutral, name).tobytes() == expected.tobytes(), name


@pytest.mark.parametrize("model", MODELS)
def test_at_neutral_every_hook_returns_what_it_was_given(model):
    p = load_parameter_set(model).coefficients
    for n, v, ambient, u in np.random.default_rng(1).normal(0.0, (150.0, 0.3, 0.3, 3.0), (200, 4)):
        state = {"n": n, "v": v, "ambient": ambient, "u": u, "heat": 0.7, "past": 0.2, "gate": 0.0}
        assert outputs(p, NEUTRAL, **state) == outputs(p, NO_EFFECTS, **state)


# Row: effect, sizes, state, by how much outputs change by hand (HQ, Tables 4.1 and 4.2), at the state of `outputs`.
# What thrust and torque bring with them, k_Tv T, k_TU T and -k_Q Q, is added where they change.
SIGNATURES = [
    ("dead_zone_shift", {"voltage": 0.2}, {}, {"n_dot": -737.2 * 0.2}),
    ("dead_zone_shift", {"voltage": 0.2}, {"u": -3.0}, {"n_dot": 725.5 * 0.2}),
    ("dead_zone_shift", {"voltage": -0.4}, {"u": 0.5}, {"n_dot": 737.2 * 0.04}),
    ("throttle_gain", {"share": 0.25}, {}, {"n_dot": -0.25 * 737.2 * 2.14}),
    ("supply_sag", {"share": 0.3}, {"u": 5.0, "n": FULL / 13.66}, {"n_dot": -0.3 * FULL}),
    ("supply_sag", {"share": 0.3}, {"u": 5.0, "n": 0.5 * FULL / 13.66}, {"n_dot": -0.15 * FULL}),
    ("supply_sag", {"share": 0.3}, {"n": 0.0}, {}),
    ("thermal_fade", {"share": 0.4}, {"heat": 0.5}, {"n_dot": -0.2 * 737.2 * 2.14}),
    ("thermal_fade", {"time_constant": 5.0}, {"heat": 0.5}, {}),
    ("start_hysteresis", {"voltage": 0.3}, {}, {"n_dot": 737.2 * 0.3}),
    ("start_hysteresis", {"voltage": 0.3}, {"n": 9.9}, {}),
    ("coulomb_friction", {"deceleration": 60.0}, {}, {"n_dot": -60.0}),
    ("coulomb_friction", {"deceleration": 60.0}, {"n": -100.0}, {"n_dot": 60.0}),
    ("viscous_friction", {"share": 0.5}, {}, {"n_dot": -0.5 * 1366.0}),
    ("brake_asymmetry", {"share": 0.5}, {"u": 0.0}, {"n_dot": -0.5 * 1366.0}),
    ("brake_asymmetry", {"share": 0.5}, {"u": 0.0, "n": -100.0}, {"n_dot": 0.5 * 1366.0}),
    ("brake_asymmetry", {"share": 0.5}, {"u": 4.0}, {}),
    ("brake_asymmetry", {"share": 0.5, "onset": 0.2}, {"u": 0.0}, {"n_dot": -0.5 * 1366.0}),
    ("propeller_fouling", {"share": 0.3}, {"v": 0.0}, {"thrust": -0.3 * 14.67, "torque": 0.3 * 0.02804}),
    ("thrust_loss", {"share": 0.5}, {"v": 0.0}, {"thrust": -0.5 * 14.67}),
    ("thrust_asymmetry", {"share": 0.2}, {"v": 0.0, "n": -100.0}, {"thrust": 0.2 * 14.67}),
    ("thrust_asymmetry", {"share": 0.2}, {}, {}),
    ("axial_flow_loss", {"share": 1.5}, {}, {"thrust": -1.5 * 0.3755 * 100.0 * 0.1}),
    ("quadratic_flow_loss", {"coefficient": 100.0}, {"v": -0.1}, {"thrust": 1.0}),
    ("flow_reversal_loss", {"share": 0.5}, {"v": -0.1}, {"thrust": -0.5 * (14.67 + 3.755 + 0.3771)}),
    ("flow_reversal_loss", {"share": 0.5}, {}, {}),
    ("ventilation", {"share": 0.8, "onset": 90.0}, {"v": 0.0, "gate": 0.0}, {"thrust": -0.8 * 14.67}),
    ("ventilation", {"share": 0.8, "onset": 110.0}, {"gate": 0.0}, {}),
    ("ventilation", {"share": 0.8, "onset": 90.0}, {}, {}),
    ("cavitation", {"share": 0.5, "onset": 80.0}, {"v": 0.0}, {"thrust": -0.5 * 0.25 * 14.67}),
    ("cavitation", {"share": 1.0, "onset": 40.0}, {"v": 0.0}, {"thrust": -14.67}),
    ("cavitation", {"share": 1.0, "onset": 110.0}, {}, {}),
    ("water_unloaded", {"share": 1.0}, {"v": 0.0}, {"thrust": -14.67, "torque": -0.02804}),
    ("ambient_current", {"speed": -0.2}, {}, {"water": -0.2, "v_dot": -67.37 * 0.1 * 0.89 * 0.2}),
    ("oblique_inflow", {"angle": np.pi / 3.0}, {}, {"v_dot": -67.37 * 0.1 * 0.89 * 0.06}),
    ("tank_recirculation", {"share": 0.5}, {"past": 0.3}, {"u_dot": 0.5 * 0.2396 * 0.3}),
]


@pytest.mark.parametrize(("effect", "sizes", "state", "changes"), SIGNATURES)
def test_an_effect_changes_what_it_says_and_nothing_else(effect, sizes, state, changes):
    before = outputs(HQ, NO_EFFECTS, **state)
    after = outputs(HQ, effect_values({effect: sizes}), **state)
    thrust, torque = changes.get("thrust", 0.0), changes.get("torque", 0.0)
    expected = {"n_dot": -1856.0 * torque, "v_dot": 0.01232 * thrust, "u_dot": 0.004855 * thrust, **changes}
    for name in OUTPUTS:
        assert after[name] - before[name] == pytest.approx(expected.get(name, 0.0), rel=1e-9, abs=1e-9), name


@pytest.mark.parametrize(("effect", "name"), [("rotor_inertia", "n_dot"), ("flow_lag", "v_dot")])
@pytest.mark.parametrize("share", [-0.5, 1.0])
def test_inertia_divides_a_rate_by_one_plus_its_size(effect, name, share):
    before, after = (outputs(HQ, e) for e in (NO_EFFECTS, effect_values({effect: {"share": share}})))
    assert after == pytest.approx({**before, name: before[name] / (1.0 + share)}, rel=1e-12)


def test_entrained_water_takes_thrust_while_the_rotor_speeds_up():
    before, after = (outputs(HQ, e) for e in (NO_EFFECTS, effect_values({"entrained_water": {"impulse": 0.01}})))
    assert after["thrust"] - before["thrust"] == pytest.approx(-0.01 * before["n_dot"])
    assert after["n_dot"] == before["n_dot"] != 0.0


BALANCE = 0.86 + (1366.0 + 1856.0 * outputs(HQ, NO_EFFECTS)["torque"]) / 737.2
"""Throttle [V] that keeps the rotor at 100 rad/s."""


@pytest.mark.parametrize("onset", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("share", [-0.8, 0.8])
def test_braking_alone_is_continuous_where_the_rotor_stops_falling(share, onset):
    braked = effect_values({"brake_asymmetry": {"share": share, "onset": onset}})
    for u in BALANCE + np.linspace(-1e-6, 1e-6, 11):
        before, after = (outputs(HQ, e, u=u)["n_dot"] for e in (NO_EFFECTS, braked))
        assert after == pytest.approx(before, abs=0.1)
        assert after * before >= 0.0


@pytest.mark.parametrize(
    ("share", "onset", "slowing"),
    [
        (0.5, 1.0, 300.0 * 1.5),
        (0.5, 0.5, 300.0 * 2.0),
        (0.5, 0.1, 300.0 + 0.5 * 1366.0),
        (0.5, 0.0, 300.0 + 0.5 * 1366.0),
        (-0.5, 1.0, 300.0 * 0.5),
        (-0.5, 0.1, 0.0),
        (-0.1, 0.1, 300.0 - 0.1 * 1366.0),
    ],
)
def test_a_rotor_that_slows_gently_is_braked_as_far_as_the_onset_tells(share, onset, slowing):
    braked = effect_values({"brake_asymmetry": {"share": share, "onset": onset}})
    assert outputs(HQ, braked, u=BALANCE - 300.0 / 737.2)["n_dot"] == pytest.approx(-slowing, abs=1e-6)


def test_a_set_without_a_flow_term_loses_thrust_by_the_reference():
    lossy = effect_values({"axial_flow_loss": {"share": 1.0}})
    airfoil = load_parameter_set("airfoil").coefficients
    loss = outputs(airfoil, NO_EFFECTS)["thrust"] - outputs(airfoil, lossy)["thrust"]
    assert loss == pytest.approx(0.4146 * 100.0 * 0.1)


def test_a_set_without_flow_gets_that_of_the_hl_model_with_the_loss_by_it():
    lossy = effect_values({"axial_flow_loss": {"share": 1.0}})
    hl, simplified = (load_parameter_set(name).coefficients for name in ("hl", "simplified"))
    state = {"v": 0.12, "ambient": 0.2}
    here, there = outputs(simplified, lossy, **state), outputs(hl, NO_EFFECTS, **state)
    force = here["thrust"]
    assert here["v_dot"] == pytest.approx(there["v_dot"] + 0.01232 * (force - there["thrust"]), abs=1e-12)
    assert here["u_dot"] == pytest.approx(there["u_dot"] + 0.004855 * (force - there["thrust"]), abs=1e-12)
    assert outputs(simplified, NO_EFFECTS, **state)["v_dot"] == 0.0


@pytest.mark.parametrize("model", MODELS)
def test_every_size_of_the_range_gives_finite_rates_in_every_class(model):
    p = load_parameter_set(model).coefficients
    for effect in IN_PLANT.values():
        for d in effect.parameters:
            for size in {-d.upper if d.both_signs else d.lower, d.upper}:
                values = outputs(p, effect_values({effect.id: {d.name: size}}), past=0.1, gate=0.0).values()
                assert np.all(np.isfinite(list(values))), (effect.id, d.name, size)


def test_effects_of_different_parts_add_their_signatures():
    parts = {"dead_zone_shift": {"voltage": 0.2}, "coulomb_friction": {"deceleration": 60.0}}
    parts |= {"quadratic_flow_loss": {"coefficient": 100.0}, "tank_recirculation": {"share": 0.5}}
    base = outputs(HQ, NO_EFFECTS, past=0.3)
    alone = [outputs(HQ, effect_values({name: sizes}), past=0.3) for name, sizes in parts.items()]
    together = outputs(HQ, effect_values(parts), past=0.3)
    for name in OUTPUTS:
        assert together[name] - base[name] == pytest.approx(sum(each[name] - base[name] for each in alone), abs=1e-9)


def test_inertia_slows_the_friction_of_another_effect_too():
    both = effect_values({"rotor_inertia": {"share": 1.0}, "viscous_friction": {"share": 0.5}})
    assert outputs(HQ, both)["n_dot"] == pytest.approx(0.5 * (outputs(HQ, NO_EFFECTS)["n_dot"] - 0.5 * 1366.0))


def test_in_air_no_other_effect_makes_thrust():
    others = {"quadratic_flow_loss": {"coefficient": 400.0}, "entrained_water": {"impulse": 0.02}}
    assert outputs(HQ, effect_values({"water_unloaded": {"share": 1.0}, **others}))["thrust"] == 0.0


def test_the_kernel_and_python_agree_on_all_effects_at_once_and_states_broadcast():
    sizes = {
        name: {p.name: 0.5 * p.upper for k, p in enumerate(effect.parameters) if k == 0 or p.neutral == 0.0}
        for name, effect in IN_PLANT.items()
    }
    e = effect_values(sizes)
    assert 0.0 not in [getattr(e, effect.field_of(p.name)) for effect in IN_PLANT.values() for p in effect.parameters]
    state = PlantState(100.0, -0.05, 0.1, 2.0, 0.3)
    run = simulate(HQ, [2.2], 1e-3, initial=state, effects=e, gates=[0.0])
    n, v, ambient = plant_step(state, 2.2, 0.0, 1e-3, 50.0, 0.25, 0.0, 0.0, 1.0, HQ, e)[:3]
    measured = ambient + e.ambient_current_speed
    assert [run.n[1], run.v[1], run.ambient[1]] == pytest.approx([n, v, measured], rel=1e-12)
    speeds = np.array([-120.0, 5.0, 120.0])
    batch = outputs(HQ, e, n=speeds, u=np.array([-3.0, 1.0, 4.0]))
    for k, (n, u) in enumerate(zip(speeds, (-3.0, 1.0, 4.0), strict=True)):
        single = outputs(HQ, e, n=n, u=u)
        assert [float(np.broadcast_to(batch[name], 3)[k]) for name in OUTPUTS] == list(single.values())


def test_sizes_may_be_arrays_in_python():
    e = EffectValues(thrust_loss_share=np.array([0.0, 0.5]))
    assert outputs(HQ, e)["thrust"] == pytest.approx(outputs(HQ, NO_EFFECTS)["thrust"] * np.array([1.0, 0.5]))


@pytest.mark.parametrize("model", ["simplified", "hl", "hq", "kim_chung", "two_state", "yoerger", "static_dead_band"])
def test_a_supply_at_half_its_voltage_halves_the_drive(model):
    p = load_parameter_set(model).coefficients
    halved = pipeline(90.0, 0.1, 0.12, 3.0, 0.0, 0.0, 1.0, 0.5, p, NO_EFFECTS)
    slower = p._replace(c_u1=0.5 * p.c_u1, c_u2=0.5 * p.c_u2)
    assert halved == pytest.approx(pipeline(90.0, 0.1, 0.12, 3.0, 0.0, 0.0, 1.0, 1.0, slower, NO_EFFECTS), rel=1e-14)


@pytest.mark.parametrize(("n", "u"), [(100.0, 3.0), (-150.0, -5.0), (40.0, -2.0)])
def test_a_supply_that_only_one_thruster_draws_from_sags_as_its_own_would(n, u):
    other = {"thermal_fade": {"share": 0.4}, "dead_zone_shift": {"voltage": 0.1}}
    own = pipeline(n, 0.1, 0.12, u, 0.5, 0.0, 1.0, 1.0, HQ, effect_values({**other, "supply_sag": {"share": 0.3}}))
    e = effect_values(other)
    supply = 1.0 - 0.3 * drawn(n, u, 0.5, HQ, e)
    assert supply < 1.0
    assert pipeline(n, 0.1, 0.12, u, 0.5, 0.0, 1.0, supply, HQ, e) == pytest.approx(own, rel=1e-14)
