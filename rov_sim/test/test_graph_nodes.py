"""What a vehicle's graph tells its nodes, the nodes take."""

import pytest

from rov_sim.vehicle.graph import EMULATED, FIRMWARE, Experiment, graph_of
from rov_sim.vehicle.sensors.settings_io import load_sensors
from thruster_control.strategies import STRATEGIES
from thruster_estimation.observer_parameters import PARAMETERS, chosen_observer

SHIPPED = {parameter.name: parameter.default for parameter in PARAMETERS}


@pytest.mark.parametrize("name", [name for name, each in STRATEGIES.items() if each.observer != "none"])
def test_every_strategy_has_observers_that_take_what_the_graph_tells_them(name: str) -> None:
    experiment = Experiment(thrusters=6, sensors=load_sensors(), strategy=name)
    observers = [node for node in graph_of(experiment) if node.executable == "observer"]
    assert len(observers) == 6
    for node in observers:
        assert set(node.parameters) <= {*SHIPPED, "use_sim_time"}
        assert chosen_observer({**SHIPPED, **node.parameters})[1] == []


def test_a_thruster_that_is_no_simulated_one_has_a_driver_and_an_emulated_one_its_device() -> None:
    def nodes(hardware: dict[int, str]):  # type: ignore[no-untyped-def]
        given = Experiment(thrusters=6, sensors=load_sensors(), hardware=hardware, lockstep=False)
        return {node.name: node for node in graph_of(given, link="a link", firmware="built")}

    found = nodes({0: "/dev/ttyACM0", 3: FIRMWARE})
    assert {"driver_0", "driver_3", "emulated_bench_3"} <= set(found) and "emulated_bench_0" not in found
    assert found["driver_0"].parameters["port"] == "/dev/ttyACM0"
    assert found["driver_3"].parameters["port"] == found["emulated_bench_3"].parameters["link"] == "a link"
    assert found["emulated_bench_3"].parameters["firmware"] == "built"
    assert found["plant"].parameters["elsewhere"] == "T1 T4"
    assert nodes({3: EMULATED})["emulated_bench_3"].parameters["firmware"] == ""


def test_hardware_that_cannot_be_is_refused_with_a_sentence() -> None:
    def given(hardware: dict[int, str], **more: bool) -> Experiment:
        return Experiment(thrusters=6, sensors=load_sensors(), hardware=hardware, **more)  # type: ignore[arg-type]

    with pytest.raises(ValueError, match=r"found T7; hardware: expected real time"):
        given({6: "/dev/ttyACM0"})
    with pytest.raises(ValueError, match="expected one emulated device at most"):
        given({0: EMULATED, 1: FIRMWARE}, lockstep=False)
    with pytest.raises(ValueError, match="expected a folder in which the firmware was built; found none"):
        graph_of(given({0: FIRMWARE}, lockstep=False))


def test_a_vehicle_that_is_watched_is_told_of_failures_by_the_watch_alone() -> None:
    def nodes(watched: str):  # type: ignore[no-untyped-def]
        return {n.name: n for n in graph_of(Experiment(thrusters=6, sensors=load_sensors(), watched=watched))}

    found = nodes("a/healthy/run")
    assert found["vehicle_watch"].parameters["baseline"] == "a/healthy/run"
    assert found["plant"].parameters["report_failures"] is False
    assert "vehicle_watch/watched" in found["plant"].parameters["participants"]
    alone = nodes("")
    assert "vehicle_watch" not in alone and alone["plant"].parameters["report_failures"] is True
