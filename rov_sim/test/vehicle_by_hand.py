"""A vehicle with its thrusters by other code than the plant's: plain NumPy, rotation matrices, scipy's integrator.

Six thrusters of the thesis' form in the places of the thesis' vehicle, at rest in still water at the beginning. Body
axes forward, starboard, down; earth north, east, down.
"""

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

GRAVITY, DENSITY = 9.81, 1000.0


def cross_matrix(a: Any) -> np.ndarray:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def matrix_of(q: Any) -> np.ndarray:
    """Body to earth."""
    w, x, y, z = np.asarray(q) / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


class Hull(NamedTuple):
    """Mass [kg], volume [m^3], height of buoyancy [m], inertia, added mass, drag (diagonals)."""

    mass: float
    volume: float
    z_B: float
    inertia: Any
    added: Any
    linear: Any
    quadratic: Any


NGS = Hull(
    30.0, 0.0302, -0.01, (0.98, 0.87, 1.40), (14.1, 15.8, 41.5, 0.715, 0.511, 0.840), (23, 20, 56, 0.8, 2.3, 0.8),
    (240, 370, 324, 4.5, 1.8, 5.7),
)  # fmt: skip


def ngs_configuration() -> np.ndarray:
    """K_t (6, 6) of the thesis' vehicle."""
    places = [
        (0.24892, -0.219202, -0.019812, 30, -30), (0.24892, 0.219202, -0.019812, -30, -30),
        (-0.20828, 0.2413, -0.019812, 30, -30), (-0.20828, -0.2413, -0.019812, -30, -30),
        (0.0, -0.1651, -0.05715, 90, -85), (0.0, 0.1651, -0.05715, -90, -85),
    ]  # fmt: skip
    columns = []
    for x, y, z, yaw, pitch in places:
        a, b = np.radians(yaw), np.radians(pitch)
        e = np.array([np.cos(a) * np.cos(b), np.sin(a) * np.cos(b), np.sin(b)])
        columns.append(np.concatenate((e, np.cross((x, y, z), e))))
    return np.array(columns).T


def thruster_rates(n: float, v: float, U: float, u: float, p: Any) -> tuple[float, float, float]:
    """dn/dt, dv/dt and T of (3.8), (4.4), (4.14), each case written out."""
    square = n * abs(n)
    force = 0.0
    if square <= p.delta_T1 and square < 0.0:
        force = p.c_T1 * (square - p.delta_T1)
    elif square >= p.delta_T2 and square > 0.0:
        force = p.c_T2 * (square - p.delta_T2)
    force -= p.c_nv_T * abs(n) * v + p.c_v_T * v * abs(v)
    load = 0.0
    if square <= p.delta_Q1 and square < 0.0:
        load = p.c_Q1 * (square - p.delta_Q1)
    elif square >= p.delta_Q2 and square > 0.0:
        load = p.c_Q2 * (square - p.delta_Q2)
    load -= p.c_nv_Q * abs(n) * v + p.c_v_Q * v * abs(v)
    drive = 0.0
    if u <= p.delta_u1:
        drive = p.c_u1 * (u - p.delta_u1)
    elif u >= p.delta_u2:
        drive = p.c_u2 * (u - p.delta_u2)
    axial = -p.k_v * v - p.k_Uv * abs(v) * (v - p.k_w * U) + p.k_Tv * force
    return -p.k_n * n - p.k_Q * load + drive, axial, force


def body_acceleration(q: Any, nu: np.ndarray, wrench: np.ndarray, hull: Hull) -> np.ndarray:
    rigid = np.diag([hull.mass] * 3 + list(hull.inertia))
    added = np.diag(hull.added)
    total = np.zeros(6)
    for mass in (rigid, added):
        momentum = mass @ nu
        total[:3] += np.cross(nu[3:], momentum[:3])
        total[3:] += np.cross(nu[3:], momentum[3:]) + np.cross(nu[:3], momentum[:3])
    drag = np.asarray(hull.linear) * nu + np.asarray(hull.quadratic) * np.abs(nu) * nu
    down = matrix_of(q).T @ [0.0, 0.0, 1.0]
    weight, buoyancy = hull.mass * GRAVITY, DENSITY * GRAVITY * hull.volume
    outer = np.concatenate(((weight - buoyancy) * down, np.cross([0.0, 0.0, hull.z_B], -buoyancy * down)))
    return np.linalg.solve(rigid + added, wrench + outer - total - drag)


class ByHand:
    """The vehicle period by period; `state`: p (3), q (4), nu (6), then n, v of each thruster, acting throttles."""

    def __init__(self, hull: Hull, K_t: np.ndarray, thrusters: Any) -> None:
        self.hull, self.K_t, self.p = hull, K_t, thrusters
        self.N = K_t.shape[1]
        self.state = np.zeros(13 + 2 * self.N)
        self.state[3] = 1.0
        self.u = np.zeros(self.N)

    def rates(self, x: np.ndarray, u: np.ndarray) -> np.ndarray:
        q, nu = x[3:7], x[7:13]
        n, v = x[13 : 13 + self.N], x[13 + self.N :]
        U = self.K_t.T @ nu
        each = np.array([thruster_rates(*row, p) for *row, p in zip(n, v, U, u, self.p, strict=True)])
        w, turn = q[0], q[1:]
        q_rate = 0.5 * np.concatenate(([-turn @ nu[3:]], w * nu[3:] + np.cross(turn, nu[3:])))
        nu_rate = body_acceleration(q, nu, self.K_t @ each[:, 2], self.hull)
        return np.concatenate((matrix_of(q) @ nu[:3], q_rate, nu_rate, each[:, 0], each[:, 1]))

    def advance(self, throttles: Any, period: float) -> None:
        """Hold commands [V] over a period [s]; acting throttles run to them at each thruster's largest rate."""
        rate = np.array([p.u_dot_max for p in self.p])
        change = np.asarray(throttles) - self.u
        lasts = np.abs(change) / rate
        edges = [
            abs(edge - u) / r for p, u, c, r in zip(self.p, self.u, change, rate, strict=True)
            for edge in (p.delta_u1, p.delta_u2) if c != 0.0 and 0.0 < (edge - u) / c < 1.0
        ]  # fmt: skip
        begin = self.u.copy()

        def acting(t: float) -> np.ndarray:
            return np.asarray(begin + np.sign(change) * rate * np.minimum(t, lasts))

        ends = sorted({0.0, period, *(t for t in (*lasts, *edges) if 0.0 < t < period)})
        for first, last in pairwise(ends):
            found = solve_ivp(
                lambda t, x: self.rates(x, acting(t)), (first, last), self.state, method="DOP853", rtol=1e-9, atol=1e-11
            )
            self.state = found.y[:, -1]
        self.state[3:7] /= np.linalg.norm(self.state[3:7])
        self.u = acting(period)
