"""Noises of recordings, learned from what a filter makes of them by expectation and maximisation."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle import rules
from gap_diagnosis.vehicle.filtering import Prepared, grounded, prepared_on, prepared_with
from gap_diagnosis.vehicle.gains import Noises
from gap_diagnosis.vehicle.instants import first_instant
from gap_diagnosis.vehicle.log import CHANNELS_OF, VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.side_by_side import side_by_side
from gap_diagnosis.vehicle.unknowns import Key
from gap_diagnosis.vehicle.whitening import log_likelihood, whitened
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from rov_sim.vehicle.innovations import states_of

__all__ = ["first_noises", "learned_from", "prepared", "unlearned"]

Array = NDArray[np.float64]
_BY_SIZE, _BY_CHANGE = (0.5, 0.0), (0.25, 0.75)
"""Powers of both moments of the random wrench that are tried, see `_wrench`: the likelihood decides between them."""
_STEP, _SWEEPS, _RISEN = 1.5, 4, 0.1
"""Factor by which noises are scaled at first, its root in each sweep; how many sweeps at most; least gain that counts,
nats."""
_TIMES = (1.0, 5.0)
"""[s] Of the random wrench, where nothing is known of it yet."""


class Block(NamedTuple):
    """Noises that are scaled together: a field of `Noises`, from the first place to before the last."""

    of: str
    first: int
    last: int


def unlearned(
    model: Model,
    logs: Sequence[VehicleLog],
    values: Mapping[Key, float],
    effects: Sequence[ActiveVehicleEffect] = (),
    noises: Noises | None = None,
    near: Sequence[Prepared] | None = None,
) -> list[Prepared]:
    """Return logs with gains for these noises at this point of the model; None: for what is typical.

    near: the same logs at a point nearby, along which they are linearised first; None: as if the vehicle rested.
    """
    noises = noises or first_noises(model, logs)
    first = _all_prepared(model, logs, noises, values, effects, _along(near, logs))
    states = [p.base.states if p.base.done else None for p in first]
    second = _all_prepared(model, logs, noises, values, effects, states)
    return [_weighted(p if p.base.done else q) for p, q in zip(second, first, strict=True)]


def prepared(
    model: Model,
    logs: Sequence[VehicleLog],
    values: Mapping[Key, float],
    effects: Sequence[ActiveVehicleEffect] = (),
    near: Sequence[Prepared] | None = None,
    *,
    afresh: bool = False,
) -> list[Prepared]:
    """Return logs with gains, whose noises are the most likely ones at this point of the model, the same in all logs.

    The wrench's deviations follow in rounds from the size of the filter's estimates and from their changes. From the
    best of all these on noises climb to where the innovations are most likely. `near` as in `unlearned`; noises begin
    with its own, or, without it or `afresh`, with what is typical.
    """

    def learned(
        noises: Noises, patient: bool = False, powers: tuple[float, float] = _BY_SIZE
    ) -> tuple[float, list[Prepared], Noises]:
        states = _along(near, logs)
        best: tuple[float, list[Prepared]] | None = None
        for turn in range(rules.LEARNED + 1):
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
                noises = _learned(model, found, powers) if done else _looser(noises)
            if done and patient and turn < rules.LEARNED - 1:
                noises = noises._replace(channels=channels)
        assert best is not None
        return *best, noises

    if near is None or afresh:
        first = first_noises(model, logs)
        ways = [
            learned(first._replace(time=time), patient, powers)
            for time in _TIMES
            for patient, powers in ((False, _BY_SIZE), (True, _BY_SIZE), (False, _BY_CHANGE))
        ]
    else:
        ways = [learned(learned_from(near))]
    _, best, ended = max(ways, key=lambda way: way[0])
    found = _climbed(model, logs, values, effects, best, ended)
    noises = learned_from(found)._replace(battery=_of_battery(found))  # no gain depends on it
    return [_weighted(replace(p, noises=noises)) for p in found]


def _along(near: Sequence[Prepared] | None, logs: Sequence[VehicleLog]) -> list[Array | None]:
    """Return the states along which logs are linearised, None for those of a vehicle at rest."""
    return [None] * len(logs) if near is None else [p.base.states if p.base.done else None for p in near]


def _climbed(
    model: Model, logs: Sequence[VehicleLog], values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect],
    found: list[Prepared], others: Noises,
) -> list[Prepared]:  # fmt: skip
    """Return logs with gains for noises at which no step of a block alone makes the body's innovations more likely.

    Moments of a filter's estimates come to rest far from there where readings hardly tell of the wrench: a vehicle with
    a gyro, an attitude and a depth alone ended a thousand nats below it. `others`: noises of what the body does not
    tell, rotors and the battery.
    """

    def on(found: list[Prepared]) -> Callable[[Noises], tuple[float, list[Prepared]]]:
        """Return what gives log likelihood and logs for noises, linearised along the states of these logs."""
        states = _along(found, logs)
        grounds = side_by_side(lambda k: grounded(model, logs[k], k, values, effects, states[k]), range(len(logs)))

        def at(noises: Noises) -> tuple[float, list[Prepared]]:
            tried = side_by_side(lambda ground: prepared_on(model, ground, noises), grounds)
            return sum(log_likelihood(p) for p in tried), tried

        return at

    begun = learned_from(found)._replace(rotor=others.rotor, speed=others.speed, battery=others.battery)
    score, found = on(found)(begun)
    blocks = _blocks(found)
    for sweep in range(_SWEEPS):
        before, moved, at = score, [], on(found)
        for block in blocks:
            was = score
            score, found = _likeliest(model, at, (score, found), block, _STEP ** (0.5**sweep))
            moved += [block] if score > was or not sweep else []
        if score < before + rules.SETTLED:
            break
        blocks = moved
    for _ in range(rules.TURNS):  # linearised where it ends, as the next one begins: flows may part elsewhere there
        before, (score, found) = score, on(found)(learned_from(found))
        if abs(score - before) < _RISEN:
            break
    return found


def _likeliest(
    model: Model, at: Callable[[Noises], tuple[float, list[Prepared]]], found: tuple[float, list[Prepared]],
    block: Block, factor: float,
) -> tuple[float, list[Prepared]]:  # fmt: skip
    """Return log likelihood and logs with a block of noises scaled to where that is largest: powers of a factor as far
    as it rises, then the top of a parabola through three of them."""
    start = learned_from(found[1])
    tried = {0.0: found}

    def ask(power: float) -> None:
        tried[power] = at(_scaled(model, start, block, factor**power))

    def best() -> float:
        return max(tried, key=lambda power: tried[power][0])

    ask(1.0)
    ask(-1.0)
    while (end := best()) in (min(tried), max(tried)):
        inner = tried[end - np.sign(end)][0]
        if tried[end][0] < inner + _RISEN:
            return tried[end]
        ask(end + np.sign(end))
    below, top, above = (tried[end + beside][0] for beside in (-1.0, 0.0, 1.0))
    slope, bend = 0.5 * (above - below), 2.0 * top - above - below
    if np.isfinite(bend) and slope**2 > 2.0 * _RISEN * bend:
        ask(end + slope / bend)
    return tried[best()]


def _blocks(found: Sequence[Prepared]) -> list[Block]:
    """Return what is scaled together: axes of the wrench, sensors that tell of the body, and the wrench's time."""
    told = np.any([np.isfinite(p.base.body).any(axis=0) for p in found], axis=0)
    sensors = [Block("channels", c.start, c.stop) for c in CHANNELS_OF.values() if told[c.start]]
    axes = [Block("wrench", axis, axis + 1) for axis in range(6)]
    return [Block("time", 0, 1), *axes, *sensors]


