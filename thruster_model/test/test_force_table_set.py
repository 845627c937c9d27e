"""A maker's table as a plant: exactly the table at rest, a first-order lag on the way, the supply as an input."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from thruster_model.cli_force_table import main
from thruster_model.command_scale import VOLTS, CommandScale
from thruster_model.equations.force_map import drive_for_force, force_at_speed, static_current, static_speed
from thruster_model.equations.thruster import input_map, input_map_inverse
from thruster_model.errors import ForceTableError, ParameterSetError
from thruster_model.flow_tank import simulate
from thruster_model.force_curves import ASSUMED_C_T, ForceCurves, scale_of
from thruster_model.force_table import ForceTable
from thruster_model.force_table_io import write_force_table
from thruster_model.force_table_map_io import read_column_map
from thruster_model.force_table_set import parameter_set_of
from thruster_model.force_table_sheets_io import read_force_table
from thruster_model.identification.experiment import Experiment, Measurement
from thruster_model.identification.fit import fit
from thruster_model.identification.prediction import predict
from thruster_model.models import MODELS
from thruster_model.parameter_set_io import dump_parameter_set, load_parameter_set, parse_parameter_set

INVENTED = load_parameter_set("force_table")
TABLE = INVENTED.force_table
assert TABLE is not None
P = INVENTED.coefficients
COMMANDS = (1100.0, 1333.0, 1469.0, 1475.0, 1500.0, 1524.0, 1527.0, 1531.0, 1601.0, 1777.7, 1900.0)


def settled(command, volts, p=P):
    """The plant's last instant after two seconds at a command [µs] and supply [V]."""
    u = INVENTED.command.throttle(command)
    run = simulate(p, np.full(40, u), 0.05, supply=np.full(40, volts / p.nominal_supply))
    return run.n[-1], run.thrust[-1], run.torque[-1]


@pytest.mark.parametrize("volts", [12.0, 12.7, 14.0, 15.9, 16.0])
def test_at_rest_the_plant_is_the_table_at_every_command_and_supply(volts):
    for command in COMMANDS:
        n, force, torque = settled(command, volts)
        assert force == pytest.approx(float(TABLE.force_at(command, volts)), abs=1e-5)
        assert n == pytest.approx(float(TABLE.value("speed", command, volts)), abs=1e-3)
        assert torque == 0.0


def test_beyond_what_was_measured_the_ends_hold():
    assert settled(1900.0, 30.0) == pytest.approx((368.6, 48.912, 0.0), abs=1e-3)
    assert settled(1100.0, 5.0) == pytest.approx((-280.4, -22.015, 0.0), abs=1e-3)
    assert float(simulate(P, [50.0] * 40, 0.1).thrust[-1]) == pytest.approx(37.931, abs=1e-5)


def test_within_the_dead_zone_nothing_turns_exactly():
    for command in (1477.0, 1500.0, 1523.0):
        assert settled(command, 16.0) == (0.0, 0.0, 0.0)
    assert settled(1530.0, 12.0) == (0.0, 0.0, 0.0)  # wider at 12 V than the band common to all
    assert settled(1530.0, 16.0)[1] > 0.0


def test_on_the_way_the_speed_follows_as_a_first_order_lag_and_the_force_is_that_of_the_speed():
    u, dt = float(INVENTED.command.throttle(1800.0)), 0.02
    run = simulate(P, np.full(30, u), dt)
    end = float(TABLE.value("speed", 1800.0, 14.0))
    t = dt * np.arange(31)
    assert run.n == pytest.approx(end * (1.0 - np.exp(-10.0 * t)), rel=1e-4, abs=1e-4)
    assert run.thrust == pytest.approx(np.interp(run.n, TABLE.speed[1], TABLE.force[1]), abs=1e-4)


def test_a_changing_supply_is_integrated_as_scipy_does():
    u, dt = float(INVENTED.command.throttle(1700.0)), 0.05
    volts = np.linspace(16.0, 12.0, 60)
    run = simulate(P, np.full(60, u), dt, supply=volts / 14.0)
    n = 0.0
    for k, each in enumerate(volts):
        target = float(TABLE.value("speed", 1700.0, each))
        n = solve_ivp(lambda t, x, to=target: 10.0 * (to - x), (0.0, dt), [n], rtol=1e-10, atol=1e-12).y[0, -1]
        assert run.n[k + 1] == pytest.approx(n, rel=1e-4)


@settings(deadline=None)
@given(st.floats(-60.0, 60.0).filter(lambda f: abs(f) > 1e-3), st.floats(12.0, 16.0))
def test_the_inverse_is_the_table_s_own_and_ends_at_its_ends(force, volts):
    command = INVENTED.command.command(input_map_inverse(drive_for_force(force, volts, P), P))
    assert float(command) == pytest.approx(float(TABLE.command_for(force, volts, outside="clamp")), abs=1e-4)


