"""The facts of a session with a device: its states, limits, orders and what was sent."""

import math
from dataclasses import dataclass
from enum import Enum

from bench_driver.errors import OutOfRange
from bench_driver.text_protocol import FULL_SCALE, THROTTLE_LIMIT

__all__ = ["LinkLimits", "LinkState", "Orders", "Sent"]


class LinkState(Enum):
    """Where the session stands."""

    ABSENT = "absent"
    OPENING = "opening"
    SETTLING = "settling"
    READY = "ready"
    SILENT = "silent"
    LOST = "lost"


@dataclass(frozen=True, kw_only=True)
class LinkLimits:
    """Times [s] and sizes of a session.

    Attributes:
        stale: a command older than this is replaced by zero.
        future: a command stamped later than now by more than this is refused.
        silence: without a measurement for so long, a device is silent.
        give_up: a device silent for so long, or not ready so long after the port was opened, is lost.
        quiet: nothing is sent for so long after opening: the boot loader of a device that is reset by the opening
            takes any byte for the start of a programming session.
        settle_count: measurements in a row before throttles are sent.
        retry_first, retry_longest: wait before the port is opened again; doubles with each failure.
        throttle: largest magnitude sent [V]; what exceeds it is clipped and counted.
        slew: largest rate of the throttle [V/s]; zero is set at once.
    """

    stale: float = 0.2
    future: float = 0.05
    silence: float = 0.2
    give_up: float = 3.0
    quiet: float = 2.0
    settle_count: int = 5
    retry_first: float = 0.5
    retry_longest: float = 5.0
    throttle: float = THROTTLE_LIMIT
    slew: float = 100.0

    def __post_init__(self) -> None:
        if not 0 <= self.throttle <= FULL_SCALE:
            raise OutOfRange("limit of the throttle [V]", f"0 to {FULL_SCALE}", self.throttle)
        for name in ("stale", "future", "silence", "give_up", "quiet", "retry_first", "retry_longest", "slew"):
            if not (math.isfinite(getattr(self, name)) and getattr(self, name) >= 0):
                raise OutOfRange(f"{name} of the link", "a number of at least 0", getattr(self, name))


@dataclass(frozen=True, kw_only=True, slots=True)
class Orders:
    """What the caller has to do now: write, then close, or open."""

    open: bool = False
    close: bool = False
    data: bytes = b""


@dataclass(frozen=True, kw_only=True, slots=True)
class Sent:
    """The throttles sent last.

    Attributes:
        stamp: when they were ordered to be sent [s].
        commanded: as asked for by the command in force [V]; NaN without one.
        throttles: as sent, after the device's quantisation [V].
        reason: why they are zero instead of what was commanded, or an empty string.
    """

    stamp: float
    commanded: tuple[float, ...]
    throttles: tuple[float, ...]
    reason: str
