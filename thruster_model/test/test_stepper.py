"""The stepper: a run in pieces is the run at once, for every effect; what is remembered does not grow."""

import numpy as np
import pytest

from thruster_model.effects.active import ActiveEffects
from thruster_model.effects.stages import LIBRARY
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.stepper import (
    AT_REST,
    NOMINAL_SUPPLY,
    ROWS,
    PlantState,
    advance,
    new_memory,
    new_sensors,
    sense,
    substeps_of,
)
from thruster_model.whole_run import readings, simulated_rows

HL = load_parameter_set("hl").coefficients
DT = 2e-3
COMMANDS = np.repeat([2.6, -3.1, 0.9, 4.0, -1.2, 0.0], 40)
GATES = (np.arange(COMMANDS.size) % 30 < 20).astype(float)
IN_TIME = [effect for effect in LIBRARY.values() if effect.logged is None]


def sized(*effects):
    return ActiveEffects(
        sizes={e.id: {p.name: 1.0 if p.unit == "s" and p.lower == 1.0 else 0.43 * (p.lower + p.upper)
                      for p in e.parameters} for e in effects if e.id != "thruster_polarity"}
    )  # fmt: skip


def in_pieces(effects, pieces, start=AT_REST):
    """Return (true rows, readings) of the run, advanced and read piece by piece."""
    e, e_sensors = effects.plant, effects.sensors
    substeps = substeps_of(DT, 1e-3, e)
    memory, sensors = new_memory(DT, substeps, e, start.u), new_sensors(DT, e_sensors, 8)
    out, read = np.empty((len(ROWS), COMMANDS.size + 1)), np.empty((5, COMMANDS.size + 1))
    state, at = start, 0
    for size in pieces:
        there = slice(at, at + size)
        state = advance(
            state, COMMANDS[there, None], DT, substeps, HL, e, GATES[there], NOMINAL_SUPPLY, memory, out, at
        )
        sense(out, at, at + size, DT, e_sensors, sensors, read)
        at += size
    sense(out, at, at + 1, DT, e_sensors, sensors, read)
    return out, read


@pytest.mark.parametrize("effect", [*IN_TIME, None], ids=lambda e: e.id if e else "all")
def test_a_run_in_pieces_is_the_run_at_once_bit_for_bit(effect):
    effects = sized(*([effect] if effect else IN_TIME))
    start = PlantState(5.0, 0.01, 0.02, 0.4)
    whole = simulated_rows(HL, COMMANDS, DT, start=start, effects=effects.plant, gates=GATES)
    rows, read = in_pieces(effects, [1, 7, 32, 80, 119, 1], start)
    assert rows.tobytes() == whole.tobytes()
    assert read.tobytes() == readings(whole, DT, effects.sensors, 8).tobytes()


def test_a_command_that_has_acted_for_long_goes_on_until_the_delayed_one_arrives():
    rest = simulated_rows(HL, np.full(3000, 2.0), 0.01)[:, -1]
    start = PlantState(rest[0], rest[1], rest[2], 2.0)
    late = ActiveEffects(sizes={"command_delay": {"time": 0.1}})
    rows = simulated_rows(HL, np.zeros(200), DT, start=start, effects=late.plant)
    np.testing.assert_allclose(rows[:, :51], np.tile(rest[:, None], 51), rtol=1e-6)
    assert rows[0, 60] < 0.9 * rest[0]


@pytest.mark.parametrize("step", [1e-3, 2e-3, 5e-3])
def test_a_delay_of_the_command_is_exact_between_the_steps_also(step):
    """Against the delay of whole steps of a fine run; a mean over the step would be off by the ramp limit's work."""
    fine = simulated_rows(
        HL, np.repeat(COMMANDS[:200], 40), 5e-5, effects=ActiveEffects(sizes={"command_delay": {"time": 0.0137}}).plant
    )
    every = round(step / 5e-5)
    held = np.repeat(COMMANDS[:200], 2)[:: round(step / 1e-3)]
    late = simulated_rows(HL, held, step, effects=ActiveEffects(sizes={"command_delay": {"time": 0.0137}}).plant)
    assert np.max(np.abs(late[0] - fine[0, ::every][: late.shape[1]])) < 0.02


