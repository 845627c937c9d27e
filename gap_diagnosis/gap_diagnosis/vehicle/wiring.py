r"""Wiring and conventions before any physics: which command moves the vehicle as which column of K_t says.

Throttles u_i, through a lag and beyond a dead band, are regressed on accelerations of the body that need no model: the
change of the gyro and the specific force. That gives a column c_i (6) of each command with its covariance. With
b_j = M^-1 K_t,j the expected direction of thruster j, the cost of taking command i for thruster j with sign s is

    min_a (c_i - s a b_j)^T S_i^-1 (c_i - s a b_j),     a > 0

and the cheapest assignment of commands to thrusters (Hungarian) is compared with the one that the set states. M only
weighs axes against each other. Columns of K_t that agree cannot be told apart, and that is said.

An IMU that is mounted at right angles to what is believed turns all columns at once, which takes many wires to explain.
So each of its 24 mountings R (`mounting`) is tried, c_i <- R c_i. Each wrong wire costs `WIRING_MARGIN`, a turned IMU
that of `TURNED_IMU` wires, and the cheapest is believed.

Wires do not change in mid-dive. So a wrong one is believed where both halves of the recordings show it, as far as they
show anything of that command: where a thruster fails, or commands follow from motions, columns are others in each half.

A command that was far beyond its dead zone and moves the vehicle along no b_j, by a deviation that lies well below what
others move it by, drives nothing: its thruster is dead, or its wire is cut. In neither half may it move it along b_i.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_toeplitz
from scipy.optimize import linear_sum_assignment
from scipy.signal import lfilter

from gap_diagnosis.vehicle.gains import down_of
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.mounting import MOUNTINGS, upright
from gap_diagnosis.vehicle.rules import LEAST_EXCITATION, TURNED_IMU, WIRING_MARGIN, WIRING_SEEN
from gap_diagnosis.vehicle.turns import read_with

__all__ = ["Wiring", "wiring_of"]

Array = NDArray[np.float64]
_ANSWERS = 0.25
"""Share of what a command moves in the middle, of those that are seen, below which three deviations say: nothing."""
_BEYOND = (0.3, 0.5)
"""[V] beyond its dead zone a command must have been, [s] for which, to be one that something should answer."""
_STANDS = 0.1
"""Share of the speed of other thrusters below which a tachometer says that a rotor stands."""
_MEMORY = 0.5
"""[s] In which what is left of an acceleration follows itself. Set by reason."""


_UNLIKE = (
    "The wiring cannot be checked: commands move the vehicle in another way in one half of the recordings than in the "
    "other, as where a thruster fails in mid-dive; `pulses` shows it."
)


@dataclass(frozen=True, kw_only=True)
class Wiring:
    """What the commands do.

    Attributes:
        order: thruster that each command drives, as cheapest; signs: +1 or -1.
        margin: cost of the stated wiring above that of the cheapest, in chi squared.
        verdict: as_stated, wrong or cannot_tell.
        silent: commands that move nothing that is seen, or that were never used; dead: those of them that surely move
            nothing.
        alike: groups of thrusters whose columns agree in direction.
        delay: of the motion behind the commands [s]; of which the rotors take their part.
        dead_band: of each command [V], NaN where it is not seen.
        sentences: what is said of it.
        mounting: of the IMU, the identity where it is as stated; gain: by how much it is cheaper, in chi squared.
    """

    order: tuple[int, ...]
    signs: tuple[int, ...]
    margin: float
    verdict: str
    silent: tuple[int, ...]
    dead: tuple[int, ...]
    alike: tuple[tuple[int, ...], ...]
    delay: float
    dead_band: tuple[float, ...]
    sentences: tuple[str, ...]
    mounting: Array
    gain: float

    def content(self) -> dict[str, Any]:
        """Return it for diagnosis.json."""
        return {
            "verdict": self.verdict, "order": list(self.order), "signs": list(self.signs), "margin": self.margin,
            "silent": list(self.silent), "dead": list(self.dead), "alike": [list(g) for g in self.alike],
            "delay": self.delay,
            "dead_band": [None if not np.isfinite(d) else d for d in self.dead_band],
        }  # fmt: skip


def wiring_of(
    logs: Sequence[VehicleLog], K_t: Array, mass: Array, edges: Sequence[float] | None = None
) -> Wiring:  # fmt: skip
    """Return what commands do in these recordings.

    Args:
        logs: recordings.
        K_t: (6, N) as the set states it; mass: M (6, 6), whose accuracy hardly matters.
        edges: of the dead zone of each thruster (N,) [V]; None: not known, and no thruster is called dead.
    """
    N = K_t.shape[1]
    used = np.sqrt(np.mean([log.throttles.var(axis=0) for log in logs], axis=0)) > LEAST_EXCITATION
    best: tuple[float, tuple[Array, Array], float, float] | None = None
    for lag, band in product((0.04, 0.12, 0.24, 0.4), (0.0, 0.4, 0.8)):
        fit = _columns(logs, lag, band)
        if best is None or fit[2] < best[0]:
            best = (fit[2], (fit[0], fit[1]), lag, band)
    assert best is not None
    columns, variances = best[1]
    b = np.linalg.inv(mass) @ K_t
    ways = [R for j, R in enumerate(MOUNTINGS) if j == 0 or upright(logs, R)]
    tried = [_assigned(*_turned(columns, variances, R), b, used) for R in ways]
    prices = [each.price + WIRING_MARGIN * TURNED_IMU * (j > 0) for j, each in enumerate(tried)]
    k = int(np.argmin(prices))
    found, gain = tried[k], prices[0] - prices[k]
    verdict, order, signs = _verdict(found, _alike(b))
    halves = [_turned(*_columns(half, *best[2:])[:2], ways[k]) for half in _halves(logs)]
    unlike = verdict == "wrong" and not all(_shows(_assigned(*half, b, used), order, signs) for half in halves)
    if unlike:
        verdict, order, signs = "cannot_tell", tuple(range(N)), (1,) * N
    silent = tuple(i for i in range(N) if not found.seen[i])
    nothing = _moves_nothing(*_turned(columns, variances, ways[k]), b, found.seen)
    nothing &= ~np.any([_moves_as_stated(*half, b) for half in halves], axis=0)
    dead = tuple(i for i in silent if used[i] and edges is not None and nothing[i] and _was_beyond(logs, i, edges[i]))
    return Wiring(
        order=order, signs=signs, margin=found.margin, verdict=verdict, silent=silent, dead=dead, alike=_alike(b),
        delay=best[2],
        dead_band=tuple(best[3] if found.seen[i] else float("nan") for i in range(N)), mounting=ways[k], gain=gain,
        sentences=(
            *(_dead_words(logs, i) for i in dead),
            *([_UNLIKE] if unlike else []),
            *_sentences(verdict, order, signs, tuple(i for i in silent if i not in dead), _alike(b), used),
        ),
    )  # fmt: skip


class _Assigned(NamedTuple):
    """Costs (N, N) of taking a command for a thruster, with signs; which commands are seen; the cheapest order."""

    cost: Array
    sign: Array
    seen: NDArray[np.bool_]
    order: NDArray[np.intp]

    @property
    def least(self) -> float:
        """Cost of the cheapest order."""
        return float(self.cost[np.arange(len(self.order)), self.order].sum())

    @property
    def margin(self) -> float:
        """Cost of the stated wiring above it."""
        return float(np.trace(self.cost)) - self.least

    @property
    def signs(self) -> tuple[int, ...]:
        """Signs in the cheapest order, +1 or -1."""
        return tuple(int(self.sign[i, j]) if self.seen[i] else 1 for i, j in enumerate(self.order))

    @property
    def price(self) -> float:
        """Cost of the cheapest order or of the stated one, each wrong wire at its price."""
        stated = np.arange(len(self.order))
        wires = [np.sum(self.seen & ((j != stated) | (self.sign[stated, j] < 0.0))) for j in (self.order, stated)]
        return float(min(self.least + WIRING_MARGIN * wires[0], np.trace(self.cost) + WIRING_MARGIN * wires[1]))


def _assigned(columns: Array, variances: Array, b: Array, used: NDArray[np.bool_]) -> _Assigned:
    """Return which thruster each command drives at the least cost, from its column and variances of it (6, N)."""
    N = b.shape[1]
    cost, sign, seen = np.zeros((N, N)), np.ones((N, N)), np.zeros(N, dtype=bool)
    for i in range(N):
        good = np.isfinite(columns[:, i])
        spread, c = np.diag(variances[good, i]), columns[good, i]
        seen[i] = used[i] and float(c @ np.linalg.pinv(spread) @ c) > WIRING_SEEN
        # directions agree within a few percent of their size, however sharp the data
        inverse = np.linalg.pinv(spread + 0.15**2 * np.diag(c**2) + 0.05**2 * (c @ c) * np.eye(c.size))
        for j in range(N):
            d = b[good, j]
            a = float(d @ inverse @ c) / max(float(d @ inverse @ d), 1e-12)
            sign[i, j] = 1.0 if a >= 0.0 else -1.0
            cost[i, j] = float((c - a * d) @ inverse @ (c - a * d)) if seen[i] else 0.0
    _, order = linear_sum_assignment(cost + 1e-6 * (1.0 - np.eye(N)))
    return _Assigned(cost, sign, seen, order)


def _halves(logs: Sequence[VehicleLog]) -> tuple[list[VehicleLog], list[VehicleLog]]:
    """Return the first halves of recordings, and the second ones."""
    return [log.part(0, log.count // 2) for log in logs], [log.part(log.count // 2, log.count) for log in logs]


def _shows(part: _Assigned, order: Sequence[int], signs: Sequence[int]) -> bool:
    """Tell whether a part of the recordings shows these wrong wires, or nothing of them."""
    wrong = [i for i, j in enumerate(order) if part.seen[i] and (j != i or signs[i] < 0)]
    return all(part.sign[i, order[i]] == signs[i] and part.cost[i, order[i]] <= part.cost[i, i] for i in wrong)


def _moves_nothing(columns: Array, variances: Array, b: Array, seen: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return which commands (N,) move the vehicle along no thruster's direction b (6, N); see the module."""
    N = b.shape[1]
    most, along = np.full(N, np.inf), np.zeros(N)
    for i in range(N):
        good = np.isfinite(columns[:, i]) & (variances[:, i] > 0.0)  # 0: readings that never change
        weighted = b[good] / variances[good, i][:, None]
        size = np.einsum("aj,aj->j", b[good], weighted)
        if good.any() and size.min() > 0.0:
            moves = np.abs(columns[good, i] @ weighted) / size
            most[i], along[i] = float((moves + 3.0 / np.sqrt(size)).max()), float(moves.max())
    if np.count_nonzero(seen) < 2:
        return np.zeros(N, dtype=bool)
    return np.asarray(~seen & (most < _ANSWERS * float(np.median(along[seen]))))


