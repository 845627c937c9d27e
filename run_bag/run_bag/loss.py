"""How many messages did not arrive: publishers number theirs, and a gap in the numbers is a loss."""

from __future__ import annotations

from collections.abc import Callable

MAX_PUBLISHERS = 64


class LossCounter:
    """Counts the messages of one topic that were lost on the way.

    A message says its number, counted from 1 by its publisher, but not which publisher that is. A number goes on
    from the nearest one below it, unless there is a publisher that was not heard before: then it begins a count of
    its own, and what that publisher sent earlier is not called lost. With one publisher this is exact; with several
    it may put a loss too low, never too high by more than publishers that come and go at once.
    """

    def __init__(self, publishers: Callable[[], int]) -> None:
        """Begin to count; `publishers` returns how many there are now, and is asked only where numbers jump."""
        self.lost = 0
        self._publishers = publishers
        self._last: list[int] = []

    def arrived(self, number: int) -> int:
        """Take the number of the next message.

        Returns:
            How many messages were lost right before it.
        """
        last = self._last
        if number - 1 in last:
            last[last.index(number - 1)] = number
            return 0
        below = [n for n in last if n < number]
        if number == 1 or not below or len(last) < self._publishers():
            del last[: max(0, len(last) + 1 - MAX_PUBLISHERS)]
            last.append(number)
            return 0
        before = max(below)
        last[last.index(before)] = number
        self.lost += number - before - 1
        return number - before - 1
