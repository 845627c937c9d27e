"""What a vehicle's graph tells its nodes, the nodes take."""

import pytest

from rov_sim.vehicle.graph import Experiment, graph_of
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
