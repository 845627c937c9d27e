"""A law with some of its numbers changed by their names, wherever in it they stand: itself, its gains, its limits.

What another gain would make of the present error is a jump of the throttle. Where a law is changed while it runs, the
throttle's rate is therefore bounded for a while; anti-windup takes that for the limit that it is.
"""

from collections.abc import Mapping
from typing import Any

from thruster_control.settings import Gains

__all__ = ["HAND_OVER_RATE", "HAND_OVER_TIME", "changed_law", "handing_over"]

HAND_OVER_RATE = 5.0
"""[V/s] The throttle's largest rate after a change: a fifth of a volt in a period of 40 ms."""
HAND_OVER_TIME = 1_000_000_000
"""[ns] For how long."""


def changed_law(law: Any, changes: Mapping[str, Any]) -> Any:
    """Return the law with the changes by name; whether they can be used is for `settings.checked` to say.

    Raises:
        ValueError: with all names that this law does not have.
    """
    gains = getattr(law, "gains", None)
    parts = [("limits", law.limits._fields), ("gains", Gains._fields if gains is not None else ())]
    own = tuple(name for name in law._fields if name not in ("gains", "limits", "table"))
    unknown = [name for name in changes if not any(name in fields for _, fields in [*parts, ("", own)])]
    if unknown:
        kind = type(law).__name__
        raise ValueError("; ".join(f"{name}: expected a number of {kind}; it has none such" for name in unknown))
    for part, fields in parts:
        chosen = {name: value for name, value in changes.items() if name in fields}
        if chosen:
            law = law._replace(**{part: getattr(law, part)._replace(**chosen)})
    return law._replace(**{name: value for name, value in changes.items() if name in own})


def handing_over(law: Any) -> Any:
    """Return the law for the time after a change: with the throttle's rate bounded."""
    rate = min(law.limits.u_dot_max, HAND_OVER_RATE)
    return law._replace(limits=law.limits._replace(u_dot_max=rate))
