"""The throttles that act until others come, and when they are zero because nobody answers for them any more."""

from collections.abc import Iterable
from math import isfinite

__all__ = ["HeldThrottles"]


class HeldThrottles:
    """Holds one throttle for each of some thrusters.

    Attributes:
        values: the throttles that came last [V], zero at first and where one was not finite.
    """

    def __init__(self, count: int, silence: float) -> None:
        """Begin at zero; `silence`: the longest time [s] for which a throttle is held, or a word counts."""
        self.values = count * [0.0]
        self._silence = silence
        self._came: list[float | None] = [None for _ in range(count)]
        self._words: dict[str, float | None] = {}

    def watch(self, names: Iterable[str]) -> None:
        """Hold throttles only as long as all of these are heard of."""
        self._words = dict.fromkeys(names)

    def hold(self, thruster: int, throttle: float, now: float) -> None:
        """Take a throttle [V] that came now [s]."""
        self.values[thruster] = throttle if isfinite(throttle) else 0.0
        self._came[thruster] = now

    def heard(self, name: str, now: float) -> None:
        """Take a word of one that is watched, now [s]."""
        if name in self._words:
            self._words[name] = now

    def at(self, now: float) -> list[float]:
        """Return the throttles that act now [s]: zero where one, or whoever stands behind it, is silent."""
        if any(self._lost(at, now) for at in self._words.values()):
            return len(self.values) * [0.0]
        return [0.0 if self._lost(at, now) else u for u, at in zip(self.values, self._came, strict=True)]

    def silent(self, now: float) -> list[str]:
        """Return who is silent, by topic."""
        words = [name for name, at in self._words.items() if self._lost(at, now)]
        return words + [f"thruster_{i}/throttle" for i, at in enumerate(self._came) if self._lost(at, now)]

    def _lost(self, at: float | None, now: float) -> bool:
        return at is None or now - at > self._silence
