"""The parameters of the driver node, and the settings that they make."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, get_args

from rclpy.node import Node

from bench_driver.driver_settings import DriverSettings, LoadCell, ProtocolName
from bench_driver.errors import BenchDriverError, SettingsRefused
from bench_driver.framed_messages import MOST_THRUSTERS
from bench_driver.link_records import LinkLimits
from bench_driver.text_protocol import FULL_SCALE, THROTTLE_LIMIT
from thruster_runtime.parameters import Parameter, changeable, declare, refused

__all__ = ["PARAMETERS", "settings_of"]

_BOUNDS = {"throttle_limit": "throttle", "slew": "slew", "stale": "stale"}
_OWN, _LINK = DriverSettings(port="-"), LinkLimits()
PARAMETERS = (
    Parameter(name="port", default="", description="serial port, e.g. /dev/ttyACM0 or a link in /dev/serial/by-id"),
    Parameter(
        name="protocol", default=_OWN.protocol, choices=get_args(ProtocolName),
        description="text: the rig's own program, 9600 baud, 25 Hz; frames: the firmware of this package, 100 Hz",
    ),
    Parameter(
        name="thrusters", default=_OWN.thrusters, lower=1, upper=MOST_THRUSTERS, description="thrusters of the device"
    ),
    Parameter(
        name="lockstep", default=_OWN.lockstep,
        description="whether /clock gives the pace: one state, one throttle, one command in each of its periods",
    ),
    Parameter(
        name="throttle_limit", default=THROTTLE_LIMIT, unit="V", lower=0.0, upper=FULL_SCALE, live=True,
        description="largest magnitude of the throttle; what exceeds it is clipped; may be lowered while it runs",
    ),
    Parameter(
        name="slew", default=_LINK.slew, unit="V/s", lower=0.0, above=True, live=True,
        description="largest rate of the throttle; zero is set at once; may be lowered while it runs",
    ),
    Parameter(
        name="stale", default=_LINK.stale, unit="s", lower=0.0, above=True, upper=1.0, live=True,
        description="age from which a throttle is replaced by zero; may be lowered while it runs",
    ),
    Parameter(
        name="quiet", default=_LINK.quiet, unit="s", lower=0.0, upper=10.0,
        description="time after opening the port in which nothing is sent: a board that it reset is starting",
    ),
    Parameter(
        name="poll", default=_OWN.poll, unit="s", lower=0.0, above=True, upper=0.02,
        description="time between two looks at the port",
    ),
    Parameter(
        name="reading_timeout", default=_OWN.reading_timeout, unit="s", lower=0.0, above=True,
        description="in lockstep, longest time of the wall's clock to wait for the device's bytes",
    ),
    Parameter(
        name="answer_timeout", default=_OWN.answer_timeout, unit="s", lower=0.0, above=True,
        description="in lockstep, longest time of the wall's clock to wait for the throttle that answers a state",
    ),
    Parameter(
        name="load_matrix", default="",
        description="wrench per voltage of the load cell's gauges: 36 numbers, row by row Fx, Fy, Fz [N/V], Mx, My, Mz "
        "[N m/V]; empty: only the gauges are published",
    ),
    Parameter(
        name="load_rest", default=" ".join(f"{v:g}" for v in _OWN.load_cell.rest), unit="V",
        description="voltage of each gauge without load: 6 numbers",
    ),
)  # fmt: skip


def settings_of(node: Node, change: Callable[[LinkLimits], None]) -> DriverSettings:
    """Declare the parameters of a node and return the settings they make.

    Those that bound the throttle may be lowered while the node runs, never raised beyond what it was started with;
    `change` gets the new ones.

    Raises:
        StartRefused: with a sentence for all that is wrong.
    """
    declared = declare(node, PARAMETERS)
    given = dict(declared)
    limits = {name: given.pop(name) for name in ("slew", "stale", "quiet")}
    problems: list[str] = []
    lists = {name: _numbers(name, given.pop(name), problems) for name in ("load_matrix", "load_rest")}
    try:
        if problems:
            raise SettingsRefused(problems)
        limits_of_link = LinkLimits(throttle=given.pop("throttle_limit"), **limits)
        cell = LoadCell.of(lists["load_matrix"], lists["load_rest"])
        settings = DriverSettings(limits=limits_of_link, load_cell=cell, **given)
    except BenchDriverError as error:
        raise refused(node, error.problems if isinstance(error, SettingsRefused) else [str(error)]) from error

    def lowered(values: Mapping[str, Any]) -> tuple[Callable[[], None], list[str]]:
        wrong = [
            f"{name}: expected at most the {declared[name]:g} that the driver was started with; found {values[name]:g}"
            for name in _BOUNDS
            if values[name] > declared[name]
        ]
        bounds = {field: values[name] for name, field in _BOUNDS.items()}
        return (lambda: change(replace(limits_of_link, **bounds))), wrong

    changeable(node, PARAMETERS, declared, lowered)
    return settings


def _numbers(name: str, text: str, problems: list[str]) -> list[float]:
    try:
        return [float(word) for word in text.replace(",", " ").split()]
    except ValueError as error:
        problems.append(f"{name}: expected numbers; {error}")
        return []
