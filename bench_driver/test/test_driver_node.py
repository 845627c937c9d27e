"""The driver's node: each wire, and its fault table as /diagnostics tells it."""

import math
from collections.abc import Callable
from functools import partial

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from driver_scene import Scene
from rclpy.context import Context
from rclpy.executors import Executor
from rclpy.parameter import Parameter

from bench_driver.driver_node import Driver
from bench_driver.link_records import LinkState
from bench_driver.text_protocol import speed_from_count
from thruster_msgs.msg import ThrusterState
from thruster_runtime.errors import StartRefused

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
MATRIX = " ".join("20" if i % 7 == 0 else "0" for i in range(36))
ZERO = pytest.approx(0.0, abs=0.021)  # text: zero has no count


@pytest.fixture
def make(context: Context, spun: Callable[..., Executor]) -> Callable[..., Scene]:
    return partial(Scene, context, spun)


# ---- wires


@pytest.mark.parametrize("protocol", ["text", "frames"])
def test_states_and_flows_go_out_in_si_units_with_one_stamp(make: Callable[..., Scene], protocol: str) -> None:
    scene = make(protocol)
    scene.line.count = 300
    scene.drive()
    assert scene.spin(lambda: len(scene.heard["thruster_0/state"]) > 10 and len(scene.heard["thruster_0/flow"]) > 10)
    state = scene.heard["thruster_0/state"][9]
    flow = scene.heard["thruster_0/flow"][9]
    assert isinstance(state, ThrusterState)
    assert state.n == speed_from_count(300)
    assert state.sign_source == ThrusterState.SIGN_UNKNOWN
    assert math.isnan(state.supply_voltage) and math.isnan(state.current)
    assert flow.ambient == pytest.approx(0.0, abs=1e-3)
    assert math.isnan(flow.axial)
    assert state.header == flow.header
    assert state.header.frame_id == "thruster_0"


@pytest.mark.parametrize(("protocol", "step"), [("text", 10 / 255), ("frames", 10 / 4080)])
def test_a_throttle_reaches_the_device_and_what_was_sent_is_told(
    make: Callable[..., Scene], protocol: str, step: float
) -> None:
    scene = make(protocol)
    scene.drive(-1.234)
    assert abs(scene.line.throttle + 1.234) <= step / 2 + 1e-9
    assert scene.spin(lambda: scene.heard["thruster_0/throttle_sent"][-1:])
    scene.spin(lambda: False, 0.1)
    sent = scene.heard["thruster_0/throttle_sent"][-1]
    assert sent.commanded == -1.234
    assert sent.sent == pytest.approx(scene.line.throttle, abs=1e-9)


def test_the_load_cell_goes_out_where_its_matrix_is_known(make: Callable[..., Scene]) -> None:
    scene = make("frames", load_matrix=MATRIX)
    scene.drive()
    assert scene.spin(lambda: scene.heard["thruster_0/load"] and scene.heard["thruster_0/gauges"])
    load, gauges = scene.heard["thruster_0/load"][-1], scene.heard["thruster_0/gauges"][-1]
    assert list(gauges.voltage) == [5.0 / 1024 * count for count in (512, 612, 512, 512, 512, 512)]
    assert load.wrench.force.y == pytest.approx(20.0 * 100 * 5.0 / 1024)
    assert load.wrench.force.x == load.wrench.torque.z == 0.0


def test_without_a_matrix_there_is_no_load_topic(make: Callable[..., Scene]) -> None:
    scene = make("frames")
    assert scene.node.count_publishers("thruster_0/load") == 0
    assert scene.node.count_publishers("thruster_0/gauges") == 1


# ---- faults


def test_an_absent_port_is_an_error_and_comes_to_life_when_it_is_plugged_in(make: Callable[..., Scene]) -> None:
    scene = make()
    scene.line.plugged = False
    scene.run(1.0)
    assert scene.says(ERROR, "absent: no such port; is the device plugged in?")
    scene.line.plugged = True
    scene.drive()
    assert scene.says(OK, "ready (frames, 1 thrusters, 6 load channels, 100 Hz")


@pytest.mark.parametrize("protocol", ["text", "frames"])
def test_an_unplugged_device_is_an_error_and_one_plugged_in_again_is_told(
    make: Callable[..., Scene], protocol: str
) -> None:
    scene = make(protocol)
    scene.drive()
    scene.line.plugged = False
    scene.run(0.3)
    assert scene.says(ERROR, "no such port")
    assert scene.line.throttle == ZERO, "the device's own watchdog"
    scene.line.plugged = True
    scene.drive()
    assert scene.says(WARN, "the port was opened again")
    scene.run(6.0)
    assert scene.says(OK, "ready")