def _scaled(model: Model, noises: Noises, block: Block, factor: float) -> Noises:
    if block.of == "time":  # with what pushes anew in a period as it is: readings tell that apart from the time
        shortest, longest = rules.CORRELATION_TIMES
        time = min(max(noises.time * factor, shortest), longest)
        return noises._replace(time=time, wrench=_plausible(model, noises.wrench * np.sqrt(time / noises.time)))
    scaled: Array = getattr(noises, block.of).copy()
    scaled[block.first : block.last] *= factor
    if block.of == "wrench":
        return noises._replace(wrench=_plausible(model, scaled))
    return noises._replace(channels=scaled)


def _plausible(model: Model, wrench: Array) -> Array:
    """Return deviations (6,) of a wrench that is as small and as large as one may be."""
    least = np.array([rules.LEAST_FORCE] * 3 + [rules.LEAST_MOMENT] * 3)
    most = np.repeat(rules.MOST_PUSHED, 3) * model.vehicle.coefficients.mass_matrix.diagonal()
    return np.clip(wrench, least, most)


def learned_from(found: Sequence[Prepared]) -> Noises:
    """Return the noises that these logs are prepared with."""
    return found[0].noises


def _all_prepared(
    model: Model, logs: Sequence[VehicleLog], noises: Noises, values: Mapping[Key, float],
    effects: Sequence[ActiveVehicleEffect], states: Sequence[Array | None],
) -> list[Prepared]:  # fmt: skip
    def one(k: int) -> Prepared:
        return prepared_with(model, logs[k], k, noises, values, effects, states[k])

    return side_by_side(one, range(len(logs)))


