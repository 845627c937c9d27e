"""A graph of its own for each test: private context, own domain."""

import os
from collections.abc import Iterator

import pytest
import rclpy
from rclpy.context import Context


@pytest.fixture
def domain_id() -> int:
    """The domain of this run, or of this process where none is set."""
    return int(os.environ["ROS_DOMAIN_ID"])


@pytest.fixture
def context(domain_id: int) -> Iterator[Context]:
    private = Context()
    rclpy.init(args=[], context=private, domain_id=domain_id)
    yield private
    rclpy.try_shutdown(context=private)
