"""Whitened innovations of recordings under any point of the model."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.gains import Gains, Motion, Noises, filter_gains, motion_of, rotor_gains, slopes
from gap_diagnosis.vehicle.inflow import Inflow, inflow
from gap_diagnosis.vehicle.instants import as_read, counted, instant_at, read_later, shifted
from gap_diagnosis.vehicle.log import VehicleLog, held
from gap_diagnosis.vehicle.model import Built, Model
from gap_diagnosis.vehicle.onset import pieces
from gap_diagnosis.vehicle.running import Running, State, followed, outputs
from gap_diagnosis.vehicle.unknowns import Key
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from rov_sim.vehicle.innovations import PARTS, followed_charge, states_of, states_width
from rov_sim.vehicle.kernel import COARSE, FINE
from rov_sim.vehicle.plant import VehicleSettings
from rov_sim.vehicle.truth import VehicleState
from thruster_model.equations.rotation_vector import rotation
from thruster_model.vehicle_coefficients import VehicleCoefficients

__all__ = [
    "Filtered", "Ground", "Prepared", "at_rest", "filtered", "foreseen", "foreseen_deviations", "grounded",
    "initial_state", "prepared_on", "prepared_with", "rotor_decay", "slopes_along", "starting", "wrench_of",
]  # fmt: skip

Array = NDArray[np.float64]
_LOGS = 64
"""Recordings whose beginning is kept: a fit asks for the same ones ever again."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Filtered:
    """What one run of the filter gives: innovations (K, 13), (K, N), (K, 2), states as `innovations` fills them."""

    body: Array
    rotor: Array
    battery: Array
    states: Array
    done: bool


@dataclass(frozen=True, kw_only=True, eq=False)
class Prepared:
    """One log with gains for it.

    Attributes:
        log, run: the recording and its number; late: by how many parts of a period its instants lie before the stamps
            of what an IMU tells.
        gains, noises: of the body's filter.
        speed_gains, spread: of the rotors'.
        base: what the filter gives at the point for which the gains were made.
        weights: (K, M) of whitened readings, below 1 where one is an outlier.
    """

    log: VehicleLog
    run: int
    gains: Gains
    noises: Noises
    speed_gains: Array
    spread: Array
    base: Filtered
    late: int = 0
    weights: Array = field(default_factory=lambda: np.ones((0, 0)))


class Ground(NamedTuple):
    """One log at a point of the model: as given and with its commands shifted, its number, by how many parts of a
    period its instants are early, what the model is there from which instant on, and how the vehicle moves along states
    of a filter."""

    given: VehicleLog
    log: VehicleLog
    run: int
    late: int
    parts: list[tuple[int, Built]]
    motion: Motion


@lru_cache(maxsize=_LOGS)
def initial_state(log: VehicleLog) -> VehicleState:
    """Return a vehicle as it is when the recording begins, as far as sensors tell."""
    q = log.attitude[np.isfinite(log.attitude).all(axis=1)]
    depth = log.told[np.isfinite(log.told[:, 9]), 9]
    velocity = np.zeros(6)
    for at, to in ((3, 3), (10, 0)):
        first = log.told[np.isfinite(log.told[:, at : at + 3]).all(axis=1), at : at + 3]
        if len(first):
            velocity[to : to + 3] = first[0]
    thrusters = np.zeros((log.thrusters, 4))
    speeds = np.nan_to_num(log.speeds[0])
    thrusters[:, 0] = speeds if log.signed else speeds * np.sign(log.commands[0, 0])
    thrusters[:, 2] = log.commands[0, 0]
    return VehicleState(
        np.array([0.0, 0.0, depth[0] if len(depth) else 0.0]),
        q[0] if len(q) else np.array([1.0, 0.0, 0.0, 0.0]),
        velocity,
        thrusters,
    )


def filtered(
    model: Model,
    prepared: Prepared,
    values: Mapping[Key, float],
    effects: Sequence[ActiveVehicleEffect] = (),
    extra: Array | None = None,
    *,
    coarse: bool = False,
) -> Filtered:
    """Return the innovations of one log at a point of the model.

    Args:
        model, prepared: of the log.
        values, effects: the point.
        extra: wrenches (K, 6) beside.
        coarse: with steps of half the cost, whose errors cancel in a difference of two coarse runs: for slopes.
    """
    log = prepared.log
    parts = _built(model, log, prepared.run, values, effects)
    _, built = parts[0]
    later = built.sensors.imu_late / log.period - prepared.late / PARTS
    if abs(later) >= rules.REACH:  # gains were made for readings that are near their instants
        log = read_later(log, round(later))
    log = shifted(log, values, effects)
    return _run(
        log, parts, prepared.gains.gains, prepared.speed_gains, prepared.noises.time, extra, followed(log, built),
        coarse=coarse,
    )  # fmt: skip


