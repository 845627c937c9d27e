"""The parameters of the emulated bench's node, and the settings that they make."""

from pathlib import Path
from typing import NamedTuple, get_args

from rclpy.node import Node

from bench_driver.driver_settings import LoadCell
from bench_driver.errors import SettingsRefused
from rov_sim.emulated_bench import QUIET, BenchSettings
from rov_sim.emulated_bench_io import DeviceSettings, ProtocolName
from rov_sim.rig_sensors import Rig
from thruster_model.errors import ThrusterModelError
from thruster_model.parameter_set_io import load_parameter_set
from thruster_runtime.parameters import Parameter, declare, refused

__all__ = ["PARAMETERS", "BenchNodeSettings", "settings_of"]

PARAMETERS = (
    Parameter(name="parameter_set", default="hl_bench", description="the true thruster: a parameter set or YAML file"),
    Parameter(
        name="effects", default="",
        description="unmodelled effects besides the set's: EFFECT.PARAMETER=SIZE, separated by spaces; those of the "
        "log act on the finished run, see thruster_model log_effects",
    ),
    Parameter(name="noise", default=True, description="whether the sensors are noisy as the rig's"),
    Parameter(name="seed", default=0, lower=0, description="of the noise"),
    Parameter(
        name="protocol", default="text", choices=get_args(ProtocolName),
        description="what the host speaks: text at 25 Hz or frames at 100 Hz",
    ),
    Parameter(
        name="firmware", default="",
        description="folder in which the firmware was built, to run it on an emulated processor; empty: its emulation",
    ),
    Parameter(name="link", default="", description="a name for the port; empty: only the pseudo-terminal's own"),
    Parameter(
        name="load_matrix", default="",
        description="of the load cell at the device's channels, as the driver's; empty: they rest",
    ),
    Parameter(
        name="lockstep", default=True,
        description="whether time passes when all participants are done, on /clock; false: by the wall's clock",
    ),
    Parameter(
        name="participants", default="",
        description="in lockstep, topics besides thruster_0/throttle_sent whose message stamped t ends the period t",
    ),
    Parameter(
        name="wires", default="",
        description="topics that need a publisher and a subscription before time begins",
    ),
    Parameter(
        name="settle", default=0.5, unit="s", lower=0.0, upper=60.0,
        description="wall time between the last wire's appearance and the beginning",
    ),
    Parameter(
        name="timeout", default=15.0, unit="s", lower=0.0, above=True, upper=3600.0,
        description="wall time after which what is waited for is named on /diagnostics",
    ),
)  # fmt: skip


class BenchNodeSettings(NamedTuple):
    """What the node is made of; participants and wires are names of topics, times in s of the wall's clock."""

    device: DeviceSettings
    bench: BenchSettings
    lockstep: bool
    participants: tuple[str, ...]
    wires: tuple[str, ...]
    settle: float
    timeout: float


def settings_of(node: Node) -> BenchNodeSettings:
    """Declare the parameters of a node and return the settings they make.

    Raises:
        StartRefused: with a sentence for all that is wrong.
    """
    given = declare(node, PARAMETERS)
    try:
        truth = load_parameter_set(given["parameter_set"])
        cell = LoadCell.of(_numbers(given["load_matrix"]), LoadCell().rest)
        device = DeviceSettings(
            protocol=given["protocol"], firmware=_path(given["firmware"]), link=_path(given["link"]), load_cell=cell
        )
        bench = BenchSettings(
            coefficients=truth.coefficients, effects=truth.effects.with_words(given["effects"].split()),
            rig=Rig() if given["noise"] else QUIET, period=device.period, seed=given["seed"],
        )  # fmt: skip
    except SettingsRefused as error:
        raise refused(node, error.problems) from error
    except (ValueError, ThrusterModelError) as error:
        raise refused(node, [str(error)]) from error
    words = {name: tuple(given[name].split()) for name in ("participants", "wires")}
    return BenchNodeSettings(
        device, bench, given["lockstep"], words["participants"], words["wires"], given["settle"], given["timeout"],
    )  # fmt: skip


def _numbers(text: str) -> list[float]:
    try:
        return [float(word) for word in text.replace(",", " ").split()]
    except ValueError as error:
        raise ValueError(f"load_matrix: expected numbers; {error}") from error


def _path(text: str) -> Path | None:
    return Path(text).absolute() if text else None
