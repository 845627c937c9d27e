"""The blind check's own thruster and sensors, disturbed, on clocks of their own, and with several effects at once.

Integrated by Heun's method at 0.25 ms and recorded every 5 ms; topics are thinned to rates of their own. What `cases`
draws for the blind check is drawn here by the same ranges, and where a form may differ, it is the catalogue's.
"""

import math
from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.blind_check.catalogue import EFFECTS, OUTSIDE, Kind, Spread, acting_in
from gap_diagnosis.blind_check.generator import NOISE, known_sizes, outside_sizes, thruster_of
from gap_diagnosis.blind_check.integrator import CHANNELS, GATE_PERIOD, integrate
from gap_diagnosis.blind_check.recording import FLOW_SPIKE, Colour, clean_channels, stamps_of
from gap_diagnosis.scoreboard.case import Generator, Push, Samples, Sizes, SyntheticRun, Truth
from thruster_model.parameter_set_io import load_parameter_set

__all__ = ["GENERATOR"]

Array = NDArray[np.float64]
_TICK = 0.005  # [s]
_SUBSTEPS = 20
_LEAD_IN = 3.0  # [s], a multiple of the tick
_SEED = 907
_CLASSES = {"none": 0, "one": 1, "two": 2, "many": 3, "outside": 4}
_SIGNALS = {"n": "speed", "ambient": "ambient", "thrust": "thrust", "torque": "torque"}
_TOPICS = {"n": "speed", "ambient": "flow", "thrust": "load", "torque": "load"}
_SMOOTH = tuple(
    name
    for name, kind in EFFECTS.items()
    if not kind.size.falls and kind.size.lower < kind.size.upper and kind.block not in ("log",)
    and name not in ("ventilation", "flow_spikes", "tach_quantization", "tach_dropout", "command_quantization")
)  # fmt: skip
"""Effects of which several small ones are drawn together."""


class _Conditions(NamedTuple):
    seed: int
    duration: float
    runs: int
    linear: bool
    told: bool
    every: Mapping[str, int]  # ticks between samples, by topic
    offset: Mapping[str, int]
    noise: Mapping[str, float]
    moving: bool
    memory: float
    push: tuple[float, float]
    varying: float
    outliers: float
    clocks: float  # [s] deviation of a topic's clock in a run


def _draw(kind: str, index: int, whole: bool) -> Truth:
    rng = np.random.default_rng([_SEED, _CLASSES[kind], index])
    model = str(rng.choice(["hl", "hq", "simplified"], p=[0.6, 0.3, 0.1]))
    effects, outside = {}, {}
    if kind == "outside":
        name = sorted(OUTSIDE)[index % len(OUTSIDE)]
        model = model if model not in OUTSIDE[name].inert_in else "hl"
        outside[name] = _sizes(name, OUTSIDE[name], rng, 1.0)
    elif kind != "none":
        pool = list(acting_in(model, EFFECTS))
        count = {"one": 1, "two": 2}.get(kind) or int(rng.integers(3, 7))
        names = [str(n) for n in rng.permutation([n for n in pool if n in _SMOOTH] if kind == "many" else pool)[:count]]
        if kind == "one":
            names = [list(EFFECTS)[index % len(EFFECTS)]]
            model = model if model not in EFFECTS[names[0]].inert_in else "hl"
        effects = {name: _sizes(name, EFFECTS[name], rng, 0.4 if kind == "many" else 1.0) for name in names}
    nominal = load_parameter_set(model).values
    factors = {name: float(1.0 + 0.05 * np.clip(rng.standard_normal(), -2.5, 2.5)) for name in nominal}
    factors["u_dot_max"] = 1.0
    topics = ("throttle", "speed", "flow", "load")
    every = {topic: int(rng.choice([1, 2, 4, 5, 8, 10, 20])) for topic in topics}
    memory, disturbed = float(rng.uniform(0.5, 5.0)), bool(rng.random() < 0.75)
    levels = disturbed * rng.uniform(0.2, 2.0, 2) * [NOISE["n"], NOISE["ambient"]]
    push = [float(x * math.sqrt(k * (1.0 / memory + k))) for x, k in zip(levels, (30.0, 0.5), strict=True)]
    conditions = _Conditions(
        seed=int(rng.integers(2**31)),
        duration=30.0 if whole else 15.0,
        runs=4 if whole else 3,
        linear=bool(rng.random() < 0.35),
        told=bool(rng.random() < 0.5),
        every=every,
        offset={topic: int(rng.integers(ticks)) for topic, ticks in every.items()},
        noise={name: size * float(rng.uniform(0.6, 1.6)) for name, size in NOISE.items()},
        moving=bool(rng.random() < 0.3),
        memory=memory,
        push=(push[0], push[1]),
        varying=float(rng.choice([0.0, 0.003, 0.008])),
        outliers=float(rng.choice([0.0, 0.0, 0.002])),
        clocks=0.002 * float(np.random.default_rng([_SEED, _CLASSES[kind], index, 1]).exponential()),
    )
    return Truth(
        generator="tank", kind=kind, index=index, model=model, effects=effects, outside=outside, factors=factors,
        drawn=conditions,
    )  # fmt: skip


