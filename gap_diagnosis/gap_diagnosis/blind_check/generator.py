"""Recordings of one thruster with a hidden truth: physics, sensors, log. Arrays in, arrays out."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.blind_check.catalogue import EFFECTS, OUTSIDE, Kind
from gap_diagnosis.blind_check.equations import Known, Outside, Thruster
from gap_diagnosis.blind_check.integrator import CHANNELS, GATE_PERIOD, SUBSTEPS, integrate
from gap_diagnosis.blind_check.recording import Colour, Recorded, clean_channels, log
from gap_diagnosis.blind_check.signals import PERIOD

__all__ = ["NOISE", "GeneratedRun", "Truth", "generate", "known_sizes", "outside_sizes", "thruster_of"]

Array = NDArray[np.float64]
Sizes = Mapping[str, Mapping[str, float]]

NOISE = {"n": 1.2, "ambient": 0.006, "thrust": 0.25, "torque": 4e-4}
"""Standard deviations of the sensors' white noise: rad/s, m/s, N, N m."""

_SPEED_LOOP = (0.019, 0.004, 0.04, 4.5)
_GATE_OPEN, _GATE_CLOSED = 1.5, 1.0


@dataclass(frozen=True, kw_only=True)
class Truth:
    """What is hidden in a case.

    Attributes:
        model: hl, hq or simplified.
        parameters: true values by the names of the parameter sets, SI units.
        effects: sizes of effects of the library, by id and parameter.
        outside: sizes of effects of no library, by id and parameter.
        colour: coloured disturbances, or none.
    """

    model: str
    parameters: Mapping[str, float]
    effects: Sizes = field(default_factory=dict)
    outside: Sizes = field(default_factory=dict)
    colour: Colour | None = None


@dataclass(frozen=True, kw_only=True)
class GeneratedRun:
    """One recording and its noise-free counterpart.

    Attributes:
        name: of the run.
        recorded: throttle, n, ambient, thrust, torque with stamps [s] from the start of the run.
        clean: what ideal sensors (with the effect) would have written, by channel, sample by sample as recorded.
        states: true n, v, U and acting throttle u at the instants k PERIOD.
    """

    name: str
    recorded: Mapping[str, Recorded]
    clean: Mapping[str, Array]
    states: Mapping[str, Array]


def thruster_of(model: str, parameters: Mapping[str, float]) -> Thruster:
    """Return the coefficients of a parameter set; HL and HQ have one thrust and one torque slope for both signs."""
    values = {name: float(value) for name, value in parameters.items()}
    if model in ("hl", "hq"):
        c_T, c_Q = values.pop("c_n_T"), values.pop("c_n_Q")
        values.update(c_T1=c_T, c_T2=c_T, c_Q1=c_Q, c_Q2=c_Q)
    return Thruster(**values)


def generate(truth: Truth, programme: Mapping[str, Array], *, closed_loop: bool, seed: int) -> list[GeneratedRun]:
    """Return the recordings of a campaign.

    Args:
        truth: what is hidden.
        programme: throttle [V] by run, shape (N,), `PERIOD` apart; desired speeds [rad/s] where `closed_loop`.
        closed_loop: a speed loop makes the throttle from the measured speed.
        seed: of noise, gates and all else that is random.
    """
    streams = np.random.default_rng(seed).spawn(len(programme))
    return [
        _run(truth, name, np.asarray(values, dtype=np.float64), closed_loop, rng)
        for (name, values), rng in zip(programme.items(), streams, strict=True)
    ]


def _run(truth: Truth, name: str, values: Array, closed_loop: bool, rng: np.random.Generator) -> GeneratedRun:
    count = values.size
    # drawn in this order always, so that an effect changes nothing else in a case
    noise = {channel: std * rng.standard_normal(count) for channel, std in NOISE.items()}
    gates = _gates(rng, count) if "ventilation" in truth.effects else np.ones(round(count * PERIOD / GATE_PERIOD) + 2)
    push = np.zeros((2, count + 1))
    if truth.colour is not None:
        for channel, std in NOISE.items():
            noise[channel] += std * truth.colour.outputs * truth.colour.wander(count, PERIOD, rng)
        push[0] = truth.colour.rotor * truth.colour.wander(count + 1, PERIOD, rng)
    commands = np.zeros(count) if closed_loop else values.copy()
    out = np.empty((len(CHANNELS), count))
    flow = np.empty(count * SUBSTEPS)
    integrate(
        thruster_of(truth.model, truth.parameters),
        known_sizes(truth.effects),
        outside_sizes(truth.outside),
        PERIOD,
        commands,
        values if closed_loop else np.empty(0),
        _SPEED_LOOP,
        gates,
        push,
        noise["n"],
        flow,
        out,
    )
    true = dict(zip(CHANNELS, out, strict=True))
    true["ambient_fine"] = flow
    clean = clean_channels(true, truth.effects, truth.outside, PERIOD)
    noisy = {channel: clean[channel] + noise[channel] for channel in ("ambient", "thrust", "torque")}
    noisy["n"] = true["tach_noisy"]
    recorded, written = log(commands, noisy, clean, truth.effects, truth.outside, PERIOD, rng)
    states = {key: true[key] for key in ("n", "v", "ambient", "u")}
    return GeneratedRun(name=name, recorded=recorded, clean=written, states=states)


def known_sizes(effects: Sizes) -> Known:
    """Return the sizes of the effects in the plant; those of sensors and log are passed over."""
    return Known(**_fields(effects, EFFECTS, Known._fields))


def outside_sizes(effects: Sizes) -> Outside:
    """Return the sizes of effects that no library knows, in the plant."""
    return Outside(**({"gain_step_time": math.inf} | _fields(effects, OUTSIDE, Outside._fields)))


def _fields(effects: Sizes, table: Mapping[str, Kind], fields: tuple[str, ...]) -> dict[str, float]:
    """Return the sizes by field: the effect's id for its size, id and name for what else it has."""
    given = {
        name if parameter == table[name].size.name else f"{name}_{parameter}": float(value)
        for name, parameters in effects.items()
        for parameter, value in parameters.items()
    }
    return {name: value for name, value in given.items() if name in fields}


def _gates(rng: np.random.Generator, count: int) -> Array:
    """Return 0 while air may be drawn, else 1: a two-state Markov process, every `GATE_PERIOD`."""
    gates = np.ones(round(count * PERIOD / GATE_PERIOD) + 2)
    at, shut = 0.0, bool(rng.random() < 0.5)
    while at < gates.size * GATE_PERIOD:
        lasts = float(rng.exponential(_GATE_CLOSED if shut else _GATE_OPEN))
        if shut:
            gates[int(at / GATE_PERIOD) : int((at + lasts) / GATE_PERIOD)] = 0.0
        at, shut = at + lasts, not shut
    return gates