def test_lookups_broadcast_and_kernel_and_python_agree():
    n, volts = np.linspace(-300.0, 300.0, 7), np.array([[12.0], [13.0]])
    forces = force_at_speed(n, volts, P)
    assert forces.shape == (2, 7)
    assert forces[1, 2] == force_at_speed(-100.0, 13.0, P)
    assert static_current(324.6, 14.0, P) == pytest.approx(15.76, abs=1e-3)
    assert static_speed(input_map(5.0, P), 14.0, P) == pytest.approx(324.6, abs=1e-3)


def test_without_measured_speeds_the_lag_has_one_of_its_own_and_speed_is_no_signal():
    force_only = parameter_set_of(replace(TABLE, speed=None, current=None), nominal_supply=14.0)
    assert force_only.model.signals == ("thrust",) != INVENTED.model.signals
    run = simulate(force_only.coefficients, np.full(60, 5.0), 0.05)
    assert run.thrust[-1] == pytest.approx(37.931, abs=1e-5)
    assert run.n[-1] == pytest.approx(np.sqrt(37.931 / ASSUMED_C_T), rel=1e-5)
    assert np.isnan(static_current(100.0, 14.0, force_only.coefficients))


def test_a_set_with_its_table_survives_the_file_bit_for_bit():
    again = parse_parameter_set(dump_parameter_set(INVENTED), origin="again")
    assert again.command == INVENTED.command
    assert again.coefficients.curves.tobytes() == P.curves.tobytes()
    assert again.values == INVENTED.values


def test_a_table_whose_force_falls_is_made_monotone_and_says_so():
    force = TABLE.force.copy()
    force[0, -1] = force[0, -2] - 0.2
    made = parameter_set_of(replace(TABLE, force=force))
    assert "monotone" in made.source or "monotone" in made.force_table.source
    assert np.all(np.diff(made.force_table.force, axis=1) >= 0.0)
    with pytest.raises(ForceTableError, match=r"force: expected values that never fall.*12 V, 1900 µs"):
        ForceCurves(table=replace(TABLE, force=force), scale=scale_of(TABLE))


PWM = CommandScale(unit="µs", stop=1500.0, per_volt=80.0, lowest=1100.0, highest=1900.0)


def test_commands_become_throttles_and_back_held_to_what_the_device_takes():
    assert PWM.throttle([1100.0, 1500.0, 1580.0, 2000.0, np.nan]) == pytest.approx([-5, 0, 1, 5, np.nan], nan_ok=True)
    assert PWM.command([-9.0, 0.0, 1.0, 7.0]) == pytest.approx([1100, 1500, 1580, 1900])
    assert PWM.largest_throttle == 5.0
    share = CommandScale(unit="1", per_volt=0.2, lowest=-1.0, highest=1.0)
    assert share.throttle(-0.5) == -2.5
    assert VOLTS.throttle(-2.2) == VOLTS.command(-2.2) == -2.2


TEXT = dump_parameter_set(INVENTED)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("model: force_table", "model: hl"), "model 'hl' takes none"),
        (("value: 14.0\n    unit: V", "value: 24.0\n    unit: V"), "a supply that the table holds, 12 to 16 V"),
        (("per_volt: 80.0", "per_volt: 0"), "per_volt: expected a finite number above 0; found 0"),
        (("per_volt: 80.0", "per_volt: many"), r"'command.per_volt': expected a number; found 'many'"),
        (("  per_volt: 80.0\n", ""), "'command': expected unit, stop and per_volt"),
        (
            ("  unit: µs\n  stop: 1500.0\n  per", "  unit: V\n  stop: 1500.0\n  per"),
            "expected the scale's unit V; found µs",
        ),
        (("  lowest: 1100.0", "  lowest: 1600.0"), "stop: expected a number between lowest and highest"),
        (("48.912]", "nine]"), "force: expected numbers"),
    ],
)
def test_a_set_that_does_not_fit_its_table_is_refused_with_a_sentence(change, said):
    assert change[0] in TEXT
    with pytest.raises(ParameterSetError, match=said):
        parse_parameter_set(TEXT.replace(*change, 1), origin="set")


def test_a_set_s_table_without_a_name_and_a_source_has_those_of_the_set():
    above, table = TEXT.split("force_table:\n")
    bare = "".join(line for line in table.splitlines(True) if not line.startswith(("  name:", "  source:")))
    made = parse_parameter_set(f"{above}force_table:\n{bare}", origin="set").force_table
    assert (made.name, made.source) == (INVENTED.name, INVENTED.source)
    np.testing.assert_array_equal(made.force, TABLE.force)
    on_base = parse_parameter_set(f"base: force_table\nforce_table:\n{bare}", origin="mine.yaml").force_table
    assert (on_base.name, on_base.source) == ("mine", "mine")


def test_a_model_without_a_set_s_table_has_no_coefficients():
    with pytest.raises(ValueError, match="expected the curves of a parameter set's table"):
        MODELS["force_table"].coefficients(INVENTED.values)
    without = TEXT.split("force_table:\n  name")[0]
    with pytest.raises(ParameterSetError, match="'force_table': missing; model 'force_table' needs one"):
        parse_parameter_set(without, origin="set")


