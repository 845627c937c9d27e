"""The inner loop of one thruster: every `estimate` becomes one `throttle` of the same stamp.

subscribes  thruster_i/estimate, or thruster_i/state without observer; thruster_i/thrust_setpoint, rov/thruster_failure;
            what the law measures: thruster_i/flow, thruster_i/load, rov/battery
publishes   thruster_i/throttle, /diagnostics

A strategy without observer takes the `state` in the place of the estimate: as a clock, and `force-table` its supply
voltage, or that of `rov/battery` (the nominal one where neither is measured). What is stamped when and waits for what:
`thruster_runtime.triggered_join`.
"""

import sys
from collections.abc import Callable, Mapping
from math import nan
from typing import Any

from geometry_msgs.msg import WrenchStamped
from rclpy.node import Node
from rclpy.time import Time
from sensor_msgs.msg import BatteryState

from thruster_control.inner_loop import Output, Status
from thruster_control.inner_loop_parameters import PARAMETERS, chosen_strategy, without_speed
from thruster_control.law_changes import HAND_OVER_TIME, handing_over
from thruster_control.online import START, Inputs, advance
from thruster_control.settings import SteadyFlowLaw
from thruster_control.strategies_io import Ready
from thruster_msgs.msg import (
    FlowVelocity,
    Throttle,
    ThrusterEstimate,
    ThrusterFailure,
    ThrusterState,
    ThrustSetpoint,
)
from thruster_runtime.diagnostics import Level
from thruster_runtime.join_health import JoinHealth
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import changeable, declare, refused
from thruster_runtime.qos import RELIABLE
from thruster_runtime.records import RecordPublisher, format_of, listen
from thruster_runtime.triggered_join import Due, Input, TriggeredJoin, held

__all__ = ["InnerLoopNode", "main"]

_THROTTLE = format_of(Throttle)
_WORDS: dict[Status, tuple[Level, str]] = {
    Status.RUNNING: ("ok", "running"),
    Status.LIMITED: ("ok", "running, the throttle at a limit"),
    Status.IDLE: ("ok", "idle: no thrust is asked for"),
    Status.HOLDING: ("warn", "no usable estimate: the throttle follows the set point alone"),
    Status.RUN_DOWN: ("error", "no usable estimate for too long: the throttle runs down to zero"),
    Status.NO_SET_POINT: ("warn", "no set point: the throttle runs down to zero"),
    Status.BAD_PERIOD: ("error", "no valid period: the throttle is zero"),
}
_BLIND = "the speed is reported lost: a table of steady states, without feedback"
_BATTERY_TIMEOUT = 5_000_000_000  # ns; a voltage that is older counts no more
_UNKNOWN = ThrusterEstimate(n=nan, v=nan, ambient=nan, status=ThrusterEstimate.STATUS_INVALID)


def _known(value: float | None) -> float:
    return nan if value is None else value


def _relative(volts: float, nominal: float) -> float:
    """Return the supply over the nominal one; 1 where either is unknown."""
    return volts / nominal if volts > 0.0 and nominal > 0.0 else 1.0


