r"""How fast a vehicle with N thrusters changes: body, thrusters, and what couples them.

dp/dt = J_1 nu_1,   dq/dt = 1/2 q * (0, nu_2)
M dnu_r/dt = -C(nu_r) nu_r - D(nu_r) nu_r - g + tau,   nu_r = nu - nu_c,   dnu_c/dt = [-nu_2 x nu_c; 0]
tau = sum K_t,i T_i + what acts from outside;   U_i = K_t,i^T nu_r

(2.12) holds no nu_1, so a steady current enters C_RB and C_A alike through nu_r. With momentum [a; b] = M nu_r,
C(nu_r) nu_r = [nu_2 x a; nu_2 x b + nu_1r x a]: see `equations.rigid_body`.

Functions read the row `at` of a sheet; columns, `body`, `layout`: see `tables`. p, e: `ThrusterRows`. gate (N,): see
`effects.effect.STAGES`. wrench (6,): what acts on the body from outside, body axes [N, N m].
"""

import numpy as np

from rov_sim.vehicle.tables import (
    AMBIENT,
    AXIAL,
    BODY,
    FORWARD,
    INFLOW,
    INTERACTION,
    LEFT,
    PLACE,
    REACTION,
    REVERSE,
    SCALE,
    SLOPE,
    SPEED,
    TAU,
    THRUST,
    TORQUE,
    TURNING,
)
from thruster_model.compilation import inlined
from thruster_model.equations.attitude import cross, quaternion_rate, rotated
from thruster_model.equations.hydrodynamics import current_in_body, restoring
from thruster_model.equations.rigid_body import coriolis
from thruster_model.pipeline import drawn, pipeline
from thruster_model.thruster_rows import thruster

__all__ = ["inflow_at", "interact", "load_share", "rates", "relative_velocity", "thruster_row"]


@inlined
def load_share(sheet, at, p, e):  # type: ignore[no-untyped-def]
    """Return what all thrusters draw, as a share of what they draw with all at full."""
    N = p.values.shape[0]
    n, u, heat = BODY, BODY + 2 * N, BODY + 3 * N
    total = 0.0
    for i in range(N):
        total += drawn(sheet[at, n + i], sheet[at, u + i], sheet[at, heat + i], thruster(p, i), thruster(e, i))
    return total / N


@inlined
def relative_velocity(sheet, at, body):  # type: ignore[no-untyped-def]
    """Return (nu_1r, nu_2, nu_c) as vectors of three."""
    flow = current_in_body((sheet[at, 3], sheet[at, 4], sheet[at, 5], sheet[at, 6]), body.current)
    linear = (sheet[at, 7] - flow[0], sheet[at, 8] - flow[1], sheet[at, 9] - flow[2])
    return linear, (sheet[at, 10], sheet[at, 11], sheet[at, 12]), flow


@inlined
def inflow_at(i, nu_1, nu_2, layout):  # type: ignore[no-untyped-def]
    """Return U_i [m/s] of (4.21)."""
    c = INFLOW
    linear = layout[i, c] * nu_1[0] + layout[i, c + 1] * nu_1[1] + layout[i, c + 2] * nu_1[2]
    return linear + (layout[i, c + 3] * nu_2[0] + layout[i, c + 4] * nu_2[1] + layout[i, c + 5] * nu_2[2])


@inlined
def thruster_row(i, sheet, at, U, gate, supply, layout, p, e):  # type: ignore[no-untyped-def]
    """Return dn/dt, dv/dt, rotor speed, axial flow, ambient flow, thrust and torque of thruster i in this water."""
    N = layout.shape[0]
    n, v, u, heat = BODY + i, BODY + N + i, BODY + 2 * N + i, BODY + 3 * N + i
    row = pipeline(
        sheet[at, n], sheet[at, v], U, sheet[at, u], sheet[at, heat], 0.0, gate[i], supply,
        thruster(p, i), thruster(e, i),
    )  # fmt: skip
    return layout[i, TURNING] * row[0], row[1], row[3], row[4], row[5], layout[i, SCALE] * row[6], row[7]


