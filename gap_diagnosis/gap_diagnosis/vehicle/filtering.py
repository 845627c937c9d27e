"""Whitened innovations of recordings under any point of the model, and how their noises are learned from them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.gains import Gains, Noises, filter_gains, rotor_gains, slopes
from gap_diagnosis.vehicle.inflow import inflow
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Key, Model
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from rov_sim.vehicle.innovations import innovations
from rov_sim.vehicle.plant import sheet_of
from rov_sim.vehicle.truth import VehicleState

__all__ = [
    "Filtered", "Prepared", "at_rest", "filtered", "foreseen_deviations", "initial_state", "learned_from",
    "log_likelihood", "prepared", "prepared_with", "rotor_decay", "starting", "whitened",
]  # fmt: skip

Array = NDArray[np.float64]
_FARTHEST = 50.0  # deviations: beyond it a model is wrong, not more or less so


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
        log, run: the recording and its number.
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
    weights: Array = field(default_factory=lambda: np.ones((0, 0)))


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
    thrusters[:, 0] = speeds if log.signed else speeds * np.sign(log.throttles[0])
    thrusters[:, 2] = log.throttles[0]
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
) -> Filtered:
    """Return the innovations of one log at a point of the model; `extra`: wrenches (K, 6) beside."""
    log = _shifted(prepared.log, values, effects)
    built = model.built(values, effects, run=prepared.run, signed=log.signed, initial=initial_state(log))
    return _run(log, built, prepared.gains.gains, prepared.speed_gains, prepared.noises.time, extra)


def _shifted(
    log: VehicleLog, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect] = ()
) -> VehicleLog:  # fmt: skip
    """Return a log whose commands act later by what values and effects of the log say.

    Each is a mean over a shifted period, exact where commands are held.
    """
    late = np.full(log.count, values.get(("late",), 0.0))
    for effect in effects:
        if effect.id == "log_alignment":
            late -= effect.sizes["throttle"]
        elif effect.id == "clock_drift":
            late += effect.sizes["rate"] * log.period * np.arange(log.count)
    if not late.any():
        return log
    whole, share = np.divmod(late / log.period, 1.0)
    row = np.arange(log.count) - whole.astype(int)
    here, before = (log.throttles[np.clip(at, 0, log.count - 1)] for at in (row, row - 1))
    return replace(log, throttles=(1.0 - share[:, None]) * here + share[:, None] * before)


def _run(log, built, gains, speed_gains, time, extra):  # type: ignore[no-untyped-def]
    K, N = log.count, log.thrusters
    out = np.full((K, 13), np.nan), np.full((K, N), np.nan), np.full((K, 2), np.nan), np.full((K, 19 + 3 * N), np.nan)
    steps = built.settings.steps_in(log.period)
    kernel: Any = innovations
    done = kernel(
        sheet_of(built.settings), np.ascontiguousarray(log.throttles), steps, log.period / steps,
        np.zeros((K, 6)) if extra is None else extra, float(np.exp(-log.period / time)), *built.settings.tables,
        built.sensors, built.tach, log.attitude, log.told, log.speeds, log.battery, log.lateness, gains, speed_gains,
        *out,
    )  # fmt: skip
    return Filtered(body=out[0], rotor=out[1], battery=out[2], states=out[3], done=done == K)


def _instant(log: VehicleLog, start: float) -> int:
    """Return the instant of a time [s], within the first half."""
    return min(round(start / log.period), log.count // 2)


def _first(log: VehicleLog) -> int:
    """Return the first instant that counts: later where no sensor tells the velocity at the start."""
    return _instant(log, rules.START if log.there["velocity"] else rules.START_UNTOLD)


def whitened(prepared: Prepared, result: Filtered) -> Array:
    """Return innovations as independent numbers of deviation 1 where all is right, (K, 13 + N + 2); 0: nothing told."""
    e = np.nan_to_num(result.body)
    body = np.einsum("kij,kj->ki", prepared.gains.whitener, e)
    body[~np.isfinite(prepared.base.body)] = 0.0
    rotor = np.nan_to_num(result.rotor / prepared.spread)
    battery = np.nan_to_num(result.battery / prepared.noises.battery)
    r = np.clip(np.nan_to_num(np.concatenate((body, rotor, battery), axis=1)), -_FARTHEST, _FARTHEST)
    r[~np.isfinite(result.states).all(axis=1)] = _FARTHEST  # a filter that is lost foresees nothing
    r[: _first(prepared.log)] = 0.0
    return r * prepared.weights if prepared.weights.size else r


def _slopes_of(model: Model, log: VehicleLog, states: Array | None, built):  # type: ignore[no-untyped-def]
    q = _filled(log.attitude)
    nu = np.zeros((log.count, 6)) if states is None else np.nan_to_num(states[:, 7:13])
    if states is None:
        nu[:, 3:] = np.nan_to_num(log.told[:, 3:6])
    N, c = log.thrusters, built.settings.coefficients
    n, v = np.zeros((2, log.count, N))
    if states is not None:
        n, v = np.nan_to_num(states[:, 19 : 19 + N]), np.nan_to_num(states[:, 19 + 2 * N :])
    water = inflow(built.settings.thrusters, c, nu, n, v, log.period)
    places = (np.asarray(getattr(model.sensors, s).position) for s in ("imu", "velocity", "depth"))
    A, H = slopes(q, nu, water.slopes, c, *places)
    return A, H, (c.K_t * water.doubts[:, None] ** 2) @ c.K_t.T


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
    u = log.throttles
    edges = np.array([(p.delta_u1, p.delta_u2) for p in (s.coefficients for s in model.sets)])
    undriven = (u >= edges[:, 0]) & (u <= edges[:, 1])
    return undriven & (
        np.abs(np.nan_to_num(log.speeds)) < rules.MOST_DEVIATIONS * np.nan_to_num(noises.speed, nan=np.inf)
    )


def prepared_with(
    model: Model, log: VehicleLog, run: int, noises: Noises, values: Mapping[Key, float],
    effects: Sequence[ActiveVehicleEffect] = (), states: Array | None = None,
) -> Prepared:  # fmt: skip
    """Return a log with gains for these noises, made at this point of the model."""
    built = model.built(values, effects, run=run, signed=log.signed, initial=initial_state(log))
    given, log = log, _shifted(log, values, effects)
    A, H, doubts = _slopes_of(model, log, states, built)
    untold = log.count if states is None else _instant(log, rules.START)
    gains = filter_gains(*starting(A, H, log, untold), noises, log.period, doubts, first=_first(log))
    driven = np.isfinite(log.speeds) & ~at_rest(model, log, noises)
    speed_gains, spread, _ = rotor_gains(driven, rotor_decay(model, log.period), noises)
    base = _run(log, built, gains.gains, speed_gains, noises.time, None)
    return Prepared(
        log=given, run=run, gains=gains, noises=noises, speed_gains=speed_gains, spread=spread, base=base
    )  # fmt: skip


def foreseen_deviations(
    model: Model, prepared: Prepared, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect],
    windows: Sequence[tuple[int, int, int]],
) -> Array:  # fmt: skip
    """Return the deviations (W, 13) that readings should have from free runs of this point of the model.

    windows: instants each: where a filter begins anew, from which on nothing corrects it, where it ends.
    """
    log = _shifted(prepared.log, values, effects)
    built = model.built(values, effects, run=prepared.run, signed=log.signed, initial=initial_state(log))
    A, H, doubts = _slopes_of(model, log, prepared.base.states, built)
    A, H, there = starting(A, H, log, 0)
    out = np.empty((len(windows), 13))
    for row, (first, free, last) in enumerate(windows):
        told = there.copy()
        told[free:] = False
        part = slice(first, last)
        P = filter_gains(A[part], H[part], told[part], prepared.noises, log.period, doubts[part]).last
        out[row] = np.sqrt(np.einsum("ij,jl,il->i", H[last], P, H[last]) + prepared.noises.channels**2)
    return out


def log_likelihood(prepared: Prepared) -> float:
    """Return that of the body's innovations at the point for which the gains were made; outliers count as the bound."""
    if not prepared.base.done:
        return -np.inf
    body = np.einsum("kij,kj->ki", prepared.gains.whitener, np.nan_to_num(prepared.base.body))
    body[~np.isfinite(prepared.base.body)] = 0.0
    body = body[_first(prepared.log) :]
    return -0.5 * float(np.sum(np.minimum(body**2, rules.MOST_DEVIATIONS**2))) - 0.5 * prepared.gains.log_determinant


