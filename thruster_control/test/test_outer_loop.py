"""The outer loops: (2.22) against values of others and an integration of its own, its baselines, failing inputs."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from thruster_control.outer_loop.laws import quaternion_error
from thruster_control.outer_loop.linear import linear_law
from thruster_control.outer_loop.settings import (
    OuterMemory,
    VehicleSetPoint,
    euler_law,
    outer_memory,
    pid_law,
    quaternion_law,
)
from thruster_control.outer_loop.step import OuterStatus, note_achieved, outer_loop_step

Array = NDArray[np.float64]
GAINS = ([1.0, 1, 1, 2, 2, 2], 2.0)
NAN3 = (math.nan, 0.0, 0.0)


# Compiled for a type of this file, and not kept: another process that finds it in the cache could not read that type.
compiled_outer_loop = numba.njit(error_model="numpy")(outer_loop_step)


class Vehicle(NamedTuple):
    M_RB: Array
    M_A: Array
    D_L: Array
    D_Q: Array
    weight: float
    buoyancy: float
    r_G: Array
    r_B: Array
    current: Array


def hull(**changed: Any) -> Vehicle:
    """Return the hull assumed for the six-thruster vehicle: 30 kg, 30.2 litres."""
    return Vehicle(
        M_RB=np.diag([30.0, 30, 30, 0.98, 0.87, 1.40]),
        M_A=np.diag([14.1, 15.8, 41.5, 0.715, 0.511, 0.840]),
        D_L=np.diag([23.0, 20, 56, 0.8, 2.3, 0.8]),
        D_Q=np.diag([240.0, 370, 324, 4.5, 1.8, 5.7]),
        weight=30.0 * 9.81,
        buoyancy=1000.0 * 9.81 * 0.0302,
        r_G=np.zeros(3),
        r_B=np.array([0.0, 0.0, -0.01]),
        current=np.zeros(3),
    )._replace(**changed)


def S(a: ArrayLike) -> Array:
    x, y, z = np.asarray(a)
    return np.array([[0.0, -z, y], [z, 0, -x], [-y, x, 0]])


def lopsided() -> Vehicle:
    """Return a hull with its mass off centre and coupled added mass and drag."""
    r, m, rng = np.array([0.02, -0.01, 0.03]), 30.0, np.random.default_rng(8)
    I_0 = np.diag([0.98, 0.87, 1.40]) - m * S(r) @ S(r)
    M_RB = np.block([[m * np.eye(3), -m * S(r)], [m * S(r), I_0]])
    coupling = 0.3 * rng.normal(size=(6, 6))
    return hull(r_G=r, M_RB=M_RB, M_A=hull().M_A + 0.5 * (coupling + coupling.T), D_L=hull().D_L + 0.1 * coupling**2)


def terms(c: Vehicle, R: Array, nu: Array) -> Array:
    """Return what (2.22) cancels, in the current, written with the matrices of (2.12), (2.13), (2.18) as printed."""
    w, m, v_c = nu[3:], c.M_RB[0, 0], R.T @ c.current
    through = nu - np.r_[v_c, np.zeros(3)]
    v = through[:3]
    C_RB = np.block(
        [[m * S(w), -m * S(w) @ S(c.r_G)], [m * S(c.r_G) @ S(w), -S(c.M_RB[3:, 3:] @ w)]],
    )
    a, b = c.M_A[:3, :3] @ v + c.M_A[:3, 3:] @ w, c.M_A[3:, :3] @ v + c.M_A[3:, 3:] @ w
    C_A = np.block([[np.zeros((3, 3)), -S(a)], [-S(a), -S(b)]])
    f_G, f_B = R.T @ [0, 0, c.weight], R.T @ [0, 0, -c.buoyancy]
    g = -np.r_[f_G + f_B, np.cross(c.r_G, f_G) + np.cross(c.r_B, f_B)]
    carried = c.M_A @ np.r_[np.cross(w, v_c), np.zeros(3)]  # the current turns as seen from the body
    drag = c.D_L @ through + c.D_Q @ (np.abs(through) * through)
    return np.asarray(C_RB @ nu + C_A @ through + carried + drag + g)


def attitude(euler: ArrayLike) -> Array:
    """Return the quaternion (w, x, y, z) of roll, pitch, yaw [rad]."""
    x, y, z, w = Rotation.from_euler("ZYX", np.asarray(euler)[::-1]).as_quat()
    return np.array([w, x, y, z])


def asked(
    law: Any,
    q: ArrayLike,
    nu: ArrayLike,
    sp: VehicleSetPoint,
    c: Vehicle | None = None,
    *,
    dt: float = 0.04,
    memory: OuterMemory | None = None,
    step: Callable[..., int] = outer_loop_step,
) -> tuple[Array, int]:
    wrench = np.full(6, np.nan)
    memory = outer_memory() if memory is None else memory
    given = np.asarray(q, dtype=np.float64), np.asarray(nu, dtype=np.float64)
    return wrench, step(memory, *given, sp, dt, law, hull() if c is None else c, wrench)


SP = VehicleSetPoint((0.0, 0.1, 0.5), (0.05, -0.1, 0.2), (0.01, 0.02, -0.03), (0.3, 0.0, 0.0), (0.05, 0.0, 0.0))
NU = np.array([0.2, -0.1, 0.05, 0.1, -0.05, 0.2])
ETA = np.array([0.1, -0.2, 0.3])


def moving(t: float, pitch: float = 0.5) -> VehicleSetPoint:
    """Return a set point that moves in all six degrees of freedom."""
    a, w = np.array([0.4, pitch, 0.8]), np.array([0.7, 0.5, 0.3])
    b, f = np.array([0.2, -0.1, 0.15]), np.array([0.6, 0.9, 0.4])
    return VehicleSetPoint(
        tuple(a * np.sin(w * t)), tuple(a * w * np.cos(w * t)), tuple(-a * w * w * np.sin(w * t)),
        tuple(b * np.sin(f * t)), tuple(b * f * np.cos(f * t)),
    )  # fmt: skip


# ---- (2.22)


def test_the_thrusts_of_2_22_are_those_worked_out_by_others(ngs: Array) -> None:
    expected = [8.817924866, 5.7592052358, 6.7014129705, 7.9775092305, -9.9946469163, -6.6279172923]
    for step in (outer_loop_step, compiled_outer_loop):
        wrench, status = asked(euler_law(*GAINS), attitude(ETA), NU, SP, step=step)
        assert np.linalg.solve(ngs, wrench) == pytest.approx(expected, abs=5e-10)
        assert status == OuterStatus.FOLLOWING


@pytest.mark.parametrize("form", ["euler", "quaternion"])
@pytest.mark.parametrize(
    "vehicle",
    [hull(), lopsided()._replace(current=np.array([0.2, -0.3, 0.1]))],
    ids=["hull", "lopsided in a current that it knows"],
)
def test_with_ideal_thrust_the_energy_of_the_errors_falls_as_the_proof_says(form: str, vehicle: Vehicle) -> None:
    k_I, K_P = 2.0, np.diag([1.0, 1, 1, 2, 2, 2]) + 0.2
    law = euler_law(K_P, k_I) if form == "euler" else quaternion_law(K_P, k_I)
    M, memory = vehicle.M_RB + vehicle.M_A, outer_memory()

    def errors(t: float, R: Array, nu: Array) -> tuple[Array, float]:
        """Return (Dnu, potential) by Euler angles or by rotation matrices, from their definitions."""
        sp = moving(t)
        phi, theta, psi = Rotation.from_matrix(R).as_euler("ZYX")[::-1]
        R_d = Rotation.from_euler("ZYX", sp.attitude[::-1]).as_matrix()
        if form == "euler":
            deta = np.mod(np.array([phi, theta, psi]) - sp.attitude + np.pi, 2 * np.pi) - np.pi
            return nu - np.r_[sp.velocity, rates(phi, theta) @ sp.attitude_rate], 0.5 * k_I * float(deta @ deta)
        nu_2d = R.T @ R_d @ rates(sp.attitude[0], sp.attitude[1]) @ sp.attitude_rate
        half = 0.5 * Rotation.from_matrix(R_d.T @ R).magnitude()
        return nu - np.r_[sp.velocity, nu_2d], 4.0 * k_I * (1.0 - math.cos(half))

    def rates(phi: float, theta: float) -> Array:
        s, c = math.sin(phi), math.cos(phi)
        return np.array([[1, 0, -math.sin(theta)], [0, c, s * math.cos(theta)], [0, -s, c * math.cos(theta)]])

    def slope(t: float, x: Array) -> Array:
        R, nu = x[:9].reshape(3, 3), x[9:15]
        x_, y_, z_, w_ = Rotation.from_matrix(R).as_quat()
        tau, _ = asked(law, [w_, x_, y_, z_], nu, moving(t), vehicle, memory=memory)
        dnu, _ = errors(t, R, nu)
        return np.r_[(R @ S(nu[3:])).ravel(), np.linalg.solve(M, tau - terms(vehicle, R, nu)), dnu @ K_P @ dnu]

    begin = np.r_[Rotation.from_euler("ZYX", [2.5, -0.6, 0.9]).as_matrix().ravel(), 0.3, -0.2, 0.1, 0.4, -0.3, 0.5, 0]
    found = solve_ivp(slope, (0.0, 8.0), begin, rtol=1e-10, atol=1e-12, t_eval=np.linspace(0.0, 8.0, 17))
    energies = []
    for t, x in zip(found.t, found.y.T, strict=True):
        dnu, potential = errors(t, x[:9].reshape(3, 3), x[9:15])
        energies.append(0.5 * float(dnu @ dnu) + potential)
    assert np.array(energies) + found.y[15] == pytest.approx(energies[0], abs=1e-6)
    assert energies[-1] < 1e-3 * energies[0]


def test_both_forms_agree_to_first_order_in_the_errors() -> None:
    for size in (1e-3, 1e-4):
        eta = np.array(SP.attitude) + size * np.array([1.0, -2.0, 1.5])
        at = Rotation.from_euler("ZYX", SP.attitude[::-1]).as_matrix()
        phi, theta = SP.attitude[:2]
        s, c = math.sin(phi), math.cos(phi)
        J_inv = np.array([[1, 0, -math.sin(theta)], [0, c, s * math.cos(theta)], [0, -s, c * math.cos(theta)]])
        nu = np.r_[SP.velocity, J_inv @ SP.attitude_rate]
        assert at.shape == (3, 3)
        both = [asked(law, attitude(eta), nu, SP)[0] for law in (euler_law(1.0, 2.0), quaternion_law(1.0, 2.0))]
        scale = np.abs(both[0] - asked(euler_law(1.0, 2.0), attitude(SP.attitude), nu, SP)[0]).max()
        assert np.abs(both[0] - both[1]).max() < 0.2 * scale


def test_a_quaternion_and_its_negative_are_the_same_attitude() -> None:
    q, law = attitude([2.0, 0.4, -2.5]), quaternion_law(*GAINS)
    assert asked(law, q, NU, SP)[0] == pytest.approx(asked(law, -q, NU, SP)[0], abs=1e-12)
    assert asked(law, 3.0 * q, NU, SP)[0] == pytest.approx(asked(law, q, NU, SP)[0], abs=1e-12)


def test_neither_signs_nor_noise_at_half_a_turn_make_the_way_round_chatter() -> None:
    law, memory, rng = quaternion_law(*GAINS), outer_memory(), np.random.default_rng(1)
    sp, wrenches = VehicleSetPoint(), []
    for _ in range(200):
        q = rng.choice([-1.0, 1.0]) * attitude([0, 0, math.pi + 0.05 * rng.normal()])
        wrenches.append(asked(law, q, np.zeros(6), sp, memory=memory)[0])
    assert len({math.copysign(1.0, each[5]) for each in wrenches}) == 1
    way = math.copysign(1.0, wrenches[0][5])
    for past, expected in ((0.19, way), (0.25, -way)):  # cos of half the angle: -0.095, -0.125
        turned = attitude([0, 0, -way * (math.pi + past)])
        assert math.copysign(1.0, asked(law, turned, np.zeros(6), sp, memory=memory)[0][5]) == expected


@pytest.mark.parametrize("pitch_deg", [80.0, 89.999, 90.0, -90.0, 120.0])
def test_straight_up_is_an_attitude_like_any_other_for_the_quaternion(pitch_deg: float) -> None:
    law, pitch = quaternion_law(*GAINS), math.radians(pitch_deg)
    sp = VehicleSetPoint((0.0, pitch, 0.0))
    at = asked(law, attitude([0.0, pitch, 0.0]), np.zeros(6), sp)[0]
    R = Rotation.from_euler("ZYX", [0.0, pitch, 0.0]).as_matrix()
    assert at == pytest.approx(terms(hull(), R, np.zeros(6)), abs=1e-9), "where it shall be: only weight is carried"
    off = asked(law, attitude([0.0, pitch - 0.01, 0.0]), np.zeros(6), sp)[0]
    weightless = hull(r_B=np.zeros(3))
    level = asked(law, attitude([0, -0.01, 0]), np.zeros(6), VehicleSetPoint(), weightless)[0]
    free = asked(law, attitude([0.0, pitch - 0.01, 0.0]), np.zeros(6), sp, weightless)[0]
    assert free[4] == pytest.approx(level[4], rel=1e-6)
    assert np.all(np.isfinite(off))


def test_a_vehicle_turns_over_the_top_and_round_from_any_attitude() -> None:
    vehicle, law = hull(), quaternion_law(1.5, 1.0)
    M = vehicle.M_RB + vehicle.M_A
    sp = VehicleSetPoint((0.0, math.pi / 2, 0.0))
    rng = np.random.default_rng(11)
    for case in range(4):
        begin = Rotation.random(rng=rng).as_matrix() if case else Rotation.from_euler("ZYX", [3.1, 1.2, -3]).as_matrix()
        memory = outer_memory()

        def slope(t: float, x: Array, memory: OuterMemory = memory) -> Array:
            R, nu = x[:9].reshape(3, 3), x[9:]
            x_, y_, z_, w_ = Rotation.from_matrix(R).as_quat()
            tau, _ = asked(law, [w_, x_, y_, z_], nu, sp, vehicle, memory=memory, step=compiled_outer_loop)
            return np.r_[(R @ S(nu[3:])).ravel(), np.linalg.solve(M, tau - terms(vehicle, R, nu))]

        end = solve_ivp(slope, (0.0, 25.0), np.r_[begin.ravel(), np.zeros(6)], rtol=1e-6, atol=1e-8).y[:, -1]
        wanted = Rotation.from_euler("ZYX", [0.0, math.pi / 2, 0.0]).as_matrix()
        assert Rotation.from_matrix(wanted.T @ end[:9].reshape(3, 3)).magnitude() < 1e-3


def test_the_euler_form_says_where_it_ends_and_stays_finite_there() -> None:
    law = euler_law(*GAINS)
    for pitch_deg, status in ((79.0, OuterStatus.FOLLOWING), (81.0, OuterStatus.BEYOND), (90.0, OuterStatus.BEYOND)):
        wrench, found = asked(law, attitude(np.radians([5.0, pitch_deg, 0.0])), NU, SP)
        assert found == status
        assert np.all(np.abs(wrench) < 500.0)


def test_yaw_errors_are_taken_the_short_way_round() -> None:
    sp = VehicleSetPoint((0.0, 0.0, math.radians(175.0)))
    for law in (euler_law(*GAINS), quaternion_law(*GAINS), linear_law(hull(), *GAINS), pid_law(1.0, 0.0, 1.0, 99.0)):
        wrench, _ = asked(law, attitude([0, 0, math.radians(-175.0)]), np.zeros(6), sp)
        assert wrench[5] < 0.0, type(law).__name__


def test_the_error_of_attitude_is_the_body_as_seen_from_where_it_shall_be() -> None:
    q = attitude([0.3, -0.4, 1.0])
    R_d = Rotation.from_euler("ZYX", SP.attitude[::-1])
    w, x, y, z = quaternion_error(q, SP)
    expected = R_d.inv() * Rotation.from_quat([q[1], q[2], q[3], q[0]])
    assert Rotation.from_quat([x, y, z, w]).as_matrix() == pytest.approx(expected.as_matrix(), abs=1e-12)


# ---- baselines


def test_the_linear_law_is_the_slope_of_the_euler_form_at_rest() -> None:
    vehicle = lopsided()
    exact, linear = euler_law(*GAINS), linear_law(vehicle, *GAINS)
    rest = VehicleSetPoint()
    level = asked(exact, attitude([0, 0, 0]), np.zeros(6), rest, vehicle)[0]
    assert asked(linear, attitude([0, 0, 0]), np.zeros(6), rest, vehicle)[0] == pytest.approx(level, abs=1e-12)
    rng, h = np.random.default_rng(12), 1e-6
    for _ in range(5):
        d_eta, d_nu, d = rng.normal(size=3), rng.normal(size=6), rng.normal(size=(5, 3))
        sp = VehicleSetPoint(*(tuple(h * row) for row in d))
        found = [(asked(law, attitude(h * d_eta), h * d_nu, sp, vehicle)[0] - level) / h for law in (exact, linear)]
        assert found[0] == pytest.approx(found[1], abs=2e-2 * np.abs(found[1]).max(), rel=1e-3)


def test_a_pid_takes_out_a_constant_error_and_does_not_wind_up() -> None:
    law = pid_law(10.0, 4.0, 3.0, 20.0)
    memory = outer_memory()
    sp = VehicleSetPoint(velocity=(1.0, 0.0, 0.0))
    for _ in range(10):
        wrench, _ = asked(law, [1, 0, 0, 0], np.zeros(6), sp, memory=memory, dt=0.1)
    assert memory.integral[0] == pytest.approx(1.0)
    assert wrench[0] == pytest.approx(10.0 + 4.0 * 0.9)
    for _ in range(100):
        wrench, _ = asked(law, [1, 0, 0, 0], np.zeros(6), sp, memory=memory, dt=0.1)
    assert wrench[0] == 20.0
    assert memory.integral[0] <= 2.6, "at its largest wrench it collects no more"
    before = memory.integral[0]
    note_achieved(memory, np.array([20.0, 0, 0, 0, 0, 0]), np.array([5.0, 0, 0, 0, 0, 0]))
    law = law._replace(largest=np.full(6, 100.0))
    asked(law, [1, 0, 0, 0], np.zeros(6), sp, memory=memory, dt=0.1)
    assert memory.integral[0] == before, "nor where the thrusters fall short"
    asked(law, [1, 0, 0, 0], np.array([2.0, 0, 0, 0, 0, 0]), sp, memory=memory, dt=0.1)
    assert memory.integral[0] == pytest.approx(before - 0.1), "but it empties at once"
    asked(law, [1, 0, 0, 0], np.zeros(6), sp, memory=memory, dt=60.0)
    assert memory.integral[0] == pytest.approx(before - 0.1), "over a gap nothing is integrated"


# ---- inputs that fail


@pytest.mark.parametrize(
    "law", [quaternion_law(*GAINS), euler_law(*GAINS), pid_law(1.0, 1.0, 1.0, 9.0)], ids=["quaternion", "euler", "pid"]
)
@pytest.mark.parametrize(
    ("changed", "status"),
    [
        ({"dt": 0.0}, OuterStatus.BAD_PERIOD),
        ({"dt": math.nan}, OuterStatus.BAD_PERIOD),
        ({"dt": math.inf}, OuterStatus.BAD_PERIOD),
        ({"sp": SP._replace(attitude=NAN3)}, OuterStatus.NO_SET_POINT),
        ({"sp": SP._replace(attitude_acceleration=NAN3)}, OuterStatus.NO_SET_POINT),
        ({"sp": SP._replace(velocity=(0.0, math.inf, 0.0))}, OuterStatus.NO_SET_POINT),
        ({"q": [math.nan, 0, 0, 0]}, OuterStatus.NO_STATE),
        ({"q": [0, 0, 0, 0]}, OuterStatus.NO_STATE),
        ({"nu": [0, 0, 0, math.nan, 0, 0]}, OuterStatus.NO_STATE),
    ],
    ids=str,
)
def test_inputs_that_fail_end_in_no_wrench_and_an_empty_memory(
    law: Any, changed: dict[str, Any], status: OuterStatus
) -> None:
    memory = outer_memory()
    asked(law, attitude(ETA), NU, SP, memory=memory)
    given = {"q": attitude(ETA), "nu": NU, "sp": SP, **changed}
    wrench, found = asked(law, memory=memory, **given)
    assert found == status
    assert np.array_equal(wrench, np.zeros(6))
    assert not memory.integral.any() and not memory.error.any()


def test_without_linear_velocity_attitude_is_held_all_the_same() -> None:
    law = quaternion_law(*GAINS)
    blind = np.r_[math.nan, NU[1], math.nan, NU[3:]]
    wrench, status = asked(law, attitude(ETA), blind, SP)
    assert status == OuterStatus.ATTITUDE_ONLY
    as_wanted = np.r_[SP.velocity[0], NU[1], SP.velocity[2], NU[3:]]
    assert wrench == pytest.approx(asked(law, attitude(ETA), as_wanted, SP)[0])


def test_a_kernel_and_plain_python_ask_for_the_same() -> None:
    laws = (quaternion_law(*GAINS), euler_law(*GAINS), linear_law(lopsided(), *GAINS), pid_law(10.0, 2.0, 3.0, 40.0))
    rng = np.random.default_rng(13)
    for law in laws:
        memories = outer_memory(), outer_memory()
        for _ in range(5):
            q, nu = rng.normal(size=4), rng.normal(size=6)
            one, other = (
                asked(law, q, nu, SP, lopsided(), memory=memory, step=step)
                for memory, step in zip(memories, (outer_loop_step, compiled_outer_loop), strict=True)
            )
            assert one[0] == pytest.approx(other[0], rel=1e-12, abs=1e-9)
            assert one[1] == other[1]


@pytest.mark.parametrize(
    ("build", "sentence"),
    [
        (lambda: quaternion_law(-1.0, 1.0), "K_P: expected a symmetric positive definite matrix"),
        (lambda: quaternion_law(np.triu(np.ones((6, 6))), 1.0), "K_P: expected a symmetric positive definite"),
        (lambda: quaternion_law(1.0, math.nan), "k_I: expected a finite number, 0 or more; found nan"),
        (lambda: quaternion_law(1.0, 1.0, hysteresis=1.0), "hysteresis: expected a number from 0 to below 1"),
        (lambda: euler_law(1.0, 1.0, steepest_deg=90.0), "steepest_deg: expected an angle above 0 and below 90"),
        (lambda: pid_law([1.0, 2.0], 1.0, 1.0, 1.0), "proportional: expected 6 numbers"),
        (lambda: pid_law(1.0, -1.0, 1.0, 1.0), "integral: expected finite numbers, 0 or more"),
    ],
)
def test_wrong_settings_are_refused_in_a_sentence(build: Callable[[], Any], sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        build()
