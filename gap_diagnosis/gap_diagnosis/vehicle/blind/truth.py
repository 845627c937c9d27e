"""From what a case hides to the numbers of its world, by formulas of its own."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.blind.draws import OUTSIDE_TOO, Draw
from gap_diagnosis.vehicle.blind.world import COLUMNS, STEP
from thruster_model.parameter_set import ParameterSet
from thruster_model.vehicle_set import VehicleSet

__all__ = [
    "GROUPS", "Installed", "Truth", "Unnamed", "biased", "installed", "levelled", "metered", "off", "placed", "rested",
    "slanted", "truth_of", "unnamed",
]  # fmt: skip

Array = NDArray[np.float64]
GROUPS = ("c_u2", "delta_u2", "k_n", "c_T", "c_nv and c_v", "k_v", "k_Uv", "k_Tv", "c_u1", "delta_u1", "k_Q")
"""Coefficients of a thruster that are off together."""
_AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")


class Truth(NamedTuple):
    """Arguments of `run_world` that do not change, and what is wrong with the sensors."""

    thrusters: Array
    M: Array
    D_L: Array
    D_Q: Array
    weight: float
    buoyancy: float
    r_G: Array
    r_B: Array
    current: Array
    tether: Array
    ram: float
    interaction: Array
    sag: float
    wiring: Array
    sign: Array
    sliding: Array
    sensors: dict[str, Any]


class Installed(NamedTuple):
    """By what healthy sensors are off: scales, turns about their axes [rad] and places [m], (3,) each but the depth's;
    how late stamps are [s]."""

    gyro_scale: Array
    imu_turn: Array
    imu_place: Array
    velocity_scale: Array
    velocity_turn: Array
    velocity_place: Array
    depth_scale: float
    velocity_late: float
    tachometer_late: float


class Unnamed(NamedTuple):
    """Sizes of what is outside the library, 0 where it is not there: water that slides, its moment [N m] per sine of a
    tilt and its time [s], (2,); an arm's moment [N m]; the accelerometer's bias [m/s^2] at rotors' 100 rad/s."""

    sliding: Array
    arm: float
    bias: float


def _cross_matrix(a: Array) -> Array:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _turned(x: Array, axis: Array, angle: float) -> Array:
    k = _cross_matrix(axis / np.linalg.norm(axis))
    return np.asarray((np.eye(3) + np.sin(angle) * k + (1.0 - np.cos(angle)) * k @ k) @ x)


def off(draw: Draw, vehicle: VehicleSet) -> tuple[dict[str, float], Array]:
    """Return the numbers of a case's vehicle, and factors (N, 11) of its thrusters' coefficients by `GROUPS`."""
    rng = np.random.default_rng(np.random.SeedSequence(draw.seed, spawn_key=(78,)))
    v = dict(vehicle.values)
    for name in sorted(vehicle.parameters):
        v[name] += draw.deviations * vehicle.deviation(name) * rng.normal()
    for name in v:
        if name[:2] in ("A_", "L_", "Q_", "I_"):
            v[name] = max(v[name], 0.2 * vehicle.values[name])
    factors = []
    for count in (8, 2, len(GROUPS) - 10):  # in parts: what a seed had drawn stays as it was before one was added
        common = 1.0 + 0.05 * draw.deviations * rng.normal(size=count)
        factors.append(common * (1.0 + 0.02 * draw.deviations * rng.normal(size=(len(vehicle.layout), count))))
    return v, np.hstack(factors)


def placed(draw: Draw, vehicle: VehicleSet) -> tuple[Array, Array]:
    """Return where the thrusters of a case are and which way they push, (N, 3) each."""
    rng = np.random.default_rng(np.random.SeedSequence(draw.seed, spawn_key=(80,)))
    drawn = np.array([(place.position, place.axis) for place in vehicle.layout])
    size = vehicle.values["volume"] ** (1.0 / 3.0)
    drawn += draw.deviations * np.array([0.02 * size, 0.015])[:, None] * rng.normal(size=drawn.shape)
    return drawn[:, 0], drawn[:, 1] / np.linalg.norm(drawn[:, 1], axis=1, keepdims=True)


