"""One experiment on the bench, real or emulated: ros2 launch rov_sim bench.launch.py --show-args"""

from launch import LaunchDescription

from rov_sim.launch_graph_io import bench


def generate_launch_description() -> LaunchDescription:
    """Return what is started."""
    return bench()
