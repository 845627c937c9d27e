"""Sensors and navigation filter as a compiled loop calls them: the numbers of the live ones."""

from dataclasses import replace

import numpy as np
import pytest
from vehicle_motion import DEFAULT, at, moving

from rov_sim.vehicle.sensors.believed import navigation_settings
from rov_sim.vehicle.sensors.coefficients import sensor_coefficients
from rov_sim.vehicle.sensors.in_loop import heard_at, loop_sensors, speed_at
from rov_sim.vehicle.sensors.live import Sensors
from thruster_estimation.navigation import navigation_first, navigation_step
from thruster_estimation.navigation_belief import Heard
from thruster_estimation.navigation_online import NAVIGATION_START, LateReading, navigation_advance
from thruster_estimation.navigation_output import compiled_output, navigation_output

TICK = 10_000_000  # ns


def loop(position, attitude, velocity, acceleration, n, current, s, settings, heard, speeds, found):  # type: ignore[no-untyped-def]
    """A closed loop without its controller: truth, readings, filter, at every tick."""
    told = heard_at(1, position[1], attitude[1], velocity[1], acceleration[1], current[1], s)
    belief, _ = navigation_first(told, settings)
    for k in range(1, position.shape[0]):
        if k > 1:
            told = heard_at(k, position[k], attitude[k], velocity[k], acceleration[k], current[k], s)
            belief, _ = navigation_step(belief, told, 0.01, settings)
        for j in range(14):
            heard[k, j] = told[j]
        for i in range(n.shape[1]):
            speeds[k, i] = speed_at(k, i, n[k, i], s)
        out = navigation_output(belief, settings)
        for j in range(6):
            found[k, j] = out.velocity[j]


@pytest.mark.parametrize(("late", "old"), [(0.0, 0.0), (0.035, 0.03)])
def test_a_loop_hears_and_believes_what_the_live_ones_do(late: float, old: float) -> None:
    truth = moving(0.01 * np.arange(401), thrusters=2)
    c = sensor_coefficients(DEFAULT)._replace(velocity_late=late, imu_late=old)
    settings = navigation_settings(DEFAULT)
    s = loop_sensors(DEFAULT, 9, 2, 400, TICK, c)
    heard, speeds, found = np.full((401, 14), np.nan), np.full((401, 2), np.nan), np.empty((401, 6))
    t = truth
    loop(t.position, t.attitude, t.velocity, t.acceleration, t.n, t.current, s, settings, heard, speeds, found)

    subject, track = Sensors(DEFAULT, 9, 2, c), NAVIGATION_START
    names = {"velocity": ("velocity_x", "velocity_y", "velocity_z"), "depth": ("depth",)}
    for k in range(1, 401):
        readings = {(r.sensor, r.thruster): r for r in subject.read(k * TICK, at(truth, k))}
        np.testing.assert_array_equal(heard[k, :10], readings["imu", -1].values)
        for i in (0, 1):
            if ("tachometer", i) in readings:
                assert speeds[k, i] == readings["tachometer", i].values[0]
            else:
                assert np.isnan(speeds[k, i])
        others = []
        for name, fields in names.items():
            if (name, -1) in readings:
                r = readings[name, -1]
                others.append(LateReading(r.stamp, dict(zip(fields, r.values, strict=True))))
        expected = [value for reading in others for value in reading.values.values()]
        given = heard[k, 10:][np.isfinite(heard[k, 10:])]
        np.testing.assert_array_equal(given, [value for value in expected if np.isfinite(value)])
        track = navigation_advance(track, k * TICK, Heard(*readings["imu", -1].values), others, settings)
    assert track.belief is not None
    np.testing.assert_allclose(found[400], compiled_output(track.belief, settings).velocity, rtol=1e-9)


def test_sensors_that_a_loop_cannot_hold_are_refused_in_sentences() -> None:
    with pytest.raises(ValueError, match=r"imu: expected readings at multiples of 0.04 s; found them from 0.01 s on"):
        loop_sensors(DEFAULT, 0, 1, 10, 4 * TICK)
    slow = replace(DEFAULT, depth=replace(DEFAULT.depth, delay=0.1))
    with pytest.raises(ValueError, match=r"depth: delay: expected 0 s within a compiled loop; found 0.1 s"):
        loop_sensors(slow, 0, 1, 10, TICK)


def test_a_sensor_that_is_not_there_is_never_heard() -> None:
    truth = moving(0.01 * np.arange(41), thrusters=1)
    s = loop_sensors(replace(DEFAULT, velocity=replace(DEFAULT.velocity, rate=0.0)), 0, 1, 40, TICK)
    for k in range(1, 41):
        now = at(truth, k)
        told = heard_at(k, now.position, now.attitude, now.velocity, now.acceleration, now.current, s)
        assert np.isnan(told.velocity_x)