def _moves_as_stated(columns: Array, variances: Array, b: Array) -> NDArray[np.bool_]:
    """Return which commands (N,) move the vehicle along their own thruster's direction, by three deviations or more."""
    weights = np.where(np.isfinite(columns) & (variances > 0.0), 1.0 / np.where(variances > 0.0, variances, 1.0), 0.0)
    return np.asarray((np.nan_to_num(columns) * weights * b).sum(axis=0) > 3.0 * np.sqrt((b**2 * weights).sum(axis=0)))


def _was_beyond(logs: Sequence[VehicleLog], i: int, edge: float) -> bool:
    """Tell whether a thruster was commanded far enough beyond its dead zone for long enough."""
    beyond, least = _BEYOND
    time = sum(np.count_nonzero(np.abs(log.throttles[:, i]) > edge + beyond) * log.period for log in logs)
    return bool(time >= least)


def _dead_words(logs: Sequence[VehicleLog], i: int) -> str:
    """Return what is said of a thruster that moves nothing, with what its tachometer says."""
    largest = max(float(np.abs(log.throttles[:, i]).max()) for log in logs)
    says = f"Thruster {i} was commanded up to {largest:.2g} V and moves nothing"
    turns = np.array([_speed_when_driven(logs, j) for j in range(logs[0].thrusters)])
    if not np.isfinite(turns[i]):
        return f"{says}: it is dead, or its wire is cut."
    if turns[i] < _STANDS * np.nanmedian(turns):
        return f"{says}; its tachometer says that it stands still: it is dead, or its wire is cut."
    return f"{says}, though its tachometer says that it turns: its propeller is lost, or gives no thrust."


