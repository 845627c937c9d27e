"""Effects on commands, on readings and on logs, sample by sample; and effects in parameter sets and in fits."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from thruster_model.effects.active import NOTHING, ActiveEffects
from thruster_model.effects.chains import SENSED, command_memory, command_split
from thruster_model.effects.stages import LIBRARY, NO_EFFECTS
from thruster_model.errors import ParameterSetError
from thruster_model.flow_tank import simulate
from thruster_model.identification.fit import fit
from thruster_model.parameter_set_io import dump_parameter_set, load_parameter_set, parse_parameter_set
from thruster_model.whole_run import readings

DT = 0.002
TIME = DT * np.arange(2000)
OUTSIDE = [e for e in LIBRARY.values() if e.sample is not None or e.logged is not None]
SMOOTH = {name: k + np.sin((k + 1) * TIME) for k, name in enumerate(SENSED)}
HL = load_parameter_set("hl").coefficients


def active(effect, **sizes):
    return ActiveEffects(sizes={effect: sizes})


def neutral(effect):
    return ActiveEffects(sizes={effect.id: {p.name: p.neutral for p in effect.parameters}})


def command(effects, commands):
    """Return what reaches the plant of commands (N,), sample by sample: the mean where it changes within one."""
    memory = np.zeros(command_memory(DT, effects.plant))
    split = [command_split(memory, u, DT, effects.plant) for u in commands]
    return np.array([after + (before - after) * (late / DT) if late > 0.0 else after for before, late, after in split])


def acting(effects, commands):
    """Return the acting throttle (N + 1,) under commands (N,)."""
    return simulate(HL, commands, DT, effects=effects.plant).u


def read(effects, true, seed=0):
    """Return what sensors read, by signal; those that are not given are zero."""
    values = next(iter(true.values()))
    rows = np.array([true.get(name, np.zeros(values.size)) for name in SENSED])
    return dict(zip(SENSED, readings(rows, DT, effects.sensors, seed), strict=True))


@pytest.mark.parametrize("effect", OUTSIDE, ids=lambda e: e.id)
def test_at_neutral_an_effect_changes_nothing_bit_for_bit(effect):
    e = neutral(effect)
    commands = 3.0 * np.sign(np.sin(2.0 * TIME))
    assert np.array_equal(command(e, commands), commands)
    found = read(e, SMOOTH, seed=1)
    for signal, values in SMOOTH.items():
        assert np.array_equal(found[signal], values)
        time, logged = e.log(signal, TIME, values, np.random.default_rng(1))
        assert np.array_equal(time, TIME)
        assert np.array_equal(logged, values)


@pytest.mark.parametrize("effect", OUTSIDE, ids=lambda e: e.id)
def test_an_effect_acts_on_its_own_channel_alone(effect):
    sizes = {p.name: (p.upper if np.isfinite(p.neutral) else 2.0) for p in effect.parameters}
    e = ActiveEffects(sizes={effect.id: sizes})
    found = read(e, SMOOTH, seed=2)
    touched = set()
    for signal, values in SMOOTH.items():
        time, logged = e.log(signal, TIME, values, np.random.default_rng(2))
        if not (
            np.array_equal(found[signal], values) and np.array_equal(time, TIME) and np.array_equal(logged, values)
        ):
            touched.add(signal)
    if effect.block == "command":
        assert touched == set()
        assert not np.array_equal(command(e, 3.1 * np.sin(5 * TIME)), 3.1 * np.sin(5 * TIME))
    else:
        assert touched == set(effect.channel.split() or SMOOTH)


def steps(time):
    return np.where(time < 1.0, 0.0, np.where(time < 2.5, 2.6, -1.3))


def test_a_delayed_command_is_the_command_of_before_also_between_samples():
    late = command(active("command_delay", time=0.1), steps(TIME))
    assert np.array_equal(late[50:], steps(TIME)[:-50])
    between = command(active("command_delay", time=0.1005), steps(TIME))
    assert between[550] == pytest.approx(0.75 * 2.6)
    assert np.sum(between) * DT == pytest.approx(np.sum(late) * DT - 0.0005 * (-1.3), abs=1e-9)


@pytest.mark.parametrize("late", [0.1, 0.1005, 0.0137])
def test_a_plant_under_a_delayed_command_is_the_plant_that_much_later(late):
    fine = 1e-4
    commands = steps(TIME[::10])
    plain = simulate(HL, np.repeat(commands, 200), fine)
    delayed = simulate(HL, np.repeat(commands, 10), DT, effects=active("command_delay", time=late).plant)
    later = np.concatenate((np.zeros(round(late / fine)), plain.n))[: plain.n.size : 20]
    np.testing.assert_allclose(delayed.n, later, atol=2e-3)


@pytest.mark.parametrize(("time", "uneven"), [(0.15, 0.0), (0.01, 0.0), (0.15, 0.4), (0.15, -0.4)])
def test_the_acting_throttle_lags_by_the_differential_equation_and_never_exceeds_its_rate(time, uneven):
    lagged = acting(active("command_lag", time=time, unevenness=uneven), steps(TIME))

    def rhs(t, y):
        wanted = steps(np.asarray(t))
        constant = time * (1.0 + np.where(np.abs(wanted) > np.abs(y), uneven, -uneven))
        return np.clip((wanted - y) / constant, -HL.u_dot_max, HL.u_dot_max)

    truth = solve_ivp(rhs, (0, TIME[-1]), [0.0], t_eval=TIME, max_step=0.001, rtol=1e-8, atol=1e-10).y[0]
    bound = 2e-3 if uneven == 0.0 else 1.5e-2  # which constant holds is decided as a step begins
    assert np.max(np.abs(lagged[:-1] - truth)) < bound
    assert np.max(np.abs(np.diff(lagged))) <= HL.u_dot_max * DT * (1.0 + 1e-9)


def test_commands_are_cut_off_stepped_and_ramped():
    assert np.max(np.abs(command(active("throttle_saturation", limit=2.0), steps(TIME)))) == 2.0
    assert set(np.round(command(active("command_quantization", step=0.4), steps(TIME)), 9)) == {0.0, 2.4, -1.2}
    ramped = acting(active("throttle_rate_limit", rate=5.0), steps(TIME))
    assert np.max(np.abs(np.diff(ramped))) == pytest.approx(5.0 * DT)
    assert ramped[500 + 260] == pytest.approx(2.6)
    assert ramped[500 + 101] == pytest.approx(101 * 5.0 * DT)


def test_the_tachometer_lags_steps_and_goes_blind():
    lagged = read(active("tach_lag", time=0.1), {"speed": steps(TIME)})["speed"]
    assert lagged[550] == pytest.approx(2.6 * (1 - np.exp(-1.0)), abs=0.02)
    blind = read(active("tach_dropout", threshold=2.0), {"speed": steps(TIME)})["speed"]
    assert set(blind) == {0.0, 2.6}
    assert read(active("tach_quantization", step=2.0), {"speed": steps(TIME)})["speed"][700] == 2.0


def test_the_load_cell_rings_at_its_frequency_and_comes_to_rest_at_the_load():
    seconds = DT * np.arange(6000)
    jump = {"thrust": np.where(seconds < 1.0, 0.0, 10.0)}
    ringing = read(active("load_cell_resonance", frequency=7.0, damping=0.05), jump)["thrust"]
    assert ringing[-1] == pytest.approx(10.0, abs=1e-3)
    assert np.max(ringing) == pytest.approx(10.0 * (1.0 + np.exp(-np.pi * 0.05 / np.sqrt(1 - 0.05**2))), rel=0.01)
    crossings = seconds[1:][(ringing[1:] > 10.0) & (ringing[:-1] <= 10.0)][:6]
    assert 1.0 / np.mean(np.diff(crossings)) == pytest.approx(7.0 * np.sqrt(1 - 0.05**2), rel=0.01)


@pytest.mark.parametrize("damping", [0.05, 0.7, 1.0])
def test_the_load_cells_mode_is_the_differential_equations(damping):
    load = 3.0 * np.sin(9.0 * TIME) * (TIME > 0.3)
    found = read(active("load_cell_resonance", frequency=4.0, damping=damping), {"thrust": load})["thrust"]
    w = 2.0 * np.pi * 4.0

    def rhs(t, y):
        return y[1], w * w * (np.interp(t, TIME, load) - y[0]) - 2.0 * damping * w * y[1]

    truth = solve_ivp(rhs, (0.0, TIME[-1]), [0.0, 0.0], t_eval=TIME, max_step=DT, rtol=1e-9, atol=1e-10).y[0]
    np.testing.assert_allclose(found, truth, atol=1e-4)


def test_scales_offsets_drift_and_crosstalk_are_what_they_say():
    def one(effect, signal, **sizes):
        return read(active(effect, **sizes), SMOOTH)[signal]

    assert one("flow_scale", "axial", share=0.2) == pytest.approx(1.2 * SMOOTH["axial"])
    assert one("flow_bias", "ambient", offset=-0.05) == pytest.approx(SMOOTH["ambient"] - 0.05)
    assert one("load_cell_drift", "thrust", rate=0.1) == pytest.approx(SMOOTH["thrust"] + 0.1 * TIME)
    crossed = one("load_cell_crosstalk", "thrust", gain=10.0)
    assert crossed == pytest.approx(SMOOTH["thrust"] + 10.0 * SMOOTH["torque"])
    assert one("flow_delay", "axial", time=0.5)[500:] == pytest.approx(SMOOTH["axial"][:-250][250:])
    between = one("flow_delay", "axial", time=0.0005)
    assert between[1:] == pytest.approx(0.75 * SMOOTH["axial"][1:] + 0.25 * SMOOTH["axial"][:-1])


def test_scatter_has_the_size_it_says_and_needs_a_seed():
    spiky = active("flow_spikes", share=0.2)
    assert np.array_equal(read(spiky, SMOOTH)["axial"], SMOOTH["axial"])
    hit = read(spiky, SMOOTH, seed=3)["axial"] - SMOOTH["axial"]
    assert np.mean(hit != 0) == pytest.approx(0.2, abs=0.04)
    assert np.std(hit[hit != 0]) == pytest.approx(0.3, rel=0.15)
    others = (read(spiky, SMOOTH, seed=4)["axial"], SMOOTH["axial"] + hit, read(spiky, SMOOTH, seed=3)["ambient"])
    assert not np.array_equal(others[0], others[1]), "another seed"
    assert not np.array_equal(others[2] - SMOOTH["ambient"], hit), "another sensor"
    time, _ = active("timestamp_jitter", deviation=0.02).log("speed", TIME, TIME, np.random.default_rng(4))
    assert np.all(np.diff(time) >= 0)
    _, values = active("dropped_samples", share=0.3).log("speed", TIME, SMOOTH["speed"], np.random.default_rng(5))
    assert np.mean(np.diff(values) == 0) == pytest.approx(0.3, abs=0.04)


def test_stamps_are_late_by_channel_and_clocks_drift():
    e = active("log_alignment", flow=0.08)
    assert e.log("axial", TIME, TIME, np.random.default_rng(0))[0] == pytest.approx(TIME + 0.08)
    assert np.array_equal(e.log("speed", TIME, TIME, np.random.default_rng(0))[0], TIME)
    drifting = active("clock_drift", rate=0.01).log("speed", TIME, TIME, np.random.default_rng(0))[0]
    assert drifting[-1] == pytest.approx(1.01 * TIME[-1])


def test_effects_that_follow_each_other_do_so_in_the_devices_order():
    both = ActiveEffects(sizes={"throttle_saturation": {"limit": 2.0}, "command_delay": {"time": 0.1}})
    assert np.array_equal(command(both, steps(TIME))[50:], np.clip(steps(TIME), -2, 2)[:-50])
    chain = ActiveEffects(sizes={"flow_bias": {"offset": 0.1}, "flow_scale": {"share": 0.5 - 0.3}})
    assert read(chain, SMOOTH)["axial"] == pytest.approx(1.2 * SMOOTH["axial"] + 0.1)


def test_nothing_is_nothing():
    assert NOTHING.plant is NO_EFFECTS
    assert active("flow_bias", offset=0.1).plant is NO_EFFECTS
    assert active("command_delay", time=0.1).sensors is NO_EFFECTS


EFFECT_YAML = """
effects:
  coulomb_friction:
    deceleration: {value: 60.0, unit: rad/s^2}
  command_delay:
    time: {value: 0.08, unit: s}