def _run(
    log: VehicleLog, parts: Sequence[tuple[int, Built]], gains: Array, speed_gains: Array, time: float,
    extra: Array | None, charge: Array, *, coarse: bool = False,
) -> Filtered:  # fmt: skip
    """Return what the filter gives; parts: the model from which instant on, the first of them 0."""
    out = outputs(log.count, log.thrusters)
    keep = np.exp(-log.period / time) ** np.arange(log.count + 1)
    ends = [*(first for first, _ in parts[1:]), log.count]
    state: State | None = None
    for (first, built), last in zip(parts, ends, strict=True):
        filter_ = Running(built, log.period, charge)
        if state is not None:
            filter_.state = state
        at = slice(first, last)
        done = filter_.run(
            log if len(parts) == 1 else log.part(first, last), gains[at], speed_gains[at], keep[: last - first + 1],
            [each[at] for each in out], None if extra is None else extra[at], COARSE if coarse else FINE,
        )  # fmt: skip
        if not done:
            break
        state = filter_.state
    return Filtered(body=out[0], rotor=out[1], battery=out[2], states=out[3], done=done)


def _built(
    model: Model, log: VehicleLog, run: int, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect]
) -> list[tuple[int, Built]]:  # fmt: skip
    """Return the model for each part of a log in which the same effects are on, with the instant where it begins."""
    initial = initial_state(log)
    return [
        (first, model.built(values, on, run=run, signed=log.signed, initial=initial))
        for first, on in pieces(effects, run, log.cut, log.count)
    ]


def foreseen(
    model: Model, like: VehicleLog, throttles: Array, values: Mapping[Key, float],
    effects: Sequence[ActiveVehicleEffect] = (),
) -> tuple[VehicleLog, Array]:  # fmt: skip
    """Return what sensors would tell of a vehicle that begins at rest, without noise, and its states (K, 19 + 3 N).

    Args:
        model: with its point, values and effects.
        like: a recording with the same sensors, at the same instants; where it ends it begins anew.
        throttles: (K, N) [V].
    """
    K, N = throttles.shape
    row = np.arange(K) % like.count
    blank = replace(
        like, name="foreseen", commands=held(throttles), attitude=np.tile([1.0, 0.0, 0.0, 0.0], (K, 1)),
        told=np.zeros((K, 13)), speeds=np.zeros((K, N)), battery=np.zeros((K, 2)),
        lateness=np.zeros((K, like.lateness.shape[1])),
    )  # fmt: skip
    built = model.built(values, effects, run=-1, signed=like.signed, initial=initial_state(blank))
    # without gains the innovations are what is expected, with the other sign
    ran = _run(
        shifted(blank, values, effects),
        [(0, built)],
        np.zeros((K, 16, 13)),
        np.zeros((K, N)),
        1.0,
        None,
        followed_charge(np.inf),
    )
    # the blank attitude is none: its innovation is the way back
    attitude = np.array([rotation(tuple(turn)) for turn in -ran.body[:, :3]])
    told = -ran.body
    told[~np.isfinite(like.told[row])] = np.nan
    attitude[~np.isfinite(like.attitude[row])] = np.nan
    speeds, battery = -ran.rotor, -ran.battery
    speeds[~np.isfinite(like.speeds[row])] = np.nan
    battery[~np.isfinite(like.battery[row])] = np.nan
    return replace(blank, attitude=attitude, told=told, speeds=speeds, battery=battery), ran.states


def slopes_along(
    model: Model, log: VehicleLog, states: Array | None, settings: VehicleSettings, before: Array | None = None
) -> tuple[Array, Array, Inflow]:  # fmt: skip
    """Return slopes (`gains.slopes`) and what water through thrusters does along states of a filter (K, 19 + 3 N).

    states: None: at rest, but for what a gyro tells; before: of `inflow`.
    """
    q = _filled(log.attitude)
    there = states_of(np.zeros((log.count, states_width(log.thrusters))) if states is None else np.nan_to_num(states))
    nu = there.nu.copy()
    if states is None:
        nu[:, 3:] = np.nan_to_num(log.told[:, 3:6])
    c = settings.coefficients
    water = inflow(settings, nu, there.speeds, there.flows, log.period, before)
    places = (np.asarray(getattr(model.sensors, s).position) for s in ("imu", "velocity", "depth"))
    return *slopes(q, nu, water.slopes, c, *places), water


def wrench_of(c: VehicleCoefficients, thrusts: Array) -> Array:
    """Return the covariance (K, 6, 6) of the wrench of thrusts that deviate by (K, N) [N]."""
    return (c.K_t * thrusts[:, None] ** 2) @ c.K_t.T


def _filled(q: Array) -> Array:
    out = q.copy()
    good = np.isfinite(q).all(axis=1)
    if not good.any():
        return np.tile([1.0, 0.0, 0.0, 0.0], (len(q), 1))
    k = np.maximum.accumulate(np.where(good, np.arange(len(q)), -1))
    return out[np.where(k >= 0, k, int(np.argmax(good)))]


