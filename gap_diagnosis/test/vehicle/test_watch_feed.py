"""Pieces of a watched vehicle's log, of topics that are stamped alike, apart, late, or no more."""

import numpy as np
import pytest

from gap_diagnosis.vehicle.feed_io import Feed
from gap_diagnosis.vehicle.log import VehicleLog
from run_bag import RunError

PERIOD, NANO = 40_000_000, 1_000_000_000
BEGUN = 5 * NANO


class Vehicle:
    """Three thrusters whose throttles tell the time [s] at 25 Hz, and a gyro at 100 Hz."""

    def __init__(self, apart: int) -> None:
        """Each thruster's throttles are stamped so many nanoseconds after those of the one before."""
        self.feed, self.apart = Feed(3), apart
        self.pieces, self.refused = list[VehicleLog](), list[str]()

    def sail(self, begin: float, end: float, thrusters: tuple[int, ...] = (0, 1, 2), gyro: bool = True) -> None:
        for k in range(round(begin / 0.04), round(end / 0.04)):
            for quarter in range(4 if gyro else 0):
                stamp = BEGUN + k * PERIOD + quarter * PERIOD // 4
                self.feed.add(stamp, {f"rov/imu.angular_velocity.{axis}": 0.1 for axis in "xyz"})
                self.take()
            for i in thrusters:
                stamp = BEGUN + k * PERIOD + i * self.apart
                self.feed.add_throttle(i, stamp, (stamp - BEGUN) / NANO)
                self.take()

    def take(self) -> None:
        try:
            piece = self.feed.piece()
        except RunError as error:
            self.refused.append(str(error))
            return
        if piece is not None:
            self.pieces.append(piece)


@pytest.mark.parametrize("apart", [0, 1_000_000, 13_000_001])
def test_throttles_need_not_be_stamped_alike(apart: int) -> None:
    vehicle = Vehicle(apart)
    vehicle.sail(0.0, 10.0)
    assert len(vehicle.pieces) == 9
    told = np.concatenate([piece.throttles for piece in vehicle.pieces])
    # a value that tells its own time, held: over the period k its mean is 0.04 k, whatever its offset, to half a part
    assert told[1:] == pytest.approx(0.04 * np.arange(1, 225)[:, None] + np.zeros(3), rel=0.0, abs=0.005)
    assert np.isfinite(np.concatenate([piece.told[:, 3:6] for piece in vehicle.pieces[1:]])).all()


def test_commands_of_another_rate_are_not_mixed_and_change_at_the_instants_of_a_filter_of_their_period() -> None:
    period = 0.05
    for filtered, within in ((period, False), (0.04, True)):
        feed, pieces = Feed(1, filtered), []
        for k in range(200):
            stamp = BEGUN + round(k * period * NANO)
            feed.add(stamp, {f"rov/imu.angular_velocity.{axis}": 0.1 for axis in "xyz"})
            feed.add_throttle(0, stamp, float(k % 2))
            if (piece := feed.piece()) is not None:
                pieces.append(piece)
        told = np.concatenate([piece.commands for piece in pieces[1:]])
        assert set(np.unique(told)) == {0.0, 1.0}
        assert bool(np.any(np.diff(told, axis=1) != 0.0)) is within


def test_all_is_known_up_to_the_least_of_the_latest_stamps() -> None:
    feed = Feed(2)
    assert feed.known is None
    feed.add_throttle(0, BEGUN, 1.0)
    assert feed.known is None, "the other one may still come"
    feed.add_throttle(1, BEGUN - 3, 1.0)
    assert feed.known == BEGUN - 3
    feed.add_throttle(1, BEGUN + PERIOD, 1.0)
    assert feed.known == BEGUN
    feed.add(BEGUN + 2 * PERIOD, {"rov/depth.depth": 1.0})
    assert feed.known == BEGUN and feed.silent == []


def test_a_throttle_that_falls_silent_counts_as_zero_and_holds_nothing_up() -> None:
    vehicle = Vehicle(1_000_000)
    vehicle.sail(0.0, 4.0)
    assert vehicle.feed.silent == []
    vehicle.sail(4.0, 10.0, thrusters=(0, 2))
    assert vehicle.feed.silent == [1]
    told = np.concatenate([piece.throttles for piece in vehicle.pieces])
    assert len(told) == 200, "a second of silence later than if it spoke"
    assert told[105:120, 1] == pytest.approx(3.961), "held"
    assert np.all(told[126:, 1] == 0.0)
    assert np.all(np.diff(told[:, [0, 2]], axis=0) > 0.0)
    vehicle.sail(10.0, 15.0)
    assert vehicle.feed.silent == []
    told = np.concatenate([piece.throttles for piece in vehicle.pieces])
    assert len(told) == 13 * 25 + 25
    assert np.all(told[126:249, 1] == 0.0) and np.all(told[252:, 1] > 10.0)


def test_a_throttle_that_never_comes_is_waited_for_no_longer_than_one_that_falls_silent() -> None:
    vehicle = Vehicle(0)
    vehicle.sail(0.0, 6.0, thrusters=(0, 2))
    assert vehicle.feed.silent == [1] and len(vehicle.pieces) == 4
    assert np.all(vehicle.pieces[-1].throttles[:, 1] == 0.0)
    assert np.all(vehicle.pieces[-1].throttles[:, 0] >= 3.0)


def test_where_all_throttles_fall_silent_time_goes_on_and_nothing_heaps_up() -> None:
    vehicle = Vehicle(0)
    vehicle.sail(0.0, 3.0)
    vehicle.sail(3.0, 60.0, thrusters=())
    assert vehicle.feed.silent == [0, 1, 2] and len(vehicle.pieces) == 58
    assert np.all(vehicle.pieces[-1].throttles == 0.0)
    assert max(map(len, vehicle.feed._stamps.values())) < 1000


def test_a_piece_in_which_nothing_tells_the_motion_is_refused_and_the_next_one_follows() -> None:
    vehicle = Vehicle(0)
    vehicle.sail(0.0, 4.0)
    vehicle.sail(4.0, 12.0, gyro=False)
    vehicle.sail(12.0, 14.0)
    assert vehicle.refused and "expected rov/imu or rov/odometry with attitude or rates" in vehicle.refused[0]
    assert len(vehicle.refused) + len(vehicle.pieces) == 13
    assert np.isfinite(vehicle.pieces[-1].told[1:, 3:6]).all()
