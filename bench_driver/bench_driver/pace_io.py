"""Two paces for a session on a port: by the wall's clock, and in lockstep with a simulated one.

In real time the port is looked at all the time, a measurement is stamped by when it was taken on the host's clock, and
a command is as old as its stamp says.

In lockstep nothing happens between two ticks of /clock. At a tick the bytes of the period before it are read and what
they tell is published; then the throttle with the stamp of that state is waited for; then the link may send. So each
tick is over with exactly one word about what was sent, which is what a simulator waits for. A reading in text is
stamped by the tick at which the count that it answers was sent, a frame by the device's clock, the simulator's own.
A throttle that does not come in time is given up: the link then decides by the age of the last one.
"""

import math
from collections.abc import Callable

from bench_driver.dialect import Measurement
from bench_driver.driver_settings import DriverSettings
from bench_driver.link import Link
from bench_driver.link_records import LinkState, Sent
from bench_driver.serial_port_io import SerialPort
from bench_driver.serial_session_io import Port, SerialSession

__all__ = ["LockstepPace", "RealTimePace"]

Stamped = tuple[int, Measurement]
OpenPort = Callable[[str, int], Port]
_APART = 1000  # ns
_TALKING = (LinkState.SETTLING, LinkState.READY, LinkState.SILENT)


class RealTimePace:
    """By the wall's clock, see the module.

    Args:
        settings: of the driver.
        link: of its protocol.
        monotonic: time of the link [s]; stamps: the node's clock [ns].
        open_port: opens a port by name and line speed.
    """

    def __init__(
        self,
        settings: DriverSettings,
        link: Link,
        monotonic: Callable[[], float],
        stamps: Callable[[], int],
        open_port: OpenPort = SerialPort,
    ) -> None:
        self.session = SerialSession(link, settings.port, monotonic, open_port)
        self._link, self._monotonic, self._stamps = link, monotonic, stamps
        self._asked: dict[int, tuple[float, float]] = {}
        self._told: Sent | None = None
        self._latest = 0

    @property
    def now(self) -> float:
        """Return the link's time [s]."""
        return self._monotonic()

    def command(self, stamp: int, thruster: int, throttle: float) -> None:
        """Take a throttle; commands are given to the link once each thruster has one, as old as the oldest."""
        self._asked[thruster] = (self._monotonic() - 1e-9 * (self._stamps() - stamp), throttle)
        if len(self._asked) == self._link.dialect.thrusters:
            throttles = [self._asked[i][1] for i in range(self._link.dialect.thrusters)]
            self._link.command(min(instant for instant, _ in self._asked.values()), throttles)

    def read(self) -> list[Stamped]:
        """Return the measurements that have come, with their stamps, each later than the one before."""
        measured = []
        for found in self.session.receive():  # readings that arrive together would have one stamp
            self._latest = max(self._stamp(found.stamp), self._latest + _APART)
            measured.append((self._latest, found))
        return measured

    def write(self) -> list[tuple[int, Sent | None]]:
        """Write what is due; return it."""
        self.session.send()
        sent = self._link.sent
        if sent is None or sent is self._told:
            return []
        self._told = sent
        return [(self._stamp(sent.stamp), sent)]

    def trouble(self) -> str:
        """Return nothing: the link says it all."""
        return ""

    def _stamp(self, instant: float) -> int:
        return self._stamps() - round(1e9 * (self._monotonic() - instant))


class LockstepPace:
    """In lockstep with a simulated clock, see the module.

    Args:
        settings: of the driver.
        link: of its protocol.
        wall: time by which nothing is waited for too long [s].
        open_port: opens a port by name and line speed.

    Attributes:
        unanswered: number of states that no throttle came for in time.
    """

    def __init__(
        self, settings: DriverSettings, link: Link, wall: Callable[[], float], open_port: OpenPort = SerialPort
    ) -> None:
        self.session = SerialSession(link, settings.port, lambda: self._time, open_port)
        self.unanswered = 0
        self._settings, self._link, self._wall = settings, link, wall
        self._tick: int | None = None
        self._time = -math.inf
        self._phase = "done"
        self._deadline = math.inf
        self._awaited = 0
        self._lately = False
        self._answers: dict[int, dict[int, float]] = {}
        self._sent_at: int | None = None
        self._owed = False  # an answer of the device to what was sent last

    @property
    def now(self) -> float:
        """Return the link's time [s]: that of the last tick, not going back where the simulation begins anew."""
        return self._time

    def tick(self, stamp: int) -> list[tuple[int, Sent | None]]:
        """Begin the period that ends at `stamp` [ns]; return what is left to be told of the one before it."""
        left: list[tuple[int, Sent | None]]
        left = [] if self._phase == "done" or self._tick is None else [(self._tick, None)]
        if self._tick is None or not math.isfinite(self._time):
            self._time = 1e-9 * stamp
        elif stamp > self._tick:
            self._time += 1e-9 * (stamp - self._tick)
        self._tick = stamp
        expecting = self._owed and self._link.state in _TALKING
        self._enter("reading", self._settings.reading_timeout if expecting else 0.0)
        return left

    def command(self, stamp: int, thruster: int, throttle: float) -> None:
        """Take the throttle that answers the state of an instant."""
        if self._phase != "answer" or stamp >= self._awaited:
            self._answers.setdefault(stamp, {})[thruster] = throttle
            for old in sorted(self._answers)[:-4]:
                del self._answers[old]

    def read(self) -> list[Stamped]:
        """Return the measurements of this period with their stamps, once they are there."""
        if self._phase != "reading" or self._tick is None:
            return []
        found = [(self._stamp(each), each) for each in self.session.receive()]
        if found:
            self._owed = False
            self._awaited = found[-1][0]
            self._enter("answer", self._settings.answer_timeout)
        elif self._wall() >= self._deadline:
            self._enter("send", 0.0)
        return found

    def write(self) -> list[tuple[int, Sent | None]]:
        """Write once the answer is there; return what was sent in this period, None for nothing."""
        if self._phase == "answer":
            answer = self._answers.get(self._awaited, {})
            if len(answer) == self._link.dialect.thrusters:
                self._lately = False
                self._link.command(self._time, [answer[i] for i in sorted(answer)])
            elif self._wall() < self._deadline:
                return []
            else:
                self.unanswered += 1
                self._lately = True
            self._enter("send", 0.0)
        if self._phase != "send" or self._tick is None:
            return []
        before = self._link.sent
        self.session.send()
        self._enter("done", math.inf)
        sent = self._link.sent
        if sent is before:
            return [(self._tick, None)]
        self._sent_at, self._owed = self._tick, True
        return [(self._tick, sent)]

    def trouble(self) -> str:
        """Return that throttles are missing, while they are."""
        return f"no throttle came for {self.unanswered} states so far" if self._lately else ""

    def _enter(self, phase: str, timeout: float) -> None:
        self._phase, self._deadline = phase, self._wall() + timeout

    def _stamp(self, found: Measurement) -> int:
        """Return when the measurement was made [ns]."""
        if self._settings.protocol == "text" and self._sent_at is not None:
            return self._sent_at
        assert self._tick is not None
        return self._tick - 1000 * round(1e6 * (self._time - found.stamp))