def slanted(draw: Draw, vehicle: VehicleSet) -> Array:
    """Return the products of inertia of a case, (3, 3) [kg m^2]."""
    rng = np.random.default_rng(np.random.SeedSequence(draw.seed, spawn_key=(82,)))
    moments = np.array([vehicle.values[f"I_{axis}"] for axis in "xyz"])
    out = np.triu(0.02 * draw.deviations * np.sqrt(np.outer(moments, moments)) * rng.normal(size=(3, 3)), 1)
    return np.asarray(out + out.T)


def installed(draw: Draw) -> Installed:
    """Return by what the sensors of a case are off as they are calibrated and mounted."""
    rng = np.random.default_rng(np.random.SeedSequence(draw.seed, spawn_key=(81,)))
    deviations = draw.deviations * np.array([0.005, 0.0075, 0.01, 0.01, 0.0075, 0.01])
    scale, turn, place, of_velocity, turn_of_it, place_of_it = deviations[:, None] * rng.normal(size=(6, 3))
    depth, late, rotors_late = draw.deviations * np.array([0.005, 0.003, 0.003]) * rng.normal(size=3)
    return Installed(scale, turn, place, of_velocity, turn_of_it, place_of_it, depth, late, rotors_late)


def rested(draw: Draw, run: int) -> Array:
    """Return the battery's relative voltage at rest as a run begins, and by how much it falls in a second [1/s]."""
    rng = np.random.default_rng(np.random.SeedSequence(draw.seed, spawn_key=(83, run)))
    return rng.uniform((0.93, 0.5e-4), (1.03, 3e-4))


def metered(draw: Draw) -> tuple[float, float, float]:
    """Return what a case's battery sensor reads: volts of a full one, current of nothing and of all at full [A]."""
    rng = np.random.default_rng(np.random.SeedSequence(draw.seed, spawn_key=(85,)))
    of_volts, of_idle, of_full = draw.deviations * np.array([0.03, 0.4, 0.15]) * rng.normal(size=3)
    return 16.0 * (1.0 + of_volts), 1.5 * np.exp(of_idle), 100.0 * (1.0 + of_full)


def biased(draw: Draw) -> tuple[float, float]:
    """Return deviations of the biases with which a case's gyro [rad/s] and accelerometer [m/s^2] begin a run."""
    rng = np.random.default_rng(np.random.SeedSequence(draw.seed, spawn_key=(86,)))
    return float(rng.uniform(0.0005, 0.002)), float(rng.uniform(0.01, 0.04))


def unnamed(draw: Draw) -> Unnamed:
    """Return the sizes of what a case has that is outside the library."""
    rng = np.random.default_rng(np.random.SeedSequence(draw.seed, spawn_key=(89,)))
    moment, time, arm, bias = rng.uniform((0.5, 0.5, 0.2, 0.3), (1.5, 2.0, 0.6, 1.0))
    there = [draw.outside == kind for kind in OUTSIDE_TOO]
    return Unnamed(np.array([moment * there[0], time]), arm * there[1], bias * there[2])


def levelled(draw: Draw, run: int) -> Array:
    """Return by how much the attitude is turned further than its IMU in a run, about its three axes [rad]."""
    rng = np.random.default_rng(np.random.SeedSequence(draw.seed, spawn_key=(84, run)))
    return 0.01 * draw.deviations * rng.normal(size=3)