@inlined
def interact(sheet, layout):  # type: ignore[no-untyped-def]
    """Fill row LEFT with what thrusters leave of each other's thrusts [N] in row THRUST."""
    N = layout.shape[0]
    for j in range(N):
        share = 0.0
        for i in range(N):
            share += layout[j, INTERACTION + i] * abs(sheet[THRUST, i])
        sheet[LEFT, j] = sheet[THRUST, j] * max(1.0 - share, 0.0)


@inlined
def rates(sheet, at, gate, wrench, body, layout, p, e):  # type: ignore[no-untyped-def]
    """Fill row SLOPE with the rates of the state in row `at`, and rows SPEED to TORQUE with the thrusters' there.

    Return (load, supply) there: of the thrusters as `load_share` has it, 0 where nothing sags; relative voltage.
    """
    N = layout.shape[0]
    q = (sheet[at, 3], sheet[at, 4], sheet[at, 5], sheet[at, 6])
    nu_1, nu_2, flow = relative_velocity(sheet, at, body)
    load = load_share(sheet, at, p, e) if body.sags else 0.0
    supply = body.supply * max(1.0 - body.sag * load, 0.0)
    for i in range(N):
        row = thruster_row(i, sheet, at, inflow_at(i, nu_1, nu_2, layout), gate, supply, layout, p, e)
        sheet[SLOPE, BODY + i], sheet[SLOPE, BODY + N + i] = row[0], row[1]
        sheet[SPEED, i], sheet[AXIAL, i], sheet[AMBIENT, i] = row[2], row[3], row[4]
        sheet[THRUST, i], sheet[TORQUE, i] = row[5], row[6]
    _gather_wrench(sheet, at, nu_1, nu_2, wrench, body, layout)
    gained = _body_rates(sheet, q, nu_1, nu_2, flow, body)
    north, east, down = rotated(q, (sheet[at, 7], sheet[at, 8], sheet[at, 9]))
    turned = quaternion_rate(q, nu_2)
    sheet[SLOPE, 0], sheet[SLOPE, 1], sheet[SLOPE, 2] = north, east, down
    sheet[SLOPE, 3], sheet[SLOPE, 4], sheet[SLOPE, 5], sheet[SLOPE, 6] = turned[0], turned[1], turned[2], turned[3]
    sheet[SLOPE, 7], sheet[SLOPE, 8], sheet[SLOPE, 9] = gained[0], gained[1], gained[2]
    sheet[SLOPE, 10], sheet[SLOPE, 11], sheet[SLOPE, 12] = gained[3], gained[4], gained[5]
    return load, supply


@inlined
def _gather_wrench(sheet, at, nu_1, nu_2, wrench, body, layout):  # type: ignore[no-untyped-def]
    """Fill row TAU with what acts on the body but for water, weight and the turning itself [N, N m]."""
    N = layout.shape[0]
    for j in range(6):
        sheet[TAU, j] = wrench[j]
    thrusts = THRUST
    if body.interacts:
        interact(sheet, layout)
        thrusts = LEFT
    for i in range(N):
        T = sheet[thrusts, i]
        c = FORWARD if T >= 0.0 else REVERSE
        for j in range(6):
            sheet[TAU, j] += layout[i, c + j] * T
    if body.reacts:
        for i in range(N):
            n = sheet[at, BODY + i]
            for j in range(3):
                sheet[TAU, 3 + j] += layout[i, REACTION + j] * n * abs(n)
    if body.ram > 0.0:
        for i in range(N):
            _turn_flow(i, sheet, sheet[thrusts, i], nu_1, nu_2, body.ram, layout)
    if body.tethered:
        _tow(sheet, nu_1, nu_2, body.tether)


@inlined
def _velocity_at(r, nu_1, nu_2):  # type: ignore[no-untyped-def]
    """Return the velocity [m/s] of a point of the body."""
    turning = cross(nu_2, r)
    return nu_1[0] + turning[0], nu_1[1] + turning[1], nu_1[2] + turning[2]


@inlined
def _pull_at(sheet, r, force):  # type: ignore[no-untyped-def]
    """Add a force [N] at a point of the body to row TAU."""
    moment = cross(r, force)
    for j in range(3):
        sheet[TAU, j] += force[j]
        sheet[TAU, 3 + j] += moment[j]


