"""The scene's messages: transforms, path, arrows."""

from collections.abc import Iterable, Sequence

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point, Pose, PoseStamped, TransformStamped, Vector3, Vector3Stamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from std_msgs.msg import ColorRGBA, Header
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from rov_sim.vehicle.scene import BASE_FRD, MAP_NED, Arrow, Colour, Layout, Transform

__all__ = ["attitude_message", "hull", "marker_array", "path_message", "tf_message", "time_message"]

Array = NDArray[np.float64]
_SHAFT, _HEAD = 0.012, 0.03  # m, diameters of an arrow
_THINNEST = 0.05  # m, of the hull in any direction
_HULL = Colour(0.35, 0.5, 0.7, 0.35)


def time_message(stamp: int) -> Time:
    """Return a stamp [ns] as a message."""
    seconds, rest = divmod(stamp, 1_000_000_000)
    return Time(sec=seconds, nanosec=rest)


def tf_message(stamp: int, tree: Iterable[Transform]) -> TFMessage:
    """Return transforms that hold at `stamp` [ns]."""
    found = TFMessage()
    for each in tree:
        one = TransformStamped(header=Header(stamp=time_message(stamp), frame_id=each.parent))
        one.child_frame_id = each.child
        t, r = one.transform.translation, one.transform.rotation
        t.x, t.y, t.z = (float(value) for value in each.translation)
        r.w, r.x, r.y, r.z = (float(value) for value in each.rotation)
        found.transforms.append(one)
    return found


def attitude_message(stamp: int, angles: Array) -> Vector3Stamped:
    """Return roll, pitch, yaw [rad], (3,), as x, y, z: plots of viewers cannot turn a quaternion into them."""
    roll, pitch, yaw = (float(angle) for angle in angles)
    return Vector3Stamped(
        header=Header(stamp=time_message(stamp), frame_id=MAP_NED), vector=Vector3(x=roll, y=pitch, z=yaw)
    )


def path_message(stamp: int, frame: str, poses: Sequence[tuple[int, Array, Array]]) -> Path:
    """Return a path of poses (stamp [ns], position [m], attitude (w, x, y, z)) in a frame."""
    found = Path(header=Header(stamp=time_message(stamp), frame_id=frame))
    for when, position, attitude in poses:
        one = PoseStamped(header=Header(stamp=time_message(when), frame_id=frame))
        _place(one.pose, position, attitude)
        found.poses.append(one)
    return found


def _place(pose: Pose, position: Array, attitude: Array) -> None:
    p, q = pose.position, pose.orientation
    p.x, p.y, p.z = (float(value) for value in position)
    q.w, q.x, q.y, q.z = (float(value) for value in attitude)


def marker_array(stamp: int, thrusters: int, hull: Marker | None, **sets: Sequence[Arrow]) -> MarkerArray:
    """Return the hull and arrows by the name of their set; a thruster without an arrow takes its last one away."""
    found = MarkerArray()
    if hull is not None:
        hull.header.stamp = time_message(stamp)
        found.markers.append(hull)
    for name, arrows in sets.items():
        drawn = {arrow.thruster: arrow for arrow in arrows}
        for k in range(thrusters):
            found.markers.append(_marker(stamp, name, k, drawn.get(k)))
    return found


def _marker(stamp: int, name: str, index: int, arrow: Arrow | None) -> Marker:
    one = Marker(header=Header(stamp=time_message(stamp), frame_id=BASE_FRD), ns=name, id=index, type=Marker.ARROW)
    one.pose.orientation.w = 1.0
    one.action = Marker.DELETE if arrow is None else Marker.ADD
    if arrow is not None:
        one.points = [Point(x=float(p[0]), y=float(p[1]), z=float(p[2])) for p in (arrow.start, arrow.end)]
        one.scale.x, one.scale.y, one.scale.z = _SHAFT, _HEAD, 0.0
        one.color = _colour(arrow.colour)
    return one


def _colour(colour: Colour) -> ColorRGBA:
    return ColorRGBA(r=colour.red, g=colour.green, b=colour.blue, a=colour.opacity)


def hull(layout: Layout) -> Marker:
    """Return a box around the thrusters, in the body's frame."""
    low, high = layout.positions.min(axis=0), layout.positions.max(axis=0)
    one = Marker(header=Header(frame_id=BASE_FRD), ns="hull", id=0, type=Marker.CUBE, action=Marker.ADD)
    _place(one.pose, 0.5 * (low + high), np.array([1.0, 0.0, 0.0, 0.0]))
    one.scale.x, one.scale.y, one.scale.z = (max(float(width), _THINNEST) for width in high - low)
    one.color = _colour(_HULL)
    return one
