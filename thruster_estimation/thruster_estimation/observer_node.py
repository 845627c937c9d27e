"""The observer of one thruster: every `state` becomes one `estimate` of the same stamp.

subscribes  thruster_i/state; thruster_i/throttle or thruster_i/throttle_sent; thruster_i/flow if the observer uses it
publishes   thruster_i/estimate, /diagnostics
"""

import sys
from collections.abc import Callable, Mapping
from functools import lru_cache
from math import nan
from typing import Any

from rclpy.node import Node

from thruster_estimation.belief import Belief, Level, Status, level, reason
from thruster_estimation.observer_parameters import PARAMETERS, chosen_observer
from thruster_estimation.online import (
    START,
    Measured,
    Track,
    advance,
    covariance_matrix,
    mean_throttle,
    plausible,
    states,
)
from thruster_estimation.settings import SpeedEkfSettings
from thruster_msgs.msg import FlowVelocity, Throttle, ThrusterEstimate, ThrusterState
from thruster_runtime.diagnostics import Level as DiagnosticLevel
from thruster_runtime.join_health import JoinHealth
from thruster_runtime.node_main import node_main
from thruster_runtime.parameters import changeable, declare, refused
from thruster_runtime.records import RecordPublisher, format_of, listen
from thruster_runtime.triggered_join import Due, Input, TriggeredJoin, newest_within

__all__ = ["ObserverNode", "main"]

_ESTIMATE = format_of(ThrusterEstimate)
_WORDS: dict[Level, DiagnosticLevel] = {Level.OK: "ok", Level.DEGRADED: "warn", Level.INVALID: "error"}


@lru_cache(maxsize=1024)
def _verdict(status: int, refused: int) -> tuple[Level, str]:
    return max(level(status), level(status | refused)), reason(status | refused)


class ObserverNode(Node):
    """Subscribes `state`, `flow` where the observer uses it, and the throttle; publishes `estimate`."""

    def __init__(self, **options: Any) -> None:
        """Refuse wrong parameters, compile the observer, then listen; `options` are those of rclpy's Node."""
        super().__init__("observer", **options)
        values = declare(self, PARAMETERS)
        chosen, problems = chosen_observer(values)
        if chosen is None:
            raise refused(self, problems)
        self._settings, self._p = chosen
        self._throttle_timeout = round(values["throttle_timeout"] * 1e9)
        self._name: str = values["estimator"]
        self._largest = values["largest_speed"], values["largest_flow"]
        self._refused = {"implausible speeds": 0, "implausible flows": 0}
        self._track = START
        self._compile()

        uses_flow = not isinstance(self._settings, SpeedEkfSettings)
        inputs = {"throttle": Input(timeout=self._throttle_timeout, wait=values["wait_for_throttle"], former=True)}
        if uses_flow:
            inputs["flow"] = Input(timeout=round(values["flow_timeout"] * 1e9), wait=values["wait_for_flow"])
        self._join = TriggeredJoin("state", inputs)
        self._health = JoinHealth(self, self._join)

        prefix = f"thruster_{values['thruster']}"
        self._estimates = RecordPublisher(self, ThrusterEstimate, f"{prefix}/estimate")
        if uses_flow:
            listen(self, FlowVelocity, f"{prefix}/flow", self._on_flow)
        if values["throttle"] == "sent":
            listen(self, Throttle, f"{prefix}/throttle_sent", self._on_sent)
        else:
            listen(self, Throttle, f"{prefix}/throttle", self._on_commanded)
        listen(self, ThrusterState, f"{prefix}/state", self._on_state)
        changeable(self, PARAMETERS, values, self._change)

    def _change(self, values: Mapping[str, Any]) -> tuple[Callable[[], None], list[str]]:
        """Densities, gates and gains count from the next state on; the belief stays."""
        chosen, problems = chosen_observer(values)

        def count() -> None:
            assert chosen is not None
            self._settings, self._p = chosen
            self._largest = values["largest_speed"], values["largest_flow"]

        return count, problems

    def _compile(self) -> None:
        """Step once beside the track: the first message shall not wait for a compiler."""
        still = Measured(0, 0.0, 0.0, True)
        track = advance(START, still, 0.0, self._settings, self._p)
        advance(track, still._replace(stamp=1), 0.0, self._settings, self._p)

    def _on_state(self, state: Any) -> None:
        self._take("state", state.stamp, state)

    def _on_flow(self, flow: Any) -> None:
        self._take("flow", flow.stamp, nan if flow.spike else flow.ambient)

    def _on_commanded(self, throttle: Any) -> None:
        self._take("throttle", throttle.stamp, throttle.commanded)

    def _on_sent(self, throttle: Any) -> None:
        self._take("throttle", throttle.stamp, throttle.sent)

    def _take(self, name: str, stamp: int, kept: Any) -> None:
        for due in self._join.put(name, stamp, kept):
            self._estimate(due)

    def _estimate(self, due: Due) -> None:
        state = due.message
        signed = state.sign_source == ThrusterState.SIGN_MEASURED
        U = newest_within(due, "flow") if "flow" in due.inputs else None
        measured, flags = plausible(
            Measured(due.stamp, state.n if signed else abs(state.n), nan if U is None else U, not signed),
            *self._largest,
        )
        self._refused["implausible speeds"] += bool(flags & Status.IMPLAUSIBLE_N)
        self._refused["implausible flows"] += bool(flags & Status.IMPLAUSIBLE_U)
        u = mean_throttle(due.inputs["throttle"], due.former, due.stamp, self._throttle_timeout)
        # a restart is told by the join, before the stamps say so
        track = START if due.former is None else self._track
        self._track = advance(track, measured, u, self._settings, self._p)
        self._publish(due.stamp, state.frame_id, self._track, flags)

    def _publish(self, stamp: int, frame_id: str, track: Track, flags: Status) -> None:
        belief = track.belief
        assert isinstance(belief, Belief)
        how, why = _verdict(int(belief.status), int(flags))
        n, v, U = states(belief, self._settings)
        estimate = _ESTIMATE.record(
            stamp=stamp, frame_id=frame_id, n=n, v=v, ambient=U, covariance=covariance_matrix(belief).ravel(),
            estimator=self._name, status=how, reason=why,
        )  # fmt: skip
        self._estimates.publish(estimate)
        self._health.report(stamp, _WORDS[how], why or "estimating", self._refused)


def main() -> int:
    """Run the node until it is told to stop."""
    return node_main(ObserverNode, __doc__, PARAMETERS)


if __name__ == "__main__":
    sys.exit(main())
