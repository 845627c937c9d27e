"""Hosts of either protocol, as plain as they can be, for the tests of devices."""

import random
from dataclasses import dataclass, field

from bench_driver import framed_messages as messages
from bench_driver.device import Device, Inputs, Outputs
from bench_driver.framed_protocol import Frame, FrameDecoder, encode
from bench_driver.text_protocol import LineDecoder, Reading

__all__ = ["FRAMES", "Frames", "Text", "inputs"]

FRAMES = 115200
TEXT_PERIOD = 0.04
FRAME_PERIOD = 0.01


def inputs(device: Device, seed: int = 1) -> Inputs:
    chance = random.Random(seed)
    n, loads = device.thrusters, device.loads
    counts = [chance.randrange(1024) for _ in range(2 * n + loads)]
    return Inputs(
        tachometer_counts=tuple(counts[:n]), flow_counts=tuple(counts[n : 2 * n]), load_counts=tuple(counts[2 * n :])
    )


@dataclass
class Text:
    """A host that speaks text."""

    device: Device
    readings: list[Reading] = field(default_factory=list)
    decoder: LineDecoder = field(default_factory=LineDecoder)

    def say(self, data: bytes, period: float = TEXT_PERIOD) -> Outputs:
        outputs = self.device.advance(period, inputs(self.device), data)
        self.readings += self.decoder.feed(outputs.data)
        return outputs


@dataclass
class Frames:
    """A host that speaks frames; keeps what came back."""

    device: Device
    sequence: int = 0
    found: list[Frame] = field(default_factory=list)
    decoder: FrameDecoder = field(default_factory=lambda: FrameDecoder(messages.FROM_DEVICE))

    def frame(self, kind: int, payload: bytes = b"") -> bytes:
        self.sequence += 1
        return encode(Frame(kind, self.sequence % 65536, 0, payload))

    def command(self, *throttles: int, enable: bool = True) -> bytes:
        command = messages.Command(throttles=throttles, enabled=(enable,) * len(throttles))
        return self.frame(messages.COMMAND, command.payload())

    def say(self, data: bytes = b"", period: float = FRAME_PERIOD) -> Outputs:
        outputs = self.device.advance(period, inputs(self.device), data)
        self.found += self.decoder.feed(outputs.data)
        return outputs

    def connect(self) -> None:
        zeros = (0,) * self.device.thrusters
        for _ in range(40):
            self.say(self.command(*zeros, enable=False))
        assert self.states, "no state after 0.4 s"

    def drive(self, *throttles: int) -> Outputs:
        """Enable with zeros, then set the throttles [mV]."""
        self.say(self.command(*(0,) * len(throttles)))
        self.say(self.command(*throttles))
        return self.say()

    @property
    def states(self) -> list[messages.State]:
        states = [messages.state(frame.payload) for frame in self.found if frame.type == messages.STATE]
        assert None not in states
        return [state for state in states if state is not None]

    @property
    def hellos(self) -> list[messages.Hello]:
        return [messages.hello(frame.payload) for frame in self.found if frame.type == messages.HELLO]