def _speed_when_driven(logs: Sequence[VehicleLog], i: int) -> float:
    """Return the middle speed of a rotor [rad/s] under commands beyond half its largest; NaN: nothing tells it."""
    u = np.abs(np.concatenate([log.throttles[:, i] for log in logs]))
    n = np.abs(np.concatenate([log.speeds[:, i] for log in logs]))
    told = n[(u > 0.5 * u.max()) & np.isfinite(n)]
    return float(np.median(told)) if told.size else float("nan")


def _turned(columns: Array, variances: Array, R: Array) -> tuple[Array, Array]:
    """Return columns (6, N), of force and turning, and their variances as they are where the IMU is mounted by R."""

    def turned(rows: Array, R: Array) -> Array:
        return np.concatenate([read_with(each.T, R).T for each in (rows[:3], rows[3:])])

    return turned(columns, R), turned(variances, np.abs(R))


def _verdict(found: _Assigned, alike: tuple[tuple[int, ...], ...]) -> tuple[str, tuple[int, ...], tuple[int, ...]]:
    """Return as_stated, wrong or cannot_tell, with the order and the signs that go with it."""
    N = len(found.order)
    moved = [i for i in range(N) if found.seen[i] and found.order[i] != i]
    reversed_ = any(found.seen[i] and found.sign[i, i] < 0.0 and found.order[i] == i for i in range(N))
    within = all(any({i, int(found.order[i])} <= set(g) for g in alike) for i in moved)
    if (moved and found.margin > WIRING_MARGIN and not within) or reversed_:
        return "wrong", tuple(map(int, found.order)), found.signs
    return "as_stated" if found.seen.any() else "cannot_tell", tuple(range(N)), (1,) * N


