"""What viewers such as Foxglove and RViz draw of a vehicle: frames, path, and an arrow for the thrust of each thruster.

subscribes  rov/odometry (or rov/truth) and, for each thruster, thruster_i/thrust_setpoint and, of a simulated one,
            thruster_i/truth
publishes   /tf and rov/attitude (roll, pitch, yaw [rad]) with each pose, rov/path and rov/scene now and then;
            /diagnostics

Only looks: nobody waits for it.
"""

import sys
from math import nan
from typing import Any

import numpy as np
from geometry_msgs.msg import Vector3Stamped
from nav_msgs.msg import Odometry, Path
from rclpy.node import Node
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import MarkerArray

from rov_sim.vehicle.layout_io import layout_of
from rov_sim.vehicle.poses import euler_angles, upright
from rov_sim.vehicle.scene import BASE_FRD, MAP, MAP_NED, WANTED, Layout, PathMemory, arrows, transforms
from rov_sim.vehicle.scene_messages import attitude_message, hull, marker_array, path_message, tf_message
from thruster_model.errors import ThrusterModelError
from thruster_msgs.msg import ThrusterTruth, ThrustSetpoint
from thruster_runtime.diagnostics import Diagnostics
from thruster_runtime.errors import StartRefused
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import Parameter, declare
from thruster_runtime.qos import RELIABLE
from thruster_runtime.stamps import nanoseconds

__all__ = ["PARAMETERS", "SceneNode", "main"]

PARAMETERS = (
    Parameter(name="vehicle", default="ngs", description="vehicle set, by name or file: where its thrusters are"),
    Parameter(
        name="source", default="odometry", choices=("odometry", "truth"), description="what says where the vehicle is"
    ),
    Parameter(
        name="rep_103", default=True,
        description="with the frames map and base_link, whose z is up; else map_ned is the root",
    ),
    Parameter(
        name="scene_period", default=0.1, unit="s", lower=0.0, upper=60.0, description="between two sets of arrows"
    ),
    Parameter(name="path_period", default=1.0, unit="s", lower=0.0, upper=60.0, description="between two paths"),
    Parameter(
        name="path_spacing", default=0.02, unit="m", lower=0.0, above=True, upper=100.0,
        description="between points of the path, doubled whenever there are too many",
    ),
    Parameter(name="path_points", default=500, lower=2, upper=10_000, description="most points of the path"),
    Parameter(
        name="arrow_length", default=0.03, unit="m/N", lower=0.0, above=True, upper=10.0,
        description="length of an arrow per thrust",
    ),
    Parameter(
        name="forward_limit", default=20.0, unit="N", lower=0.0, above=True, upper=10_000.0,
        description="largest forward thrust: arrows turn orange at 80 % of it, red at it",
    ),
    Parameter(
        name="reverse_limit", default=20.0, unit="N", lower=0.0, above=True, upper=10_000.0,
        description="likewise backwards, as a positive number",
    ),
)  # fmt: skip


class SceneNode(Node):
    """Publishes what is to be drawn."""

    def __init__(self, *, layout: Layout | None = None, **options: Any) -> None:
        """Refuse wrong parameters, then draw.

        Args:
            layout: of the thrusters; None: that of the vehicle set.
            options: those of Node.
        """
        super().__init__("scene", **options)
        self._values = values = declare(self, PARAMETERS)
        if layout is None:
            try:
                layout = layout_of(values["vehicle"])
            except ThrusterModelError as error:
                raise StartRefused(f"vehicle: {error}") from error
        self._layout, self._hull = layout, hull(layout)
        count = len(layout.positions)
        self._true, self._wanted = [nan] * count, [nan] * count
        self._path = PathMemory(values["path_spacing"], values["path_points"])
        self._due = {"scene": 0, "path": 0}
        self._last = 0
        self._diagnostics = Diagnostics(self)
        self._tf = self.create_publisher(TFMessage, "/tf", RELIABLE)
        self._attitudes = self.create_publisher(Vector3Stamped, "rov/attitude", RELIABLE)
        self._paths = self.create_publisher(Path, "rov/path", RELIABLE)
        self._scenes = self.create_publisher(MarkerArray, "rov/scene", RELIABLE)
        self.create_subscription(Odometry, f"rov/{values['source']}", self._on_pose, RELIABLE)
        for k in range(count):
            self.create_subscription(ThrusterTruth, f"thruster_{k}/truth", self._keep(self._true, k), RELIABLE)
            self.create_subscription(
                ThrustSetpoint, f"thruster_{k}/thrust_setpoint", self._keep(self._wanted, k), RELIABLE
            )

    @staticmethod
    def _keep(thrusts: list[float], index: int) -> Any:
        def take(message: Any) -> None:
            thrusts[index] = message.thrust

        return take

    def _on_pose(self, message: Odometry) -> None:
        frames = (message.header.frame_id or MAP_NED, message.child_frame_id or BASE_FRD)
        if frames != (MAP_NED, BASE_FRD):
            found = " and ".join(frames)
            self._diagnostics.report("error", f"nothing is drawn: expected {MAP_NED} and {BASE_FRD}; found {found}")
            return
        p, q = message.pose.pose.position, message.pose.pose.orientation
        place, turn = np.array([p.x, p.y, p.z]), np.array([q.w, q.x, q.y, q.z])
        if not (np.isfinite(place).all() and np.isfinite(turn).all()):
            self._diagnostics.report("warn", "the pose is not known: nothing is drawn")
            return
        self._draw(nanoseconds(message.header.stamp), place, turn)
        self._diagnostics.report("ok", f"drawing rov/{self._values['source']}")

    def _draw(self, stamp: int, place: Any, turn: Any) -> None:
        values, rep_103 = self._values, self._values["rep_103"]
        if stamp < self._last:  # played again
            self._due = {"scene": 0, "path": 0}
        self._last = stamp
        self._tf.publish(tf_message(stamp, transforms(place, turn, rep_103=rep_103)))
        self._attitudes.publish(attitude_message(stamp, euler_angles(turn)))
        self._path.add(stamp, *(upright(place, turn) if rep_103 else (place, turn)))
        if self._is_due("path", stamp):
            self._paths.publish(path_message(stamp, MAP if rep_103 else MAP_NED, self._path.kept))
        if self._is_due("scene", stamp):
            look = {"length": values["arrow_length"], "limits": (values["reverse_limit"], values["forward_limit"])}
            thrust = arrows(self._layout, self._true, **look)
            wanted = arrows(self._layout, self._wanted, **look, colour=WANTED if thrust else None)
            self._scenes.publish(marker_array(stamp, len(self._true), self._hull, thrust=thrust, wanted=wanted))

    def _is_due(self, name: str, stamp: int) -> bool:
        if stamp < self._due[name]:
            return False
        self._due[name] = stamp + round(1e9 * self._values[f"{name}_period"])
        return True


def main() -> int:
    """Run the node until it is told to stop."""
    return node_main(SceneNode, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
