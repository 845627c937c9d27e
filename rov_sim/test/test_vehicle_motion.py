"""What a vehicle's motion must obey: another integrator, another origin, another frame, momentum, streams."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rov_sim.vehicle.benchmark import plain_rates
from rov_sim.vehicle.effects.active import ActiveVehicleEffect, thruster_effects
from rov_sim.vehicle.plant import VehicleSettings, simulate
from rov_sim.vehicle.settings_io import load_vehicle_settings
from rov_sim.vehicle.truth import at_rest
from thruster_model.effects.stages import LIBRARY
from thruster_model.equations.attitude import quaternion_from_euler, rotated, rotated_back
from thruster_model.equations.rigid_body import rigid_body_mass, skew
from thruster_model.equations.vehicle_inflow import thruster_configuration
from thruster_model.vehicle_coefficients import vehicle_coefficients

NGS = load_vehicle_settings("ngs")
HQ = NGS.thrusters[0]
HELD = np.array([2.0, 1.8, 2.2, 1.6, -1.5, -2.0])
NU = np.array([0.4, -0.2, 0.1, 0.5, -0.3, 0.7])
I_G = np.array([[0.9, -0.1, 0.05], [-0.1, 0.8, 0.02], [0.05, 0.02, 1.4]])


def odd_body(**changes):
    """A body without any symmetry in a current, its centre of mass off the origin, drag and added mass full."""
    rng = np.random.default_rng(5)
    full = rng.normal(size=(6, 6))
    given = {
        "M_RB": rigid_body_mass(20.0, (0.05, -0.02, 0.08), I_G),
        "M_A": np.diag([8.0, 20, 30, 0.3, 0.4, 0.5]) + 0.05 * (full + full.T),
        "D_L": np.diag([10.0, 20, 30, 1, 1, 1]) + 0.5 * full,
        "D_Q": np.diag([50.0, 80, 90, 2, 2, 2]) + 0.5 * full.T,
        "weight": 20 * 9.81,
        "buoyancy": 200.0,
        "r_G": (0.05, -0.02, 0.08),
        "r_B": (0.0, 0.01, -0.05),
        "K_t": NGS.coefficients.K_t,
        "current": (0.3, -0.2, 0.1),
    }
    return vehicle_coefficients(**{**given, **changes})


def with_throttle(settings, u, start):
    thrusters = np.zeros((settings.count, 4))
    thrusters[:, 2] = u
    return replace(settings, initial=start._replace(thrusters=thrusters))


def test_another_integrator_of_the_printed_equations_goes_the_same_way() -> None:
    start = at_rest(6, angles=(0.3, -0.5, 1.0), velocity=NU)
    settings = with_throttle(VehicleSettings(coefficients=odd_body(), thrusters=(HQ,) * 6), HELD, start)
    settings.initial.thrusters[:, 1] = 0.05  # at v = 0 a stream stirs the plant alone
    run = simulate(settings, np.tile(HELD, (30, 1)), 0.1)
    x = np.concatenate((start.position, start.attitude, start.velocity, np.zeros(6), np.full(6, 0.05)))
    found = solve_ivp(
        lambda _, y: plain_rates(y, HELD, settings), (0.0, 3.0), x, method="DOP853", rtol=1e-9, atol=1e-11
    )
    np.testing.assert_allclose(run.velocity[-1], found.y[7:13, -1], atol=1e-7)
    np.testing.assert_allclose(run.position[-1], found.y[:3, -1], atol=1e-7)
    np.testing.assert_allclose(run.attitude[-1], found.y[3:7, -1], atol=1e-7)
    np.testing.assert_allclose(run.axial[-1], found.y[19:, -1], atol=1e-7)


def test_one_body_described_about_two_origins_moves_alike() -> None:
    d = np.array([0.2, -0.1, 0.3])  # the second origin, in body axes
    shift = np.block([[np.eye(3), skew(d)], [np.zeros((3, 3)), np.eye(3)]])  # nu about the first of nu about the second
    M_A = np.diag([8.0, 20, 30, 0.3, 0.4, 0.5])
    r_G, r_B = np.array([0.05, -0.02, 0.08]), np.array([0.0, 0.01, -0.05])
    places = NGS.coefficients.positions.T
    axes = NGS.coefficients.K_t[:3].T
    still = {"D_L": np.zeros(6), "D_Q": np.zeros(6), "current": (0.3, -0.2, 0.1)}
    first = odd_body(M_A=M_A, r_G=r_G, r_B=r_B, M_RB=rigid_body_mass(20.0, r_G, I_G), **still)
    second = odd_body(
        M_A=shift.T @ M_A @ shift, r_G=r_G - d, r_B=r_B - d, M_RB=rigid_body_mass(20.0, r_G - d, I_G),
        K_t=thruster_configuration(places - d, axes), **still,
    )  # fmt: skip
    runs = []
    for c, velocity, place in ((first, NU, np.zeros(3)), (second, np.linalg.solve(shift, NU), d)):
        q = quaternion_from_euler((0.3, -0.5, 1.0))
        start = at_rest(6, angles=(0.3, -0.5, 1.0), velocity=velocity, position=rotated(q, tuple(place)))
        settings = with_throttle(VehicleSettings(coefficients=c, thrusters=(HQ,) * 6), HELD, start)
        runs.append(simulate(settings, np.tile(HELD, (20, 1)), 0.1))
    np.testing.assert_allclose(runs[0].attitude, runs[1].attitude, atol=1e-9)
    seen = [p + rotated(tuple(q), tuple(d)) for p, q in zip(runs[0].position, runs[0].attitude, strict=True)]
    np.testing.assert_allclose(runs[1].position, seen, atol=1e-9)


def test_a_steady_current_is_a_frame_that_drifts() -> None:
    v_c = np.array([0.3, -0.2, 0.1])
    q = quaternion_from_euler((0.3, -0.5, 1.0))
    along = np.concatenate((rotated_back(q, tuple(v_c)), np.zeros(3)))
    runs = []
    for c, velocity in ((odd_body(current=v_c), NU), (odd_body(current=(0, 0, 0)), NU - along)):
        start = at_rest(6, angles=(0.3, -0.5, 1.0), velocity=velocity)
        settings = with_throttle(VehicleSettings(coefficients=c, thrusters=(HQ,) * 6), HELD, start)
        runs.append(simulate(settings, np.tile(HELD, (30, 1)), 0.1))
    np.testing.assert_allclose(runs[0].attitude, runs[1].attitude, atol=1e-10)
    np.testing.assert_allclose(runs[0].position, runs[1].position + np.outer(runs[0].time, v_c), atol=1e-10)
    np.testing.assert_allclose(runs[0].thrust, runs[1].thrust, atol=1e-8)


def test_free_motion_keeps_linear_and_angular_momentum() -> None:
    c = odd_body(D_L=np.zeros(6), D_Q=np.zeros(6), weight=0.0, buoyancy=0.0, current=(0, 0, 0))
    hull = VehicleSettings(
        coefficients=c._replace(thrust_scale=np.zeros(6)), thrusters=(HQ,) * 6, initial=at_rest(6, velocity=NU)
    )
    run = simulate(hull, np.zeros((100, 6)), 0.1)
    kept = []
    for p, q, nu in zip(run.position, run.attitude, run.velocity, strict=True):
        a, b = np.split(c.mass_matrix @ nu, 2)
        linear = np.array(rotated(tuple(q), tuple(a)))
        kept.append(np.concatenate((linear, np.array(rotated(tuple(q), tuple(b))) + np.cross(p, linear))))
    np.testing.assert_allclose(kept, np.tile(kept[0], (101, 1)), atol=1e-8)


def held_in_a_stream(U, u, stir=1e-3):
    """One thruster on a body that nothing moves; return its thrust [N] once all has settled."""
    c = vehicle_coefficients(
        M_RB=np.eye(6) * 1e9, M_A=np.zeros(6), D_L=np.zeros(6), D_Q=np.zeros(6), weight=0.0, buoyancy=0.0,
        r_B=np.zeros(3), K_t=[[1.0], [0], [0], [0], [0], [0]],
    )._replace(stir=stir)  # fmt: skip
    start = at_rest(1, velocity=(U, 0, 0, 0, 0, 0))
    settings = VehicleSettings(coefficients=c, thrusters=(HQ,), initial=start)
    return float(simulate(settings, np.full((100, 1), u), 0.2).thrust[-1, 0])


@pytest.mark.parametrize(("U", "thrust"), [(0.0, 15.9966), (0.2, 9.7414), (0.5, -6.5431)])
def test_a_thruster_at_three_volts_loses_thrust_as_it_advances(U, thrust) -> None:
    assert held_in_a_stream(U, 3.0) == pytest.approx(thrust, abs=5e-5)


def test_an_idle_thruster_in_a_stream_drags_whatever_stirs_it() -> None:
    found = [held_in_a_stream(0.5, 0.0, stir) for stir in (1e-5, 1e-4, 1e-3, 5e-3)]
    assert found[0] == pytest.approx(-7.0, abs=1.0)
    np.testing.assert_allclose(found, found[0], rtol=1e-6)
    assert held_in_a_stream(-0.5, 0.0) == pytest.approx(-found[0], rel=1e-6)
    assert held_in_a_stream(0.01, 0.0) == 0.0  # too slow a stream: v = 0 is stable


ON_A_VEHICLE = [
    name
    for name, effect in LIBRARY.items()
    if effect.block in ("command", "rotor", "thrust", "flow")
    and name not in ("ambient_current", "tank_recirculation", "supply_sag")
]
TIMES = 0.04 * np.arange(75)
PROGRAMME = np.outer(3.0 * np.sin(4.0 * TIMES) + 0.1, np.ones(6))


def of_one_thruster(name, share):
    sizes = {}
    for d in LIBRARY[name].parameters[:1]:
        end = d.upper if np.isfinite(d.upper) else d.lower
        sizes[d.name] = d.neutral if share == 0.0 else (d.lower + share * (end - d.lower))
    values = thruster_effects([ActiveVehicleEffect(id=name, sizes=sizes, thruster=2)], 6)
    return simulate(replace(NGS, effects=values), PROGRAMME, 0.04, gates=np.zeros((75, 6)))


@pytest.mark.parametrize("name", ON_A_VEHICLE)
def test_every_effect_of_a_thruster_acts_on_the_one_that_has_it(name) -> None:
    plain = of_one_thruster("thrust_loss", 0.0)
    changed = of_one_thruster(name, {"thruster_polarity": 1.0, "throttle_saturation": 0.1}.get(name, 0.9))
    told = [np.max(np.abs(getattr(changed, k) - getattr(plain, k)), axis=0) for k in ("n", "thrust", "torque", "axial")]
    assert max(row[2] for row in told) > 1e-3
    others = [0, 1, 3, 4, 5]
    early = np.max(np.abs(changed.n[:3] - plain.n[:3])[:, others])
    assert early < 1e-3


def test_a_delayed_command_comes_as_much_later() -> None:
    u = np.zeros((50, 6))
    u[5:] = 2.0
    late = thruster_effects([ActiveVehicleEffect(id="command_delay", sizes={"time": 0.12}, thruster=0)], 6)
    run = simulate(replace(NGS, effects=late), u, 0.04)
    np.testing.assert_allclose(run.u[8:, 0], run.u[5:-3, 1], atol=1e-12)


@pytest.mark.parametrize(
    ("volts", "drag", "surge"), [(3.0, 1, 0.290), (5.0, 1, 0.556), (3.0, 0, 0.523), (5.0, 0, 0.956)]
)
def test_surge_ends_where_the_own_stream_takes_the_thrust(volts: float, drag: int, surge: float) -> None:
    c = NGS.coefficients
    surge_alone = np.diag([0.0, 1e4, 1e4, 1e3, 1e3, 1e3])  # the others are held
    keep = np.diag([float(drag), 1, 1, 1, 1, 1])
    held = c._replace(D_L=keep @ np.asarray(c.D_L) + surge_alone, D_Q=keep @ np.asarray(c.D_Q))
    run = simulate(replace(NGS, coefficients=held), np.tile([volts] * 4 + [0.0, 0.0], (300, 1)), 0.1)
    assert run.velocity[-1, 0] == pytest.approx(surge, abs=1.5e-3)


@pytest.mark.parametrize(("X", "over"), [(15.0, False), (20.0, True)])
def test_the_heavy_pitches_over_where_its_forward_thrusters_push_harder_than_it_rights_itself(X, over) -> None:
    """T1 to T4 push 85 mm below the origin against a moment of 1.31 N m: 15.5 N at rest, 18 N under way."""
    heavy = load_vehicle_settings("bluerov2_heavy", largest_step=0.01)
    slowly = X * np.clip(np.arange(600) / 200.0, 0.0, 1.0)
    wrench = np.zeros((600, 6))
    wrench[:, 0], wrench[:, 4] = slowly, 0.085 * slowly
    q = simulate(heavy, np.zeros((600, 8)), 0.1, wrench=wrench).attitude
    upright = 1.0 - 2.0 * (q[:, 1] ** 2 + q[:, 2] ** 2)  # cosine of the tilt
    assert (np.min(upright) < np.cos(np.deg2rad(120.0))) == over
    assert over or np.min(upright) > np.cos(np.deg2rad(70.0))
