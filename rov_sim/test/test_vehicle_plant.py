"""The vehicle's plant: known numbers, period by period as at once, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from numba import njit

from rov_sim.vehicle import kernel, plant
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from rov_sim.vehicle.plant import VehiclePlant, VehicleSettings, simulate
from rov_sim.vehicle.rates import thruster_row
from rov_sim.vehicle.settings_io import load_vehicle_settings
from rov_sim.vehicle.tables import BODY, STATE, empty_sheet
from rov_sim.vehicle.truth import at_rest
from thruster_model.effects.stages import NEUTRAL
from thruster_model.equations.attitude import quaternion_from_euler, rotated
from thruster_model.errors import VehicleError
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set

HELD = np.array([2.0, 1.8, 2.2, 1.6, -1.5, -2.0])


@pytest.fixture(scope="module")
def ngs():
    return load_vehicle_settings("ngs")


def started(settings, u, **changes):
    thrusters = np.zeros((settings.count, 4))
    thrusters[:, 2] = u
    return replace(settings, initial=at_rest(settings.count, **changes)._replace(thrusters=thrusters))


def test_the_ngs_moves_as_two_independent_simulations_say(ngs) -> None:
    run = simulate(started(ngs, HELD), np.tile(HELD, (100, 1)), 0.1)
    np.testing.assert_allclose(
        run.velocity[10],
        (0.1310633841, 0.0397923789, -0.02330649277, 0.1333777456, -0.02783300255, -0.1249677472),
        atol=5e-11,
    )
    np.testing.assert_allclose(run.position[100], (1.299172222, -0.2242972503, -0.01538673453), atol=5e-10)
    np.testing.assert_allclose(
        run.attitude[100], (0.8810284894, 0.07571296391, -0.04394533755, -0.4648926277), atol=5e-11
    )
    np.testing.assert_allclose(
        run.velocity[100],
        (0.1333922444, 0.04939015511, -0.008372862016, -0.004971184945, -0.01637443975, -0.0899125012),
        atol=5e-11,
    )
    np.testing.assert_allclose(
        run.axial[100],
        (0.07909153651, 0.08221628135, 0.1243969619, 0.043422433, -0.008704993441, -0.02131603342),
        atol=5e-11,
    )


@pytest.mark.parametrize(("X", "surge"), [(50.0, 0.5488881855), (100.0, 0.7949704690)])
def test_the_heavys_hull_alone_settles_at_the_known_surge(X, surge) -> None:
    """As heavy as the water it displaces; thrusters without any force."""
    settings = load_vehicle_settings("bluerov2_heavy")
    c = settings.coefficients
    hull = replace(settings, coefficients=c._replace(weight=c.buoyancy, thrust_scale=np.zeros(8)))
    run = simulate(hull, np.zeros((600, 8)), 0.05, wrench=np.tile([X, 0, 0, 0, 0, 0], (600, 1)))
    assert run.velocity[-1, 0] == pytest.approx(surge, abs=5e-11)


def test_a_run_is_its_periods_bit_for_bit(ngs) -> None:
    rng = np.random.default_rng(3)
    u = rng.uniform(-4, 4, (40, 6))
    wrench = rng.normal(size=(40, 6))
    for settings in (ngs, replace(ngs, effects=(NEUTRAL,) * 6)):
        run = simulate(settings, u, 0.04, wrench=wrench)
        plant = VehiclePlant(settings)
        for k in range(40):
            truth = plant.advance(u[k], 0.04, wrench[k])
            for name in ("position", "attitude", "velocity", "n", "axial", "u"):
                np.testing.assert_array_equal(getattr(truth, name), getattr(run, name)[k + 1], err_msg=name)
        np.testing.assert_array_equal(plant.state.thrusters, run.final.thrusters)


@pytest.mark.parametrize("delay", [0.0125, 0.0153])
def test_a_command_that_arrives_within_a_step_acts_from_its_instant_on(delay: float) -> None:
    """Beside steps in which none arrives: a command smeared over its step is 0.3 rad/s off."""
    late = ActiveVehicleEffect(id="command_delay", sizes={"time": delay})
    sooner = ActiveVehicleEffect(id="command_delay", sizes={"time": 0.0071}, thruster=2)
    commands = np.zeros((25, 6))
    commands[5:12, :3], commands[12:, 3:] = 2.0, -3.0

    def run(step: float, *effects: ActiveVehicleEffect):  # type: ignore[no-untyped-def]
        return simulate(load_vehicle_settings("ngs", effects=effects, largest_step=step), commands, 0.04)

    whole, split = run(1e-4, late), run(1e-3, late)
    np.testing.assert_allclose(split.n, whole.n, rtol=0.0, atol=5e-3)
    np.testing.assert_allclose(split.velocity, whole.velocity, rtol=0.0, atol=1e-5)
    several = [replace(late, thruster=i) for i in (0, 1, 3, 4, 5)]
    np.testing.assert_allclose(run(1e-3, sooner, *several).n, run(1e-4, sooner, *several).n, rtol=0.0, atol=5e-3)


def test_effects_at_neutral_change_no_bit(ngs) -> None:
    u = np.random.default_rng(4).uniform(-4, 4, (20, 6))
    plain, neutral = simulate(ngs, u, 0.04), simulate(replace(ngs, effects=(NEUTRAL,) * 6), u, 0.04)
    for name, first, second in zip(plain._fields[:-1], plain[:-1], neutral[:-1], strict=True):
        np.testing.assert_array_equal(first, second, err_msg=name)


def test_ninety_degrees_of_pitch_are_an_attitude_like_any_other(ngs) -> None:
    heavy = ngs.coefficients._replace(weight=ngs.coefficients.buoyancy, r_B=np.zeros(3))
    start = at_rest(6, angles=(0.0, np.pi / 2 - 1e-3, 0.0), velocity=(0.2, 0, 0, 0, 0.5, 0))
    run = simulate(replace(ngs, coefficients=heavy, initial=start), np.zeros((100, 6)), 0.04)
    assert np.all(np.isfinite(run.velocity))
    nose = np.array([rotated(tuple(q), (1.0, 0.0, 0.0)) for q in run.attitude])
    assert nose[0, 0] > 0 > nose[-1, 0]  # it went over the top
    np.testing.assert_allclose(np.linalg.norm(run.attitude, axis=1), 1.0, atol=1e-14)


def test_the_acceleration_told_is_the_slope_of_the_velocity(ngs) -> None:
    run = simulate(ngs, np.tile(HELD, (400, 1)), 1e-3)
    slope = (run.velocity[2:] - run.velocity[:-2]) / 2e-3
    np.testing.assert_allclose(run.acceleration[101:399], slope[100:398], atol=2e-4)


OTHERS = ["kim_chung", "four_quadrant", "static_quadratic", "table", "airfoil", "two_state"]


def assert_driven(settings: VehicleSettings) -> None:
    """Assert that the four horizontal thrusters drive forward."""
    run = simulate(settings, np.tile([2.0, 2.0, 2.0, 2.0, 0, 0], (50, 1)), 0.04)
    assert run.velocity[-1, 0] > 0.05
    assert np.all(run.thrust[-1, :4] > 0.0)


@pytest.mark.parametrize(
    "model", ["simplified", "hl", "force_table", *(pytest.param(each, marks=pytest.mark.long) for each in OTHERS)]
)
def test_every_class_of_thrusters_drives_a_vehicle(model) -> None:
    assert_driven(load_vehicle_settings("ngs", thruster=model))


@pytest.mark.parametrize("model", OTHERS)
def test_uncompiled_every_class_drives_a_vehicle_too_and_compiles_where_a_kernel_touches_it(model, monkeypatch) -> None:
    """Whole kernels take ten seconds a class to compile, which the test above does at length."""
    for name in ("run_vehicle", "measured"):
        monkeypatch.setattr(kernel, name, getattr(kernel, name).py_func)
    monkeypatch.setattr(kernel, "advance_period", kernel.advance)
    monkeypatch.setattr(plant, "run_vehicle", kernel.run_vehicle)
    settings = load_vehicle_settings("ngs", thruster=model, largest_step=0.02)
    assert_driven(settings)
    tables, sheet = settings.tables, empty_sheet(6)
    sheet[STATE, BODY : BODY + 24] = np.random.default_rng(5).uniform(0.1, 2.0, 24)
    given = (sheet, STATE, 0.1, np.ones(6), 0.97, tables.layout, tables.p, tables.e)
    row = njit(error_model="numpy")(thruster_row)
    for i in range(6):
        assert row(i, *given) == pytest.approx(thruster_row(i, *given), rel=1e-12)


def test_thrusters_of_several_classes_are_refused(ngs) -> None:
    hq, table = load_parameter_set("hq").coefficients, load_parameter_set("table").coefficients
    with pytest.raises(VehicleError, match="expected thrusters of one class; found TableCoefficients, Thruster"):
        replace(ngs, thrusters=(hq,) * 5 + (table,))


def test_a_direction_without_mass_is_refused(ngs) -> None:
    with pytest.raises(VehicleError, match=r"M = M_RB \+ M_A: expected a matrix with an inverse; found a singular one"):
        replace(ngs, coefficients=ngs.coefficients._replace(M_A=-ngs.coefficients.M_RB))


def test_numbers_that_are_none_are_refused(ngs) -> None:
    with pytest.raises(VehicleError, match="weight: expected finite numbers; found nan"):
        replace(ngs, coefficients=ngs.coefficients._replace(weight=np.nan))
    with pytest.raises(VehicleError, match="u_commanded: expected finite numbers; found nan"):
        simulate(ngs, np.full((3, 6), np.nan), 0.04)
    with pytest.raises(VehicleError, match=r"throttles: expected shape \(6,\); found \(5,\)"):
        VehiclePlant(ngs).advance(np.zeros(5), 0.04)
    with pytest.raises(VehicleError, match="attitude: expected a unit quaternion"):
        replace(ngs, initial=at_rest(6)._replace(attitude=np.array([2.0, 0, 0, 0])))
    with pytest.raises(VehicleError, match="period: expected a positive time; found 0"):
        VehiclePlant(ngs).advance(np.zeros(6), 0.0)


def test_steps_that_are_too_long_are_refused(ngs) -> None:
    with pytest.raises(VehicleError, match=r"expected at most 0.183 s, as a rotor \(k_n\) settles at 13.66 1/s"):
        replace(ngs, largest_step=0.5)


def test_a_state_that_grows_beyond_numbers_is_told_with_its_time(ngs) -> None:
    wild = ngs.coefficients._replace(D_Q=-1e6 * np.eye(6))
    with pytest.raises(VehicleError, match="state: expected finite numbers; found others after"):
        simulate(replace(ngs, coefficients=wild), np.full((100, 6), 3.0), 0.1)


@pytest.mark.parametrize("name", ["ambient_current", "tank_recirculation"])
def test_effects_of_a_tank_are_refused(name) -> None:
    with pytest.raises(ValueError, match="found one of a tank"):
        ActiveVehicleEffect(id=name, sizes={})


def test_added_mass_above_mass_moves_like_any_other() -> None:
    settings = load_vehicle_settings("bluerov2_heavy")
    c = settings.coefficients
    assert c.M_A[2, 2] > c.M_RB[2, 2]
    run = simulate(settings, np.zeros((50, 8)), 0.04, wrench=np.tile([0, 0, 5.0, 0, 0, 0], (50, 1)))
    first = (5.0 + c.weight - c.buoyancy) / (c.M_RB[2, 2] + c.M_A[2, 2])
    assert run.acceleration[0, 2] == pytest.approx(first, rel=1e-12)


def test_settings_come_from_a_set_and_its_names() -> None:
    vehicle = load_vehicle_set("ngs")
    settings = load_vehicle_settings(vehicle, thruster="hl")
    assert isinstance(settings, VehicleSettings)
    assert settings.coefficients.full_thrust[0] > 10.0
    assert quaternion_from_euler((0.0, 0.0, 0.0)) == tuple(settings.initial.attitude)
