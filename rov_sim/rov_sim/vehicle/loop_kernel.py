"""The closed loop of a vehicle: all periods of a run in one kernel, in the order of the nodes of the graph.

At t_k = k dt, k = 1, 2, …:
1. sensors read the truth where they are due;
2. the feedback: the truth with Gaussian noise, or what the navigation filter makes of the readings;
3. the set point of t_k;
4. the outer loop's wrench and its allocation; U = K_t^T nu of what is fed back;
5., 6. observers and inner loops (`inner_loops`);
7. the plant holds the throttles until t_k+1.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rov_sim.vehicle.inner_loops import ESTIMATES, inner_loops_tick
from rov_sim.vehicle.kernel import advance_period, measured
from rov_sim.vehicle.noisy_odometry import odometry_with
from rov_sim.vehicle.sensors.in_loop import heard_at, speed_at
from rov_sim.vehicle.tables import BODY
from thruster_control.allocation.allocate import allocate
from thruster_control.outer_loop.step import note_achieved, outer_loop_step
from thruster_control.vehicle_set_points import set_point_at
from thruster_estimation.navigation import begun, navigation_first, navigation_step
from thruster_estimation.navigation_belief import Heard
from thruster_estimation.navigation_output import navigation_motion
from thruster_model.compilation import compiled, equation

__all__ = ["Feedback", "Outer", "Plant", "Record", "record_of", "run_vehicle_loop"]

Array = NDArray[np.float64]
_NOTHING = (np.nan,) * len(Heard._fields)


class Feedback(NamedTuple):
    """What is fed back.

    Attributes:
        estimator: 1: the navigation filter on the sensors; 0: the truth with `errors`.
        errors: of the odometry (K, 9).
        sensors: `LoopSensors`; navigation: `NavigationSettings`.
    """

    estimator: int
    errors: Array
    sensors: Any
    navigation: Any


class Outer(NamedTuple):
    """The outer loop: law, the vehicle as it believes it, allocation with the limits (N,) [N], and its memories.

    kinematic: 1: observers are told U = K_t^T nu as measured; 0: nothing.
    """

    law: Any
    vehicle: Any
    allocation: Any
    lower: Array
    upper: Array
    memory: Any
    allocated: Any
    kinematic: int


class Record(NamedTuple):
    """What a run leaves, rows at the beginnings of its K periods, SI units.

    points (K, 15): set points, by the fields of `VehicleSetPoint`; position (K, 3), attitude (K, 4), velocity (K, 6):
    the truth; told_attitude, told_velocity: what was fed back;
    wrench (K, 6): wanted; T_d, n, axial, ambient, thrust (K, N): wanted thrust and the truth of each thruster;
    y_n, y_U (K, N): what observers got; estimates (K, N, len(ESTIMATES)); status (K, 3): of the outer loop, of the
    allocation, of the navigation filter.
    """

    points: Array
    position: Array
    attitude: Array
    velocity: Array
    told_attitude: Array
    told_velocity: Array
    wrench: Array
    T_d: Array
    n: Array
    axial: Array
    ambient: Array
    thrust: Array
    y_n: Array
    y_U: Array
    estimates: Array
    status: NDArray[np.int64]


def record_of(periods: int, thrusters: int) -> Record:
    """Return an empty record."""
    arrays: list[Any] = [np.empty((periods, size)) for size in (15, 3, 4, 6, 4, 6, 6)]
    arrays += [np.empty((periods, thrusters)) for _ in range(7)]
    arrays += [np.empty((periods, thrusters, len(ESTIMATES))), np.zeros((periods, 3), dtype=np.int64)]
    return Record(*arrays)


@compiled
def _outer_tick(outer, told_attitude, told_velocity, point, dt, wrench, T_d, y_U, status):  # type: ignore[no-untyped-def]
    """Fill wrench, T_d and y_U of tick k from what is fed back."""
    status[0] = outer_loop_step(outer.memory, told_attitude, told_velocity, point, dt, outer.law, outer.vehicle, wrench)
    _, status[1] = allocate(wrench, outer.lower, outer.upper, outer.allocation, outer.allocated, T_d)
    note_achieved(outer.memory, wrench, outer.allocated.achieved)
    for i in range(T_d.size):
        y_U[i] = np.nan
        if outer.kinematic != 0:
            y_U[i] = 0.0
            for j in range(6):
                y_U[i] += outer.vehicle.inflow[j, i] * told_velocity[j]


@compiled
def _navigated(belief, heard, first, dt, settings, told_attitude, told_velocity):  # type: ignore[no-untyped-def]
    """Return the filter's belief after a tick; fill attitude and velocity."""
    if first:
        belief, _ = navigation_first(heard, settings)
    else:
        belief, _ = navigation_step(belief, heard, dt, settings)
    _, attitude, velocity = navigation_motion(belief, settings)
    for i in range(4):
        told_attitude[i] = attitude[i]
    for i in range(6):
        told_velocity[i] = velocity[i]
    return belief


