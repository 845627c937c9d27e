"""The nodes of a vehicle's experiment and their parameters, written once: for scripts, for one process, for tests.

plant ─ rov/imu, velocity, depth ─> navigation ─ rov/odometry ─> reference ─ rov/setpoint ─> allocator
allocator ─ thruster_i/thrust_setpoint, flow ─> observer_i ─ estimate ─> inner_loop_i ─ throttle ─> plant
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple

from rov_sim.vehicle.sensors.believed import navigation_parameters
from rov_sim.vehicle.sensors.settings import VehicleSensors
from thruster_control.strategies import STRATEGIES, strategy
from thruster_estimation.settings import OBSERVERS

__all__ = ["EMULATED", "FIRMWARE", "Experiment", "GraphNode", "graph_of"]

EMULATED, FIRMWARE = "emulated", "firmware"
"""In the place of a port: the emulated bench; the same with the board's own firmware on an emulated processor."""
_TIMEOUT = 0.12
"""[s] In real time: silence after which a set point counts no more."""
_NO_NOISE = 1e-6
"""[rad/s] What `dead-zone` is told of the tachometer: it takes the speed as it was measured."""


class GraphNode(NamedTuple):
    """One node: name, package and executable, class as package.module:Class, parameters, other names of its topics."""

    name: str
    package: str
    executable: str
    kind: str
    parameters: Mapping[str, Any]
    renamed: Mapping[str, str] = MappingProxyType({})


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """What is run.

    Attributes:
        vehicle: vehicle set of plant and outer loop; thrusters: how many it has.
        truth: parameter set of the true thrusters; "": the vehicle's own.
        strategy: of the inner loops.
        script: set points; start_delay: how long its beginning is held first [s].
        feedback: truth (with noise) or estimator.
        rate: of all loops [Hz].
        gain: K_P = gain I [1/s], k_I = gain times 1/s [1/s^2].
        u_max: largest throttle [V].
        allocation: pseudo-inverse, direction or least-squares.
        given_up: axes, separated by commas, whose wrench counts last.
        set: that observers and laws believe in; "": the strategy's own.
        flow: whether observers are told U = K_t^T nu; else they predict U by (4.5) alone.
        sensors: as the controllers know them; sensors_file: the plant's, "": those of the package.
        plant: more parameters of the plant: effects, failures, current, random wrench, noise.
        seed: of everything random.
        lockstep: on /clock; false: by the wall's clock.
        recorded: whether a recorder is there: lockstep, or in real time the script, waits until it hears each thruster.
        scene: whether a node draws for viewers; nobody waits for it.
        watched: run of the healthy vehicle, from which a node learns that watches thrusters and sensors; it alone tells
            of failures then, the plant does not; "": nobody watches.
        hardware: ports of thrusters that are not simulated, by index; `EMULATED` or `FIRMWARE`: the emulated bench.

    Raises:
        ValueError: with all that is wrong.
    """

    thrusters: int
    sensors: VehicleSensors
    vehicle: str = "ngs"
    truth: str = ""
    strategy: str = "hq-ekf"
    script: str = "surge_and_pitch"
    start_delay: float = 1.0
    feedback: str = "truth"
    rate: float = 25.0
    gain: float = 2.0
    u_max: float = 5.0
    allocation: str = "least-squares"
    given_up: str = ""
    set: str = ""
    flow: bool = True
    sensors_file: str = ""
    plant: Mapping[str, Any] = field(default_factory=dict)
    seed: int = 0
    lockstep: bool = True
    recorded: bool = True
    scene: bool = False
    watched: str = ""
    hardware: Mapping[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        wrong = []
        if self.strategy not in STRATEGIES:
            wrong.append(f"strategy: expected one of {', '.join(STRATEGIES)}; found {self.strategy!r}")
        if self.feedback not in ("truth", "estimator"):
            wrong.append(f"feedback: expected truth or estimator; found {self.feedback!r}")
        for i in self.hardware:
            if not 0 <= i < self.thrusters:
                wrong.append(f"hardware: expected thrusters T1 to T{self.thrusters}; found T{i + 1}")
        if self.hardware and self.lockstep:
            wrong.append("hardware: expected real time, as a device does not wait; found lockstep")
        if sum(port in (EMULATED, FIRMWARE) for port in self.hardware.values()) > 1:
            wrong.append("hardware: expected one emulated device at most; found more")
        if wrong:
            raise ValueError("; ".join(wrong))
        object.__setattr__(self, "plant", MappingProxyType(dict(self.plant)))
        object.__setattr__(self, "hardware", MappingProxyType(dict(self.hardware)))

    @property
    def observer(self) -> str:
        """Name of the strategy's observer, "none" for none."""
        return strategy(self.strategy).observer


def graph_of(given: Experiment, *, link: str = "", firmware: str = "") -> list[GraphNode]:
    """Return the nodes, the plant first.

    Args:
        given: what is run.
        link: a name for the port of an emulated device.
        firmware: folder in which the firmware was built, for a thruster with `FIRMWARE`.

    Raises:
        ValueError: firmware is asked for that was not built.
    """
    if FIRMWARE in given.hardware.values() and not firmware:
        raise ValueError("hardware: expected a folder in which the firmware was built; found none")
    nodes = [_plant(given)]
    if given.feedback == "estimator":
        nodes.append(_node(given, "navigation", "thruster_estimation", _navigation(given)))
    reference = {"script": given.script, "start_delay": given.start_delay}
    if given.recorded and not given.lockstep:  # a device takes its time to be ready
        reference["wait_for"] = "recorder/recorded"
    nodes.append(_node(given, "vehicle_reference", "thruster_control", reference))
    nodes.append(_node(given, "allocator", "thruster_control", _allocator(given)))
    for i in range(given.thrusters):
        if given.observer != "none":
            nodes.append(_node(given, "observer", "thruster_estimation", _observer(given, i), i))
        nodes.append(_node(given, "inner_loop", "thruster_control", _inner_loop(given, i), i))
    if given.scene:
        nodes.append(_node(given, "scene", "rov_sim", {"vehicle": given.vehicle}))
    if given.watched:
        watching = {"vehicle": given.vehicle, "baseline": given.watched, "report_failures": True}
        nodes.append(_node(given, "watch", "gap_diagnosis", watching)._replace(name="vehicle_watch"))
    for i, port in given.hardware.items():
        emulated = port in (EMULATED, FIRMWARE)
        if emulated:
            nodes.append(_bench(given, i, link, firmware if port == FIRMWARE else ""))
        nodes.append(_driver(given, i, link if emulated else port))
    return nodes


_CLASSES = {
    "plant": "rov_sim.vehicle.plant_node:PlantNode",
    "navigation": "thruster_estimation.navigation_node:NavigationNode",
    "vehicle_reference": "thruster_control.vehicle_reference_node:VehicleReferenceNode",
    "allocator": "thruster_control.allocator_node:AllocatorNode",
    "observer": "thruster_estimation.observer_node:ObserverNode",
    "inner_loop": "thruster_control.inner_loop_node:InnerLoopNode",
    "scene": "rov_sim.vehicle.scene_node:SceneNode",
    "watch": "gap_diagnosis.vehicle.watch_node:VehicleWatch",
    "driver": "bench_driver.driver_node:Driver",
    "emulated_bench": "rov_sim.emulated_bench_node:EmulatedBenchNode",
}


def _node(
    given: Experiment, executable: str, package: str, parameters: Mapping[str, Any], thruster: int | None = None
) -> GraphNode:
    name = executable if thruster is None else f"{executable}_{thruster}"
    clock = {"use_sim_time": True} if given.lockstep else {}
    return GraphNode(name, package, executable, _CLASSES[executable], {**clock, **parameters})


def _plant(given: Experiment) -> GraphNode:
    participants = ["rov/setpoint", "rov/wrench"]
    wires = [f"thruster_{i}/{name}" for i in range(given.thrusters) for name in ("state", "thrust_setpoint")]
    if given.observer != "none":
        wires += [f"thruster_{i}/estimate" for i in range(given.thrusters)]
    wires += ["rov/odometry"]
    if given.feedback == "estimator":
        participants.append("rov/odometry")
        wires += ["rov/imu", "rov/velocity", "rov/depth"]
    if given.recorded and given.lockstep:
        participants.append("recorder/recorded")
    if given.watched and given.lockstep:
        participants.append("vehicle_watch/watched")
        wires += ["rov/thruster_failure"]
    parameters = {
        "vehicle": given.vehicle, "truth": given.truth, "sensors": given.sensors_file, "seed": given.seed,
        "rate": given.rate, "feedback": given.feedback, "lockstep": given.lockstep,
        "elsewhere": " ".join(f"T{i + 1}" for i in given.hardware), "participants": " ".join(participants),
        "wires": " ".join(wires), "report_failures": not given.watched, **given.plant,
    }  # fmt: skip
    return _node(given, "plant", "rov_sim", parameters)


def _navigation(given: Experiment) -> dict[str, Any]:
    return {"period": 1.0 / given.rate, **navigation_parameters(given.sensors)}


def _allocator(given: Experiment) -> dict[str, Any]:
    return {
        "vehicle": given.vehicle, "u_max": given.u_max, "K_P_linear": given.gain, "K_P_angular": given.gain,
        "k_I": given.gain, "period": 1.0 / given.rate, "flow": "kinematic" if given.flow else "none",
        "method": given.allocation, "given_up": given.given_up,
        **({} if given.lockstep else {"setpoint_timeout": _TIMEOUT, "odometry_timeout": _TIMEOUT}),
    }  # fmt: skip


def _observer(given: Experiment, i: int) -> dict[str, Any]:
    speed = max(given.sensors.tachometer.noise[0], 1e-3) if given.strategy != "dead-zone" else _NO_NOISE
    found = {
        "thruster": i, "estimator": given.observer, "period": 1.0 / given.rate,
        "parameter_set": given.set or _believed(given),
        "wait_for_flow": given.flow and i not in given.hardware,
        "throttle": "sent" if i in given.hardware else "commanded", "wait_for_throttle": given.lockstep,
    }  # fmt: skip
    weighed = OBSERVERS[given.observer]._fields  # gains that are given are told no noise
    if "r_n" in weighed:
        found["speed_noise"] = speed
    if "r_U" in weighed:
        found["flow_noise"] = max(given.plant.get("velocity_noise", given.sensors.velocity.noise[0]), 1e-3)
    return found


def _believed(given: Experiment) -> str:
    """Return the parameter set of the strategy; no observer works with a steady flow."""
    own = strategy(given.strategy).parameter_set
    return "simplified" if given.strategy == "steady-flow" else own


def _inner_loop(given: Experiment, i: int) -> dict[str, Any]:
    believed = {"parameter_set": given.set} if given.set else {}
    timeout = {} if given.lockstep else {"setpoint_timeout": _TIMEOUT}
    return {
        "thruster": i, "strategy": given.strategy, "u_max": given.u_max, "period": 1.0 / given.rate, **believed,
        "wait_for_setpoint": i not in given.hardware,  # a device's instants are its own
        **timeout,
    }  # fmt: skip


def _driver(given: Experiment, i: int, port: str) -> GraphNode:
    """Return the driver of one thruster; the flow that the rig's instrument measures is not that of the vehicle."""
    parameters = {"port": port, "lockstep": False, "throttle_limit": min(given.u_max, 3.0)}
    renamed = {f"thruster_0/{name}": f"thruster_{i}/{name}" for name in ("throttle", "throttle_sent", "state")}
    renamed["thruster_0/flow"] = f"daq/thruster_{i}/flow"
    return _node(given, "driver", "bench_driver", parameters, i)._replace(renamed=renamed)


def _bench(given: Experiment, i: int, link: str, firmware: str) -> GraphNode:
    truth = (given.truth.split() or ["hq"])[0]
    parameters = {"parameter_set": truth, "seed": given.seed, "lockstep": False, "link": link, "firmware": firmware}
    node = _node(given, "emulated_bench", "rov_sim", parameters, i)
    return node._replace(
        renamed={"thruster_0/truth": f"daq/thruster_{i}/truth", "daq/thruster_0/load": f"daq/thruster_{i}/load"}
    )