def measured(rate, scale, seed, supply):
    """A run of a table thruster integrated anew: speed and thrust every 20 ms, noise of 0.5 rad/s and 0.1 N."""
    rng, dt = np.random.default_rng(seed), 0.02
    t = dt * np.arange(1500)
    command = 1500.0 + np.where(t > 1.0, 320.0 * np.sin(0.9 * t) * np.cos(0.31 * t), 0.0)
    n, speeds = 0.0, []
    for k in range(t.size):
        speeds.append(n)
        n += (1.0 - np.exp(-rate * dt)) * (float(TABLE.value("speed", command[k], supply[k])) - n)
    forces = [scale * np.interp(n, *(TABLE.at_supply(v).__getattribute__(q)[0] for q in ("speed", "force")))
              for n, v in zip(speeds, supply, strict=True)]  # fmt: skip
    values = {"speed": (np.array(speeds), 0.5), "thrust": (np.array(forces), 0.1)}
    return Experiment(
        name="table",
        dt=dt,
        throttle=INVENTED.command.throttle(command),
        measurements={
            name: Measurement(signal=name, time=t, values=x + rng.normal(0.0, s, t.size), width=0.0, noise=s)
            for name, (x, s) in values.items()
        },
        supply=supply,
    )


def test_a_fit_finds_lag_and_scale_of_a_thruster_whose_battery_runs_down():
    run = measured(6.5, 0.9, 3, np.linspace(15.8, 12.5, 1500))
    found = fit(INVENTED, [run]).parameter_set.parameters
    for name, truth in (("rate", 6.5), ("thrust_scale", 0.9), ("command_scale", 1.0), ("delta_u2", 0.3)):
        p = found[name]
        assert abs(p.value - truth) < 4.0 * p.standard_deviation, (name, p)
        assert p.standard_deviation < 0.03 * max(1.0, truth)


def test_the_supply_counts_a_fifth_of_the_thrust_in_a_run():
    run = measured(10.0, 1.0, 3, np.full(1500, 12.5))
    there, nominal = (predict(each, P)["thrust"] for each in (run, replace(run, supply=None)))
    error = run.measurements["thrust"].values
    assert np.std(there - error) == pytest.approx(0.1, rel=0.1)
    assert np.std(nominal - error) > 0.1 * np.std(error)


def test_one_command_makes_the_set_of_a_table(tmp_path, capsys):
    write_force_table(TABLE, tmp_path / "table.yaml")
    out, made = tmp_path / "copy.yaml", tmp_path / "set.yaml"
    more = ["--set", str(made), "--nominal-supply", "15", "--lag", "0.2"]
    assert main([str(tmp_path / "table.yaml"), "--out", str(out), *more]) == 0
    assert "unit: µs, stop: 1500.0, per_volt: 80.0" in capsys.readouterr().out
    found = load_parameter_set(made)
    assert found.values["rate"] == 5.0
    assert found.values["nominal_supply"] == 15.0
    assert found.coefficients.curves.tobytes() == P.curves.tobytes()
    assert main([str(tmp_path / "table.yaml"), "--out", str(tmp_path / "b.yaml"), "--set", str(made)]) == 1
    assert "exists and is not overwritten" in capsys.readouterr().err


def test_a_supply_that_is_no_voltage_is_refused():
    with pytest.raises(ValueError, match="supply: expected finite values from 0 of the commands' shape"):
        simulate(P, [1.0, 2.0], 0.1, supply=[1.0])


def test_a_table_of_two_commands_at_one_supply_works():
    least = ForceTable(
        command=[-1.0, 0.0, 1.0], command_unit="1", stop=0.0, supply=[12.0], force=[[-1.0, 0.0, 2.0]], source="by hand"
    )
    p = parameter_set_of(least).coefficients
    assert simulate(p, np.full(60, 2.5), 0.05).thrust[-1] == pytest.approx(1.0, abs=1e-6)
    assert simulate(p, np.full(60, -5.0), 0.05).thrust[-1] == pytest.approx(-1.0, abs=1e-6)


def test_the_t200_s_own_sheet_becomes_a_plant_that_is_its_table(t200_data, request):
    maps = request.config.rootpath / "thruster_model/config/t200_columns.yaml"
    table = read_force_table(next(t200_data.glob("*.xlsx")), read_column_map(maps))
    t200 = parameter_set_of(table, nominal_supply=16.0)
    assert (t200.values["delta_u1"], t200.values["delta_u2"]) == (-0.3, 0.35)  # 1476 to 1528 µs
    p, kept = t200.coefficients, t200.force_table
    for command in (1100.0, 1211.0, 1474.0, 1530.0, 1850.0, 1900.0):
        for volts in (10.0, 14.8, 20.0):
            u = t200.command.throttle(command)
            run = simulate(p, np.full(60, u), 0.05, supply=np.full(60, volts / 16.0))
            assert run.thrust[-1] == pytest.approx(float(kept.force_at(command, volts)), abs=2e-3)
            assert abs(run.thrust[-1] - float(table.force_at(command, volts))) < 0.1