def truth_of(draw: Draw, vehicle: VehicleSet, sets: tuple[ParameterSet, ...]) -> Truth:
    """Return the world of a case: believed numbers, off by what parameters deviate, with its effects."""
    v, shares = off(draw, vehicle)
    N = len(vehicle.layout)
    positions, axes = placed(draw, vehicle)
    table = np.zeros((N, len(COLUMNS)))
    at = {name: k for k, name in enumerate(COLUMNS)}
    for i, place in enumerate(vehicle.layout):
        p, f = sets[i].coefficients, shares[i]
        row = dict(zip(("rx", "ry", "rz", "ex", "ey", "ez"), (*positions[i], *axes[i]), strict=True))
        row |= {"c_u1": p.c_u1 * f[8], "c_u2": p.c_u2 * f[0], "d_1": p.delta_u1 * f[9], "d_2": p.delta_u2 * f[1]}
        row |= {"k_n": p.k_n * f[2], "k_q": p.k_Q * p.c_Q2 * f[10], "c_T": p.c_T2 * f[3], "c_nv": p.c_nv_T * f[4]}
        row |= {"c_v": p.c_v_T * f[4], "k_v": p.k_v * f[5], "k_Uv": p.k_Uv * f[6], "k_w": p.k_w}
        row |= {"k_Tv": p.k_Tv * f[7], "hand": place.turn, "share": 1.0, "reverse": 1.0, "turning": 1.0}
        row |= {"hull_axis": -1.0, "cav_onset": 1e6, "fade_time": 30.0}
        ends = row["c_u1"] * (5.0 + row["d_1"]), row["c_u2"] * (5.0 - row["d_2"])
        row["power"] = max(ends) ** 2 / row["k_n"]
        for name, value in row.items():
            table[i, at[name]] = value
    m, g = v["mass"], v["gravity"]
    r_G = np.array([v.get(f"{a}_G", 0.0) for a in "xyz"])
    r_B = np.array([v.get(f"{a}_B", 0.0) for a in "xyz"])
    A = np.array([v[f"A_{a}"] for a in "uvwpqr"])
    L, Q = (np.array([v[f"{k}_{a}"] for a in "uvwpqr"]) for k in "LQ")
    I_G = np.diag([v["I_x"], v["I_y"], v["I_z"]]) + slanted(draw, vehicle)
    world: dict[str, Any] = {
        "mass": m, "weight": m * g, "buoyancy": v["density"] * g * v["volume"], "r_G": r_G, "r_B": r_B, "A": A, "L": L,
        "Q": Q, "current": np.zeros(3), "tether": np.zeros(4), "ram": 0.0, "interaction": np.zeros((N, N)), "sag": 0.0,
        "wiring": np.arange(N, dtype=float), "sign": np.ones(N), "extra": np.zeros((6, 6)),
        "torque": v.get("reaction_torque", 0.0), "full": [_full_thrust(sets[i].coefficients) for i in range(N)],
    }  # fmt: skip
    sensors: dict[str, Any] = {}
    for effect, target, sizes in draw.effects:
        _add(effect, target, sizes, world, table, at, sensors)
    S = _cross_matrix(world["r_G"])
    I_O = I_G - m * S @ S
    M = np.block([[m * np.eye(3), -m * S], [m * S, I_O]]) + np.diag(world["A"]) + world["extra"]
    weight, arm = world["weight"], world["r_G"] * m * g
    if "load" in world:
        mass, place = world["load"]
        weight, arm = weight + mass * g, arm + mass * g * place
    return Truth(
        table, M, np.diag(world["L"]), np.diag(world["Q"]), weight, world["buoyancy"], arm / weight, world["r_B"],
        world["current"], world["tether"], world["ram"], world["interaction"], world["sag"], world["wiring"],
        world["sign"], unnamed(draw).sliding, sensors,
    )  # fmt: skip


def _full_thrust(p: Any) -> float:
    """Return the steady thrust at 5 V in still water: n from the rotor's balance, v from the flow's, by bisection."""
    drive = p.c_u2 * (5.0 - p.delta_u2)
    b = p.k_Q * p.c_Q2
    n = drive / p.k_n if b == 0.0 else (-p.k_n + np.sqrt(p.k_n**2 + 4.0 * b * drive)) / (2.0 * b)
    low, high = 0.0, 20.0
    for _ in range(80):
        v = 0.5 * (low + high)
        T = p.c_T2 * n * n - p.c_nv_T * n * v - p.c_v_T * v * v
        if p.k_Tv * T > p.k_v * v + p.k_Uv * v * v:
            low = v
        else:
            high = v
    return float(T)


