"""One experiment with a vehicle in simulated water: ros2 launch rov_sim vehicle.launch.py --show-args"""

from launch import LaunchDescription

from rov_sim.launch_graph_io import vehicle


def generate_launch_description() -> LaunchDescription:
    """Return what is started."""
    return vehicle()
