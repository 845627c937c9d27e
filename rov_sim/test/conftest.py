"""A graph of its own for each test that needs one: private context, own domain; and this folder's modules."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def context() -> Iterator[Context]:
    private = Context()
    domain = int(os.environ["ROS_DOMAIN_ID"])
    rclpy.init(args=[], context=private, domain_id=domain)
    yield private
    rclpy.try_shutdown(context=private)