@pytest.mark.parametrize(
    "effects",
    [{}, {"throttle_rate_limit": {"rate": 20.0}}, {"command_delay": {"time": 0.0137}}, {"command_lag": {"time": 0.05}},
     {"command_lag": {"time": 0.05, "unevenness": 0.3}},
     {"command_quantization": {"step": 0.5}, "command_delay": {"time": 0.05}},
     {"tank_recirculation": {"share": 0.5, "delay": 1.0}, "throttle_rate_limit": {"rate": 20.0}}],
)  # fmt: skip
def test_commands_that_change_within_periods_act_then(effects):
    """Against short periods in which none does. Their mean over each period begins early where a limit makes a ramp."""
    rng = np.random.default_rng(4)
    fine = np.repeat(rng.uniform(-4.0, 4.0, 12), rng.integers(300, 700, 12))
    fine = fine[: fine.size // 60 * 60]
    e = ActiveEffects(sizes=effects).plant
    expected = simulated_rows(HL, fine, 1e-2 / 60, effects=e)[:, ::60]
    found = simulated_rows(HL, fine.reshape(-1, 60), 1e-2, largest_step=2.5e-3, effects=e)
    assert np.max(np.abs(found[0] - expected[0])) < 0.02
    smeared = simulated_rows(HL, fine.reshape(-1, 60).mean(axis=1), 1e-2, largest_step=2.5e-3, effects=e)
    assert np.max(np.abs(smeared[0] - expected[0])) > 1.0


@pytest.mark.parametrize(
    "effects",
    [{}, {"throttle_rate_limit": {"rate": 20.0}}, {"command_delay": {"time": 0.0137}}, {"command_lag": {"time": 0.05}},
     {"command_lag": {"time": 0.05}, "throttle_rate_limit": {"rate": 20.0}},
     {"tank_recirculation": {"share": 0.5, "delay": 1.0}, "command_delay": {"time": 0.0137}}],
)  # fmt: skip
def test_commands_on_straight_lines_act_as_the_finest_stairs_do(effects):
    """Lines of up to 150 V/s, beyond the throttle's own limit; stairs of each period come late where the limit acts."""
    ends = np.repeat(np.random.default_rng(5).uniform(-3.0, 3.0, 20), 2)
    knots = np.arange(ends.size) * 0.04
    e = ActiveEffects(sizes=effects).plant
    fine, step = 1e-2 / 200, 1e-2
    middles = np.interp(fine * (np.arange(round(knots[-1] / fine)) + 0.5), knots, ends)
    start = PlantState(0.0, 0.0, 0.0, ends[0])
    expected = simulated_rows(HL, middles, fine, start=start, effects=e)[:, ::200]
    at = step * np.arange(1, round(knots[-1] / step) + 1)
    found = simulated_rows(HL, np.interp(at, knots, ends), step, start=start, effects=e, straight=True)
    assert np.max(np.abs(found[5] - expected[5])) < 4e-3  # a stair of the fine ones
    assert np.max(np.abs(found[0] - expected[0])) < 0.04
    stairs = simulated_rows(HL, middles.reshape(-1, 200).mean(axis=1), step, start=start, effects=e)
    assert np.max(np.abs(stairs[0] - expected[0])) > 0.2


def test_lines_in_pieces_are_the_lines_at_once_bit_for_bit():
    e = ActiveEffects(sizes={"command_delay": {"time": 0.0137}}).plant
    whole = simulated_rows(HL, COMMANDS, DT, effects=e, straight=True)
    memory, out = new_memory(DT, 2, e, straight=True), np.empty((len(ROWS), COMMANDS.size + 1))
    first = advance(AT_REST, COMMANDS[:77, None], DT, 2, HL, e, np.empty(0), NOMINAL_SUPPLY, memory, out, 0)
    advance(first, COMMANDS[77:, None], DT, 2, HL, e, np.empty(0), NOMINAL_SUPPLY, memory, out, 77)
    assert out.tobytes() == whole.tobytes()