def test_garbage_is_a_warning_and_no_measurement(make: Callable[..., Scene]) -> None:
    scene = make()
    scene.drive()
    scene.spin(lambda: False, 0.1)
    before = len(scene.heard["thruster_0/state"])
    scene.line.loses_answers = True
    for _ in range(5):
        scene.line.babble(bytes(range(256)))
        scene.run(0.01)
    assert scene.says(WARN, "bytes that are no frame")
    assert len(scene.heard["thruster_0/state"]) == before
    scene.line.loses_answers = False
    scene.drive()


@pytest.mark.parametrize("protocol", ["text", "frames"])
def test_a_silent_device_is_an_error_and_gets_zero(make: Callable[..., Scene], protocol: str) -> None:
    scene = make(protocol)
    scene.drive()
    scene.line.loses_answers = True
    scene.run(0.4)
    assert scene.says(ERROR, "the device is silent: no measurement for 0.2 s")
    assert scene.line.throttle == ZERO
    scene.line.loses_answers = False
    scene.drive()


def test_a_reset_is_a_warning_and_starts_with_zero(make: Callable[..., Scene]) -> None:
    scene = make()
    scene.drive()
    scene.run(1.0)  # a clock that has run for less cannot be seen to jump
    scene.line.device.reset()
    scene.line.advance(0.005)
    assert scene.line.throttle == 0.0
    scene.run(2.0)
    assert scene.says(WARN, "the device was reset (1 times so far)")
    scene.drive()


def test_a_device_with_other_channels_is_refused(make: Callable[..., Scene]) -> None:
    scene = make("frames", thrusters=2)
    scene.run(2.0)
    assert scene.says(ERROR, "the device has 1 thrusters and largest code 4080, expected 2 and 4080")


@pytest.mark.parametrize("protocol", ["text", "frames"])
def test_commands_that_stop_leave_zero_after_200_ms(make: Callable[..., Scene], protocol: str) -> None:
    scene = make(protocol)
    scene.drive()
    scene.throttle = None
    scene.run(0.15)
    assert scene.line.throttle == pytest.approx(2.0, abs=0.03)
    scene.run(0.15)
    assert scene.line.throttle == ZERO
    assert scene.link.sent is not None and scene.link.sent.reason == "the command is too old"


@pytest.mark.parametrize(
    ("throttle", "sent", "said"), [(math.nan, 0.0, "commands that are not a number"), (9.0, 3.0, "throttles clipped")]
)
def test_a_command_that_cannot_be_sent_is_a_warning(
    make: Callable[..., Scene], throttle: float, sent: float, said: str
) -> None:
    scene = make()
    scene.drive()
    scene.throttle = throttle
    scene.run(0.3)
    assert scene.line.throttle == pytest.approx(sent, abs=0.003)
    assert scene.says(WARN, said)


def test_zero_is_held_without_any_command(make: Callable[..., Scene]) -> None:
    scene = make()
    scene.run(3.0)
    assert scene.link.state is LinkState.READY
    assert scene.line.throttle == 0.0
    assert scene.link.sent is not None and scene.link.sent.reason == "no command yet"


@pytest.mark.parametrize("protocol", ["text", "frames"])
def test_a_node_that_stops_leaves_zero_and_says_so(make: Callable[..., Scene], protocol: str) -> None:
    scene = make(protocol)
    scene.drive()
    scene.driver.on_stop()
    scene.line.advance(0.03)
    assert scene.line.throttle == 0.0, "disabled"
    assert scene.spin(lambda: scene.heard["thruster_0/throttle_sent"][-1].sent == 0.0)


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ({}, "port: expected the name of a serial port"),
        ({"port": "p", "thrusters": 2}, "thrusters: expected 1 to 1 with the protocol text; found 2"),
        ({"port": "p", "throttle_limit": 7.0}, "throttle_limit"),
        ({"port": "p", "protocol": "morse"}, "protocol"),
        ({"port": "p", "load_matrix": "1 2 three"}, "load_matrix: expected numbers"),
        ({"port": "p", "load_matrix": "1 2 3"}, "load_matrix: expected no or 36 finite numbers; found 3"),
    ],
)
def test_wrong_parameters_are_refused_with_a_sentence(
    context: Context, parameters: dict[str, object], said: str
) -> None:
    overrides = [Parameter(name, value=value) for name, value in parameters.items()]
    with pytest.raises(StartRefused, match=said):
        Driver(context=context, parameter_overrides=overrides)
