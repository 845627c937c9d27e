"""The emulated bench's node: who keeps time waiting, what goes out with which stamp, what is refused."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from bench_graph import Graph, parameters
from rclpy.context import Context
from rclpy.node import Node
from std_msgs.msg import Header

from bench_driver.link_records import LinkState
from rov_sim.emulated_bench import BenchSettings
from rov_sim.emulated_bench_io import DeviceSettings, EmulatedBench
from rov_sim.emulated_bench_node import EmulatedBenchNode
from thruster_model.effects.active import ActiveEffects
from thruster_model.parameter_set_io import load_parameter_set, write_parameter_set
from thruster_runtime.errors import StartRefused
from thruster_runtime.executors import spin_until

MILLISECOND = 1_000_000


@pytest.fixture
def make(context: Context) -> Iterator[Callable[..., Graph]]:
    graphs: list[Graph] = []

    def made(**given: object) -> Graph:
        graphs.append(Graph(context, **given))  # type: ignore[arg-type]
        return graphs[-1]

    yield made
    for graph in graphs:
        graph.close()


@pytest.mark.parametrize(("protocol", "period"), [("text", 40), ("frames", 10)])
def test_time_passes_in_the_protocols_periods_and_a_throttle_turns_the_thruster(
    make: Callable[..., Graph], protocol: str, period: int
) -> None:
    graph = make(protocol=protocol)
    graph.answer(2.0)
    assert graph.until(3.0), graph.bench.waiting_for()
    assert graph.driver._link.state is LinkState.READY
    truth = graph.heard["thruster_0/truth"][-1]
    assert truth.throttle == pytest.approx(2.0, abs=0.021)
    assert truth.n > 50.0 and truth.thrust > 1.0
    stamps = graph.stamps("thruster_0/truth")
    assert stamps == [period * MILLISECOND * (i + 1) for i in range(len(stamps))]
    sent = graph.stamps("thruster_0/throttle_sent")
    assert sent[: len(stamps) - 1] == stamps[: len(sent)][: len(stamps) - 1], "one word in each period"
    assert graph.heard["thruster_0/state"][-1].n == pytest.approx(truth.n, rel=0.05)


def test_the_load_cells_mean_is_stamped_in_the_middle_of_its_period(make: Callable[..., Graph]) -> None:
    graph = make()
    graph.answer(2.0)
    assert graph.until(3.0)
    truth = graph.heard["thruster_0/truth"]
    load = graph.heard["daq/thruster_0/load"]
    middles = [stamp - 20 * MILLISECOND for stamp in graph.stamps("thruster_0/truth")]
    assert graph.stamps("daq/thruster_0/load") == middles
    for k in (-1, -20):
        assert load[k].wrench.force.x == pytest.approx(0.5 * (truth[k].thrust + truth[k - 1].thrust), rel=2e-3)
        assert math.isnan(load[k].wrench.torque.z)


def test_time_does_not_begin_before_its_wires_are_there(make: Callable[..., Graph]) -> None:
    graph = make(wires="thruster_0/throttle")
    assert not spin_until(graph.executor, lambda: bool(graph.heard["/clock"]), 0.7)
    assert graph.bench.waiting_for() == ["a publisher and a subscription of thruster_0/throttle"]
    graph.answer(0.0)
    assert graph.until(0.4)


def test_a_participant_that_stays_away_is_named_and_time_waits_for_it(make: Callable[..., Graph]) -> None:
    graph = make(participants="recorder/recorded", timeout=0.3)
    recorder = Node("recorder", context=graph.context)
    topic = recorder.create_publisher(Header, "recorder/recorded", 10)
    graph.add(recorder)
    graph.answer(0.0)
    assert spin_until(graph.executor, lambda: bool(graph.heard["/clock"]), 10.0)
    waiting = "time stands still, waiting for recorder/recorded"
    assert spin_until(graph.executor, lambda: waiting in graph.statuses("/emulated_bench"), 5.0)
    assert len(graph.heard["/clock"]) == 1
    done = Header()
    done.stamp = graph.heard["/clock"][0].clock
    topic.publish(done)
    assert spin_until(graph.executor, lambda: len(graph.heard["/clock"]) == 2, 5.0)
    assert not spin_until(graph.executor, lambda: len(graph.heard["/clock"]) > 2, 0.3), (
        "its word is of the period before"
    )


def test_a_driver_that_goes_away_stops_time_and_is_named(make: Callable[..., Graph]) -> None:
    graph = make(timeout=0.3)
    graph.answer(1.0)
    assert graph.until(1.0)
    graph.executor.remove_node(graph.driver)
    spin_until(graph.executor, lambda: False, 0.2)
    count = len(graph.heard["/clock"])
    waiting = "time stands still, waiting for thruster_0/throttle_sent"
    assert spin_until(graph.executor, lambda: waiting in graph.statuses("/emulated_bench"), 5.0)
    assert len(graph.heard["/clock"]) == count


def test_two_runs_with_one_seed_have_the_same_content(make: Callable[..., Graph]) -> None:
    found = []
    for _ in range(2):
        graph = make(noise=True, seed=5)
        graph.answer(-1.5)
        assert graph.until(2.0)
        names = ("thruster_0/state", "thruster_0/flow", "thruster_0/truth", "daq/thruster_0/load")
        end = 2_000 * MILLISECOND
        found.append(
            [
                [m for m, t in zip(graph.heard[n], graph.stamps(n), strict=True) if t < end - 80 * MILLISECOND]
                for n in names
            ]
        )
        graph.close()
        graph.close = lambda: None  # type: ignore[method-assign]
    assert found[0] == found[1] or _equal(found[0], found[1])
    assert len(found[0][0]) > 30


def _equal(a: list[list[object]], b: list[list[object]]) -> bool:
    """Return whether the messages say the same; NaN is not equal to itself."""
    return all([repr(x) for x in one] == [repr(x) for x in other] for one, other in zip(a, b, strict=True))


def test_in_real_time_there_is_no_clock_and_the_thruster_turns(make: Callable[..., Graph]) -> None:
    graph = make(lockstep=False)
    graph.answer(2.0)
    turned = lambda: any(m.n > 20.0 for m in graph.heard["thruster_0/truth"])  # noqa: E731
    assert spin_until(graph.executor, turned, 20.0)
    assert not graph.heard["/clock"]
    stamps = graph.stamps("thruster_0/truth")
    assert stamps[-1] > 1_000_000_000 * 1_000_000_000 // 1000


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"parameter_set": "nobody"}, "parameter_set|nobody"),
        ({"effects": "coulomb_friction"}, "expected EFFECT.PARAMETER=SIZE"),
        ({"effects": "tach_lag.time=5"}, "expected 0 or 0 to 0.4 s; found 5.0"),
        ({"protocol": "morse"}, "protocol"),
        ({"participants": "a/b"}, "participants: expected topics that end in one of"),
        ({"firmware": "/nowhere"}, "device: /nowhere/emulator: expected a file"),
        ({"load_matrix": "1 2 x"}, "load_matrix: expected numbers"),
        ({"link": "/nowhere/port"}, "link: expected a name in an existing folder"),
    ],
)
def test_wrong_parameters_are_refused_with_a_sentence(context: Context, given: dict[str, object], said: str) -> None:
    with pytest.raises(StartRefused, match=said):
        EmulatedBenchNode(context=context, parameter_overrides=parameters(**given))


def test_a_set_is_taken_with_all_of_its_effects(context: Context, tmp_path: Path) -> None:
    sizes = {"tach_lag": {"time": 0.05}, "clock_drift": {"rate": 0.001}, "coulomb_friction": {"deceleration": 60.0}}
    file = tmp_path / "truth.yaml"
    write_parameter_set(replace(load_parameter_set("hl_bench"), effects=ActiveEffects(sizes=sizes)), file)
    node = EmulatedBenchNode(
        context=context, parameter_overrides=parameters(parameter_set=str(file), effects="command_delay.time=0.02")
    )
    try:
        assert set(node._given.bench.effects.sizes) == {*sizes, "command_delay"}
    finally:
        node.bench.close()
        node.destroy_node()


def test_a_link_that_exists_is_not_overwritten(context: Context, tmp_path: Path) -> None:
    (tmp_path / "port").write_text("mine")
    with pytest.raises(StartRefused, match="expected a name that is free"):
        EmulatedBenchNode(context=context, parameter_overrides=parameters(link=str(tmp_path / "port")))
    assert (tmp_path / "port").read_text() == "mine"


@pytest.mark.parametrize("protocol", ["text", "frames"])
def test_the_device_waits_for_whole_commands(tmp_path: Path, protocol: str) -> None:
    settings = DeviceSettings(protocol=protocol, link=tmp_path / "port")  # type: ignore[arg-type]
    coefficients = load_parameter_set("hl_bench").coefficients
    from bench_driver.driver_settings import DriverSettings

    dialect = DriverSettings(port="p", protocol=protocol).dialect()  # type: ignore[arg-type]
    command = dialect.zero(0.0, enable=True)
    with EmulatedBench(settings, BenchSettings(coefficients=coefficients)) as bench:
        assert not bench.heard()
        with (tmp_path / "port").open("wb", buffering=0) as port:
            port.write(command[:-1])
            assert not bench.heard()
            port.write(command[-1:])
            assert bench.heard()
            bench.advance(0.04)
            assert not bench.heard()
    assert not (tmp_path / "port").is_symlink()
