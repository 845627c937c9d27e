"""Fixtures for the tests of all packages, and a ROS domain for this process of pytest alone."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from thruster_runtime.domains import reserved_domain

if TYPE_CHECKING:
    from rclpy.context import Context
    from rclpy.executors import Executor
    from rclpy.node import Node

ROOT = Path(__file__).resolve().parent
# Whatever the shell has: in one domain, the graphs of two processes of tests (or a live one) would hear each other.
os.environ["ROS_DOMAIN_ID"] = str(reserved_domain())
# A shell starts what it sends to the background with Ctrl-C ignored, and every program that a test starts inherits it.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

BY_THE_WALL = {
    "test_bench_experiment.py", "test_driver_process.py", "test_ending.py", "test_graph_degraded.py",
    "test_killed_recorder.py", "test_launch.py", "test_link.py", "test_live_vehicle.py", "test_player.py",
    "test_recorder.py", "test_report_example.py", "test_rov_experiment.py", "test_rov_graph.py", "test_scene_node.py",
    "test_stock_ros2.py",
}  # fmt: skip
"""Files that judge graphs or browsers by the wall's clock: side by side they would take each other's time."""
COMPILED_ALIKE = (
    {"rov_sim/test/test_vehicle_loop.py", "rov_sim/test/test_rov_study.py"},
    {"rov_sim/test/test_bench_study.py", "rov_sim/test/test_closed_loop.py"},
    {"thruster_model/test/test_classes.py", "thruster_model/test/test_effects.py"},
)
"""Files that compile the same large kernels, for half a minute: side by side each would do so."""


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Keep the tests of a file in one process, those by the wall's clock all in one, and those that compile alike.

    The groups of pytest-xdist 3.8 do that no more: they stand in names that pytest 9.1 makes anew.
    """
    from xdist.scheduler import LoadScopeScheduling

    class ByFile(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            file = nodeid.partition("::")[0]
            alike = next((min(group) for group in COMPILED_ALIKE if file in group), file)
            return "by the wall" if Path(file).name in BY_THE_WALL else alike

    return ByFile(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the longest."""

    def turn(item: pytest.Item) -> int:
        return 0 if item.path.name in BY_THE_WALL else 1 if ROOT / "gap_diagnosis" in item.path.parents else 2

    items.sort(key=turn)


@pytest.fixture
def context() -> Iterator[Context]:
    """Return a context of this test's own, in the domain of this process."""
    import rclpy  # only where it is needed: most tests have no graph

    private = rclpy.Context()
    rclpy.init(args=[], context=private, domain_id=int(os.environ["ROS_DOMAIN_ID"]))
    yield private
    rclpy.try_shutdown(context=private)


@pytest.fixture
def spun(context: Context) -> Iterator[Callable[..., Executor]]:
    """Return a function that makes an executor for nodes; after the test they leave it, it ends, and so do they."""
    from thruster_runtime.executors import make_executor

    made: list[tuple[Executor, tuple[Node, ...]]] = []

    def spin(*nodes: Node, kind: str = "events") -> Executor:
        executor = make_executor(kind, context=context)
        made.append((executor, nodes))
        for node in nodes:
            executor.add_node(node)
        return executor

    yield spin
    for executor, nodes in made:
        for node in nodes:
            executor.remove_node(node)
        executor.shutdown()
        for node in nodes:
            node.destroy_node()


def data_folder(variable: str, name: str, what: str) -> Path:
    """Return the folder of data that cannot be part of the project, or skip.

    The environment variable names it; else it is looked for beside the repository.
    """
    given = os.environ.get(variable)
    folder = Path(given) if given else Path(__file__).resolve().parent / "../shared/data" / name
    if not folder.is_dir():
        pytest.skip(f"no {what} at {folder}; {variable} names the folder")
    return folder.resolve()


@pytest.fixture(scope="session")
def thruster_bench_data() -> Path:
    """Return the folder with the bench's recordings, or skip."""
    return data_folder("THRUSTER_BENCH_DATA", "thruster_bench", "recordings of the thruster bench")


@pytest.fixture(scope="session")
def t200_data() -> Path:
    """Return the folder with the maker's performance data of the T200, or skip."""
    return data_folder("T200_DATA", "t200", "performance data of the T200")


@pytest.fixture(scope="session")
def pool_data() -> Path:
    """Return the folder with recordings of a vehicle in a pool, or skip."""
    return data_folder("POOL_DATA", "bluerov_pool", "recordings of a vehicle in a pool")
