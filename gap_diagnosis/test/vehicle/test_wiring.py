"""Wiring from correlations: vehicles whose accelerations are made here, without any plant."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.wiring import wiring_of
from thruster_model.vehicle_set_io import load_vehicle_set

Array = NDArray[np.float64]
VEHICLE = load_vehicle_set("ngs")
MASS = np.asarray(VEHICLE.coefficients.mass_matrix)


def driven(
    K_t: Array, order: Sequence[int], signs: Sequence[float], *, seed: int = 1, unused: Sequence[int] = ()
) -> VehicleLog:
    """Return the log of a level vehicle: thrust in proportion to the command of its wire, damping, noise."""
    rng = np.random.default_rng(seed)
    K, N = 1500, K_t.shape[1]
    u = np.repeat(rng.uniform(-2.0, 2.0, (K // 25, N)), 25, axis=0)
    u[:, list(unused)] = 0.0
    thrust, now, nu = np.zeros((K, N)), np.zeros(N), np.zeros((K + 1, 6))
    wired = np.zeros((K, N))
    for i in range(N):
        wired[:, order[i]] = signs[i] * u[:, i]
    acceleration = np.zeros((K, 6))
    for k in range(K):
        now = now + 0.3 * (3.0 * wired[k] * np.abs(wired[k]) - now)
        thrust[k] = now
        acceleration[k] = np.linalg.solve(MASS, K_t @ now) - 0.8 * nu[k]
        nu[k + 1] = nu[k] + 0.04 * acceleration[k]
    told = np.full((K, 13), np.nan)
    told[:, 3:6] = nu[:-1, 3:] + 0.002 * rng.normal(size=(K, 3))
    told[:, 6:9] = acceleration[:, :3] - [0.0, 0.0, 9.81] + 0.03 * rng.normal(size=(K, 3))
    none = np.full(13, np.nan)
    return VehicleLog(
        name="made here", period=0.04, throttles=u, attitude=np.tile([1.0, 0.0, 0.0, 0.0], (K, 1)), told=told,
        speeds=np.full((K, N), np.nan), battery=np.full((K, 2), np.nan), lateness=np.zeros(K), noise=none,
        speed_noise=np.full(N, np.nan), battery_noise=np.full(2, np.nan),
    )  # fmt: skip


def test_a_vehicle_as_stated_is_found_as_stated() -> None:
    K_t = VEHICLE.configuration
    for seed in range(8):
        assert wiring_of([driven(K_t, range(6), [1.0] * 6, seed=seed)], K_t, MASS).verdict == "as_stated"


@pytest.mark.parametrize("pair", [(0, 1), (0, 4), (2, 5), (3, 4)])
def test_an_exchange_is_found_with_both_its_thrusters(pair: tuple[int, int]) -> None:
    order = list(range(6))
    order[pair[0]], order[pair[1]] = order[pair[1]], order[pair[0]]
    found = wiring_of([driven(VEHICLE.configuration, order, [1.0] * 6)], VEHICLE.configuration, MASS)
    assert (found.verdict, found.order) == ("wrong", tuple(order))


@pytest.mark.parametrize("i", range(6))
def test_a_thruster_the_other_way_round_is_found(i: int) -> None:
    signs = [1.0] * 6
    signs[i] = -1.0
    found = wiring_of([driven(VEHICLE.configuration, range(6), signs)], VEHICLE.configuration, MASS)
    assert (found.verdict, found.signs) == ("wrong", tuple(int(s) for s in signs))
    assert f"The command of thruster {i} drives it the other way round." in found.sentences


def test_thrusters_that_push_alike_are_named_and_their_exchange_is_no_finding() -> None:
    K_t = VEHICLE.configuration.copy()
    K_t[:, 1] = K_t[:, 0]
    found = wiring_of([driven(K_t, [1, 0, 2, 3, 4, 5], [1.0] * 6)], K_t, MASS)
    assert found.verdict == "as_stated" and found.alike == ((0, 1),)
    assert any("an exchange among them cannot be seen" in s for s in found.sentences)


def test_a_thruster_that_is_never_commanded_is_said_to_be_unknown() -> None:
    found = wiring_of([driven(VEHICLE.configuration, range(6), [1.0] * 6, unused=[3])], VEHICLE.configuration, MASS)
    assert 3 in found.silent
    assert any("never commanded" in s for s in found.sentences)


def test_without_an_attitude_the_gyro_alone_tells_a_wrong_wire() -> None:
    blind = replace(driven(VEHICLE.configuration, range(6), [1.0] * 6), attitude=np.full((1500, 4), np.nan))
    found = wiring_of([blind], VEHICLE.configuration, MASS)
    assert (found.verdict, found.silent) == ("as_stated", ())
    turned = replace(driven(VEHICLE.configuration, range(6), [1.0, -1.0] + [1.0] * 4), attitude=blind.attitude)
    found = wiring_of([turned], VEHICLE.configuration, MASS)
    assert (found.verdict, found.signs) == ("wrong", (1, -1, 1, 1, 1, 1))
