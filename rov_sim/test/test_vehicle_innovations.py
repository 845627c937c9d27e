"""The plant corrected by its sensors: without gains it is the plant, with them it follows what is measured."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from rov_sim.vehicle.innovations import (
    CHANNELS,
    CORRECTED,
    PARTS,
    followed_charge,
    innovations,
    past_width,
    states_of,
    states_width,
)
from rov_sim.vehicle.kernel import FINE
from rov_sim.vehicle.plant import VehicleSettings, sheet_of, simulate
from rov_sim.vehicle.sensors.coefficients import sensor_coefficients
from rov_sim.vehicle.sensors.settings_io import load_sensors
from rov_sim.vehicle.settings_io import load_vehicle_settings

Array = NDArray[np.float64]
PERIOD, K = 0.04, 100


@pytest.fixture(scope="module")
def settings() -> VehicleSettings:
    return load_vehicle_settings("ngs", largest_step=0.02)


@pytest.fixture(scope="module")
def throttles() -> Array:
    return np.repeat(np.random.default_rng(1).uniform(-2.0, 2.0, (K // 20, 6)), 20, axis=0)


def ran(
    settings: VehicleSettings, throttles: Array, attitude: Array, gains: Array, late: float = 0.0,
    voltages: Array | None = None, charge: Array | None = None, speeds: Array | None = None, older: float = 0.0,
    currents: Array | None = None, sheet: Array | None = None, past: Array | None = None,
) -> list[Array]:  # fmt: skip
    """Return innovations of the body (K, 13), of N rotors and of the battery and states (K, ...) for attitudes,
    voltages, currents and speeds told, nothing else; late: the IMU [s]; charge: as of `innovations`, by default not
    followed; older: readings, than their instants, in periods; sheet, past: of a run that goes on. Speeds correct those
    of the rotors by half."""
    K = len(throttles)
    battery = np.full((K, 2), np.nan)
    if currents is not None:
        battery[:, 1] = currents
    if voltages is not None:
        battery[:, 0] = voltages
    N, steps = settings.count, settings.steps_in(PERIOD / PARTS)
    told = np.full((K, CHANNELS), np.nan)
    out: list[Any] = [np.empty((K, CHANNELS)), np.empty((K, N)), np.empty((K, 2)), np.empty((K, states_width(N)))]
    kernel: Any = innovations
    held = np.repeat(throttles[:, None], PARTS, axis=1)
    done = kernel(
        sheet_of(settings) if sheet is None else sheet, held, steps, PERIOD / PARTS / steps, FINE,
        np.zeros((K, 6)), 0.98, *settings.tables,
        sensor_coefficients(load_sensors())._replace(imu_late=late), np.tile([1.0, 0.0], (N, 1)), attitude, told,
        np.full((K, N), np.nan) if speeds is None else speeds,
        battery, np.full((K, 5 + N), older), gains, np.full((K, N), 0.5),
        followed_charge(np.inf) if charge is None else charge,
        np.full(past_width(N), np.nan) if past is None else past, *out,
    )  # fmt: skip
    assert done == K
    return out


def run(*given: Any, **named: Any) -> tuple[Array, Array]:
    """Return innovations of the body and of N rotors (K, 13 + N) and states (K, ...), see `ran`."""
    body, rotors, _, states = ran(*given, **named)
    return np.hstack((body, rotors)), states


def test_without_gains_it_is_the_plant(settings: VehicleSettings, throttles: Array) -> None:
    truth = simulate(settings, throttles, PERIOD)
    e, states = run(settings, throttles, truth.attitude[:-1], np.zeros((K, CORRECTED, CHANNELS)))
    # The filter's steps are split where the last throttle is reached, the plant's at each (`kernel.advance`).
    assert states[:, 3:7] == pytest.approx(truth.attitude[:-1], rel=0.0, abs=1e-5)
    assert states[:, 7:13] == pytest.approx(truth.velocity[:-1], rel=0.0, abs=1e-5)
    assert np.abs(e[:, :3]).max() < 1e-5
    assert np.all(np.isnan(e[:, 3:CHANNELS]))


@pytest.mark.parametrize("halves", [1, 3, 4])
def test_a_late_imu_is_expected_to_tell_what_was(settings: VehicleSettings, throttles: Array, halves: int) -> None:
    truth = simulate(settings, np.repeat(throttles, 2, axis=0), PERIOD / 2.0)
    told = truth.attitude[np.maximum(2 * np.arange(K) - halves, 0)]
    none, some = np.zeros((K, CORRECTED, CHANNELS)), np.zeros((K, CORRECTED, CHANNELS))
    some[:, :3, :3] = 0.5 * np.eye(3)
    whole = slice(2, K - 2)
    believed, _ = run(settings, throttles, told, none)
    for gains in (none, some):
        late, _ = run(settings, throttles, told, gains, halves * PERIOD / 2.0)
        assert np.abs(late[whole, :3]).max() < 0.05 * np.abs(believed[whole, :3]).max()


@pytest.mark.parametrize("eighths", [1, 4, 7])
def test_readings_between_instants_are_expected_as_it_was_then(
    settings: VehicleSettings, throttles: Array, eighths: int
) -> None:
    truth = simulate(settings, np.repeat(throttles, 8, axis=0), PERIOD / 8.0)
    at = np.maximum(8 * np.arange(K) - eighths, 0)
    told = truth.attitude[at], truth.n[at]
    none = np.zeros((K, CORRECTED, CHANNELS))
    late, _ = run(settings, throttles, told[0], none, speeds=told[1], older=eighths / 8.0)
    taken_as_now, _ = run(settings, throttles, told[0], none, speeds=told[1])
    whole = slice(2, K)
    for of, share in ((slice(0, 3), 0.1), (slice(CHANNELS, None), 0.15)):
        assert np.abs(late[whole, of]).max() < share * np.abs(taken_as_now[whole, of]).max()


def test_with_gains_it_follows_the_attitude_that_is_told(settings: VehicleSettings, throttles: Array) -> None:
    turned = np.tile([np.cos(0.1), 0.0, 0.0, np.sin(0.1)], (K, 1))  # 0.2 rad of yaw, where the plant is told nothing
    gains = np.zeros((K, CORRECTED, CHANNELS))
    gains[:, :3, :3] = 0.5 * np.eye(3)
    e, _ = run(settings, np.zeros_like(throttles), turned, gains)
    assert e[0, 2] == pytest.approx(0.2)
    assert e[:4, 2] == pytest.approx(0.2 * 0.5 ** np.arange(4), rel=0.02)
    assert abs(e[20, 2]) < 1e-3


def test_readings_move_a_rotor_that_turns_and_not_one_that_has_stopped(
    settings: VehicleSettings, throttles: Array
) -> None:
    turning = np.array([1.0, 1.0, 0.0, 1.0, 1.0, 1.0])
    stopped = replace(settings, coefficients=settings.coefficients._replace(turning=turning))
    level, none = np.tile([1.0, 0.0, 0.0, 0.0], (K, 1)), np.zeros((K, CORRECTED, CHANNELS))
    _, states = run(stopped, np.zeros_like(throttles), level, none, speeds=np.full((K, 6), 3.0))
    speeds = states_of(states).speeds
    assert np.all(speeds[:, 2] == 0.0)
    assert np.all(speeds[:, turning == 1.0] > 1.0)


NOMINAL = sensor_coefficients(load_sensors()).nominal_voltage


def test_a_battery_that_is_told_to_be_low_feeds_its_thrusters_less(settings: VehicleSettings, throttles: Array) -> None:
    level, none = np.tile([1.0, 0.0, 0.0, 0.0], (K, 1)), np.zeros((K, CORRECTED, CHANNELS))
    weak = replace(settings, coefficients=settings.coefficients._replace(supply=0.9))
    _, expected = run(weak, throttles, level, none)
    charge = followed_charge(500.0)
    _, found = run(settings, throttles, level, none, voltages=np.full(K, 0.9 * NOMINAL), charge=charge)
    assert found[:, :13] == pytest.approx(expected[:, :13], rel=0.0, abs=1e-9)
    assert charge[0] == pytest.approx(0.9)
    _, full = run(settings, throttles, level, none)
    assert np.abs(full[:, 7:13] - expected[:, 7:13]).max() > 0.01


def test_a_charge_is_followed_slowly_and_what_falls_at_once_is_left(
    settings: VehicleSettings, throttles: Array
) -> None:
    level, none = np.tile([1.0, 0.0, 0.0, 0.0], (K, 1)), np.zeros((K, CORRECTED, CHANNELS))
    voltages = np.where(np.arange(K) < K - 5, NOMINAL, 0.9 * NOMINAL)
    charge = followed_charge(250.0)
    run(settings, throttles, level, none, voltages=voltages, charge=charge)
    assert 0.98 < charge[0] < 1.0


def test_a_battery_that_empties_evenly_is_not_followed_late(settings: VehicleSettings, throttles: Array) -> None:
    level, none = np.tile([1.0, 0.0, 0.0, 0.0], (K, 1)), np.zeros((K, CORRECTED, CHANNELS))
    charge = followed_charge(50.0)
    told = 1.0 - 5e-4 * np.arange(2 * K)
    for piece in (told[:K], told[K:]):
        run(settings, throttles, level, none, voltages=NOMINAL * piece, charge=charge)
    assert charge[0] == pytest.approx(told[-1] - 5e-4, abs=5e-5)  # a mean of the last 50 would be 0.02 late


def test_a_charge_is_followed_alike_in_one_piece_and_in_two_and_as_matrices_have_it(
    settings: VehicleSettings, throttles: Array
) -> None:
    level, none = np.tile([1.0, 0.0, 0.0, 0.0], (K, 1)), np.zeros((K, CORRECTED, CHANNELS))
    told = np.where(np.arange(2 * K) % 30 == 0, NOMINAL * (1.0 - 1e-6 * np.arange(2 * K) ** 2), np.nan)  # over the seam
    charge = followed_charge(40.0)
    for piece in (told[:K], told[K:]):
        run(settings, throttles, level, none, voltages=piece, charge=charge)
    x, last, P = np.array([1.0, 0.0]), -1, np.diag(followed_charge(40.0)[[3, 5]])
    for k, voltage in enumerate(told):
        if np.isfinite(voltage):
            m = k - last
            F = np.array([[1.0, m], [0.0, 1.0]])
            P = F @ P @ F.T + m / 40.0**4 * np.array([[m**3 / 3.0, m**2 / 2.0], [m**2 / 2.0, m]])
            G = P[:, 0] / (P[0, 0] + 1.0)
            x, P, last = x + G * (voltage / NOMINAL - x[0]), P - np.outer(G, P[0]), k
        x[0] += x[1]
    assert charge[[0, 2]] == pytest.approx(x, abs=1e-9)


def test_a_current_is_expected_alike_in_one_piece_and_instant_by_instant(
    settings: VehicleSettings, throttles: Array
) -> None:
    level, none = np.tile([1.0, 0.0, 0.0, 0.0], (K, 1)), np.zeros((K, CORRECTED, CHANNELS))
    told = np.where(np.arange(K) % 5 == 2, 0.0, np.nan)
    whole = ran(settings, throttles, level, none, older=0.4, currents=told)[2][:, 1]
    sheet, past = sheet_of(settings), np.full(past_width(settings.count), np.nan)
    pieces = [
        ran(
            settings, throttles[k : k + 1], level[:1], none[:1], older=0.4, currents=told[k : k + 1], sheet=sheet,
            past=past,
        )[2][0, 1]
        for k in range(K)
    ]  # fmt: skip
    assert np.isfinite(whole).sum() == K // 5 and np.ptp(whole[np.isfinite(whole)]) > 1.0
    assert pieces == pytest.approx(whole, abs=1e-9, nan_ok=True)