def _looser(noises: Noises) -> Noises:
    """Return noises for a filter that has lost the vehicle: less faith in its readings, more room for the wrench."""
    return noises._replace(wrench=2.0 * noises.wrench, channels=1.5 * noises.channels)


def _weighted(prepared: Prepared) -> Prepared:
    size = np.abs(whitened(prepared, prepared.base))
    return replace(prepared, weights=np.minimum(rules.MOST_DEVIATIONS / np.maximum(size, 1e-9), 1.0))


def first_noises(model: Model, logs: Sequence[VehicleLog]) -> Noises:
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


def _learned(model: Model, found: Sequence[Prepared], powers: tuple[float, float]) -> Noises:
    """Return the noises that the filters' own estimates speak for; powers: see `_wrench`."""
    old = found[0].noises
    wrench = _plausible(model, _wrench(found, *powers))
    left, spread = [], []
    for p in found:
        # noise of a reading, given all readings up to it: R S^-1 e, and R - R S^-1 R beside it
        W = p.gains.whitener
        S_inverse = np.einsum("kji,kjl->kil", W, W)
        R = np.where(np.isfinite(p.base.body), old.channels**2, np.nan)
        far = (R * np.einsum("kij,kj->ki", S_inverse, np.nan_to_num(p.base.body))) ** 2
        left.append(far[first_instant(p.log) :])
        spread.append((R - R**2 * np.einsum("kii->ki", S_inverse))[first_instant(p.log) :])
    R = _trimmed(np.concatenate(left)) + _mean(np.concatenate(spread))
    channels = np.where(np.isfinite(R), np.sqrt(R), old.channels)
    channels = np.maximum(channels, 0.5 * found[0].noises.channels)
    e = np.concatenate([p.base.rotor[first_instant(p.log) :] for p in found])
    rotor, speed = old.rotor.copy(), old.speed.copy()
    S = np.concatenate([p.spread[first_instant(p.log) :] for p in found]) ** 2
    for i in range(e.shape[1]):
        if np.isfinite(e[:, i]).sum() > 50:
            excess = _trimmed(e[:, i : i + 1] ** 2)[0] - np.mean(S[:, i])
            rotor[i] = np.sqrt(max(rotor[i] ** 2 + 0.5 * excess, 1e-4))
    return Noises(wrench, old.time, channels, rotor, speed, _of_battery(found))


def _of_battery(found: Sequence[Prepared]) -> Array:
    """Return the deviations (2,) of the battery's readings, those of before where there are hardly any."""
    b = np.concatenate([p.base.battery[first_instant(p.log) :] for p in found])
    told = np.maximum(np.sqrt(_trimmed(b**2)), _battery_floor([p.log for p in found]))
    return np.where(np.isfinite(b).sum(axis=0) > 20, told, learned_from(found).battery)


def _wrench(found: Sequence[Prepared], of_size: float, of_change: float) -> Array:
    """Return the deviations (6,) of the random wrench that the filters' estimates speak for.

    Two moments tell of its variance. Its mean square takes a constant moment, or one that drifts, for a large random
    one. The mean square of its changes within a period does not, but moves little in a round where readings hardly
    tell of the wrench. Each counts with a power of its own.
    """
    old, keep = found[0].noises, np.exp(-found[0].log.period / found[0].noises.time)
    squares, changes, spreads = [], [], []
    for p in found:
        first = first_instant(p.log)
        w, variance = np.nan_to_num(states_of(p.base.states).wrench)[first:], p.gains.wrench_variance[first:]
        squares.append(w**2 + variance)
        changes.append((w[1:] - keep * w[:-1]) ** 2)
        spreads.append(variance[1:] - keep**2 * variance[:-1])
    pushed = _trimmed(np.concatenate(changes)) + _mean(np.concatenate(spreads))
    by_size = _trimmed(np.concatenate(squares)) / old.wrench**2
    by_change = np.maximum(pushed, 0.0) / (1.0 - keep**2) / old.wrench**2
    moved = by_size**of_size * by_change**of_change  # NaN in a log of an instant, which tells nothing
    return np.where(np.isfinite(moved), old.wrench * moved, old.wrench)


def _trimmed(squares: Array) -> Array:
    """Return means of columns, values beyond 16 times the mean counting as that."""
    return _mean(np.minimum(squares, 16.0 * _mean(squares)))


def _mean(values: Array) -> Array:
    """Return the means of columns over what is there, NaN where nothing is."""
    there = np.isfinite(values)
    count = there.sum(axis=0)
    total = np.where(there, values, 0.0).sum(axis=0)
    return np.asarray(np.where(count > 0, total / np.maximum(count, 1), np.nan))
