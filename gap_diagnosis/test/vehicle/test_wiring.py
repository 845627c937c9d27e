"""Wiring from correlations: vehicles whose accelerations are made here, without any plant."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.conventions import conventions_of
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.log import VehicleLog, held
from gap_diagnosis.vehicle.mounting import MOUNTINGS, imu_mounted, named, turned_too
from gap_diagnosis.vehicle.wiring import wiring_of
from thruster_model.vehicle_set_io import load_vehicle_set

Array = NDArray[np.float64]
VEHICLE = load_vehicle_set("ngs")
MASS = np.asarray(VEHICLE.coefficients.mass_matrix)


def driven(
    K_t: Array, order: Sequence[int], signs: Sequence[float], *, seed: int = 1, unused: Sequence[int] = (),
    then: Sequence[int] | None = None, then_signs: Sequence[float] | None = None,
) -> VehicleLog:  # fmt: skip
    """Return the log of a level vehicle: thrust in proportion to the command of its wire, damping, noise.

    `then`, `then_signs`: order and signs in the second half, None: as in the first one.
    """
    rng = np.random.default_rng(seed)
    K, N = 1500, K_t.shape[1]
    u = np.repeat(rng.uniform(-2.0, 2.0, (K // 25, N)), 25, axis=0)
    u[:, list(unused)] = 0.0
    thrust, now, nu = np.zeros((K, N)), np.zeros(N), np.zeros((K + 1, 6))
    wired = np.zeros((K, N))
    for i in range(N):
        wired[: K // 2, order[i]] = signs[i] * u[: K // 2, i]
        later = (signs if then_signs is None else then_signs)[i]
        wired[K // 2 :, (order if then is None else then)[i]] = later * u[K // 2 :, i]
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
        name="made here", period=0.04, commands=held(u), attitude=np.tile([1.0, 0.0, 0.0, 0.0], (K, 1)), told=told,
        speeds=np.full((K, N), np.nan), battery=np.full((K, 2), np.nan), lateness=np.zeros((K, 5 + N)), noise=none,
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


def test_what_one_half_of_a_recording_denies_is_not_said() -> None:
    found = wiring_of(
        [driven(VEHICLE.configuration, [1, 0, 2, 3, 4, 5], [1.0] * 6, then=range(6))], VEHICLE.configuration, MASS
    )
    assert (found.verdict, found.order) == ("cannot_tell", tuple(range(6)))
    lasting = driven(VEHICLE.configuration, [1, 0, 2, 3, 4, 5], [1.0] * 6, then=[1, 0, 2, 3, 4, 5])
    assert wiring_of([lasting], VEHICLE.configuration, MASS).verdict == "wrong"


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


def with_dead(i: int, level: float, speeds: float) -> VehicleLog:
    """Return a log in which one thruster is commanded up to `level` [V], nothing answers, and its tachometer reads
    `speeds` [rad/s]; the others turn at 80."""
    log = driven(VEHICLE.configuration, range(6), [1.0] * 6, unused=[i])
    throttles, told = log.throttles.copy(), np.full(log.speeds.shape, 80.0)
    throttles[:, i] = np.repeat(np.random.default_rng(9).uniform(-level, level, len(throttles) // 25), 25)
    told[:, i] = speeds
    return replace(log, commands=held(throttles), speeds=told)


@pytest.mark.parametrize(
    ("speeds", "says"),
    [
        (0.0, "moves nothing; its tachometer says that it stands still: it is dead, or its wire is cut."),
        (np.nan, "moves nothing: it is dead, or its wire is cut."),
        (60.0, "moves nothing, though its tachometer says that it turns: its propeller is lost, or gives no thrust."),
    ],
)
def test_a_thruster_that_answers_no_command_is_called_dead(speeds: float, says: str) -> None:
    found = wiring_of([with_dead(3, 2.0, speeds)], VEHICLE.configuration, MASS, [0.5] * 6)
    assert found.dead == (3,) and found.sentences == (f"Thruster 3 was commanded up to 2 V and {says}",)


def test_no_thruster_is_called_dead_that_moves_the_vehicle_in_one_half() -> None:
    signs = [1.0, 1.0, 1.0, 0.5, 1.0, 1.0]
    log = driven(VEHICLE.configuration, range(6), signs, then_signs=[-0.6 if s < 1.0 else s for s in signs])
    found = wiring_of([log], VEHICLE.configuration, MASS, [0.5] * 6)
    assert found.dead == () and 3 in found.silent


def test_no_thruster_is_called_dead_that_was_commanded_within_its_dead_zone_or_among_noise() -> None:
    weak = with_dead(3, 0.7, 0.0)
    assert wiring_of([weak], VEHICLE.configuration, MASS, [0.5] * 6).dead == ()
    log = with_dead(3, 2.0, 0.0)
    noise = np.random.default_rng(6).normal(size=log.told.shape) * np.repeat((0.5, 3.0, 0.0), (6, 3, 4))
    found = wiring_of([replace(log, told=log.told + noise)], VEHICLE.configuration, MASS, [0.5] * 6)
    assert found.dead == () and 3 in found.silent
    for seed in range(4):
        sound = driven(VEHICLE.configuration, range(6), [1.0] * 6, seed=seed)
        assert wiring_of([sound], VEHICLE.configuration, MASS, [0.5] * 6).dead == ()


def test_without_an_attitude_the_gyro_alone_tells_a_wrong_wire() -> None:
    blind = replace(driven(VEHICLE.configuration, range(6), [1.0] * 6), attitude=np.full((1500, 4), np.nan))
    found = wiring_of([blind], VEHICLE.configuration, MASS)
    assert (found.verdict, found.silent) == ("as_stated", ())
    turned = replace(driven(VEHICLE.configuration, range(6), [1.0, -1.0] + [1.0] * 4), attitude=blind.attitude)
    found = wiring_of([turned], VEHICLE.configuration, MASS)
    assert (found.verdict, found.signs) == ("wrong", (1, -1, 1, 1, 1, 1))


@pytest.mark.parametrize("attitude", ["right", "turned too", "none"])
@pytest.mark.parametrize("k", [1, 7, 13, 22])
def test_a_turned_imu_is_one_finding_and_no_wrong_wire(k: int, attitude: str) -> None:
    R = MOUNTINGS[k]
    true = driven(VEHICLE.configuration, range(6), [1.0] * 6)
    told = true.told.copy()
    for at in (slice(3, 6), slice(6, 9)):
        told[:, at] = true.told[:, at] @ R  # R^T y
    q = {"right": (1.0, 0.0, 0.0, 0.0), "none": (np.nan,) * 4}.get(attitude)
    if q is None:
        q = Rotation.from_matrix(R).as_quat()[[3, 0, 1, 2]]
    log = replace(true, told=told, attitude=np.tile(q, (len(told), 1)))
    found = conventions_of(load_model("ngs"), [log])
    assert (found.verdict, found.wiring.order, found.wiring.signs) == ("turned", tuple(range(6)), (1,) * 6)
    np.testing.assert_array_equal(found.imu.R, R)
    assert found.sentences[0].startswith("The IMU is mounted turned: its ")
    read = found.read(log)
    np.testing.assert_allclose(read.told, true.told)
    assert [each.effect for each in read.oddities] == ["imu_misalignment"]


@pytest.mark.parametrize("seed", range(4))
def test_a_noisy_gyro_alone_shows_every_wire(seed: int) -> None:
    log = driven(VEHICLE.configuration, [4, 1, 2, 3, 0, 5], [1.0] * 6, seed=seed)
    told = log.told + 0.15 * np.random.default_rng(50 + seed).normal(size=log.told.shape)
    told[:, 6:9] = np.nan
    found = wiring_of([replace(log, told=told)], VEHICLE.configuration, MASS)
    assert (found.verdict, found.order, found.silent) == ("wrong", (4, 1, 2, 3, 0, 5), ())


def test_an_attitude_that_is_told_less_often_than_the_gyro_hides_no_wire() -> None:
    log = driven(VEHICLE.configuration, [4, 1, 2, 3, 0, 5], [1.0] * 6)
    attitude = log.attitude.copy()
    attitude[1::2] = np.nan
    found = wiring_of([replace(log, attitude=attitude)], VEHICLE.configuration, MASS)
    assert (found.verdict, found.order, found.silent) == ("wrong", (4, 1, 2, 3, 0, 5), ())


def test_there_are_24_mountings_and_the_stated_one_is_the_first() -> None:
    assert len({R.tobytes() for R in MOUNTINGS}) == 24
    np.testing.assert_array_equal(MOUNTINGS[0], np.eye(3))
    assert named(np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])) == ("-y", "x", "z")


def test_a_turned_imu_hides_no_wrong_wire_beside_it() -> None:
    true = driven(VEHICLE.configuration, [0, 1, 2, 4, 3, 5], [1.0] * 6)
    told = true.told.copy()
    told[:, 3:6], told[:, 6:9] = true.told[:, 3:6] @ MOUNTINGS[5], true.told[:, 6:9] @ MOUNTINGS[5]
    found = wiring_of([replace(true, told=told)], VEHICLE.configuration, MASS)
    assert (found.verdict, found.order) == ("wrong", (0, 1, 2, 4, 3, 5)) and found.gain > 0.0


@pytest.mark.parametrize("turn", [R for R in MOUNTINGS if R[2, 2] == 1.0])
def test_an_attitude_is_turned_back_where_it_was_turned_with_the_gyro(turn: Array) -> None:
    t = 0.04 * np.arange(400)
    body = Rotation.from_euler("ZYX", np.stack((np.sin(t), 0.3 * np.sin(1.3 * t), 0.4 * np.cos(0.7 * t)), axis=1))
    rates = (body[:-1].inv() * body[1:]).as_rotvec() / 0.04
    true = driven(VEHICLE.configuration, range(6), [1.0] * 6)
    told = true.told[:400].copy()
    told[:, 3:6] = np.vstack((rates, rates[-1])) @ turn
    for given in (body, body * Rotation.from_matrix(turn)):
        log = replace(true.part(0, 400), told=told, attitude=given.as_quat()[:, [3, 0, 1, 2]])
        read = Rotation.from_quat(imu_mounted(log, turn, turned_too([log], turn)).attitude[:, [1, 2, 3, 0]])
        assert (read.inv() * body).magnitude().max() < 1e-6
