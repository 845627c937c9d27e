r"""The navigation filter while readings arrive, each sensor at its own rate and delay.

A reading counts at the first instant of the IMU at or after its stamp. One that arrives after later readings of the IMU
is taken in where it belongs: the filter goes back to the belief before that instant and takes all steps since anew, so
that the estimate does not depend on when things arrive, but for the time until they do.
"""

from collections.abc import Sequence
from typing import NamedTuple

from thruster_estimation.navigation_belief import Heard, NavigationBelief, NavigationSettings
from thruster_estimation.navigation_output import compiled_first, compiled_navigation

__all__ = ["NAVIGATION_START", "LateReading", "NavigationTrack", "Step", "navigation_advance"]

_SECOND = 1_000_000_000


class LateReading(NamedTuple):
    """A reading of velocity log or depth sensor: stamp [ns], fields of `Heard` by name."""

    stamp: int
    values: dict[str, float]


class Step(NamedTuple):
    """An instant of the IMU [ns], all that was told of it, and the belief after it."""

    stamp: int
    heard: Heard
    belief: NavigationBelief


class NavigationTrack(NamedTuple):
    """The latest steps, the last one being the present; `dropped`: how many readings came too late to be used."""

    steps: tuple[Step, ...] = ()
    dropped: int = 0

    @property
    def belief(self) -> NavigationBelief | None:
        """The present belief, None before the first step."""
        return self.steps[-1].belief if self.steps else None


NAVIGATION_START = NavigationTrack()


def navigation_advance(
    track: NavigationTrack, stamp: int, imu: Heard, others: Sequence[LateReading], settings: NavigationSettings, *,
    memory: int = _SECOND,
) -> NavigationTrack:  # fmt: skip
    """Return the track at the instant `stamp` [ns] of the IMU; one that is not later than the last starts anew.

    Args:
        track: before; `NAVIGATION_START` at first.
        stamp: of the reading of the IMU [ns].
        imu: that reading, nothing else in it.
        others: what arrived from the other sensors and is stamped `stamp` or before.
        settings: `checked_navigation` ones.
        memory: how far back readings may belong [ns].
    """
    steps = [step for step in track.steps if step.stamp >= stamp - memory] or list(track.steps[-1:])
    if steps and stamp <= steps[-1].stamp:
        steps = []
    present = imu
    first, dropped = len(steps), track.dropped
    for reading in others:
        at = next((k for k, step in enumerate(steps) if step.stamp >= reading.stamp), len(steps))
        if at == len(steps):
            present = present._replace(**reading.values)
        elif at == 0:
            dropped += 1  # nothing before it to go back to
        else:
            steps[at] = steps[at]._replace(heard=steps[at].heard._replace(**reading.values))
            first = min(first, at)
    for k in range(first, len(steps)):
        belief = _stepped(steps[k - 1], steps[k].stamp, steps[k].heard, settings)
        steps[k] = steps[k]._replace(belief=belief)
    if steps:
        belief = _stepped(steps[-1], stamp, present, settings)
    else:
        belief = compiled_first(present, settings)[0]
    return NavigationTrack((*steps, Step(stamp, present, belief)), dropped)


def _stepped(before: Step, stamp: int, heard: Heard, settings: NavigationSettings) -> NavigationBelief:
    belief: NavigationBelief = compiled_navigation(before.belief, heard, 1e-9 * (stamp - before.stamp), settings)[0]
    return belief