@inlined
def _turn_flow(i, sheet, T, nu_1, nu_2, ram, layout):  # type: ignore[no-untyped-def]
    """Add to row TAU what it takes to turn the water that thruster i takes in into its axis, at a thrust T [N]."""
    c = INFLOW
    e = (layout[i, c], layout[i, c + 1], layout[i, c + 2])
    c = PLACE
    r = (layout[i, c], layout[i, c + 1], layout[i, c + 2])
    v = _velocity_at(r, nu_1, nu_2)
    along = e[0] * v[0] + e[1] * v[1] + e[2] * v[2]
    taken = -ram * np.sqrt(abs(T))
    _pull_at(sheet, r, (taken * (v[0] - along * e[0]), taken * (v[1] - along * e[1]), taken * (v[2] - along * e[2])))


@inlined
def _tow(sheet, nu_1, nu_2, tether):  # type: ignore[no-untyped-def]
    """Add to row TAU what a cable pulls that is drawn along at its anchor."""
    r = (tether[1], tether[2], tether[3])
    v = _velocity_at(r, nu_1, nu_2)
    pull = -tether[0] * np.sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    _pull_at(sheet, r, (pull * v[0], pull * v[1], pull * v[2]))


@inlined
def _body_rates(sheet, q, nu_1, nu_2, flow, body):  # type: ignore[no-untyped-def]
    """Return dnu/dt [m/s^2, rad/s^2] as six numbers, under the wrench in row TAU."""
    nu = (nu_1[0], nu_1[1], nu_1[2], nu_2[0], nu_2[1], nu_2[2])
    size = (abs(nu[0]), abs(nu[1]), abs(nu[2]), abs(nu[3]), abs(nu[4]), abs(nu[5]))
    M, L, Q, K = body.M, body.D_L, body.D_Q, body.M_inverse
    a = (_row(M[0], nu), _row(M[1], nu), _row(M[2], nu))
    b = (_row(M[3], nu), _row(M[4], nu), _row(M[5], nu))
    turned, righted = coriolis(a, b, nu_1, nu_2), restoring(q, body.weight, body.buoyancy, body.r_G, body.r_B)
    f = (
        sheet[TAU, 0] - turned[0][0] - righted[0][0] - _drag(L[0], Q[0], nu, size),
        sheet[TAU, 1] - turned[0][1] - righted[0][1] - _drag(L[1], Q[1], nu, size),
        sheet[TAU, 2] - turned[0][2] - righted[0][2] - _drag(L[2], Q[2], nu, size),
        sheet[TAU, 3] - turned[1][0] - righted[1][0] - _drag(L[3], Q[3], nu, size),
        sheet[TAU, 4] - turned[1][1] - righted[1][1] - _drag(L[4], Q[4], nu, size),
        sheet[TAU, 5] - turned[1][2] - righted[1][2] - _drag(L[5], Q[5], nu, size),
    )
    carried = cross(nu_2, flow)
    return (
        _row(K[0], f) - carried[0], _row(K[1], f) - carried[1], _row(K[2], f) - carried[2],
        _row(K[3], f), _row(K[4], f), _row(K[5], f),
    )  # fmt: skip


@inlined
def _row(m, x):  # type: ignore[no-untyped-def]
    """Return the product of a matrix's row and x, of six numbers each."""
    return m[0] * x[0] + m[1] * x[1] + m[2] * x[2] + (m[3] * x[3] + m[4] * x[4] + m[5] * x[5])


@inlined
def _drag(linear, quadratic, x, size):  # type: ignore[no-untyped-def]
    """Return a row of (D_L + D_Q |x|) times x."""
    d, q = linear, quadratic
    first = (d[0] + q[0] * size[0]) * x[0] + (d[1] + q[1] * size[1]) * x[1] + (d[2] + q[2] * size[2]) * x[2]
    last = (d[3] + q[3] * size[3]) * x[3] + (d[4] + q[4] * size[4]) * x[4] + (d[5] + q[5] * size[5]) * x[5]
    return first + last
