"""A law with some of its numbers changed by their names, wherever in it they stand: itself, its gains, its limits."""

from collections.abc import Mapping
from typing import Any

from thruster_control.settings import Gains

__all__ = ["changed_law"]


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
