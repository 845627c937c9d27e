"""A ROS context in the domain of this run of the tests."""

import os

import rclpy
from rclpy.context import Context

__all__ = ["a_context"]


def a_context() -> Context:
    """Return a context in this run's domain."""
    context = Context()
    rclpy.init(args=[], context=context, domain_id=int(os.environ["ROS_DOMAIN_ID"]))
    return context
