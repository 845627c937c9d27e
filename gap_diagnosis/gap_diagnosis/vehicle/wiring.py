r"""Wiring and conventions before any physics: which command moves the vehicle as which column of K_t says.

Throttles u_i, through a lag and beyond a dead band, are regressed on accelerations of the body that need no model: the
derivative of the gyro and the specific force. That gives a column c_i (6) of each command with its covariance. With
b_j = M^-1 K_t,j the expected direction of thruster j, the cost of taking command i for thruster j with sign s is

    min_a (c_i - s a b_j)^T S_i^-1 (c_i - s a b_j),     a > 0

and the cheapest assignment of commands to thrusters (Hungarian) is compared with the one that the set states. M only
weighs axes against each other. Columns of K_t that agree cannot be told apart, and that is said.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

from gap_diagnosis.vehicle.gains import down_of
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.rules import LEAST_EXCITATION, WIRING_MARGIN, WIRING_SEEN

__all__ = ["Wiring", "wiring_of"]

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Wiring:
    """What the commands do.

    Attributes:
        order: thruster that each command drives, as cheapest; signs: +1 or -1.
        margin: cost of the stated wiring above that of the cheapest, in chi squared.
        verdict: as_stated, wrong or cannot_tell.
        silent: commands that move nothing that is seen, or that were never used.
        alike: groups of thrusters whose columns agree in direction.
        delay: of the motion behind the commands [s]; of which the rotors take their part.
        dead_band: of each command [V], NaN where it is not seen.
        sentences: what is said of it.
    """

    order: tuple[int, ...]
    signs: tuple[int, ...]
    margin: float
    verdict: str
    silent: tuple[int, ...]
    alike: tuple[tuple[int, ...], ...]
    delay: float
    dead_band: tuple[float, ...]
    sentences: tuple[str, ...]

    def content(self) -> dict[str, Any]:
        """Return it for diagnosis.json."""
        return {
            "verdict": self.verdict, "order": list(self.order), "signs": list(self.signs), "margin": self.margin,
            "silent": list(self.silent), "alike": [list(g) for g in self.alike], "delay": self.delay,
            "dead_band": [None if not np.isfinite(d) else d for d in self.dead_band], "sentences": list(self.sentences),
        }  # fmt: skip


def wiring_of(logs: Sequence[VehicleLog], K_t: Array, mass: Array) -> Wiring:
    """Return what commands do in these recordings.

    Args:
        logs: recordings.
        K_t: (6, N) as the set states it; mass: M (6, 6), whose accuracy hardly matters.
    """
    N = K_t.shape[1]
    used = np.sqrt(np.mean([log.throttles.var(axis=0) for log in logs], axis=0)) > LEAST_EXCITATION
    best: tuple[float, tuple[Array, list[Array]], float, float] | None = None
    for lag, band in product((0.04, 0.12, 0.24, 0.4), (0.0, 0.4, 0.8)):
        fit = _columns(logs, lag, band)
        if best is None or fit[2] < best[0]:
            best = (fit[2], (fit[0], fit[1]), lag, band)
    assert best is not None
    columns, spreads = best[1]
    b = np.linalg.inv(mass) @ K_t
    b[:3] -= 0.0
    cost, sign, seen = np.zeros((N, N)), np.ones((N, N)), np.zeros(N, dtype=bool)
    for i in range(N):
        good = np.isfinite(columns[:, i])
        inverse = np.linalg.pinv(spreads[i][np.ix_(good, good)])
        c = columns[good, i]
        size = float(c @ inverse @ c)
        seen[i] = used[i] and size > WIRING_SEEN
        # directions agree within a few percent of their size, however sharp the data
        inverse = np.linalg.pinv(
            spreads[i][np.ix_(good, good)] + 0.15**2 * np.diag(c**2) + 0.05**2 * (c @ c) * np.eye(c.size)
        )
        for j in range(N):
            d = b[good, j]
            a = float(d @ inverse @ c) / max(float(d @ inverse @ d), 1e-12)
            sign[i, j] = 1.0 if a >= 0.0 else -1.0
            cost[i, j] = float((c - a * d) @ inverse @ (c - a * d)) if seen[i] else 0.0
    rows, order = linear_sum_assignment(cost + 1e-6 * (1.0 - np.eye(N)))
    signs = tuple(int(sign[i, j]) if seen[i] else 1 for i, j in zip(rows, order, strict=True))
    stated = float(np.trace(cost))
    wrong_sign = [i for i in range(N) if seen[i] and sign[i, i] < 0.0 and order[i] == i]
    margin = stated - float(cost[rows, order].sum())
    alike = _alike(b)
    silent = tuple(i for i in range(N) if not seen[i])
    moved = [i for i in range(N) if seen[i] and order[i] != i]
    within = all(any({i, int(order[i])} <= set(g) for g in alike) for i in moved)
    if (moved and margin > WIRING_MARGIN and not within) or wrong_sign:
        verdict = "wrong"
    elif len(silent) == N:
        verdict = "cannot_tell"
    else:
        verdict, order = "as_stated", np.arange(N)
        signs = tuple(1 for _ in range(N))
    return Wiring(
        order=tuple(map(int, order)), signs=signs, margin=margin, verdict=verdict, silent=silent, alike=alike,
        delay=best[2], dead_band=tuple(best[3] if seen[i] else float("nan") for i in range(N)),
        sentences=_sentences(verdict, order, signs, silent, alike, used),
    )  # fmt: skip


def _columns(logs: Sequence[VehicleLog], lag: float, band: float) -> tuple[Array, list[Array], float]:
    """Return columns (6, N) of acceleration per volt beyond the band, their covariances, and the error left."""
    X, Y = [], []
    for log in logs:
        u = np.sign(log.throttles) * np.maximum(np.abs(log.throttles) - band, 0.0)
        keep = np.exp(-log.period / lag)
        followed = np.empty_like(u)
        now = u[0]
        for k in range(len(u)):
            followed[k] = now
            now = keep * now + (1.0 - keep) * u[k]
        rate = log.told[:, 3:6]
        turning = np.full_like(rate, np.nan)
        turning[1:-1] = (rate[2:] - rate[:-2]) / (2.0 * log.period)
        force = log.told[:, 6:9] + 9.81 * down_of(log.attitude)
        y = np.concatenate((force, turning), axis=1)
        down = down_of(log.attitude)
        if not np.isfinite(down).any():  # without an attitude the gyro alone tells, and what gravity turns is not known
            down = np.zeros_like(down)
        slow = np.concatenate(
            (np.ones((len(u), 1)), down, rate, rate * np.abs(rate), np.cross(rate, rate[:, [1, 2, 0]])), axis=1
        )
        X.append(np.concatenate((followed * np.abs(followed) ** 0.5, slow), axis=1))
        Y.append(y)
    x, y = np.concatenate(X), np.concatenate(Y)
    N = logs[0].thrusters
    columns, variances, left = np.full((6, N), np.nan), np.full((6, N), np.nan), 0.0
    for a in range(6):
        good = np.isfinite(y[:, a]) & np.isfinite(x).all(axis=1)
        if good.sum() < 5 * x.shape[1]:
            continue
        x_a, y_a, memory = x[good], y[good, a], 0.0
        for _ in range(3):  # what is left follows itself: both sides are whitened by how much it does
            x_w, y_w = x_a[1:] - memory * x_a[:-1], y_a[1:] - memory * y_a[:-1]
            inverse = np.linalg.inv(x_w.T @ x_w + 1e-6 * np.eye(x.shape[1]))
            beta = inverse @ x_w.T @ y_w
            e = y_a - x_a @ beta
            memory = float(np.clip(e[1:] @ e[:-1] / max(e @ e, 1e-12), 0.0, 0.98))
        w = y_w - x_w @ beta
        again = float(np.clip(w[1:] @ w[:-1] / max(w @ w, 1e-12), 0.0, 0.9))
        variance = float(np.mean(w**2)) * (1.0 + again) / (1.0 - again)
        columns[a], variances[a] = beta[:N], variance * np.diag(inverse)[:N]
        left += good.sum() * np.log(max(float(np.mean(w**2)), 1e-12))
    return columns, [np.diag(np.nan_to_num(variances[:, i], nan=1.0)) for i in range(N)], left


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
        says.append(
            f"The command of thruster {', '.join(map(str, dead))} moves nothing that stands out from the other motion."
        )
    says += [f"Thrusters {', '.join(map(str, g))} push alike: an exchange among them cannot be seen." for g in alike]
    return tuple(says)