def _add(
    effect: str, target: Mapping[str, Any], sizes: Mapping[str, float], w: dict[str, Any], table: Array,
    at: dict[str, int], sensors: dict[str, Any],
) -> None:  # fmt: skip
    """Put one effect into the world."""
    i, s = target.get("thruster"), next(iter(sizes.values()), 1.0)
    axis = _AXES.index(target["axis"]) if target.get("axis") in _AXES else 0
    if effect == "thrust_loss":
        table[i, at["share"]] *= 1.0 - s
    elif effect == "thrust_asymmetry":
        table[i, at["reverse"]] *= 1.0 - s
    elif effect == "throttle_gain":
        table[i, [at["c_u1"], at["c_u2"]]] *= 1.0 - s
    elif effect == "dead_zone_shift":
        table[i, at["d_1"]] -= s
        table[i, at["d_2"]] += s
    elif effect == "viscous_friction":
        table[i, at["k_n"]] *= 1.0 + s
    elif effect == "coulomb_friction":
        table[i, at["coulomb"]] = s
    elif effect == "command_delay":
        table[i, at["delay"]] = round(s / STEP)
    elif effect == "command_lag":
        table[i, at["lag"]] = s
    elif effect == "cavitation":
        table[i, at["cav_share"]], table[i, at["cav_onset"]] = s, sizes["onset"]
    elif effect == "thermal_fade":
        table[i, at["fade"]], table[i, at["fade_time"]] = s, sizes["time_constant"]
    elif effect == "thruster_failure":
        table[i, at["turning"]] = 0.0
    elif effect == "thruster_polarity":
        w["sign"][i] = -1.0
    elif effect == "thruster_swap":
        w["wiring"][[i, target["other"]]] = w["wiring"][[target["other"], i]]
    elif effect == "thruster_misalignment":
        e = table[i, at["ex"] : at["ez"] + 1].copy()
        level = np.array([-e[1], e[0], 0.0])
        first = level / np.linalg.norm(level) if np.linalg.norm(level) > 1e-6 else np.array([1.0, 0.0, 0.0])
        about = first if target["kind"] == "first_normal" else np.cross(e, first)
        table[i, at["ex"] : at["ez"] + 1] = _turned(e, about, s)
    elif effect == "hull_interaction":
        e = table[i, at["ex"] : at["ez"] + 1]
        table[i, at["hull_axis"]], table[i, at["hull_share"]] = int(np.argmax(np.round(np.abs(e), 1))), s
    elif effect == "thruster_interaction":
        w["interaction"][i, target["other"]] = s / w["full"][i]
    elif effect == "reaction_torque":
        table[:, at["torque"]] = s * w["torque"]
    elif effect == "supply_sag":
        w["sag"] = s
    elif effect == "added_mass":
        w["A"][axis] *= 1.0 + s
    elif effect == "linear_drag":
        w["L"][axis] *= 1.0 + s
    elif effect == "quadratic_drag":
        w["Q"][axis] *= 1.0 + s
    elif effect == "buoyancy_offset":
        w["buoyancy"] += s
    elif effect == "payload":
        place = np.array([sizes[a] for a in "xyz"])
        S = _cross_matrix(place)
        w["load"] = (s, place)
        w["extra"] += np.block([[s * np.eye(3), -s * S], [s * S, -s * S @ S]])
    elif effect == "cg_shift":
        w["r_G"] = w["r_G"] + np.array([sizes.get(a, 0.0) for a in "xyz"])
    elif effect == "cb_shift":
        w["r_B"] = w["r_B"] + np.array([sizes.get(a, 0.0) for a in "xyz"])
    elif effect == "water_current":
        w["current"] = np.array([sizes.get(a, 0.0) for a in ("north", "east", "down")])
    elif effect == "tether_drag":
        w["tether"] = np.array([0.5 * 1000.0 * 1.2 * 0.008 * s, sizes["x"], sizes["y"], sizes["z"]])
    elif effect == "ram_drag":
        w["ram"] = np.sqrt(0.5 * 1000.0 * 0.25 * np.pi * s**2)
    else:
        sensors[effect] = (target.get("axis"), s if len(sizes) == 1 else tuple(sizes.values()))
