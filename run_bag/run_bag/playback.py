"""Playing a timeline: at a rate against a clock, as fast as possible, or in lockstep. The clock is an argument."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass

from .arrivals import Arrivals
from .errors import InvalidRunError, MissingParticipantError
from .timeline import Instant

NANOSECONDS = 1_000_000_000


@dataclass(frozen=True)
class Played:
    """What was done: messages published, and how late the latest instant was [s]."""

    messages: int = 0
    latest: float = 0.0


def with_ticks(instants: Iterable[Instant], period: int) -> Iterator[Instant]:
    """Yield the instants, and empty ones at least every `period` [ns] between them, so that a clock goes on evenly.

    0: the instants alone.
    """
    tick: int | None = None
    for instant in instants:
        while tick is not None and tick < instant.time:
            yield Instant(tick, [])
            tick += period
        yield instant
        if period and (tick is None or tick <= instant.time):
            start = instant.time if tick is None else tick
            tick = start + ((instant.time - start) // period + 1) * period


def play(
    instants: Iterable[Instant],
    publish: Callable[[Instant], None],
    *,
    rate: float | None,
    monotonic: Callable[[], float],
    sleep: Callable[[float], bool],
    acknowledged: Callable[[Instant], None] = lambda instant: None,
) -> Played:
    """Publish instant after instant.

    Each is due at (its time - first time) / rate after the first, so that errors of single waits do not add up. What
    is late is published at once; nothing is left out.

    Args:
        instants: in order of time.
        publish: publishes one.
        rate: seconds of the run per second; None: no waiting.
        monotonic: the time [s].
        sleep: waits for so long [s] and returns whether to stop.
        acknowledged: returns when the next instant may follow.

    Returns:
        What was done, up to the end or to where it was stopped.
    """
    begin = first = None
    messages, latest = 0, 0.0
    for instant in instants:
        if begin is None or first is None:
            begin, first = monotonic(), instant.time
        if rate is None:
            if sleep(0.0):
                break
        else:
            due = begin + (instant.time - first) / NANOSECONDS / rate
            if sleep(max(0.0, due - monotonic())):
                break
            latest = max(latest, monotonic() - due)
        publish(instant)
        messages += len(instant.messages)
        acknowledged(instant)
    return Played(messages, latest)


def participants(texts: Iterable[str]) -> dict[str, frozenset[str] | None]:
    """Return which output each text names, and the inputs that it answers (None: every instant).

    "OUTPUT" answers each instant, "OUTPUT:INPUT,INPUT" those alone at which one of the inputs has a message.

    Raises:
        InvalidRunError: all texts of another form.
    """
    result: dict[str, frozenset[str] | None] = {}
    problems = []
    for text in texts:
        output, colon, inputs = text.partition(":")
        names = frozenset(_full(name) for name in inputs.split(",") if name)
        if not output or (colon and not names):
            problems.append(f"expected OUTPUT or OUTPUT:INPUT,INPUT, found {text!r}")
        result[_full(output)] = names or None
    if problems:
        raise InvalidRunError("wait_for", problems)
    return result


def _full(name: str) -> str:
    return f"/{name.lstrip('/')}"


class Lockstep:
    """Holds the player until the participants have answered an instant; messages arrive in another thread."""

    def __init__(self, outputs: Mapping[str, frozenset[str] | None], timeout: float) -> None:
        """Wait for `outputs` (see `participants`), at most `timeout` [s] for one instant."""
        self._outputs = outputs
        self._timeout = timeout
        self._arrivals = Arrivals(outputs)
        self._changed = threading.Condition()

    def arrived(self, topic: str, stamp: int) -> None:
        """Take the stamp [ns] of an output."""
        with self._changed:
            self._arrivals.arrived(topic, stamp)
            self._changed.notify_all()

    def again(self) -> None:
        """Forget what has arrived, before the run is played from its start again."""
        with self._changed:
            self._arrivals = Arrivals(self._outputs)

    def wait(self, time: int, inputs: set[str], stopped: Callable[[], bool]) -> None:
        """Return when every participant that answers these inputs has answered the instant, or on a stop.

        Raises:
            MissingParticipantError: with the names of those that have not in time.
        """
        asked = [o for o, answers in self._outputs.items() if answers is None or answers & inputs]
        if not inputs or not asked:
            return
        with self._changed:
            self._changed.wait_for(lambda: stopped() or not self._arrivals.missing(time, asked), self._timeout)
            missing = () if stopped() else self._arrivals.missing(time, asked)
        if missing:
            text = f"no message stamped {time / NANOSECONDS:.9f} s within {self._timeout:g} s on {', '.join(missing)}"
            raise MissingParticipantError(text, topic=missing[0], position=time, expected=asked, found=missing)

    def wake(self) -> None:
        """Let a waiting player look whether it is to stop."""
        with self._changed:
            self._changed.notify_all()
