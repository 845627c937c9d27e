"""A sealed case as recordings: its world driven through runs, read by sensors, written as a logger does."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.truth import Truth, biased, installed, levelled, metered, rested, truth_of, unnamed
from gap_diagnosis.vehicle.blind.world import COLUMNS, STEP, run_world
from rov_sim.vehicle.sensors.settings import VehicleSensors
from run_bag import Topic
from run_bag.known_topics import KNOWN_VEHICLE
from thruster_model.parameter_set import ParameterSet
from thruster_model.vehicle_set import VehicleSet

__all__ = ["LATE", "recorded", "recorded_run"]

Array = NDArray[np.float64]
NANO, RPM = 1_000_000_000, np.pi / 30.0
LATE = 20.0
"""[s] after which what fails in mid-run fails."""


def recorded(
    draw: Draw, vehicle: VehicleSet, sets: tuple[ParameterSet, ...], sensors: VehicleSensors
) -> list[list[Topic]]:
    """Return the topics of each run of a case."""
    truth = truth_of(draw, vehicle, sets)
    return [recorded_run(draw, _in_run(k, draw, truth), vehicle, sensors, k, kind) for k, kind in enumerate(draw.kinds)]


def _in_run(k: int, draw: Draw, truth: Truth) -> Truth:
    """Return the world of a run: without what has not begun yet or is over."""
    if draw.begins is None:
        return truth
    (first, time, last), table = draw.begins, truth.thrusters.copy()
    if first <= k <= last:
        table[:, COLUMNS.index("since")] = time if k == first else 0.0
    else:
        table[:, COLUMNS.index("share")] = 1.0
    return truth._replace(thrusters=table)


def _wander(rng: np.random.Generator, K: int, size: float, periods: float) -> Array:
    keep = np.exp(-1.0 / periods)
    z = rng.normal(size=K) * size
    out = np.empty(K)
    now = z[0]
    for k in range(K):
        now = keep * now + np.sqrt(1.0 - keep**2) * z[k] if k else z[0]
        out[k] = now
    return out


def _programme(
    rng: np.random.Generator, kind: str, t: Array, K_t: Array, level: float
) -> tuple[Array, Array]:  # fmt: skip
    """Return commands (K, N) [V] beyond the dead zone and set points (K, 4) of roll, pitch, yaw, depth.

    t: instants of commands (K,) [s]; kind: hold (station keeping), sines, steps or pulses.
    """
    K, N = len(t), K_t.shape[1]
    share = np.linalg.pinv(K_t)[:, [0, 1, 2, 5]]
    share /= np.abs(share).max(axis=0)
    wanted, push = np.zeros((K, 4)), np.zeros((K, 4))
    wanted[:, 3] = 3.0
    commands = np.zeros((K, N))
    hold = max(int(rng.uniform(1.5, 4.0) / t[1]), 1)
    blocks = np.arange(K) // hold
    if kind == "hold":
        pass  # station keeping: feedback alone
    elif kind == "sines":
        for j in range(4):
            for _ in range(3):
                push[:, j] += 0.6 * np.sin(2 * np.pi * rng.uniform(0.03, 0.4) * t + rng.uniform(0, 6.3))
        wanted[:, 2] = 0.8 * np.sin(2 * np.pi * 0.05 * t)
        dither = np.array([np.sin(2 * np.pi * rng.uniform(0.1, 0.8) * t + rng.uniform(0, 6.3)) for _ in range(N)]).T
        commands = 0.5 * level * dither
    elif kind == "steps":
        draws = rng.uniform(-1.0, 1.0, (blocks[-1] + 1, 4))
        push = draws[blocks]
        wanted[:, 2] = (rng.uniform(-1.5, 1.5, blocks[-1] + 1))[blocks]
        wanted[:, 0] = (rng.uniform(-0.3, 0.3, blocks[-1] + 1))[blocks]
        wanted[:, 3] = 3.0 + (rng.uniform(-0.5, 0.5, blocks[-1] + 1))[blocks]
        commands = 0.3 * level * (rng.uniform(-1.0, 1.0, (blocks[-1] + 1, N)))[blocks]
    else:
        each = max(K // (2 * N), 2)
        for i in range(N):
            for half, sign in enumerate((1.0, -1.0)):
                first = (2 * i + half) * each
                commands[first : first + int(0.6 * each), i] = sign * level
    return commands + level * push @ share.T, wanted


def recorded_run(
    draw: Draw, truth: Truth, vehicle: VehicleSet, sensors: VehicleSensors, run: int, kind: str
) -> list[Topic]:  # fmt: skip
    """Return the topics of one run of a world; its number draws programme and noises."""
    rng = np.random.default_rng(np.random.SeedSequence(draw.seed, spawn_key=(79, run)))
    K, N = int(draw.duration / draw.period), len(truth.thrusters)
    steps, t = round(draw.period / STEP), np.arange(K, dtype=np.float64) * draw.period
    K_t = vehicle.configuration
    commands, wanted = _programme(rng, kind, t, K_t, float(rng.uniform(1.0, 2.2)))
    size = np.array([draw.wrench] * 3 + [0.2 * draw.wrench] * 3)
    wrench = np.column_stack([_wander(rng, K, s, draw.time / draw.period) for s in size])
    gains = _feedback(vehicle, K_t, quiet=kind == "pulses")
    noise = rng.normal(size=(K, 12)) * np.array([0.004] * 3 + [0.003] * 3 + [0.006, 0.01] + [0.0] * 4)
    _outside(draw, wrench, truth, t, rng)
    sent, out = np.zeros((K, N)), np.zeros((K * steps, 18))
    out_n, supply = np.zeros((K * steps, N)), np.zeros((K * steps, 2))
    done = run_world(
        commands, steps, truth.thrusters, truth.M, truth.D_L, truth.D_Q, truth.weight, truth.buoyancy, truth.r_G,
        truth.r_B, truth.current, truth.tether, truth.ram, truth.interaction, truth.sag, truth.wiring, truth.sign,
        truth.sliding, wrench, np.array([0.0, 0.0, 3.0]), np.eye(3), gains, wanted, noise, rested(draw, run), out,
        out_n, sent, supply,
    )  # fmt: skip
    if done < K:
        raise ArithmeticError(f"case {draw.seed}: the world diverged in run {run}")
    return _topics(draw, truth, sensors, run, rng, sent, out, out_n, supply)


def _outside(draw: Draw, wrench: Array, truth: Truth, t: Array, rng: np.random.Generator) -> None:
    """Change the wrench (K, 6) by something that the library does not have and that does not depend on the motion."""
    kind = draw.outside
    if kind == "leak":
        wrench[:, 2] += 4.0 * t / t[-1]
        wrench[:, 4] += 0.4 * t / t[-1]
    elif kind == "breathing_thrust":
        wrench[:, 0] += 4.0 * np.sign(np.sin(2 * np.pi * t / rng.uniform(4.0, 8.0)))
        wrench[:, 5] += 0.5 * np.sign(np.sin(2 * np.pi * t / rng.uniform(4.0, 8.0)))
    elif kind == "moving_arm":  # to and fro about every ten seconds, a second each way
        wrench[:, 4] += unnamed(draw).arm * np.clip(4.0 * np.sin(2 * np.pi * t / rng.uniform(8.0, 14.0)), -1.0, 1.0)
    elif kind == "lost_foam":
        wrench[t >= LATE, 2] += 5.0
    elif kind == "lift":
        truth.D_Q[2, 0] += 40.0 * rng.choice((-1.0, 1.0))
        truth.D_Q[4, 0] += 8.0 * rng.choice((-1.0, 1.0))


def _feedback(vehicle: VehicleSet, K_t: Array, *, quiet: bool) -> Array:
    """Return gains (N, 12) [V per rad, rad/s, m, m/s] that hold attitude and depth; weak ones while thrusters pulse."""
    share = np.linalg.pinv(K_t)
    c = vehicle.coefficients.mass_matrix.diagonal()
    wrench = np.zeros((6, 12))
    for axis in range(3):
        wrench[3 + axis, axis], wrench[3 + axis, 3 + axis] = 4.0 * c[3 + axis], 3.0 * c[3 + axis]
    wrench[2, 6], wrench[2, 7] = 0.8 * c[2], 1.0 * c[2]
    return (0.0 if quiet else 0.12) * share @ wrench


def _topics(
    draw: Draw, truth: Truth, s: VehicleSensors, run: int, rng: np.random.Generator, sent: Array, out: Array,
    n: Array, supply: Array,
) -> list[Topic]:  # fmt: skip
    """Return what a logger writes: each sensor at its rate, off by its noise and by what is wrong with it."""
    K, N = sent.shape
    wrong: dict[str, Any] = truth.sensors
    off, factor = installed(draw), draw.noise
    t0 = NANO

    def stamps(at: NDArray[Any], late: float = 0.0) -> NDArray[np.int64]:
        return t0 + np.round((at * STEP + late) * 1e9).astype(np.int64)

    unsent, at_command = np.full(K, np.nan), draw.period * np.arange(K)
    topics = [Topic.of_thruster(i, "throttle", at_command, {"commanded": sent[:, i], "sent": unsent}) for i in range(N)]

    def reading(sensor: str) -> NDArray[np.int64]:
        """Return the instants, in steps, at which a sensor reads."""
        every = round(draw.every[sensor] / STEP)
        return np.arange(1 + rng.integers(every), len(out) - 2, every)

    at = told_at = reading("imu")
    if "imu_delay" in wrong:
        at = np.maximum(told_at - round(wrong["imu_delay"][1] / STEP), 1)
    R = out[:, 3:12].reshape(-1, 3, 3)
    v, w = out[:, 12:15], out[:, 15:18]
    R_s = Rotation.from_rotvec(off.imu_turn).as_matrix()
    if "imu_misalignment" in wrong:
        R_s = R_s @ _axis_turn(*wrong["imu_misalignment"])
    r = np.asarray(s.imu.position) + off.imu_place
    moving = np.einsum("kij,kj->ki", R, v + np.cross(w, r))
    acceleration = (moving[at + 1] - moving[at - 1]) / (2.0 * STEP)
    force = np.einsum("kji,kj->ki", R[at], acceleration - np.array([0.0, 0.0, 9.81])) @ R_s
    bias = [rng.normal(size=3) * deviation for deviation in biased(draw)]
    rate = w[at] @ R_s * (1.0 + off.gyro_scale)
    if "gyro_scale" in wrong:
        rate = rate * (1.0 + wrong["gyro_scale"][1])
    if "imu_bias" in wrong:
        axis, size = wrong["imu_bias"]
        rate[:, "xyz".index(axis)] += size
    shaken = np.mean((n[at] / 100.0) ** 2, axis=1)
    force += unnamed(draw).bias * np.outer(shaken, np.array([0.6, 0.0, -0.8]))
    rate = rate + bias[0] + rng.normal(size=rate.shape) * 0.003 * factor
    force = force + bias[1] + rng.normal(size=force.shape) * 0.05 * factor
    yaw = wrong["magnetic_disturbance"][1] * supply[at, 1] if "magnetic_disturbance" in wrong else np.zeros(at.size)
    if "compass_deviation" in wrong:
        turns = np.exp(1j * np.arctan2(R[at, 1, 0], R[at, 0, 0]))
        B, C, D, E = wrong["compass_deviation"][1]
        yaw = yaw + B * turns.imag + C * turns.real + D * (turns**2).imag + E * (turns**2).real
    errors = levelled(draw, run) + rng.normal(size=(at.size, 3)) * 0.004 * factor
    q = _quaternions(R[at] @ R_s, yaw, errors)
    fields: dict[str, Any] = {f"orientation.{a}": q[:, k] for k, a in enumerate("wxyz")}
    fields |= {f"angular_velocity.{a}": rate[:, k] for k, a in enumerate("xyz")}
    fields |= {f"linear_acceleration.{a}": force[:, k] for k, a in enumerate("xyz")}
    topics.append(_vehicle("rov/imu", stamps(told_at), fields))
    at = reading("depth")
    place = np.einsum("kij,j->ki", R[at], np.asarray(s.depth.position))
    depth = (1.0 + off.depth_scale) * (out[at, 2] + place[:, 2]) + rng.normal(size=at.size) * 0.006 * factor
    topics.append(_vehicle("rov/depth", stamps(at), {"depth": depth}))
    if "velocity" not in draw.missing:
        at = reading("velocity")
        late = round(wrong["velocity_delay"][1] / STEP) if "velocity_delay" in wrong else 0
        then = np.maximum(at - late, 0)
        told = v[then] + np.cross(w[then], np.asarray(s.velocity.position) + off.velocity_place)
        told = told @ Rotation.from_rotvec(off.velocity_turn).as_matrix() * (1.0 + off.velocity_scale)
        if "velocity_misalignment" in wrong:
            told = told @ _axis_turn(*wrong["velocity_misalignment"])
        if "velocity_scale" in wrong:
            told = told * (1.0 + wrong["velocity_scale"][1])
        told = told + rng.normal(size=told.shape) * 0.008 * factor
        fields = {f"twist.twist.linear.{a}": told[:, k] for k, a in enumerate("xyz")}
        topics.append(_vehicle("rov/velocity", stamps(at, off.velocity_late), fields))
    if "tachometer" not in draw.missing:
        at = reading("tachometer")
        for i in range(N):
            told = n[at, i] + rng.normal(size=at.size) * 1.2 * factor
            told = np.round(told / RPM) * RPM if draw.whole else told
            fields = {"n": told, "sign_source": np.ones(at.size, int)}
            topics.append(Topic.of_thruster(i, "state", at * STEP + off.tachometer_late, fields))
    if "battery" not in draw.missing:
        at = reading("battery")
        volts, idle, full = metered(draw)
        voltage = volts * supply[at, 0] + rng.normal(size=at.size) * 0.02 * factor
        current = idle + full * supply[at, 1] + rng.normal(size=at.size) * 0.3 * factor
        topics.append(_vehicle("rov/battery", stamps(at), {"voltage": voltage, "current": -current}))
    return topics


def _vehicle(name: str, stamps: NDArray[np.int64], fields: dict[str, Any]) -> Topic:
    return Topic(name=name, type=KNOWN_VEHICLE[name], stamps=stamps, fields=fields, frame="base_link_frd")


def _axis_turn(axis: str, angle: float) -> Array:
    k = "xyz".index(axis)
    c, s = np.cos(angle), np.sin(angle)
    out = np.eye(3)
    a, b = (k + 1) % 3, (k + 2) % 3
    out[a, a], out[a, b], out[b, a], out[b, b] = c, -s, s, c
    return out


def _quaternions(R: Array, yaw: Array, errors: Array) -> Array:

    turned = Rotation.from_euler("z", yaw[:, None]) * Rotation.from_matrix(R) * Rotation.from_rotvec(errors)
    return np.asarray(np.roll(turned.as_quat(), 1, axis=1))