"""


def test_a_parameter_set_carries_effects_through_yaml():
    text = dump_parameter_set(load_parameter_set("hl")) + EFFECT_YAML
    loaded = parse_parameter_set(text, origin="mine.yaml")
    assert loaded.effects.sizes["coulomb_friction"]["deceleration"] == 60.0
    again = parse_parameter_set(dump_parameter_set(loaded), origin="again.yaml")
    assert again.effects.sizes == loaded.effects.sizes


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("coulomb_friction:", "dry_friction:", "key 'effects.dry_friction': expected one of"),
        ("deceleration:", "acceleration:", "expected parameters deceleration; found 'acceleration'"),
        ("value: 60.0", "value: 6000.0", "expected 0 or 0 to 500 rad/s^2; found 6000.0"),
        ("unit: rad/s^2", "unit: rpm", "unit': expected 'rad/s^2'; found 'rpm'"),
        ("{value: 0.08, unit: s}", "0.08", "expected {value: 0.0, unit: s}; found 0.08"),
        ("unit: s}", "unit: s, standard_deviation: 0.01}", "time.standard_deviation': a known effect is exact"),
        ("unit: s}", "unit: s, deviation: 0.01}", "key 'effects.command_delay.time.deviation': unknown"),
    ],
)
def test_what_is_wrong_with_an_effect_is_said(old, new, sentence):
    text = dump_parameter_set(load_parameter_set("hl")) + EFFECT_YAML.replace(old, new)
    with pytest.raises(ParameterSetError) as error:
        parse_parameter_set(text, origin="mine.yaml")
    assert sentence in str(error.value)


def test_a_fit_with_the_effect_in_its_start_set_finds_the_parameters_that_one_without_it_misses(independent_bench):
    """Truth: commands 80 ms late, made by other code."""
    truth = load_parameter_set("hl").with_values({"c_nv_Q": 1.2e-3, "c_n_Q": 6e-6, "k_Q": 900.0}, source="truth")
    rng = np.random.default_rng(12)

    def late(amplitude, rate):
        return lambda t: (t > 1.08) * amplitude * np.sin(rate * (t - 1.08)) * np.cos(0.23 * (t - 1.08))

    runs = []
    for k, (amplitude, rate) in enumerate(((2.8, 1.1), (2.3, 3.1))):
        signals = ("speed", "thrust", "torque", "axial", "ambient")
        run = independent_bench(f"{k}", late(amplitude, rate), 12.0, truth.values, rng, signals)
        shift = round(0.08 / run.dt)
        early = np.concatenate((run.throttle[shift:], np.full(shift, run.throttle[-1])))
        runs.append(type(run)(name=run.name, dt=run.dt, throttle=early, measurements=run.measurements))
    start = load_parameter_set("hl")
    text = dump_parameter_set(start) + "effects:\n  command_delay:\n    time: {value: 0.08, unit: s}\n"
    with_effect = fit(parse_parameter_set(text, origin="with"), runs).parameter_set.values
    without = fit(start, runs).parameter_set.values
    assert with_effect["k_n"] == pytest.approx(truth.values["k_n"], rel=0.03)
    assert abs(without["k_n"] / truth.values["k_n"] - 1.0) > 0.1
