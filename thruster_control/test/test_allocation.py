"""Allocation of wrenches: values worked out by others, exact solvers, dead zones, failures."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import linprog, lsq_linear

from thruster_control.allocation.allocate import AllocationStatus, allocate, compiled_allocate
from thruster_control.allocation.bounded_least_squares import compiled_bounded_least_squares
from thruster_control.allocation.configuration import inverse, lost_directions, null_vectors
from thruster_control.allocation.failures import Failure, FailureKind, allocation, failures_in_words, known, problem
from thruster_control.allocation.limits import constant_limits, limits_at, limits_of_sets, steady_thrust
from thruster_control.allocation.settings import AllocationMemory, AllocationSettings, Method, allocation_memory
from thruster_model.parameter_set_io import load_parameter_set

Array = NDArray[np.float64]
DEAD = Failure(FailureKind.DEAD)


class Allocated(NamedTuple):
    T: Array
    share: float
    status: int
    memory: AllocationMemory


def allocated(
    K_t: Array,
    wrench: ArrayLike,
    limits: tuple[float, float] = (-1e3, 1e3),
    failures: dict[int, Failure] | None = None,
    memory: AllocationMemory | None = None,
    step: Any = compiled_allocate,
    **chosen: Any,
) -> Allocated:
    a = allocation(K_t, AllocationSettings(**chosen), failures)
    count = K_t.shape[1]
    memory = allocation_memory(count) if memory is None else memory
    T = np.full(count, np.nan)
    lower, upper = np.full(count, limits[0]), np.full(count, limits[1])
    share, status = step(np.array(wrench, dtype=np.float64), lower, upper, a, memory, T)
    return Allocated(T, share, status, memory)


# ---- the configuration


def test_the_inverse_of_six_thrusters_and_of_eight_is_the_pseudo_inverse(ngs: Array, heavy: Array) -> None:
    singular = np.linalg.svd(ngs)[1]
    assert singular == pytest.approx([2.0400507, 1.0359013, 0.8758799, 0.5980914, 0.2285953, 0.2145336], abs=5e-8)
    singular = np.linalg.svd(heavy)[1]
    assert singular == pytest.approx([2, 1.4198431, 1.419463, 0.4342713, 0.377595, 0.2391124], abs=5e-8)
    assert inverse(ngs)[:, 4] == pytest.approx([2.1872266, 2.1872266, -2.1872266, -2.1872266, 0, 0], abs=5e-8)
    assert inverse(ngs) == pytest.approx(np.linalg.inv(ngs), abs=1e-12)
    assert inverse(heavy) == pytest.approx(np.linalg.pinv(heavy), abs=1e-12)


def test_null_vectors_are_of_few_thrusters_and_make_no_wrench(ngs: Array, heavy: Array) -> None:
    assert null_vectors(ngs).shape == (0, 6)
    assert null_vectors(heavy) == pytest.approx(np.array([[1, 1, 1, 1, 0, 0, 0, 0], [0, 0, 0, 0, 1, -1, -1, 1.0]]))
    heavy_without = np.where(np.arange(8) == 0, 0.0, heavy)
    assert null_vectors(heavy_without) == pytest.approx(np.array([[0, 0, 0, 0, 1, -1, -1, 1.0]]))


def test_a_lost_direction_is_orthogonal_to_all_wrenches(ngs: Array) -> None:
    for thruster in range(6):
        left = np.where(np.arange(6) == thruster, 0.0, ngs)
        (direction,) = lost_directions(left)
        assert np.abs(direction @ left).max() < 1e-12
    assert lost_directions(ngs).shape == (0, 6)


@pytest.mark.parametrize("thruster", range(6))
def test_without_a_thruster_attitude_is_kept_and_translation_gives_way(ngs: Array, thruster: int) -> None:
    wrench = np.array([20.0, -10.0, 5.0, 1.0, -2.0, 1.5])
    found = allocated(ngs, wrench, failures={thruster: DEAD})
    assert found.T[thruster] == 0.0
    assert found.memory.achieved == pytest.approx(ngs @ found.T, abs=1e-12)
    assert found.memory.achieved[3:] == pytest.approx(wrench[3:], abs=1e-9)
    assert np.abs(found.memory.achieved[:3] - wrench[:3]).max() > 0.1
    words = failures_in_words(ngs, {thruster: DEAD})
    assert words.startswith(f"thruster {thruster} is dead; K_t has rank 5 of 6: no control of ")
    assert ("heave (0.83) with surge (0.55)" if thruster > 3 else "sway (0.8") in words
    assert words.endswith("attitude is kept before translation")


def test_an_axis_on_which_a_vehicle_is_steady_by_itself_can_be_given_up_for_translation(heavy: Array) -> None:
    two_verticals = heavy.copy()
    two_verticals[:, 4:] = 0.0
    two_verticals[2:4, 4:6] = [[-1.0, -1.0], [-0.1, 0.1]]  # amidships: they roll and heave, and pitch nothing
    wrench = [10.0, 5.0, 3.0, 0.0, 0.0, 0.0]
    assert allocated(two_verticals, wrench).memory.achieved[0] == pytest.approx(0.0, abs=1e-9)
    surging = allocated(two_verticals, wrench, given_up=("pitch",)).memory.achieved
    assert surging[[0, 1, 2, 3, 5]] == pytest.approx([10.0, 5.0, 3.0, 0.0, 0.0], abs=1e-9)
    assert failures_in_words(two_verticals, given_up=("pitch",)).endswith("rank 5 of 6: no control of pitch")


@pytest.mark.parametrize("K_t", [np.ones((5, 6)), np.full((6, 6), np.nan)], ids=["shape", "nan"])
def test_what_is_no_configuration_is_refused_in_a_sentence(K_t: Array) -> None:
    with pytest.raises(ValueError, match=r"K_t: expected finite numbers of shape \(6, N\); found shape"):
        allocation(K_t, AllocationSettings())


# ---- within the limits


def test_hovering_takes_the_thrusts_worked_out_by_hand(ngs: Array, heavy: Array) -> None:
    light = [0.0, 0.0, -0.981, 0.0, 0.0, 0.0]  # the Heavy's, 13.5 kg against 13.4 kg displaced
    assert pytest.approx([0, 0, 0, 0, *4 * [0.24525]], abs=1e-12) == allocated(heavy, light).T
    away = allocated(heavy, light, smallest_thrust=1.0).T
    assert away == pytest.approx([1, 1, 1, 1, 1.4905, -1, -1, 1.4905], abs=1e-12)
    assert heavy @ away == pytest.approx(light, abs=1e-12)
    down = (30.0 - 30.2) * 9.81  # of 30 kg in 30.2 litres: it is held down
    found = allocated(ngs, [0, 0, -down, 0, 0, 0]).T
    assert found[4:] == pytest.approx([-0.9847472606] * 2, abs=5e-11)
    assert found[:4] == pytest.approx(np.zeros(4), abs=1e-9)


def test_without_its_first_thruster_the_heavy_surges_on_two(heavy: Array) -> None:
    found = allocated(heavy, [40, 0, 0, 0, 0, 0], failures={0: DEAD})
    expected = [0, 0, -28.2842712, -28.2842712, -7.0833333, -7.0833333, 7.0833333, 7.0833333]
    assert pytest.approx(expected, abs=5e-8) == found.T
    assert found.status == AllocationStatus.EXACT


def test_a_weak_thruster_is_asked_for_more_and_a_stuck_one_is_carried_by_the_others(heavy: Array) -> None:
    wrench = np.array([10.0, 3.0, -2.0, 0.5, 0.2, 1.0])
    weak = allocated(heavy, wrench, failures={2: Failure(FailureKind.WEAK, effectiveness=0.25)})
    produced = weak.T * np.where(np.arange(8) == 2, 0.25, 1.0)
    assert heavy @ produced == pytest.approx(wrench, abs=1e-9)
    stuck = allocated(heavy, wrench, failures={5: Failure(FailureKind.STUCK, stuck_thrust=-4.0)})
    assert stuck.T[5] == 0.0
    assert heavy @ np.where(np.arange(8) == 5, -4.0, stuck.T) == pytest.approx(wrench, abs=1e-9)
    assert stuck.memory.achieved == pytest.approx(wrench, abs=1e-9)


def test_a_thruster_without_a_measured_speed_is_used_as_before(ngs: Array) -> None:
    wrench = [10.0, 3.0, -2.0, 0.5, 0.2, 1.0]
    failure = {3: Failure(FailureKind.NO_SPEED)}
    assert np.array_equal(allocated(ngs, wrench, failures=failure).T, allocated(ngs, wrench).T)
    assert failures_in_words(ngs, failure) == "thruster 3 runs without a measured speed"


# ---- at the limits


def test_a_wrench_beyond_the_limits_keeps_its_direction_or_gets_closest(ngs: Array) -> None:
    wrench, limits = np.array([40.0, 0, 0, 0, 3, 0]), (-12.0, 15.0)
    kept = allocated(ngs, wrench, limits, method=Method.DIRECTION)
    assert kept.share == pytest.approx(0.7337417047, abs=5e-11)
    assert ngs @ kept.T == pytest.approx(kept.share * wrench, abs=1e-12)
    closest = allocated(ngs, wrench, limits, method=Method.LEAST_SQUARES, moment_weight=4.0)
    expected = [15, 15, 8.6642291098, 8.6642291098, -11.8773113103, -11.8773113103]
    assert pytest.approx(expected, abs=5e-9) == closest.T
    assert kept.status == closest.status == AllocationStatus.REDUCED
    beyond = allocated(ngs, wrench, limits, method=Method.PSEUDO_INVERSE)
    assert beyond.status == AllocationStatus.BEYOND_LIMITS
    assert pytest.approx(np.linalg.solve(ngs, wrench), abs=1e-9) == beyond.T


def test_bounded_least_squares_agree_with_scipy_for_up_to_nine_unknowns() -> None:
    rng = np.random.default_rng(1)
    for case in range(400):
        n = int(rng.integers(1, 10))
        K = rng.normal(size=(6, n)) if case % 3 else np.round(rng.normal(size=(6, n)))  # rounded: ties, lost ranks
        A = np.vstack((np.diag([5.0, 5, 5, 1, 1, 1]) @ K, 1e-4 * np.eye(n)))
        b = np.r_[20.0 * rng.normal(size=6), np.zeros(n)]
        lower, upper = -rng.uniform(0, 5, n), rng.uniform(0, 5, n)
        x, held, y, R = np.empty(n), np.empty(n), np.empty(n), np.empty((n + 6, n + 1))
        assert compiled_bounded_least_squares(A, b, lower, upper, x, held, R, y)
        oracle = lsq_linear(A, b, (lower, upper), method="bvls", tol=1e-14)
        assert np.all((lower <= x) & (x <= upper))
        assert 0.5 * np.sum((A @ x - b) ** 2) <= oracle.cost * (1.0 + 1e-9) + 1e-9
        assert np.array_equal(held == 0.0, (lower < x) & (x < upper))


def test_least_squares_with_null_vectors_agree_with_scipy(heavy: Array) -> None:
    rng = np.random.default_rng(2)
    W = np.diag([1.0, 1, 1, 10, 10, 10])
    for _ in range(50):
        wrench = rng.normal(size=6) * [60, 60, 60, 5, 5, 5]
        T = allocated(heavy, wrench, (-12.0, 15.0)).T
        oracle = lsq_linear(W @ heavy, W @ wrench, (-12.0, 15.0), method="bvls", tol=1e-14)
        assert 0.5 * np.sum((W @ (heavy @ T - wrench)) ** 2) <= oracle.cost * (1.0 + 1e-7) + 1e-7


def test_the_kept_direction_uses_null_vectors_up_to_the_largest_share_there_is(heavy: Array) -> None:
    rng = np.random.default_rng(3)
    gained = 0
    for _ in range(50):
        wrench = rng.normal(size=6) * [60, 60, 60, 5, 5, 5]
        found = allocated(heavy, wrench, (-12.0, 15.0), method=Method.DIRECTION)
        equal = np.column_stack((heavy, -wrench))
        best = linprog(np.r_[np.zeros(8), -1.0], A_eq=equal, b_eq=np.zeros(6), bounds=[(-12, 15)] * 8 + [(0, 1)]).x[-1]
        assert found.share == pytest.approx(best, abs=1e-6)
        assert heavy @ found.T == pytest.approx(found.share * wrench, abs=1e-9)
        assert found.T.min() >= -12.0 - 1e-9 and found.T.max() <= 15.0 + 1e-9
        shortest = np.linalg.pinv(heavy) @ wrench
        gained += found.share > 1.05 * min(1.0, *np.where(shortest > 0, 15.0 / shortest, -12.0 / shortest))
    assert gained > 10, "null vectors allow more than shrinking does"


def test_a_thruster_that_the_stream_drives_backwards_leaves_least_squares(ngs: Array) -> None:
    a = allocation(ngs, AllocationSettings(method=Method.DIRECTION))
    memory, T = allocation_memory(6), np.empty(6)
    lower, upper = np.full(6, -20.0), np.array([-6.5, 15, 15, 15, 15, 15])
    _, status = compiled_allocate(np.array([40.0, 0, 0, 0, 0, 0]), lower, upper, a, memory, T)
    assert status == AllocationStatus.REDUCED
    assert np.all((lower <= T) & (upper >= T))
    oracle = lsq_linear(np.diag(a.weights) @ ngs, a.weights * [40.0, 0, 0, 0, 0, 0], (lower, upper), tol=1e-14)
    assert pytest.approx(oracle.x, abs=1e-4) == T


def test_a_kernel_and_plain_python_allocate_alike(heavy: Array) -> None:
    rng = np.random.default_rng(5)
    for method in Method:
        memories = allocation_memory(8), allocation_memory(8)
        for _ in range(10):
            wrench = rng.normal(size=6) * [40, 40, 40, 4, 4, 4]
            chosen = {"method": method, "smallest_thrust": 1.0}
            one = allocated(heavy, wrench, (-12.0, 15.0), memory=memories[0], **chosen)
            other = allocated(heavy, wrench, (-12.0, 15.0), memory=memories[1], step=allocate, **chosen)
            assert pytest.approx(other.T, abs=1e-9) == one.T
            assert one[1:3] == pytest.approx(other[1:3], abs=1e-9)


def test_a_wrench_that_is_no_number_asks_for_nothing(ngs: Array) -> None:
    found = allocated(ngs, [math.nan, 0, 0, 0, 0, 0])
    assert (found.status, found.share) == (AllocationStatus.NOT_FINITE, 0.0)
    assert np.array_equal(found.T, np.zeros(6))


# ---- dead zones


def test_null_vectors_keep_thrusters_turning_and_noise_does_not_toss_between_choices(heavy: Array) -> None:
    rng, memory, before = np.random.default_rng(4), allocation_memory(8), np.zeros(8)
    reversals = 0
    for k in range(500):
        wrench = 0.05 * rng.normal(size=6) + [2.0 * math.sin(k / 40.0), 0, 0.3 * math.cos(k / 25.0), 0, 0, 0]
        T = allocated(heavy, wrench, memory=memory, smallest_thrust=1.0).T
        assert np.abs(T).min() >= 1.0 - 1e-9
        assert heavy @ T == pytest.approx(wrench, abs=1e-9)
        reversals += int(np.sum(T * before < 0.0))
        before = T
    assert reversals <= 16


def test_limits_hold_for_thrusts_that_avoid_the_dead_zone(heavy: Array) -> None:
    light = [0, 0, -0.981, 0, 0, 0]
    found = allocated(heavy, light, (-1.2, 1.2), smallest_thrust=1.0).T
    assert found == pytest.approx(np.r_[np.ones(4), np.zeros(4)]), "1.49 N is not allowed: the verticals stand still"


def test_without_null_vectors_the_dead_zone_costs_a_bounded_wrench_error_and_few_changes(ngs: Array) -> None:
    rng, memory, before = np.random.default_rng(6), allocation_memory(6), np.zeros(6)
    changes = needed = 0
    last = np.zeros(6)
    for k in range(1000):
        wanted = 0.1 * rng.normal(size=6) + 1.5 * math.sin(k / 80.0)
        T = allocated(ngs, ngs @ wanted, memory=memory, smallest_thrust=1.0, hysteresis=0.6).T
        assert np.all((np.abs(T) >= 1.0 - 1e-9) | (T == 0.0))
        assert np.abs(T - wanted).max() <= 0.8 + 1e-9
        changes += int(np.sum(np.sign(T) != np.sign(before)))
        needed += int(np.sum(wanted * last < 0.0))
        before, last = T, wanted
    assert 0 < changes <= 60 < needed
    assert np.array_equal(allocated(ngs, np.zeros(6), smallest_thrust=1.0).T, np.zeros(6)), "at rest nothing starts"


# ---- limits and reports


def test_full_throttle_in_a_stream_gives_the_thrust_that_the_set_has_there() -> None:
    p = load_parameter_set("hq").coefficients
    assert [steady_thrust(3.0, U, p) for U in (0.0, 0.2, 0.5)] == pytest.approx([15.9966, 9.7414, -6.5431], abs=5e-5)
    limits = limits_of_sets([p, p], 3.0)
    lower, upper = np.empty(2), np.empty(2)
    limits_at(limits, np.array([0.2, 0.213]), lower, upper)
    assert upper == pytest.approx([9.7414, steady_thrust(3.0, 0.213, p)], abs=5e-3)
    assert lower == pytest.approx([steady_thrust(-3.0, 0.2, p), steady_thrust(-3.0, 0.213, p)], abs=5e-3)
    limits_at(limits, np.array([math.nan, 9.0]), lower, upper)
    assert upper[0] == pytest.approx(15.9966, abs=5e-5), "an unknown flow counts as none"
    assert upper[1] == limits.forward[1, -1]


def test_limits_without_flow_are_what_they_are() -> None:
    lower, upper = np.empty(2), np.empty(2)
    limits_at(constant_limits([-3.0, -4.0], [5.0, 6.0]), np.array([0.7, -0.7]), lower, upper)
    assert (lower.tolist(), upper.tolist()) == ([-3.0, -4.0], [5.0, 6.0])


@pytest.mark.parametrize(
    ("build", "sentence"),
    [
        (lambda: constant_limits([1.0], [-1.0]), "limits: expected finite reverse <= forward"),
        (lambda: limits_of_sets([], math.nan), "u_max: expected a finite number above 0; found nan"),
        (lambda: AllocationSettings(moment_weight=0.0), "moment_weight: expected a number from 0.001 to 1000"),
        (lambda: AllocationSettings(smallest_thrust=-1.0), "smallest_thrust: expected a finite number of newtons"),
        (lambda: AllocationSettings(given_up=("depth",)), "given_up: expected axes among surge, .*; found depth"),
        (
            lambda: allocation(np.eye(6), AllocationSettings(), {2: Failure(FailureKind.STUCK)}),
            "thruster 2: expected a failure of known size",
        ),
        (
            lambda: allocation(np.eye(6), AllocationSettings(), {6: DEAD}),
            "thruster: expected an index from 0 to 5; found 6",
        ),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(build: Any, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence):
        build()


def test_a_report_of_a_failure_is_checked_and_its_unknown_size_replaced() -> None:
    assert problem(1, 9, math.nan, math.nan, 6).startswith("kind: expected one of 0 (NONE), 1 (DEAD)")
    assert problem(1, 2, -0.5, math.nan, 6) == (
        "effectiveness: expected a finite number above 0, or NaN for unknown; found -0.5"
    )
    assert problem(1, 3, math.nan, math.inf, 6).startswith("stuck_thrust: expected a finite number of newtons")
    assert problem(1, 4, math.nan, math.nan, 6) == ""
    assert known(Failure(FailureKind.WEAK), 3.0).effectiveness == 0.5
    assert known(Failure(FailureKind.STUCK), 3.0).stuck_thrust == 3.0
    assert known(DEAD, 3.0) == DEAD