class Plant(NamedTuple):
    """The true vehicle as `kernel` takes it.

    Attributes:
        sheet: with the state; out: a row of `measured`.
        gate: of each thruster (N,); wrench: from outside (6,) [N, N m].
        tables: of the vehicle.
        steps: of each period; step: [s].
    """

    sheet: Array
    out: Array
    gate: Array
    wrench: Array
    tables: Any
    steps: int
    step: float


@equation
def _recorded(record, j, out):  # type: ignore[no-untyped-def]
    """Keep the truth of a tick as row j."""
    N = record.n.shape[1]
    at = BODY + 8
    record.position[j], record.attitude[j], record.velocity[j] = out[:3], out[3:7], out[7:13]
    record.n[j], record.axial[j], record.ambient[j] = (
        out[at : at + N],
        out[at + N : at + 2 * N],
        out[at + 2 * N : at + 3 * N],
    )
    record.thrust[j] = out[at + 4 * N : at + 5 * N]


@equation
def _kept(point, row):  # type: ignore[no-untyped-def]
    for i in range(3):
        row[i], row[3 + i], row[6 + i] = point.attitude[i], point.attitude_rate[i], point.attitude_acceleration[i]
        row[9 + i], row[12 + i] = point.velocity[i], point.acceleration[i]


@compiled
def _advanced(plant, throttles):  # type: ignore[no-untyped-def]
    """Advance the plant by a period under held throttles (N,) [V], and read it."""
    s, t = plant, plant.tables
    advance_period(s.sheet, throttles, s.steps, s.step, s.gate, s.wrench, t.body, t.layout, t.p, t.e)
    measured(s.sheet, s.gate, s.wrench, t.body, t.layout, t.p, t.e, s.out)


@compiled
def run_vehicle_loop(script, plant, dt, f, outer, loops, wiring, observer, law, p_c, record):  # type: ignore[no-untyped-def]
    """Run the ticks k = 1 ... K of `record`'s K rows, `dt` [s] apart, from a plant at rest at time 0.

    Args:
        script: set points; plant: `Plant`; f: `Feedback`; outer: `Outer`; loops, wiring: of `inner_loops`.
        observer, law, p_c: settings and coefficients of the inner loops.
        record: `Record`, filled.
    """
    N = record.n.shape[1]
    x = plant.out
    throttles = np.zeros(N)
    belief = begun(Heard(*_NOTHING), f.navigation, 0)
    for j in range(record.n.shape[0]):
        k = j + 1
        _advanced(plant, throttles)
        _recorded(record, j, x)
        for i in range(N):
            record.y_n[j, i] = speed_at(k, i, record.n[j, i], f.sensors)
        told_attitude, told_velocity = record.told_attitude[j], record.told_velocity[j]
        if f.estimator != 0:
            heard = heard_at(k, x[:3], x[3:7], x[7:13], x[BODY : BODY + 6], x[BODY + 7], f.sensors)
            belief = _navigated(belief, heard, j == 0, dt, f.navigation, told_attitude, told_velocity)
            record.status[j, 2] = belief.status
        else:
            odometry_with(x[3:7], x[7:13], f.errors[j], told_attitude, told_velocity)
        point = set_point_at(script, k * dt)
        _kept(point, record.points[j])
        _outer_tick(
            outer, told_attitude, told_velocity, point, dt, record.wrench[j], record.T_d[j],
            record.y_U[j], record.status[j],
        )  # fmt: skip
        inner_loops_tick(
            loops, j == 0, record.T_d[j], record.y_n[j], record.y_U[j], dt, wiring, observer, law, p_c,
            record.estimates[j],
        )  # fmt: skip
        for i in range(N):
            throttles[i] = loops.held[i]