def prepared(
    model: Model,
    logs: Sequence[VehicleLog],
    values: Mapping[Key, float],
    effects: Sequence[ActiveVehicleEffect] = (),
    start: Noises | None = None,
    rounds: int = 4,
) -> list[Prepared]:
    """Return logs with gains, whose noises are the most likely ones at this point of the model, the same in all logs.

    The wrench's deviations follow by expectation and maximisation on the filter's estimates, its time from the
    likelihood over `CORRELATION_TIMES`: from `start` its own first, the others from where that ends. The best of all
    that was tried is kept.
    """
    if rounds == 0:
        noises = start or _first_noises(model, logs)
        first = _all_prepared(model, logs, noises, values, effects, [None] * len(logs))
        states = [p.base.states if p.base.done else None for p in first]
        second = _all_prepared(model, logs, noises, values, effects, states)
        return [_weighted(p if p.base.done else q) for p, q in zip(second, first, strict=True)]

    def learned(noises: Noises, rounds: int, patient: bool = False) -> tuple[float, list[Prepared]]:
        states: list[Array | None] = [None] * len(logs)
        best: tuple[float, list[Prepared]] | None = None
        for turn in range(rounds + 1):
            found = _all_prepared(model, logs, noises, values, effects, states)
            # a lost one is tried with the slopes of where it got, then with those of a vehicle at rest again
            states = [p.base.states if p.base.done or s is None else None for p, s in zip(found, states, strict=True)]
            done = all(p.base.done for p in found)
            score = sum(log_likelihood(p) for p in found)
            if best is None or score > best[0]:
                best = (score, found)
            # sensors are believed at first: else a filter may learn to do without one of them, and stay there
            channels = noises.channels
            if turn > 0 or done:
                noises = _learned(model, found) if done else _looser(noises)
            if done and patient and turn < rounds - 1:
                noises = noises._replace(channels=channels)
        assert best is not None
        return best

    if start is None:
        first = _first_noises(model, logs)
        ways = [
            learned(first._replace(time=time), rounds, patient)
            for time in rules.CORRELATION_TIMES
            for patient in (False, True)
        ]
    else:
        ways = [learned(start, rounds)]
        ended = learned_from(ways[0][1])
        ways += [learned(ended._replace(time=t), rounds // 4) for t in rules.CORRELATION_TIMES if t != start.time]
    return [_weighted(p) for p in max(ways, key=lambda way: way[0])[1]]


def learned_from(found: Sequence[Prepared]) -> Noises:
    """Return the noises that these logs are prepared with."""
    return found[0].noises


def _all_prepared(
    model: Model, logs: Sequence[VehicleLog], noises: Noises, values: Mapping[Key, float],
    effects: Sequence[ActiveVehicleEffect], states: Sequence[Array | None],
) -> list[Prepared]:  # fmt: skip
    return [prepared_with(model, log, k, noises, values, effects, states[k]) for k, log in enumerate(logs)]


def _looser(noises: Noises) -> Noises:
    """Return noises for a filter that has lost the vehicle: less faith in its readings, more room for the wrench."""
    return noises._replace(wrench=2.0 * noises.wrench, channels=1.5 * noises.channels)


def _weighted(prepared: Prepared) -> Prepared:
    size = np.abs(whitened(prepared, prepared.base))
    return replace(prepared, weights=np.minimum(rules.MOST_DEVIATIONS / np.maximum(size, 1e-9), 1.0))


def _first_noises(model: Model, logs: Sequence[VehicleLog]) -> Noises:
    def typical(name: str) -> Array:
        values = np.array([getattr(log, name) for log in logs])
        found = np.full(values.shape[1], np.nan)
        for j in np.flatnonzero(np.isfinite(values).any(axis=0)):
            found[j] = np.nanmedian(values[:, j])
        return found

    c = model.built({}).settings.coefficients
    weight = c.mass_matrix.diagonal()
    wrench = np.concatenate((0.02 * weight[:3], 0.05 * weight[3:]))
    floor = np.array([1e-4] * 3 + [1e-4] * 3 + [2e-3] * 3 + [1e-3] + [1e-3] * 3)
    battery = np.fmax(typical("battery_noise"), _battery_floor(logs))
    return Noises(
        wrench, 2.0, np.fmax(typical("noise"), floor), np.full(model.thrusters, 0.3),
        np.fmax(typical("speed_noise"), 0.05), np.where(np.isfinite(battery), battery, 1.0),
    )  # fmt: skip


def _battery_floor(logs: Sequence[VehicleLog]) -> Array:
    """Return the least deviations of voltage and current (2,): what a thruster draws is known in its form alone."""
    told = [log.battery[:, 1][np.isfinite(log.battery[:, 1])] for log in logs]
    drawn = max((float(np.ptp(each)) for each in told if each.size), default=0.0)
    return np.array([1e-3, max(rules.DRAWN * drawn, 1e-3)])


def _learned(model: Model, found: Sequence[Prepared]) -> Noises:
    """Return the noises that the filters' own estimates speak for."""
    old = found[0].noises
    w = np.concatenate(
        [(np.nan_to_num(p.base.states[:, 13:19]) ** 2 + p.gains.wrench_variance)[_first(p.log) :] for p in found]
    )
    least = np.array([rules.LEAST_FORCE] * 3 + [rules.LEAST_MOMENT] * 3)
    most = np.repeat(rules.MOST_PUSHED, 3) * model.vehicle.coefficients.mass_matrix.diagonal()
    wrench = np.clip(np.sqrt(_trimmed(w)), least, most)
    left, spread = [], []
    for p in found:
        # noise of a reading, given all readings up to it: R S^-1 e, and R - R S^-1 R beside it
        W = p.gains.whitener
        S_inverse = np.einsum("kji,kjl->kil", W, W)
        R = np.where(np.isfinite(p.base.body), old.channels**2, np.nan)
        far = (R * np.einsum("kij,kj->ki", S_inverse, np.nan_to_num(p.base.body))) ** 2
        left.append(far[_first(p.log) :])
        spread.append((R - R**2 * np.einsum("kii->ki", S_inverse))[_first(p.log) :])
    R = _trimmed(np.concatenate(left)) + _mean(np.concatenate(spread))
    channels = np.where(np.isfinite(R), np.sqrt(R), old.channels)
    channels = np.maximum(channels, 0.5 * found[0].noises.channels)
    e = np.concatenate([p.base.rotor[_first(p.log) :] for p in found])
    rotor, speed = old.rotor.copy(), old.speed.copy()
    S = np.concatenate([p.spread[_first(p.log) :] for p in found]) ** 2
    for i in range(e.shape[1]):
        if np.isfinite(e[:, i]).sum() > 50:
            excess = _trimmed(e[:, i : i + 1] ** 2)[0] - np.mean(S[:, i])
            rotor[i] = np.sqrt(max(rotor[i] ** 2 + 0.5 * excess, 1e-4))
    battery, floor = old.battery.copy(), _battery_floor([p.log for p in found])
    b = np.concatenate([p.base.battery for p in found])
    for j in range(2):
        if np.isfinite(b[:, j]).sum() > 20:
            battery[j] = max(float(np.nanstd(b[:, j])), floor[j])
    return Noises(wrench, old.time, channels, rotor, speed, battery)


def _trimmed(squares: Array) -> Array:
    """Return means of columns, values beyond 16 times the mean counting as that."""
    return _mean(np.minimum(squares, 16.0 * _mean(squares)))


def _mean(values: Array) -> Array:
    """Return the means of columns over what is there, NaN where nothing is."""
    there = np.isfinite(values)
    count = there.sum(axis=0)
    total = np.where(there, values, 0.0).sum(axis=0)
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan))