def _sizes(name: str, kind: Kind, rng: np.random.Generator, reach: float) -> dict[str, float]:
    """Return sizes within `reach` of the range's upper end; of late stamps for a channel that is drawn."""
    found = {
        spread.name: _one(spread, rng, reach if k == 0 else 1.0) for k, spread in enumerate((kind.size, *kind.more))
    }
    return {str(rng.choice(["throttle", "speed", "load"])): found[""]} if name == "log_alignment" else found


def _one(spread: Spread, rng: np.random.Generator, reach: float) -> float:
    upper = spread.lower + reach * (spread.upper - spread.lower)
    size = float(rng.uniform(spread.lower, upper))
    if spread.law == "log":
        size = float(spread.lower * (upper / spread.lower) ** rng.random())
    if not spread.signed or rng.random() < 0.5:
        return size
    return -size * (1.0 if spread.most_negative is None else spread.most_negative / spread.upper)


def _commands(run: int, given: _Conditions) -> tuple[Samples, Array]:
    """Return the commands as logged, and what reaches the device in every tick [V], lead-in included."""
    rng = np.random.default_rng([given.seed, run, 2])
    period = _TICK * given.every["throttle"]
    at: Array = np.asarray(period * np.arange(int(given.duration / period) + 1), dtype=np.float64)
    top = float(rng.uniform(2.5, 4.0))
    if run % 3 == 0:
        u = rng.uniform(-top, top, 99)[np.searchsorted(np.cumsum(rng.uniform(0.6, 3.0, 99)), at)]
    elif run % 3 == 1:
        waves = np.geomspace(0.06, 1.0, 9) * rng.uniform(0.9, 1.1, 9)
        u = np.sum(np.sin(2.0 * np.pi * (np.outer(at, waves) + rng.random(9))), axis=1)
        u *= top / np.max(np.abs(u))
    else:
        knots = np.concatenate(([0.0], np.cumsum(rng.uniform(1.0, 5.0, 40))))
        u = np.interp(at, knots, np.concatenate(([0.0], top * rng.uniform(0.3, 1.0, 40) * (-1.0) ** np.arange(40))))
    if not given.moving:
        u = np.where(at < 1.0, 0.0, u)
    ticks: Array = np.asarray(_TICK * np.arange(round(given.duration / _TICK)), dtype=np.float64)
    if given.linear:  # in the middle of a tick
        acting = np.interp(ticks + 0.5 * _TICK, at, u)
    else:
        acting = u[np.searchsorted(at, ticks + 1e-9, side="right") - 1]
    lead = np.full(round(_LEAD_IN / _TICK) if given.moving else 0, u[0])
    return Samples(at, np.asarray(u)), np.concatenate((lead, acting))


def _walks(seed: int, run: int) -> Push:
    """Return random paths."""
    rng = np.random.default_rng([seed, run])

    def walk(_: int, at: Array, memory: float) -> Array:
        return Colour(outputs=0.0, rotor=0.0, memory=memory).wander(at.size, _TICK, rng)

    return walk


