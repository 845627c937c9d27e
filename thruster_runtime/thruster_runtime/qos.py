"""The two profiles that all topics use.

Best effort would lose samples without saying so, and an observer would take the gap for a real one.
"""

from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy


def _keep_last(depth: int) -> QoSProfile:
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.VOLATILE,
    )


RELIABLE = _keep_last(10)
"""Every publisher, and every subscription of a node that keeps up."""

RECORDER = _keep_last(5000)
"""Subscriptions of a recorder: with 10, one that writes to a slow disk loses a third of the messages."""
