"""How a link is doing, in one sentence with the counters behind it."""

from dataclasses import dataclass, field
from enum import IntEnum

from bench_driver.link import Link
from bench_driver.link_records import LinkState

__all__ = ["Diagnosis", "Level", "LinkDiagnosis"]


class Level(IntEnum):
    """As in diagnostic_msgs/DiagnosticStatus."""

    OK = 0
    WARN = 1
    ERROR = 2


@dataclass(frozen=True, kw_only=True, slots=True)
class Diagnosis:
    """State of a link at one time.

    Attributes:
        level: OK while the device is ready and the stream without faults.
        sentence: what is the matter.
        counters: all counters of link and stream since the start.
    """

    level: Level
    sentence: str
    counters: dict[str, int] = field(default_factory=dict)


_SENTENCES = {
    "garbage": "bytes that are no frame",
    "bad header": "headers that do not exist",
    "wrong checksum": "wrong checksums",
    "sequence jump": "jumps of the sequence counter",
    "not two integers": "lines that are no two integers",
    "start not seen": "lines whose start was not seen",
    "contradictory state": "states that contradict themselves",
}
_OF_THE_LINK = {"clipped": "throttles clipped", "command not a number": "commands that are not a number"}


class LinkDiagnosis:
    """Watches a link; faults of the last few seconds make a warning.

    Args:
        link: the link.
        recent: how long a fault is mentioned [s].
    """

    def __init__(self, link: Link, *, recent: float = 5.0) -> None:
        self._link = link
        self._recent = recent
        self._known: dict[str, int] = {}
        self._seen: dict[str, float] = {}
        self._resets = 0
        self._reset_at: float | None = None
        self._opened = 0
        self._opened_at: float | None = None

    def diagnose(self, now: float) -> Diagnosis:
        """Return how the link is doing; to be called about once a second."""
        link = self._link
        faults = link.dialect.faults
        self._note(now, {**faults, **{name: link.counters.get(name, 0) for name in _OF_THE_LINK}})
        counters = {**link.counters, **faults, "device reset": link.dialect.resets}
        level, sentence = self._of_the_state()
        if level is not Level.ERROR:
            remarks = self._remarks(now)
            if remarks:
                level = Level.WARN
                sentence = "; ".join([sentence, *remarks])
        return Diagnosis(level=level, sentence=sentence, counters=counters)

    def _note(self, now: float, counts: dict[str, int]) -> None:
        for name, count in counts.items():
            known = max(self._known.get(name, 0), self._link.excused.get(name, 0))
            if count > known and self._link.state in (LinkState.READY, LinkState.SILENT):
                self._seen[name] = now
        self._known = dict(counts)
        if self._link.dialect.resets > self._resets:
            self._resets, self._reset_at = self._link.dialect.resets, now
        if self._link.counters.get("opened", 0) > self._opened:
            if self._opened:
                self._opened_at = now
            self._opened = self._link.counters["opened"]

    def _of_the_state(self) -> tuple[Level, str]:
        link = self._link
        if link.state is LinkState.READY:
            return Level.OK, f"ready ({link.dialect.device})"
        if link.state is LinkState.SILENT:
            partial = f", {link.dialect.waiting} bytes of an unfinished one wait" if link.dialect.waiting else ""
            return Level.ERROR, f"the device is silent: {link.reason}{partial}"
        if link.state in (LinkState.ABSENT, LinkState.LOST):
            return Level.ERROR, f"{link.state.value}: {link.reason}"
        detail = link.dialect.refusal
        return (Level.ERROR, detail) if detail else (Level.WARN, f"{link.state.value}: {link.reason}")

    def _remarks(self, now: float) -> list[str]:
        remarks = []
        if self._reset_at is not None and now - self._reset_at <= self._recent:
            remarks.append(f"the device was reset ({self._resets} times so far)")
        if self._opened_at is not None and now - self._opened_at <= self._recent:
            remarks.append("the port was opened again")
        for name, seen in self._seen.items():
            if now - seen <= self._recent:
                words = {**_SENTENCES, **_OF_THE_LINK}.get(name, name)
                remarks.append(f"{words}: {self._known.get(name, 0)}")
        return remarks
