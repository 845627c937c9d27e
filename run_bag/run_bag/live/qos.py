"""QoS profiles as rosbag2 stores them, what a recorder asks for, and what a player offers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import Any, TypeVar

from rclpy.duration import Duration
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)

from thruster_runtime.qos import RECORDER

from ..rosbag2 import INFINITE

QUEUE = RECORDER.depth
NANOSECONDS = 1_000_000_000
LONGEST = (1 << 63) - 1
"""[ns] What rclpy and rosbag2 take for infinite."""

Policy = TypeVar("Policy", bound=IntEnum)


def as_dict(profile: QoSProfile) -> dict[str, Any]:
    """Return a profile as metadata.yaml has it: names in lower case, durations as sec and nsec."""
    return {
        "history": profile.history.name.lower(),
        "depth": profile.depth,
        "reliability": profile.reliability.name.lower(),
        "durability": profile.durability.name.lower(),
        "deadline": _duration_dict(profile.deadline),
        "lifespan": _duration_dict(profile.lifespan),
        "liveliness": profile.liveliness.name.lower(),
        "liveliness_lease_duration": _duration_dict(profile.liveliness_lease_duration),
        "avoid_ros_namespace_conventions": profile.avoid_ros_namespace_conventions,
    }


def from_dict(stored: Mapping[str, Any]) -> QoSProfile:
    """Return a stored profile; what is missing or unknown is that of the recorder's queue.

    The graph does not tell how deep a publisher's queue is, so that recordings of live topics do not know it.
    """
    depth = stored.get("depth")
    keeps_all = str(stored.get("history", "")) == "keep_all"
    return QoSProfile(
        history=HistoryPolicy.KEEP_ALL if keeps_all else HistoryPolicy.KEEP_LAST,
        depth=depth if isinstance(depth, int) and depth > 0 else QUEUE,
        reliability=_policy(stored.get("reliability"), ReliabilityPolicy.RELIABLE),
        durability=_policy(stored.get("durability"), DurabilityPolicy.VOLATILE),
        deadline=_duration(stored.get("deadline")),
        lifespan=_duration(stored.get("lifespan")),
        liveliness=_policy(stored.get("liveliness"), LivelinessPolicy.AUTOMATIC),
        liveliness_lease_duration=_duration(stored.get("liveliness_lease_duration")),
        avoid_ros_namespace_conventions=bool(stored.get("avoid_ros_namespace_conventions", False)),
    )


def request(offers: Sequence[QoSProfile]) -> QoSProfile:
    """Return the strongest profile that all these publishers can serve: reliable and latched where all of them are."""
    reliable = all(o.reliability == ReliabilityPolicy.RELIABLE for o in offers)
    latched = all(o.durability == DurabilityPolicy.TRANSIENT_LOCAL for o in offers)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=QUEUE,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def serves(offer: QoSProfile, wanted: QoSProfile) -> bool:
    """Tell whether a publisher's profile is good enough for a subscription that `request` made."""
    reliable = offer.reliability == ReliabilityPolicy.RELIABLE or wanted.reliability != ReliabilityPolicy.RELIABLE
    latched = offer.durability == DurabilityPolicy.TRANSIENT_LOCAL
    return reliable and (latched or wanted.durability != DurabilityPolicy.TRANSIENT_LOCAL)


def offer(stored: Sequence[Mapping[str, Any]]) -> QoSProfile:
    """Return one profile in place of those of all recorded publishers of a topic.

    Equal ones are restored as they are. Where they differ: reliable and latched if one of them was, which serves every
    subscription that they served; deadline, lifespan and liveliness unlimited. A volatile topic's queue is as
    deep as the recorder's, since that concerns nobody but the player.
    """
    profiles = [from_dict(one) for one in stored] or [RECORDER]
    first = profiles[0]
    if any(p != first for p in profiles):
        reliable = any(p.reliability == ReliabilityPolicy.RELIABLE for p in profiles)
        latched = any(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in profiles)
        first = QoSProfile(
            history=HistoryPolicy.KEEP_LAST,
            depth=sum(p.depth for p in profiles),
            reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
            durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
        )
    if first.durability == DurabilityPolicy.VOLATILE:
        first.depth = max(first.depth, QUEUE)
    return first


def _policy(name: object, default: Policy) -> Policy:
    found = type(default).__members__.get(str(name).upper(), default)
    return default if found.name in ("UNKNOWN", "SYSTEM_DEFAULT", "BEST_AVAILABLE") else found


def _duration_dict(duration: Duration) -> dict[str, int]:
    nanoseconds = duration.nanoseconds
    if nanoseconds >= LONGEST:
        return dict(INFINITE)
    return {"sec": nanoseconds // NANOSECONDS, "nsec": nanoseconds % NANOSECONDS}


def _duration(stored: object) -> Duration:
    if not isinstance(stored, Mapping):
        return Duration(nanoseconds=LONGEST)
    nanoseconds = int(stored.get("sec", 0)) * NANOSECONDS + int(stored.get("nsec", 0))
    return Duration(nanoseconds=LONGEST if nanoseconds <= 0 else min(nanoseconds, LONGEST))
