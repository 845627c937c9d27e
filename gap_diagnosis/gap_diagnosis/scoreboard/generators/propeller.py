"""A propeller's simulator (`propeller_plant`): blades as airfoils, one data logger, commands from another machine.

The simulator that is diagnosed has the truth's class; cases in which it has another one (HQ, which agrees with the
propeller at rest) are outside of any library of effects. Random accelerations act on rotor and water, each with a
memory of its own.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.scoreboard.case import Generator, Push, Samples, Sizes, SyntheticRun, Truth
from gap_diagnosis.scoreboard.generators.propeller_catalogue import BEYOND, ROWS, TABLE, TOGETHER
from gap_diagnosis.scoreboard.generators.propeller_plant import SKIP, STEP, go
from thruster_model.parameter_set_io import load_parameter_set

__all__ = ["GENERATOR"]

Array = NDArray[np.float64]
_SIGNALS = ("speed", "ambient", "thrust", "torque")
_DEVIATION = np.array([1.3, 0.006, 0.25, 5e-4])  # of the sensors' noise
_LEAD_IN = 3.0  # [s]
_STREAM = 1733

_N_PARAMETERS = 24


class _Setting(NamedTuple):
    """Conditions of a case."""

    stream: int
    length: float
    runs: int
    command_rate: float
    logger_rate: float
    straight: bool
    says_hold: bool
    late_logger: float
    noise: Array
    rough: float
    in_motion: bool
    memories: tuple[float, float]
    pushes: tuple[float, float]
    daily: float
    bends: Array
    clock: float  # [s] deviation of the logger's clock in a run


_PLACES = (
    "command_delay", "command_lag", "throttle_rate_limit", "throttle_saturation", "command_quantization",
    "dead_zone_shift", "throttle_gain", "supply_sag", "thermal_fade", "coulomb_friction", "viscous_friction",
    "rotor_inertia", "start_hysteresis", "thrust_loss", "thrust_asymmetry", "propeller_fouling", "entrained_water",
    "cavitation", "ambient_current", "flow_lag",
)  # fmt: skip
_FIELDS = (
    "c_u1", "c_u2", "delta_u1", "delta_u2", "u_dot_max", "k_n", "k_Q", "radius", "density", "pitch", "lift", "drag",
    "k_v", "k_Uv", "k_w", "k_Tv", "k_U", "k_UU", "k_TU",
)  # fmt: skip


def _arrays(truth: Truth, effects: Sizes, outside: Sizes, factors: Mapping[str, float]) -> tuple[Array, Array, Array]:
    nominal = load_parameter_set("airfoil").values
    c = np.array([nominal[name] * factors.get(name, 1.0) for name in _FIELDS])
    e = np.zeros(_N_PARAMETERS)
    e[2], e[3], e[20], e[21] = 1e9, 1e9, 1e9, 30.0
    for place, name in enumerate(_PLACES):
        if name in effects:
            e[place] = effects[name][ROWS[name][1]]
    e[20] = effects.get("cavitation", {}).get("onset", 1e9)
    e[21] = effects.get("thermal_fade", {}).get("time_constant", 30.0)
    b = np.concatenate((truth.drawn.bends, np.zeros(5)))
    for place, name in ((4, "soft_coupling"), (5, "speed_limit"), (6, "sloshing"), (7, "thrust_by_history")):
        if name in outside:
            b[place] = next(iter(outside[name].values()))
    return c, e, b


def _sized(rng: np.random.Generator, name: str, reach: float) -> dict[str, float]:
    _, parameter, low, high, either, more = ROWS[name]
    size = math.exp(math.log(low) + reach * rng.uniform() * math.log(high / low))
    if either and rng.uniform() < 0.5:
        size = -size
    if parameter == "*":
        parameter = ("throttle", "speed", "flow", "load")[rng.integers(4)]
    return {parameter: float(size), **{key: float(rng.uniform(a, z)) for key, a, z in more}}


def _choose(kind: str, index: int, rng: np.random.Generator) -> tuple[dict[str, Any], dict[str, Any]]:
    if kind == "outside":
        name = sorted(BEYOND)[index % len(BEYOND)]
        parameter, low, high = BEYOND[name]
        return {}, {name: {parameter: float(rng.uniform(low, high))}}
    if kind == "one":
        name = TABLE[index % len(TABLE)][0]
        return {name: _sized(rng, name, 1.0)}, {}
    if kind == "two":
        pair = rng.choice([row[0] for row in TABLE], 2, replace=False)
        return {str(name): _sized(rng, str(name), 1.0) for name in pair}, {}
    if kind == "many":
        several = rng.choice(TOGETHER, int(rng.integers(3, 7)), replace=False)
        return {str(name): _sized(rng, str(name), 0.5) for name in several}, {}
    return {}, {}


def _draw(kind: str, index: int, whole: bool) -> Truth:
    kinds = ["none", "one", "two", "many", "outside"]
    rng = np.random.default_rng((_STREAM, kinds.index(kind), index))
    effects, outside = _choose(kind, index, rng)
    names = load_parameter_set("airfoil").values
    fixed = {"radius", "density", "u_dot_max"}
    factors = {k: 1.0 if k in fixed else 1.0 + 0.05 * float(np.clip(rng.normal(), -2.2, 2.2)) for k in names}
    disturbed = rng.uniform() >= 0.25
    memories = (float(rng.uniform(0.5, 5.0)), float(rng.uniform(0.5, 5.0)))
    sizes = rng.uniform(0.1, 2.0, 2) * _DEVIATION[:2] * disturbed
    decay = (25.0, 0.6)  # [1/s] at which rotor and water forget
    pushes = [float(s * math.sqrt(k * k + k / m)) for s, k, m in zip(sizes, decay, memories, strict=True)]
    setting = _Setting(
        stream=int(rng.integers(1, 2**30)),
        length=28.0 if whole else 15.0,
        runs=4 if whole else 3,
        command_rate=float(rng.choice([10.0, 20.0, 25.0, 50.0, 100.0])),
        logger_rate=float(rng.choice([20.0, 25.0, 50.0, 100.0, 200.0])),
        straight=bool(rng.uniform() < 0.35),
        says_hold=bool(rng.uniform() < 0.5),
        late_logger=float(rng.uniform(0.0, 0.02)),
        noise=_DEVIATION * rng.uniform(0.6, 1.7, 4),
        rough=float(rng.choice([0.0, 0.001, 0.003])),
        in_motion=bool(rng.uniform() < 0.3),
        memories=memories,
        pushes=(pushes[0], pushes[1]),
        daily=float(rng.choice([0.0, 0.004, 0.008])),
        bends=np.array([rng.uniform(8.0, 13.0), rng.uniform(0.15, 0.4), rng.uniform(0.85, 1.25)]),
        clock=float(np.random.default_rng((_STREAM, kinds.index(kind), index, 1)).choice([0.0, 0.001, 0.003])),
    )
    return Truth(
        generator="propeller", kind=kind, index=index, model="hq" if "another_class" in outside else "airfoil",
        effects=effects, outside=outside, factors=factors, drawn=setting,
    )  # fmt: skip


def _command(s: _Setting, which: int) -> Samples:
    rng = np.random.default_rng((s.stream, which, 5))
    dt = 1.0 / s.command_rate
    t: Array = np.asarray(dt * np.arange(int(s.length * s.command_rate) + 1), dtype=np.float64)
    height = rng.uniform(2.4, 4.0)
    if which == 0:  # a random telegraph with random heights
        turns = np.sort(rng.uniform(0.0, s.length, int(s.length / 1.3)))
        u = rng.uniform(-height, height, turns.size + 1)[np.searchsorted(turns, t)]
    elif which == 1:  # a chirp
        u = height * np.sin(2.0 * math.pi * (0.04 * t + 0.5 * 0.9 / s.length * t * t))
    elif which == 2:  # filtered noise
        walk = rng.normal(size=t.size)
        kernel = np.exp(-t[: max(2, int(3.0 / dt))] / 0.8)
        u = np.convolve(walk, kernel)[: t.size]
        u *= height / np.max(np.abs(u))
    else:  # stairs up and down
        u = height * np.round(4.0 * np.sin(2.0 * math.pi * t / rng.uniform(9.0, 14.0))) / 4.0
    if not s.in_motion:
        u = np.where(t < 1.0, 0.0, u)
    return Samples(t, np.asarray(u, dtype=np.float64))


def _walks(seed: int, which: int, length: float) -> Push:
    """Return random paths over so many seconds."""
    rng = np.random.default_rng((seed, which, 9))
    t = np.arange(0.0, length + 1.0, 0.1)

    def walk(_: int, at: Array, memory: float) -> Array:
        near = np.exp(-np.abs(t[:, None] - t[None, :]) / memory) + 1e-9 * np.eye(t.size)
        return np.interp(at, t, np.linalg.cholesky(near) @ rng.normal(size=t.size))

    return walk


def _played(
    s: _Setting, command: Samples, arrays: tuple[Array, Array, Array], push: Push | None, outside: Sizes, which: int
) -> Array:
    start = -_LEAD_IN if s.in_motion else 0.0
    steps = round((s.length - start) / STEP)
    shove, plug = np.zeros((2, steps + 1)), np.zeros(steps + 1)
    if push is not None and any(s.pushes):
        for row, (size, memory) in enumerate(zip(s.pushes, s.memories, strict=True)):
            shove[row] = size * push(row, np.asarray(STEP * np.arange(steps + 1)), memory)
    if "loose_plug" in outside:
        rng = np.random.default_rng((s.stream, which, 11))
        for begin in rng.uniform(0.0, s.length, 2) - start:
            plug[int(begin / STEP) : int((begin + rng.uniform(1.0, 3.0)) / STEP)] = outside["loose_plug"]["share"]
    keep = np.zeros((4, steps // SKIP + 1))
    go(*arrays, command.time, command.values, s.straight, start, steps, shove, plug, keep)
    return keep[:, : round(s.length / (STEP * SKIP)) + 1]


def _measured(keep: Array, effects: Sizes) -> Array:
    """Return the sensors' dense signals (4, M), 2 ms apart, behind their dynamics, scales and offsets."""
    from scipy.signal import cont2discrete, lfilter

    dt = STEP * SKIP
    t = dt * np.arange(keep.shape[1])
    y = keep.copy()

    def size(name: str, parameter: str) -> float:
        return float(effects.get(name, {}).get(parameter, 0.0))

    if size("tach_lag", "time"):
        pole = math.exp(-dt / size("tach_lag", "time"))
        y[0] = lfilter([1.0 - pole], [1.0, -pole], y[0], zi=[pole * y[0, 0]])[0]
    y[0] *= 1.0 + size("tach_scale", "share")
    if size("flow_delay", "time"):
        y[1] = np.interp(t - size("flow_delay", "time"), t, y[1])
    y[1] += size("flow_bias", "offset")
    if size("load_cell_resonance", "frequency"):
        w, z = 2.0 * math.pi * size("load_cell_resonance", "frequency"), size("load_cell_resonance", "damping")
        top, bottom, _ = cont2discrete(([w * w], [1.0, 2.0 * z * w, w * w]), dt, "zoh")
        y[2] = y[2, 0] + lfilter(np.ravel(top), bottom, y[2] - y[2, 0])
    y[2] = y[2] * (1.0 + size("load_cell_scale", "share")) + size("load_cell_bias", "offset")
    y[2] += size("load_cell_drift", "rate") * t
    return y


