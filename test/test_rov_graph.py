"""A vehicle's whole graph in one process: one content of one seed, who is missing is named, what is lost is zero."""

from collections.abc import Callable

import pytest
from vehicle_graph import Graph

from thruster_runtime.executors import spin_until

PERIODS = 60


def test_one_seed_has_one_content_handed_over_or_not_and_the_vehicle_follows(make: Callable[..., Graph]) -> None:
    found = []
    for over in (False, True):
        graph = make(handing_over=over, seed=3)
        graph.run(PERIODS + 3)
        found.append(graph.listener.until(PERIODS * 40_000_000))
        truth = graph.plant.vehicle._plant.truth()
        assert 0.1 < truth.velocity[0] < 0.25, "it surges"
        graph.close()
    assert len({topic for _, topic, _ in found[0]}) == 6 * 6 + 8
    assert found[0] == found[1]


def test_a_failed_thruster_is_reported_and_the_others_carry_the_wrench(make: Callable[..., Graph]) -> None:
    graph = make(change={"plant": {"failures": "T2 dead at 0.8 s"}}, handing_over=True)
    graph.run(PERIODS)
    content = graph.listener.until(PERIODS * 40_000_000)
    assert [stamp for stamp, topic, _ in content if topic == "rov/thruster_failure"] == [800_000_000]
    asked = [(stamp, text) for stamp, topic, text in content if topic == "thruster_1/thrust_setpoint"]
    assert all("thrust=0.0)" in text for stamp, text in asked if stamp > 840_000_000)
    assert not all("thrust=0.0)" in text for stamp, text in asked if stamp < 800_000_000)


@pytest.mark.parametrize("missing", ["vehicle_reference", "allocator", "inner_loop_2"])
def test_time_does_not_begin_without_a_node_and_its_topic_is_named(make: Callable[..., Graph], missing: str) -> None:
    graph = make(leave_out=(missing,), change={"plant": {"timeout": 0.3}})
    topic = {"vehicle_reference": "rov/setpoint", "allocator": "rov/wrench", "inner_loop_2": "thruster_2/throttle"}
    said = f"a publisher and a subscription of {topic[missing]}"
    spin_until(graph.executor, lambda: False, 1.0)
    assert said in graph.plant.waiting_for() and graph.plant.vehicle.time == 0


@pytest.mark.parametrize("lost", ["vehicle_reference", "allocator", "inner_loop_2"])
def test_in_lockstep_time_stops_when_a_node_is_lost_and_it_is_named(make: Callable[..., Graph], lost: str) -> None:
    graph = make()
    graph.run(10)
    node = graph.nodes.pop(lost)
    graph.executor.remove_node(node)
    spin_until(graph.executor, lambda: False, 0.3)  # what has come for it already
    node.destroy_node()
    gone = f"{lost} is gone"
    assert spin_until(graph.executor, lambda: any(gone in each for each in graph.plant.waiting_for()), 20.0)
    time = graph.plant.vehicle.time
    spin_until(graph.executor, lambda: False, 0.5)
    assert graph.plant.vehicle.time == time


@pytest.mark.parametrize("lost", ["vehicle_reference", "allocator", "inner_loop_2", "navigation"])
def test_in_real_time_the_loss_of_a_node_is_zero_throttle_within_a_fifth_of_a_second(
    make: Callable[..., Graph], lost: str
) -> None:
    graph = make(lockstep=False, feedback="estimator", handing_over=False)
    held = graph.plant._held
    monotonic = graph.plant._monotonic
    turning = lambda: all(abs(u) > 0.3 for u in held.at(monotonic()))  # noqa: E731
    assert spin_until(graph.executor, turning, 30.0), held.silent(monotonic())
    node = graph.nodes.pop(lost)
    graph.executor.remove_node(node)
    begin = monotonic()
    affected = [2] if lost == "inner_loop_2" else range(6)
    stopped = lambda: all(held.at(monotonic())[i] == 0.0 for i in affected)  # noqa: E731
    assert spin_until(graph.executor, stopped, 5.0)
    assert monotonic() - begin < 0.2
    node.destroy_node()
