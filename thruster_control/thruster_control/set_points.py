"""A set point of thrust from the first tick on: the rig's references or a constant, after a delay, so many times."""

from dataclasses import dataclass
from math import isfinite

from thruster_control.references import DURATION, REFERENCES

__all__ = ["KINDS", "SetPoint"]

KINDS = (*REFERENCES, "triangle", "constant")
"""`triangle` is another name of the rig's ramp."""


@dataclass(frozen=True, kw_only=True)
class SetPoint:
    """A set point over time.

    Attributes:
        kind: one of `KINDS`.
        level: thrust of the kind `constant` [N].
        start_delay: how long 0 N is asked for first [s].
        repeats: how many runs of `references.DURATION` follow, after which 0 N is asked for; 0: without end.
    """

    kind: str
    level: float = 0.0
    start_delay: float = 0.0
    repeats: int = 1

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"kind: expected one of {', '.join(KINDS)}; found {self.kind!r}")
        if not (isfinite(self.level) and isfinite(self.start_delay) and self.start_delay >= 0.0 and self.repeats >= 0):
            found = f"{self.level} N, {self.start_delay} s, {self.repeats}"
            raise ValueError(f"expected a finite level, a delay and repeats of 0 or more; found {found}")

    def thrust(self, elapsed_ns: int) -> float:
        """Return the wanted thrust [N] at a time since the first tick [ns]."""
        since = elapsed_ns - round(self.start_delay * 1e9)
        if since < 0:
            return 0.0
        run, inside = divmod(since, round(DURATION * 1e9))
        if self.repeats and run >= self.repeats:
            return 0.0
        if self.kind == "constant":
            return self.level
        reference = REFERENCES["ramp" if self.kind == "triangle" else self.kind]
        return float(reference.thrust(inside / 1e9))
