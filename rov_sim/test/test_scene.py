"""What viewers draw: the vehicle is upright, arrows push where thrusters do, the path stays short."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from rov_sim.vehicle.scene import (
    AT_LIMIT,
    BASE,
    BASE_FRD,
    MAP,
    MAP_NED,
    NEAR,
    WITHIN,
    Layout,
    PathMemory,
    Transform,
    arrows,
    transforms,
)  # fmt: skip

RNG = np.random.default_rng(5)
LAYOUT = Layout(np.array([[0.2, -0.2, 0.0], [0.0, 0.2, 0.1]]), np.array([[0.0, 2.0, 0.0], [0.0, 0.0, -1.0]]))
LOOK = {"length": 0.1, "limits": (10.0, 20.0)}


def moved(tree: list[Transform], child: str, root: str, point: np.ndarray) -> np.ndarray:
    """Return a point of the child's frame in the root's, along the tree."""
    parents = {each.child: each for each in tree}
    while child != root:
        one = parents[child]
        point = Rotation.from_quat(np.roll(one.rotation, -1)).apply(point) + one.translation
        child = one.parent
    return point


def test_each_frame_has_one_parent_and_map_is_the_root_of_all() -> None:
    tree = transforms(np.zeros(3), [1.0, 0.0, 0.0, 0.0])
    assert sorted(each.child for each in tree) == sorted([BASE, BASE_FRD, MAP_NED])
    for frame in (BASE, BASE_FRD, MAP_NED):
        moved(tree, frame, MAP, np.zeros(3))


def test_the_tree_holds_the_attitude_between_the_frames_that_it_is_told_in() -> None:
    turn = Rotation.random(rng=RNG)
    place, point = RNG.normal(size=3), RNG.normal(size=3)
    tree = transforms(place, np.roll(turn.as_quat(), 1))
    in_map = moved(tree, BASE_FRD, MAP, point)
    in_ned = turn.apply(point) + place
    assert in_map == pytest.approx(moved(tree, MAP_NED, MAP, in_ned))
    assert in_map == pytest.approx([in_ned[1], in_ned[0], -in_ned[2]])


def test_without_rep_103_the_attitude_is_the_only_transform() -> None:
    (only,) = transforms([1.0, 2.0, 3.0], [0.0, 1.0, 0.0, 0.0], rep_103=False)
    assert (only.parent, only.child) == (MAP_NED, BASE_FRD)
    assert only.translation.tolist() == [1.0, 2.0, 3.0] and only.rotation.tolist() == [0.0, 1.0, 0.0, 0.0]


def test_an_arrow_begins_at_its_thruster_and_is_as_long_as_the_thrust_along_the_axis_of_length_one() -> None:
    forward, reverse = arrows(LAYOUT, [5.0, -2.0], **LOOK)  # type: ignore[arg-type]
    assert forward.start.tolist() == [0.2, -0.2, 0.0] and forward.end == pytest.approx([0.2, 0.3, 0.0])
    assert reverse.end == pytest.approx([0.0, 0.2, 0.3])


@pytest.mark.parametrize(
    ("thrust", "colour"), [(15.0, WITHIN), (17.0, NEAR), (20.0, AT_LIMIT), (-9.0, NEAR), (-11.0, AT_LIMIT)]
)
def test_an_arrow_s_colour_tells_how_near_the_limit_of_its_direction_is(thrust: float, colour: object) -> None:
    assert arrows(LAYOUT, [thrust, np.nan], **LOOK)[0].colour == colour  # type: ignore[arg-type]


def test_a_thrust_that_is_unknown_or_nothing_has_no_arrow() -> None:
    assert arrows(LAYOUT, [np.nan, 0.0], **LOOK) == []  # type: ignore[arg-type]


def test_a_path_of_any_length_stays_within_its_number_of_points_and_begins_where_it_began() -> None:
    path = PathMemory(0.02, 100)
    for k in range(20_000):
        path.add(k, np.array([0.01 * k, 0.0, 0.0]), np.array([1.0, 0.0, 0.0, 0.0]))
    assert len(path.kept) <= 100 and path.kept[0][0] == 0
    gaps = np.diff([p[0] for _, p, _ in path.kept])
    assert gaps == pytest.approx(np.full(gaps.size, path.spacing), rel=0.1)
    path.add(5, np.zeros(3), np.zeros(4))
    assert len(path.kept) == 1, "played again: the path begins anew"