def rotor_decay(model: Model, period: float) -> Array:
    """Return the share of a disturbance of each rotor that is left after a period (N,)."""
    return np.array([np.exp(-min(float(s.coefficients.k_n), 50.0) * period) for s in model.sets])


def starting(A: Array, H: Array, log: VehicleLog, first: int) -> tuple[Array, Array, NDArray[np.bool_]]:
    """Return slopes (`gains.slopes`) and which channels tell (K, 13) where nothing counts before the first instant.

    A vehicle that starts in motion pushes through water whose axial flow is not known yet. How it accelerates and
    turns, taken for what a known thrust does, made velocities of 100 m/s in three samples (tuning seeds 1205, 1211).
    So at first neither tells the velocity.
    """
    there, A = log.telling.copy(), A.copy()
    there[:first, 6:9] = False
    A[:first, 3:9, 3:6] = 0.0
    return A, H, there


def at_rest(model: Model, log: VehicleLog, noises: Noises) -> NDArray[np.bool_]:
    """Return where rotors are at rest (K, N): not driven, and read as zero.

    What disturbs a rotor is its drive; at rest there is none. Corrected by a tachometer's noise there it would stir the
    axial flow, and an idle thruster in a stream drags from when it is stirred.
    """
    u = log.commands
    edges = np.array([(p.delta_u1, p.delta_u2) for p in (s.coefficients for s in model.sets)])
    undriven = np.all((u >= edges[:, 0]) & (u <= edges[:, 1]), axis=1)
    return undriven & (
        np.abs(np.nan_to_num(log.speeds)) < rules.MOST_DEVIATIONS * np.nan_to_num(noises.speed, nan=np.inf)
    )


def grounded(
    model: Model, log: VehicleLog, run: int, values: Mapping[Key, float],
    effects: Sequence[ActiveVehicleEffect] = (), states: Array | None = None,
) -> Ground:  # fmt: skip
    """Return a log with the slopes of this point of the model, along these states of a filter; None: at rest."""
    parts = _built(model, log, run, values, effects)
    late = max(round(PARTS * parts[-1][1].sensors.imu_late / log.period), 0)
    given = log
    if late:
        given = as_read(log, late)
        parts = _built(model, given, run, values, effects)
    log, (_, built) = shifted(given, values, effects), parts[-1]
    A, H, water = slopes_along(model, log, states, built.settings)
    untold = log.count if states is None else instant_at(log, rules.START)
    slopes_there = starting(A, H, log, untold)
    doubts = wrench_of(built.settings.coefficients, water.doubts)
    return Ground(given, log, run, late, parts, motion_of(*slopes_there, log.period, doubts))


def prepared_on(model: Model, ground: Ground, noises: Noises) -> Prepared:
    """Return a log with gains for these noises, made at this point of the model."""
    log, (_, built) = ground.log, ground.parts[-1]
    gains = filter_gains(ground.motion, noises, first=counted(log, ground.late))
    driven = np.isfinite(log.speeds) & ~at_rest(model, log, noises)
    for first, there in ground.parts:  # a rotor that has stopped is not stirred either
        driven[first:] &= there.settings.coefficients.turning != 0.0
    speed_gains, spread, _ = rotor_gains(driven, rotor_decay(model, log.period), noises)
    base = _run(log, ground.parts, gains.gains, speed_gains, noises.time, None, followed(log, built))
    return Prepared(
        log=ground.given, run=ground.run, gains=gains, noises=noises, speed_gains=speed_gains, spread=spread, base=base,
        late=ground.late,
    )  # fmt: skip


def prepared_with(
    model: Model, log: VehicleLog, run: int, noises: Noises, values: Mapping[Key, float],
    effects: Sequence[ActiveVehicleEffect] = (), states: Array | None = None,
) -> Prepared:  # fmt: skip
    """Return a log with gains for these noises, made at this point of the model, see `grounded`."""
    return prepared_on(model, grounded(model, log, run, values, effects, states), noises)


def foreseen_deviations(
    model: Model, prepared: Prepared, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect],
    windows: Sequence[tuple[int, int, int]],
) -> Array:  # fmt: skip
    """Return the deviations (W, 13) that readings should have from free runs of this point of the model.

    windows: instants each: where a filter begins anew, from which on nothing corrects it, where it ends.
    """
    log = shifted(prepared.log, values, effects)
    built = model.built(values, effects, run=prepared.run, signed=log.signed, initial=initial_state(prepared.log))
    A, H, water = slopes_along(model, log, prepared.base.states, built.settings)
    doubts = wrench_of(built.settings.coefficients, water.doubts)
    motion = motion_of(*starting(A, H, log, 0), log.period, doubts)
    out = np.empty((len(windows), 13))
    for row, (first, free, last) in enumerate(windows):
        told = motion.there[first:last].copy()
        told[free - first :] = False
        P = filter_gains(motion.part(first, last)._replace(there=told), prepared.noises).last
        out[row] = np.sqrt(np.einsum("ij,jl,il->i", H[last], P, H[last]) + prepared.noises.channels**2)
    return out