def _channels(
    truth: Truth, run: int, commands: Array, effects: Sizes, outside: Sizes, factors: Mapping[str, float],
    push: Push | None,
) -> tuple[dict[str, Array], Array]:  # fmt: skip
    """Return (readings without noise by channel, the tachometer with its noise), (N,) each, lead-in cut off."""
    given: _Conditions = truth.drawn
    count = commands.size
    rng = np.random.default_rng([given.seed, run, 3])
    gates = np.ones(round(count * _TICK / GATE_PERIOD) + 2)
    if "ventilation" in effects:
        edges = np.cumsum(rng.exponential(1.2, 80))
        gates = (np.searchsorted(edges, GATE_PERIOD * np.arange(gates.size)) % 2).astype(np.float64)
    shove = np.zeros((2, count + 1))
    if push is not None and any(given.push):
        for row, size in enumerate(given.push):
            shove[row] = size * push(row, np.asarray(_TICK * np.arange(count + 1)), given.memory)
    noise = given.noise["n"] * rng.standard_normal(count)
    out, flow = np.empty((len(CHANNELS), count)), np.empty(count * _SUBSTEPS)
    nominal = load_parameter_set(truth.model).values
    thruster = thruster_of(truth.model, {name: value * factors.get(name, 1.0) for name, value in nominal.items()})
    integrate(
        thruster, known_sizes(effects), outside_sizes(outside), _TICK, commands.copy(), np.empty(0),
        (0.0, 0.0, 0.0, 0.0), gates, shove, noise, flow, out,
    )  # fmt: skip
    true = dict(zip(CHANNELS, out, strict=True)) | {"ambient_fine": flow}
    cut = round(_LEAD_IN / _TICK) if given.moving else 0
    clean = clean_channels(true, effects, outside, _TICK, begins=cut * _TICK)
    return {name: values[cut:] for name, values in clean.items()}, true["tach_noisy"][cut:]


def _record(truth: Truth) -> list[SyntheticRun]:
    given: _Conditions = truth.drawn
    runs = []
    for run in range(given.runs):
        rng = np.random.default_rng([given.seed, run])
        factors = {k: f * float(1.0 + given.varying * rng.standard_normal()) for k, f in truth.factors.items()}
        command, acting = _commands(run, given)
        clean, tachometer = _channels(
            truth, run, acting, truth.effects, truth.outside, factors, _walks(given.seed, run)
        )
        ticks: Array = np.asarray(_TICK * np.arange(tachometer.size), dtype=np.float64)
        off: dict[str, float] = {}
        clocks = np.random.default_rng([given.seed, run, 1])
        signals = {}
        for name, values in clean.items():
            topic = _TOPICS[name]
            late = off.setdefault(topic, given.clocks * float(clocks.standard_normal()))
            kept = np.arange(given.offset[topic], ticks.size, given.every[topic])
            at = ticks[kept]
            y = tachometer[kept] if name == "n" else values[kept] + given.noise[name] * rng.standard_normal(kept.size)
            if name == "ambient" and "flow_spikes" in truth.effects:
                hit = rng.random(y.size) < truth.effects["flow_spikes"]["share"]
                y = y + np.where(hit, FLOW_SPIKE * rng.standard_normal(y.size), 0.0)
            if "dropped_samples" in truth.effects:
                fresh = rng.random(y.size) >= truth.effects["dropped_samples"]["share"]
                fresh[0] = True
                y = y[np.maximum.accumulate(np.where(fresh, np.arange(y.size), 0))]
            y = y + 20.0 * given.noise[name] * (rng.random(y.size) < given.outliers) * rng.standard_normal(y.size)
            signals[_SIGNALS[name]] = (late + stamps_of(at, topic, truth.effects, truth.outside, rng), y)
        sent = stamps_of(command.time, "throttle", truth.effects, truth.outside, rng)
        origin = min(float(sent[0]), *(float(at[0]) for at, _ in signals.values()))
        runs.append(
            SyntheticRun(
                name=f"run_{run}",
                throttle=Samples(sent - origin, command.values),
                signals={name: Samples(at - origin, y) for name, (at, y) in signals.items()},
                hold=("linear" if given.linear else "previous") if given.told else None,
            )
        )
    return runs


def _clean(truth: Truth, effects: Sizes, outside: Sizes, factors: Mapping[str, float], push: Push | None) -> Array:
    given: _Conditions = truth.drawn
    rows = []
    shift = effects.get("log_alignment", {})
    rate = effects.get("clock_drift", {}).get("rate", 0.0)
    for run in range(given.runs):
        clean, _ = _channels(truth, run, _commands(run, given)[1], effects, outside, factors, push)
        for name, values in clean.items():
            topic = _TOPICS[name]
            ticks: Array = np.asarray(_TICK * np.arange(values.size), dtype=np.float64)
            at = ticks[given.offset[topic] :: given.every[topic]]
            when = at * (1.0 - rate) - shift.get(topic, 0.0) + shift.get("throttle", 0.0)
            rows.append(np.interp(when, ticks, values) / given.noise[name])
    return np.concatenate(rows).reshape(given.runs, -1)


GENERATOR = Generator(
    name="tank",
    title="the blind check's thruster by Heun's method, disturbed, its topics thinned to rates of their own",
    draw=_draw,
    record=_record,
    clean=_clean,
)
