"""The nodes of an experiment on the bench and their parameters, written once: for script, `ros2 launch` and tests.

emulated_bench ─ port ─> driver ─ state, flow ─> observer ─ estimate ─> inner_loop ─ throttle ─> driver
reference ─ thrust_setpoint ─> inner_loop; the recorder hears all of it; the watch ends when the run is over
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from rov_sim.vehicle.graph import GraphNode
from thruster_control.references import REFERENCES
from thruster_control.strategies import STRATEGIES

__all__ = ["BenchExperiment", "bench_graph", "problem_of_port", "recorder", "watch"]

_SET_POINTS = (*REFERENCES, "triangle")
_START_DELAY = 1.0
"""[s] 0 N before the run."""
_TIMEOUT = 0.12
"""[s] In real time: silence after which a set point counts no more, three periods."""
_NEVER = ("dead-zone", "force-table")
_THRUSTER = "thruster_0"


def problem_of_port(port: str) -> str:
    """Return what is wrong with a serial port as far as that shows without opening it, which would reset a device; ""
    where nothing is."""
    if Path(port).is_char_device():
        return ""
    return f"expected a serial port; found {'no device' if Path(port).exists() else 'nothing'} at {port}"


@dataclass(frozen=True, kw_only=True)
class BenchExperiment:
    """What is run.

    Attributes:
        reference: set point: step, triangle (or ramp), sine; strategy: of the inner loop.
        port: of a real device; "": the emulated bench.
        firmware: folder of the built firmware, which the emulated bench runs then; "": none.
        real_time: by the wall's clock, as a real device always is; else in lockstep.
        protocol: what the device speaks.
        truth: parameter set of the emulated thruster; effects: its unmodelled ones.
        set: parameter set that observer and law believe in; "": the strategy's own.
        form: how the observer is discretised.
        noise, seed: of the emulated sensors.

    Raises:
        ValueError: with all that is wrong.
    """

    reference: str
    strategy: str
    port: str = ""
    firmware: str = ""
    real_time: bool = False
    protocol: str = "text"
    truth: str = "hl_bench"
    effects: str = ""
    set: str = ""
    form: str = "proper"
    noise: bool = True
    seed: int = 0

    def __post_init__(self) -> None:
        strategies = [name for name in STRATEGIES if name not in _NEVER]
        choices: Mapping[str, Sequence[str]] = {
            "reference": _SET_POINTS, "strategy": strategies, "protocol": ("text", "frames"),
            "form": ("proper", "bench"),
        }  # fmt: skip
        wrong = [
            f"{name}: expected one of {', '.join(known)}; found {getattr(self, name)!r}"
            for name, known in choices.items()
            if getattr(self, name) not in known
        ]
        if self.port and self.firmware:
            wrong.append(f"firmware: expected the emulated bench; found the device at {self.port}")
        if self.port and (problem := problem_of_port(self.port)):
            wrong.append(f"port: {problem}")
        if self.seed < 0:
            wrong.append(f"seed: expected an integer, 0 or more; found {self.seed}")
        if wrong:
            raise ValueError("\n".join(wrong))

    @property
    def lockstep(self) -> bool:
        """Whether time is simulated."""
        return not (self.real_time or self.port)

    @property
    def observer(self) -> str:
        """Name of the strategy's observer, "none" for none."""
        return STRATEGIES[self.strategy].observer


def bench_graph(given: BenchExperiment, folder: Path) -> list[GraphNode]:
    """Return the nodes in the order in which they start; run and port lie in the folder."""
    set_and_law = {"parameter_set": given.set} if given.set else {}
    wires = ["state", "thrust_setpoint", "throttle"]
    if given.observer != "none":
        wires.append("estimate")
    if given.observer not in ("none", "speed-ekf"):
        wires.append("flow")
    heard = [f"/{_THRUSTER}/{name}" for name in ("throttle_sent", *wires)]
    port = given.port or str(folder / "port")
    about = {"experiment": "closed loop", **{name: getattr(given, name) for name in ("reference", "strategy", "form")}}
    nodes = [recorder(folder / "run", about, acknowledge=heard[:1], wait_for=heard)]
    if not given.port:
        bench = {
            "lockstep": given.lockstep, "link": port, "protocol": given.protocol, "firmware": given.firmware,
            "parameter_set": given.truth, "effects": given.effects, "noise": given.noise, "seed": given.seed,
            "wires": " ".join(f"{_THRUSTER}/{name}" for name in wires), "participants": "recorder/recorded",
        }  # fmt: skip
        nodes.append(GraphNode("emulated_bench", "rov_sim", "emulated_bench", "", bench))
    if given.observer != "none":
        own = "simplified" if given.observer == "speed-ekf" else STRATEGIES[given.strategy].parameter_set
        observer = {
            "estimator": given.observer, "parameter_set": given.set or own, "form": given.form,
            "throttle": "sent", "wait_for_throttle": given.lockstep,
        }  # fmt: skip
        nodes.append(GraphNode("observer", "thruster_estimation", "observer", "", observer))
    timeout = {} if given.lockstep else {"setpoint_timeout": _TIMEOUT}
    law = {"strategy": given.strategy, **set_and_law, **timeout}
    nodes.append(GraphNode("inner_loop", "thruster_control", "inner_loop", "", law))
    wanted = {"kind": given.reference, "start_delay": _START_DELAY, "wait_for": "recorder/recorded"}
    nodes.append(GraphNode("reference", "thruster_control", "reference", "", wanted))
    # The driver last: it is the only one that reaches the thruster.
    driver = {"port": port, "protocol": given.protocol, "lockstep": given.lockstep}
    nodes.append(GraphNode("driver", "bench_driver", "driver", "", driver))
    if given.lockstep:
        nodes = [node._replace(parameters={"use_sim_time": True, **node.parameters}) for node in nodes]
    return [*nodes[:-1], watch(start_delay=_START_DELAY, begin=240.0), nodes[-1]]


def recorder(run: Path, about: Mapping[str, Any], *, acknowledge: Sequence[str], wait_for: Sequence[str]) -> GraphNode:
    """Return the recorder of an experiment: everything but what carries the wall's time."""
    parameters = {
        "out": str(run), "topics": [".*"], "exclude": ["/parameter_events", "/rosout"],
        "acknowledge": list(acknowledge), "wait_for": list(wait_for), "about": yaml.safe_dump(dict(about)),
    }  # fmt: skip
    return GraphNode("recorder", "run_bag", "recorder", "", parameters)


def watch(**parameters: Any) -> GraphNode:
    """Return the node that ends when the run is over."""
    return GraphNode("experiment_watch", "rov_sim", "experiment_watch", "", parameters)