def _columns(logs: Sequence[VehicleLog], lag: float, band: float) -> tuple[Array, Array, float]:
    """Return columns (6, N) of acceleration per volt beyond the band, their variances (6, N), and the error left."""
    X, Y = [], []
    for log in logs:
        u = np.sign(log.throttles) * np.maximum(np.abs(log.throttles) - band, 0.0)
        keep = np.exp(-log.period / lag)
        followed = np.empty_like(u)
        now = u[:1].sum(axis=0)  # half a log of one instant has none
        for k in range(len(u)):
            followed[k] = now
            now = keep * now + (1.0 - keep) * u[k]
        rate = log.told[:, 3:6]
        turning = np.diff(rate, axis=0) / log.period
        down = down_of(log.attitude)
        known = np.flatnonzero(np.isfinite(down).all(axis=1))
        if known.size:  # an attitude may be told less often than the gyro
            down = np.column_stack([np.interp(np.arange(len(u)), known, each[known]) for each in down.T])
        force = log.told[:, 6:9] + 9.81 * down
        if not known.size:  # without an attitude the gyro alone tells, and what gravity turns is not known
            down = np.zeros_like(down)
        slow = np.concatenate(
            (np.ones((len(u), 1)), down, rate, rate * np.abs(rate), np.cross(rate, rate[:, [1, 2, 0]])), axis=1
        )
        rows = np.concatenate((followed * np.abs(followed) ** 0.5, slow), axis=1)
        X.append((rows[:-1], 0.5 * (rows[1:] + rows[:-1])))  # at a reading of the force, between two of the gyro
        Y.append(np.concatenate((force[:-1], turning), axis=1))
    at, between = (np.concatenate(each) for each in zip(*X, strict=True))
    y = np.concatenate(Y)
    N = logs[0].thrusters
    columns, variances, left = np.full((6, N), np.nan), np.full((6, N), np.nan), 0.0
    for a in range(6):
        x = at if a < 3 else between
        good = np.isfinite(y[:, a]) & np.isfinite(x).all(axis=1)
        if good.sum() < 5 * x.shape[1]:
            continue
        x_a, y_a = x[good], y[good, a]
        memory = np.zeros(round(_MEMORY / logs[0].period))
        for _ in range(3):  # what is left follows itself: both sides are whitened by how much it does
            x_w, y_w = _whitened(x_a, memory), _whitened(y_a, memory)
            inverse = np.linalg.inv(x_w.T @ x_w + 1e-6 * np.eye(x.shape[1]))
            beta = inverse @ x_w.T @ y_w
            memory = _memory(y_a - x_a @ beta, memory.size)
        w = y_w - x_w @ beta
        again = float(np.clip(w[1:] @ w[:-1] / max(float(w @ w), 1e-12), 0.0, 0.9))
        variance = float(np.mean(w**2)) * (1.0 + again) / (1.0 - again)
        columns[a], variances[a] = beta[:N], variance * np.diag(inverse)[:N]
        left += good.sum() * np.log(max(float(np.mean(w**2)), 1e-12))
    return columns, variances, left


