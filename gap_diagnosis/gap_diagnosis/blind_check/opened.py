"""A case of the blind check after its diagnosis: all that is scored of it, and nothing larger."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from gap_diagnosis.blind_check.judging import FOREIGN, true_names
from gap_diagnosis.blind_check.shrink import Channels, actual_shrink

__all__ = ["Opened", "scored_part"]

_DIGITS = 9
_NEGLIGIBLE = 1e-7  # probability of a candidate
_UNTOLD = ("factors", "recordings", "nonce")
_SCORED: Mapping[str, tuple[str, ...]] = {
    "verdict": (),
    "p_none": (),
    "p_unknown": (),
    "candidates": ("id", "probability"),
    "effects": (
        "id", "channel", "probability", "group_probability", "indistinguishable_from", "parameters", "shrink",
    ),
    "where": ("block", "share"),
    "budget": (),
}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Opened:
    """A case after its diagnosis.

    Attributes:
        key: from the seal, without what seed and name tell as well (parameters) or only its hash needs.
        diagnosis: what is scored of diagnosis.json, numbers to nine digits.
        shrink: how far the gap really shrank; None where nothing was predicted.
        seal: the published hash.
    """

    key: Mapping[str, Any]
    diagnosis: Mapping[str, Any]
    shrink: float | None = None
    seal: str = ""

    @classmethod
    def of(cls, key: Mapping[str, Any], diagnosis: Mapping[str, Any], clean: Channels, seal: str = "") -> "Opened":
        """Return the case of a key from the seal, a diagnosis with its predictions, and noise-free channels by run."""
        predicted = diagnosis.get("predictions") or {}
        shrink = actual_shrink(clean, predicted.get("retuned", {}), predicted.get("with_effect", {}))
        told = {name: value for name, value in key.items() if name not in _UNTOLD}
        return cls(key=told, diagnosis=scored_part(diagnosis), shrink=_rounded(shrink), seal=seal)

    @property
    def single(self) -> str | None:
        """The only effect of the library that is hidden, if it is the only one and the library was whole."""
        names = true_names(self.key)
        return names[0] if len(names) == 1 and self.key["kind"] not in FOREIGN else None


def scored_part(diagnosis: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is scored of diagnosis.json, numbers to nine digits."""
    found: dict[str, Any] = {}
    for name, parts in _SCORED.items():
        if name not in diagnosis:
            continue
        value = diagnosis[name]
        if parts:
            value = [{part: each[part] for part in parts if part in each} for each in value or ()]
        if name == "candidates":
            value = [each for each in value if each["probability"] > _NEGLIGIBLE]
        found[name] = _rounded(value)
    return found


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return float(f"{value:.{_DIGITS}g}")
    if isinstance(value, Mapping):
        return {name: _rounded(each) for name, each in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(each) for each in value]
    return value