_LATE: Mapping[str, Callable[[Mapping[str, float]], float]] = {
    "speed": lambda a: a.get("speed", 0.0),
    "ambient": lambda a: a.get("flow", 0.0),
    "thrust": lambda a: a.get("load", 0.0),
    "torque": lambda a: a.get("load", 0.0),
}


def _logged(s: _Setting) -> Array:
    return np.asarray(np.arange(s.late_logger, s.length - 1e-3, 1.0 / s.logger_rate), dtype=np.float64)


def _stepped(row: Array, effects: Sizes) -> Array:
    step = effects.get("tach_quantization", {}).get("step", 0.0)
    return row if step == 0.0 else np.asarray(step * np.floor(row / step + 0.5))


def _record(truth: Truth) -> list[SyntheticRun]:
    s: _Setting = truth.drawn
    runs = []
    for which in range(s.runs):
        rng = np.random.default_rng((s.stream, which))
        scattered = {name: factor * (1.0 + s.daily * rng.normal()) for name, factor in truth.factors.items()}
        arrays = _arrays(truth, truth.effects, truth.outside, scattered)
        command = _command(s, which)
        push = _walks(s.stream, which, s.length + _LEAD_IN * s.in_motion)
        y = _measured(_played(s, command, arrays, push, truth.outside, which), truth.effects)
        dense, at = STEP * SKIP * np.arange(y.shape[1]), _logged(s)
        aligned = truth.effects.get("log_alignment", {})
        drift = truth.effects.get("clock_drift", {}).get("rate", 0.0)
        off = s.clock * np.random.default_rng((s.stream, which, 1)).normal()
        signals = {}
        for k, name in enumerate(_SIGNALS):
            row = np.interp(at, dense, y[k]) + s.noise[k] * rng.normal(size=at.size)
            row += 30.0 * s.noise[k] * rng.choice([-1.0, 1.0], at.size) * (rng.uniform(size=at.size) < s.rough)
            row = _stepped(row, truth.effects) if name == "speed" else row
            signals[name] = (at * (1.0 + drift) + _LATE[name](aligned) + off, row)
        stamps = command.time + aligned.get("throttle", 0.0)
        origin = min(stamps[0], *(time[0] for time, _ in signals.values()))
        runs.append(
            SyntheticRun(
                name=f"run_{which}",
                throttle=Samples(stamps - origin, command.values),
                signals={name: Samples(time - origin, row) for name, (time, row) in signals.items()},
                hold=("linear" if s.straight else "previous") if s.says_hold else None,
            )
        )
    return runs


def _clean(truth: Truth, effects: Sizes, outside: Sizes, factors: Mapping[str, float], push: Push | None) -> Array:
    s: _Setting = truth.drawn
    arrays = _arrays(truth, effects, outside, factors)
    aligned, drift = effects.get("log_alignment", {}), effects.get("clock_drift", {}).get("rate", 0.0)
    rows = []
    for which in range(s.runs):
        y = _measured(_played(s, _command(s, which), arrays, push, outside, which), effects)
        dense, at = STEP * SKIP * np.arange(y.shape[1]), _logged(s)
        for k, name in enumerate(_SIGNALS):
            when = at * (1.0 - drift) - _LATE[name](aligned) + aligned.get("throttle", 0.0)
            row = np.interp(when, dense, y[k])
            rows.append((_stepped(row, effects) if name == "speed" else row) / s.noise[k])
    return np.concatenate(rows).reshape(s.runs, -1)


GENERATOR = Generator(
    name="propeller",
    title="blades as airfoils by the midpoint rule, one logger for all sensors, rotor and water pushed at random",
    draw=_draw,
    record=_record,
    clean=_clean,
)