def _memory(left: Array, order: int) -> Array:
    """Return how much of what is left (K,) follows from each of the samples before it, the last one first (Yule and
    Walker): the noise of a gyro whose differences are taken comes back with the other sign, a push of the water stays.
    """
    r: Array = np.array([left[j:] @ left[: left.size - j] for j in range(order + 1)]) / max(float(left @ left), 1e-12)
    r[0] += 1e-3
    return np.asarray(solve_toeplitz(r[:-1], r[1:]))


def _whitened(rows: Array, memory: Array) -> Array:
    """Return rows (K, ...) less what follows from those before them, which the first ones lack."""
    return np.asarray(lfilter(np.concatenate(([1.0], -memory)), 1.0, rows, axis=0)[memory.size :])


def _alike(b: Array) -> tuple[tuple[int, ...], ...]:
    n = b / np.linalg.norm(b, axis=0)
    groups: list[tuple[int, ...]] = []
    for i in range(b.shape[1]):
        group = tuple(j for j in range(b.shape[1]) if abs(float(n[:, i] @ n[:, j])) > 0.999)
        if len(group) > 1 and group not in groups:
            groups.append(group)
    return tuple(groups)


def _sentences(verdict, order, signs, silent, alike, used):  # type: ignore[no-untyped-def]
    says = []
    for i, j in enumerate(order):
        if verdict == "wrong" and i not in silent and (int(j) != i or signs[i] < 0):
            moves = f"moves the vehicle as thruster {int(j)}" if int(j) != i else "drives it"
            says.append(f"The command of thruster {i} {moves}{' the other way round' if signs[i] < 0 else ''}.")
    idle = [i for i in silent if not used[i]]
    dead = [i for i in silent if used[i]]
    if idle:
        says.append(f"Thruster {', '.join(map(str, idle))} was never commanded: nothing is known of its wire.")
    if dead:
        named = ", ".join(map(str, dead))
        says.append(
            f"The wiring of thruster {named} cannot be checked: what it moves does not stand out; `pulses` shows it."
        )
    says += [f"Thrusters {', '.join(map(str, g))} push alike: an exchange among them cannot be seen." for g in alike]
    return tuple(says)
