r"""A laboratory's simulator: HL or HQ (`lab_plant`), pushed at random, each topic on a clock of its own.

Rotor and water are pushed by random accelerations that are remembered for 0.5 to 5 s (none in one case of four).
Commands are held, or straight lines between their samples. Forms differ a little from those of the diagnosis' library:
a start needs another speed, heat follows another power, friction sets in smoothly. Nothing here is shared.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.scoreboard.case import Generator, Push, Samples, Sizes, SyntheticRun, Truth
from gap_diagnosis.scoreboard.generators.lab_catalogue import EFFECTS, IN_PLANT, MORE, OUTSIDE, SMALL
from gap_diagnosis.scoreboard.generators.lab_plant import STEP, Coefficients, simulated
from thruster_model.compilation import compiled
from thruster_model.parameter_set_io import load_parameter_set

__all__ = ["GENERATOR"]

Array = NDArray[np.float64]
_EVERY = 2  # steps between dense outputs
_BEFORE = 4.0  # [s] that a run which begins in motion has been going on
_NOISE = {"speed": 1.0, "ambient": 0.005, "thrust": 0.3, "torque": 4e-4}
_RATES = (10.0, 20.0, 25.0, 40.0, 50.0, 80.0, 100.0, 200.0)  # [Hz]
_SEED = 41
_CLASS = {"none": 0, "one": 1, "two": 2, "many": 3, "outside": 4}


class _Drawn(NamedTuple):
    """What the conditions of a case are."""

    seed: int
    duration: float
    runs: int
    linear: bool
    told: bool
    rates: Mapping[str, float]
    phases: Mapping[str, float]
    noise: Mapping[str, float]
    tails: bool
    moving: bool
    outliers: float
    memory: float
    push: tuple[float, float]
    varying: float
    forms: tuple[float, float, float, float]
    clocks: float  # [s] deviation of a topic's clock in a run
    uneven: float  # share of a period by which commands come late


def _draw(kind: str, index: int, whole: bool) -> Truth:
    rng = np.random.default_rng([_SEED, _CLASS[kind], index])
    model = "hq" if rng.random() < 0.5 else "hl"
    nominal = load_parameter_set(model).values
    factors = {name: float(np.exp(0.05 * np.clip(rng.standard_normal(), -2, 2))) for name in nominal}
    factors["u_dot_max"] = 1.0
    pool = list(EFFECTS)
    count = {"none": 0, "one": 1, "two": 2, "many": int(rng.integers(3, 7)), "outside": 0}[kind]
    names = list(rng.permutation(SMALL if kind == "many" else pool)[:count])
    if kind == "one":
        names = [pool[index % len(pool)]]
    effects = {str(name): _size(str(name), rng, small=kind == "many") for name in names}
    outside: dict[str, dict[str, float]] = {}
    if kind == "outside":
        name = list(OUTSIDE)[index % len(OUTSIDE)]
        parameter, low, high = OUTSIDE[name]
        outside[name] = {parameter: float(np.exp(rng.uniform(np.log(low), np.log(high))))}
    topics = ("throttle", "speed", "ambient", "load")
    rates = {topic: float(rng.choice(_RATES)) for topic in topics}
    disturbed = rng.random() < 0.75
    timing = np.random.default_rng([_SEED, _CLASS[kind], index, 1])
    memory = float(rng.uniform(0.5, 5.0))
    level = rng.uniform(0.2, 2.0, 2) * disturbed
    drawn = _Drawn(
        seed=int(rng.integers(2**31)),
        duration=30.0 if whole else 15.0,
        runs=4 if whole else 3,
        linear=bool(rng.random() < 0.4),
        told=bool(rng.random() < 0.5),
        rates=rates,
        phases={topic: float(rng.uniform(0.0, 1.0)) / rate for topic, rate in rates.items()},
        noise={name: float(size * np.exp(0.4 * rng.standard_normal())) for name, size in _NOISE.items()},
        tails=bool(rng.random() < 0.4),
        moving=bool(rng.random() < 0.3),
        outliers=float(rng.uniform(5e-4, 3e-3)) if rng.random() < 0.4 else 0.0,
        memory=memory,
        push=_push_for(level, memory, nominal),
        varying=float(rng.uniform(0.002, 0.01)) if rng.random() < 0.5 else 0.0,
        forms=(
            float(rng.uniform(7.0, 14.0)), float(rng.uniform(0.8, 1.3)), float(rng.uniform(0.25, 0.5)),
            float(rng.uniform(0.9, 1.2)),
        ),
        clocks=float(timing.uniform(0.0, 3e-3)),
        uneven=float(timing.uniform(0.0, 0.6)) if timing.random() < 0.5 else 0.0,
    )  # fmt: skip
    return Truth(
        generator="lab", kind=kind, index=index, model=model, effects=effects, outside=outside, factors=factors,
        drawn=drawn,
    )  # fmt: skip


def _push_for(level: Array, memory: float, nominal: Mapping[str, float]) -> tuple[float, float]:
    """Return standard deviations of the accelerations of rotor and water which move n and U by `level` noises."""
    found = []
    for size, noise, rate in ((level[0], 1.0, nominal["k_n"] + 20.0), (level[1], 0.005, nominal["k_U"] + 0.3)):
        found.append(float(size * noise * math.sqrt(rate * (1.0 + rate * memory) / memory)))
    return found[0], found[1]


def _size(name: str, rng: np.random.Generator, *, small: bool) -> dict[str, float]:
    parameter, low, high, signed = EFFECTS[name]
    size = low * (high / low) ** float(rng.uniform(0.0, 0.45 if small else 1.0))
    if signed and rng.random() < 0.5:
        size = -size
    if name == "log_alignment":
        parameter = str(rng.choice(["throttle", "speed", "flow", "load"]))
    found = {parameter: float(size)}
    if name in MORE:
        more, low, high = MORE[name]
        found[more] = float(np.exp(rng.uniform(np.log(low), np.log(high))))
    return found


def _plant(truth: Truth, effects: Sizes, outside: Sizes, factors: Mapping[str, float]) -> Coefficients:
    nominal = load_parameter_set(truth.model).values
    g = {name: value * factors.get(name, 1.0) for name, value in nominal.items()}
    d: _Drawn = truth.drawn
    sizes = {
        IN_PLANT[name, parameter]: value
        for name, parameters in {**effects, **outside}.items()
        for parameter, value in parameters.items()
        if (name, parameter) in IN_PLANT
    }
    return Coefficients(
        g["c_u1"], g["c_u2"], g["delta_u1"], g["delta_u2"], g["u_dot_max"], g["k_n"], g["k_Q"],
        g["c_n_T"], g["c_nv_T"], g.get("c_v_T", 0.0), g["c_n_Q"], g["c_nv_Q"], g.get("c_v_Q", 0.0),
        g["k_v"], g["k_Uv"], g["k_w"], g["k_Tv"], g["k_U"], g["k_UU"], g["k_TU"],
        turning=d.forms[0], heat_power=d.forms[1], dry_width=d.forms[2], vapour_power=d.forms[3], **sizes,
    )  # fmt: skip


def _programme(run: int, d: _Drawn, rng: np.random.Generator) -> Samples:
    period = 1.0 / d.rates["throttle"]
    at: Array = np.asarray(period * np.arange(math.ceil(d.duration / period)), dtype=np.float64)
    top = float(rng.uniform(2.6, 4.2))
    if run % 4 == 0:
        levels = rng.uniform(-top, top, 120)
        wanted = levels[np.searchsorted(np.cumsum(rng.uniform(0.5, 2.8, 120)), at)]
    elif run % 4 == 1:
        tones = rng.uniform(0.05, 0.9, 7)
        phases = rng.uniform(0.0, 6.28, 7)
        wave = np.sum(np.sin(6.283 * tones[:, None] * at + phases[:, None]), axis=0)
        wanted = top * wave / np.max(np.abs(wave))
    elif run % 4 == 2:
        knots = np.concatenate(([0.0], np.cumsum(rng.uniform(1.0, 4.0, 60))))
        wanted = np.interp(at, knots, np.concatenate(([0.0], rng.uniform(-top, top, 60))))
    else:
        wanted = np.where(np.sin(6.283 * 0.13 * at + rng.uniform(0, 6.28)) > 0.0, 1.0, -1.0) * rng.uniform(1.4, top)
    if not d.moving:
        wanted = np.where(at < 0.8, 0.0, wanted)
    late = d.uneven * period * np.random.default_rng([d.seed, run, 2]).random(at.size)
    late[0] = 0.0
    return Samples(at + late, np.asarray(wanted, dtype=np.float64))


def _walks(seed: int, run: int, length: float) -> Push:
    """Return random paths over so many seconds."""
    rng = np.random.default_rng([seed, run])
    knots = np.arange(0.0, length + 0.1, 0.05)

    def walk(_: int, at: Array, memory: float) -> Array:
        keep = math.exp(-0.05 / memory)
        x, passed = rng.standard_normal(), []
        for shock in rng.standard_normal(knots.size):
            passed.append(x)
            x = keep * x + math.sqrt(1.0 - keep * keep) * shock
        return np.interp(at, knots, passed)

    return walk


def _dense(d: _Drawn, command: Samples, p: Coefficients, push: Push | None) -> tuple[Array, Array]:
    """Return (instants [s], outputs (4, M)) of a run."""
    first = -_BEFORE if d.moving else 0.0
    steps = round((d.duration - first) / STEP)
    shove = np.zeros((2, steps + 1))
    if push is not None and any(d.push):
        for row in range(2):
            shove[row] = d.push[row] * push(row, np.asarray(STEP * np.arange(steps + 1)), d.memory)
    rows = round(d.duration / (STEP * _EVERY)) + 1
    out = np.zeros((4, rows))
    simulated(command.time, command.values, d.linear, first, steps, shove, _EVERY, p, out)
    return np.asarray(STEP * _EVERY * np.arange(rows), dtype=np.float64), out


@compiled
def _filtered(values, dt, lag):  # type: ignore[no-untyped-def]
    found = np.empty(values.size)
    y = values[0]
    for k in range(values.size):
        y = values[k] + (y - values[k]) * math.exp(-dt / lag)
        found[k] = y
    return found


@compiled
def _rung(values, dt, frequency, damping):  # type: ignore[no-untyped-def]
    found, w = np.empty(values.size), 2.0 * math.pi * frequency
    y, rate = values[0], 0.0
    for k in range(values.size):
        for _ in range(4):
            rate += 0.25 * dt * (w * w * (values[k] - y) - 2.0 * damping * w * rate)
            y += 0.25 * dt * rate
        found[k] = y
    return found


def _sensed(at: Array, out: Array, effects: Sizes, outside: Sizes) -> dict[str, Array]:
    """Return what sensors tell at all instants, without noise and converters."""
    speed, flow, force, moment = (row.copy() for row in out)
    dt = at[1] - at[0]
    if "tach_lag" in effects:
        speed = _filtered(speed, dt, effects["tach_lag"]["time"])
    speed *= 1.0 + effects.get("tach_scale", {}).get("share", 0.0)
    if "flow_delay" in effects:
        flow = np.interp(at - effects["flow_delay"]["time"], at, flow)
    if "flow_meter_wall" in outside:
        flow = flow * (1.0 - outside["flow_meter_wall"]["share"] * np.abs(flow) / 0.3)
    flow = flow * (1.0 + effects.get("flow_scale", {}).get("share", 0.0))
    flow += effects.get("flow_bias", {}).get("offset", 0.0)
    if "load_cell_resonance" in effects:
        force = _rung(force, dt, effects["load_cell_resonance"]["frequency"], effects["load_cell_resonance"]["damping"])
    force += effects.get("load_cell_crosstalk", {}).get("gain", 0.0) * moment
    force *= 1.0 + effects.get("load_cell_scale", {}).get("share", 0.0)
    force += effects.get("load_cell_bias", {}).get("offset", 0.0)
    force += effects.get("load_cell_drift", {}).get("rate", 0.0) * at
    return {"speed": speed, "ambient": flow, "thrust": force, "torque": moment}


_TOPIC = {"speed": "speed", "ambient": "ambient", "thrust": "load", "torque": "load"}


def _instants(topic: str, d: _Drawn) -> Array:
    period = 1.0 / d.rates[topic]
    return np.asarray(np.arange(d.phases[topic], d.duration - 1e-6, period), dtype=np.float64)


def _stamped(topic: str, at: Array, effects: Sizes, rng: np.random.Generator) -> Array:
    parameter = {"throttle": "throttle", "speed": "speed", "ambient": "flow", "load": "load"}[topic]
    stamps = at + effects.get("log_alignment", {}).get(parameter, 0.0)
    if topic != "throttle":
        stamps = stamps * (1.0 + effects.get("clock_drift", {}).get("rate", 0.0))
    if "timestamp_jitter" in effects:
        stamps = np.sort(stamps + effects["timestamp_jitter"]["deviation"] * rng.standard_normal(at.size))
    return np.asarray(stamps)


def _converted(signal: str, y: Array, effects: Sizes, rng: np.random.Generator) -> Array:
    if signal == "speed":
        if "tach_quantization" in effects:
            y = effects["tach_quantization"]["step"] * np.round(y / effects["tach_quantization"]["step"])
        if "tach_dropout" in effects:
            y = np.where(np.abs(y) < effects["tach_dropout"]["threshold"], 0.0, y)
    if signal == "ambient" and "flow_spikes" in effects:
        hit = rng.random(y.size) < effects["flow_spikes"]["share"]
        y = y + hit * 0.3 * rng.standard_normal(y.size)
    return y


def _record(truth: Truth) -> list[SyntheticRun]:
    d: _Drawn = truth.drawn
    found = []
    for run in range(d.runs):
        rng = np.random.default_rng([d.seed, run])
        factors = {k: f * (1.0 + d.varying * rng.standard_normal()) for k, f in truth.factors.items()}
        factors["u_dot_max"] = 1.0
        p = _plant(truth, truth.effects, truth.outside, factors)
        command = _programme(run, d, np.random.default_rng([d.seed, run, 1]))
        at, out = _dense(d, command, p, _walks(d.seed, run, d.duration + _BEFORE * d.moving))
        sensed = _sensed(at, out, truth.effects, truth.outside)
        topics = dict.fromkeys(_TOPIC.values())
        off = dict(zip(topics, d.clocks * np.random.default_rng([d.seed, run, 3]).standard_normal(3), strict=True))
        signals, stamps = {}, {t: off[t] + _stamped(t, _instants(t, d), truth.effects, rng) for t in topics}
        for signal, values in sensed.items():
            topic = _TOPIC[signal]
            y = np.interp(_instants(topic, d), at, values)
            shocks = rng.standard_t(4, y.size) / math.sqrt(2.0) if d.tails else rng.standard_normal(y.size)
            y = y + d.noise[signal] * (shocks + 0.3 * (d.varying > 0.0) * rng.standard_normal())
            y = y + 25.0 * d.noise[signal] * (rng.random(y.size) < d.outliers) * rng.standard_normal(y.size)
            y = _converted(signal, y, truth.effects, rng)
            if "dropped_samples" in truth.effects:
                kept = rng.random(y.size) >= truth.effects["dropped_samples"]["share"]
                kept[0] = True
                y = y[np.maximum.accumulate(np.where(kept, np.arange(y.size), 0))]
            signals[signal] = Samples(stamps[topic], y)
        throttle = Samples(_stamped("throttle", command.time, truth.effects, rng), command.values)
        begin = min(throttle.time[0], *(s.time[0] for s in signals.values()))
        throttle = Samples(throttle.time - begin, throttle.values)
        signals = {name: Samples(s.time - begin, s.values) for name, s in signals.items()}
        hold = ("linear" if d.linear else "previous") if d.told else None
        found.append(SyntheticRun(name=f"run_{run}", throttle=throttle, signals=signals, hold=hold))
    return found


def _clean(truth: Truth, effects: Sizes, outside: Sizes, factors: Mapping[str, float], push: Push | None) -> Array:
    d: _Drawn = truth.drawn
    p = _plant(truth, effects, outside, factors)
    rows = []
    for run in range(d.runs):
        command = _programme(run, d, np.random.default_rng([d.seed, run, 1]))
        at, out = _dense(d, command, p, push)
        alignment = effects.get("log_alignment", {})
        for signal, values in _sensed(at, out, effects, outside).items():
            topic = _TOPIC[signal]
            late = alignment.get({"ambient": "flow"}.get(topic, topic), 0.0) - alignment.get("throttle", 0.0)
            when = _instants(topic, d)
            when = when - late - effects.get("clock_drift", {}).get("rate", 0.0) * when
            y = np.interp(when, at, values)
            rows.append(_converted(signal, y, {k: s for k, s in effects.items() if k != "flow_spikes"},
                                   np.random.default_rng(0)) / d.noise[signal])  # fmt: skip
    return np.concatenate(rows).reshape(d.runs, -1)


GENERATOR = Generator(
    name="lab",
    title="HL and HQ by Runge-Kutta at 0.5 ms, topics on clocks of their own, rotor and water pushed at random",
    draw=_draw,
    record=_record,
    clean=_clean,
)