class InnerLoopNode(Node):
    """Subscribes `estimate` or `state`, `thrust_setpoint`, what the law measures, the battery; publishes `throttle`."""

    def __init__(self, **options: Any) -> None:
        """Refuse wrong parameters, compile the law, then listen; `options` are those of rclpy's Node."""
        super().__init__("inner_loop", **options)
        values = declare(self, PARAMETERS)
        ready, problems = chosen_strategy(values)
        if ready is None:
            raise refused(self, problems)
        self._p, self._period, self._blind = ready.coefficients, values["period"], False
        self._setpoint_timeout, self._measured_timeout = (
            round(values[name] * 1e9) for name in ("setpoint_timeout", "measured_timeout")
        )
        self._nominal_supply = getattr(self._p, "nominal_supply", nan)
        self._track = START
        self._take_up(ready)
        self._changed: int | None = None  # the first instant after a change [ns], 0: still to come
        for settings in (self._with_speed, self._without_speed):
            # Once beside the track: the first message shall not wait for a compiler.
            advance(START, Inputs(0, 0.0, 0.0, 0.0, 0.0, False, nan, 0.0, 1.0), self._period, settings, self._p)

        self._thruster = values["thruster"]
        prefix = f"thruster_{values['thruster']}"
        inputs = {"setpoint": Input(timeout=self._setpoint_timeout, wait=values["wait_for_setpoint"])}
        measured = Input(timeout=self._measured_timeout)
        if isinstance(self._with_speed, SteadyFlowLaw):
            inputs["flow"] = measured
            listen(self, FlowVelocity, f"{prefix}/flow", self._on_flow)
        if values["load_cell"]:
            inputs["load"] = measured
            listen(self, WrenchStamped, f"{prefix}/load", self._on_load)
        if values["battery_every"] > 0.0:
            inputs["battery"] = Input(timeout=_BATTERY_TIMEOUT, every=round(values["battery_every"] * 1e9))
            self.create_subscription(BatteryState, "rov/battery", self._on_battery, RELIABLE)
        self._frame_id = ""
        self._join = TriggeredJoin("trigger", inputs)
        self._health = JoinHealth(self, self._join)
        self._throttles = RecordPublisher(self, Throttle, f"{prefix}/throttle")
        listen(self, ThrustSetpoint, f"{prefix}/thrust_setpoint", self._on_setpoint)
        listen(self, ThrusterFailure, "rov/thruster_failure", self._on_failure)
        if ready.strategy.observer == "none":
            listen(self, ThrusterState, f"{prefix}/state", self._on_state)
        else:
            listen(self, ThrusterEstimate, f"{prefix}/estimate", self._on_estimate)
        changeable(self, PARAMETERS, values, self._change)

    def _take_up(self, ready: Ready) -> None:
        self._with_speed, self._without_speed = ready.settings, without_speed(ready)

    def _change(self, values: Mapping[str, Any]) -> tuple[Callable[[], None], list[str]]:
        """Gains and limits count from the next instant on; for a while the throttle moves slowly, without a jump."""
        ready, problems = chosen_strategy(values)

        def count() -> None:
            assert ready is not None
            self._take_up(ready)
            self._changed = 0

        return count, problems

    def _settings_at(self, stamp: int) -> Any:
        """Return the law's settings for an instant [ns]."""
        settings = self._without_speed if self._blind else self._with_speed
        if self._changed is None:
            return settings
        self._changed = self._changed or stamp
        if not 0 <= stamp - self._changed < HAND_OVER_TIME:
            self._changed = None
            return settings
        return handing_over(settings)

    def on_stop(self) -> None:
        """Command zero."""
        stamp = self._throttles.last_word(self)
        self._throttles.publish(_THROTTLE.record(stamp=stamp, frame_id=self._frame_id, commanded=0.0, sent=nan))

    def _on_setpoint(self, setpoint: Any) -> None:
        self._take("setpoint", setpoint.stamp, setpoint.thrust)

    def _on_failure(self, failure: Any) -> None:
        if failure.thruster == self._thruster:
            self._blind = failure.kind == ThrusterFailure.KIND_NO_SPEED

    def _on_flow(self, flow: Any) -> None:
        self._take("flow", flow.stamp, nan if flow.spike else flow.ambient)

    def _on_load(self, load: Any) -> None:
        self._take("load", load.stamp, load.wrench_force_x)

    def _on_battery(self, battery: BatteryState) -> None:
        self._take("battery", Time.from_msg(battery.header.stamp).nanoseconds, battery.voltage)

    def _on_state(self, state: Any) -> None:
        self._take("trigger", state.stamp, (state.frame_id, _UNKNOWN, state.supply_voltage))

    def _on_estimate(self, estimate: Any) -> None:
        self._take("trigger", estimate.stamp, (estimate.frame_id, estimate, nan))

    def _take(self, name: str, stamp: int, kept: Any) -> None:
        for due in self._join.put(name, stamp, kept):
            self._control(due)

    def _control(self, due: Due) -> None:
        frame_id, estimate, volts = due.message
        if "battery" in due.inputs:
            volts = _known(held(due, "battery", _BATTERY_TIMEOUT))
        # in simulated time the clock may come after the estimate; none is younger than now
        age = max(0.0, (self.get_clock().now().nanoseconds - due.stamp) / 1e9)
        inputs = Inputs(
            stamp=due.stamp,
            T_d=_known(held(due, "setpoint", self._setpoint_timeout)),
            n=estimate.n,
            v=estimate.v,
            U=self._measured(due, "flow") if "flow" in due.inputs else estimate.ambient,
            valid=estimate.status != ThrusterEstimate.STATUS_INVALID,
            T=self._measured(due, "load") if "load" in due.inputs else nan,
            age=age,
            supply=_relative(volts, self._nominal_supply),
        )
        track = START if due.former is None else self._track
        self._track, out = advance(track, inputs, self._period, self._settings_at(due.stamp), self._p)
        self._publish(due.stamp, frame_id, out)

    def _measured(self, due: Due, name: str) -> float:
        return _known(held(due, name, self._measured_timeout))

    def _publish(self, stamp: int, frame_id: str, out: Output) -> None:
        self._frame_id = frame_id
        self._throttles.publish(_THROTTLE.record(stamp=stamp, frame_id=frame_id, commanded=out.u, sent=nan))
        level, words = _WORDS[Status(out.status)]
        if self._blind and self._without_speed is not self._with_speed:
            level, words = ("warn" if level == "ok" else level), f"{words}; {_BLIND}"
        self._health.report(stamp, level, words)


def main() -> int:
    """Run the node until it is told to stop."""
    return node_main(InnerLoopNode, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
