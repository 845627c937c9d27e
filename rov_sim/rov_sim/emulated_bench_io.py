"""The emulated bench on a pseudo-terminal: plant, device and port in one, advanced period by period."""

import math
import os
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Literal, get_args

from bench_driver import framed_messages, framed_protocol, text_protocol
from bench_driver.device import Device
from bench_driver.driver_settings import LoadCell
from bench_driver.emulated_device import EmulatedDevice
from bench_driver.framed_protocol import FrameDecoder
from bench_driver.pty_device_io import PtyDevice
from bench_driver.simavr_device_io import SimavrDevice
from rov_sim.emulated_bench import BenchPlant, BenchSettings

__all__ = ["DeviceSettings", "EmulatedBench", "ProtocolName"]

ProtocolName = Literal["text", "frames"]
_SPEEDS = {"text": text_protocol.BAUD, "frames": framed_protocol.BAUD}
_PERIODS = {"text": text_protocol.PERIOD, "frames": 1 / framed_protocol.RATE}
_LOADS = 6
_STEPS = {"python": 0.001, "firmware": 0.005}  # s, of the device


@dataclass(frozen=True, kw_only=True)
class DeviceSettings:
    """The device between the plant and the port.

    Attributes:
        protocol: what the host will speak.
        firmware: folder in which the firmware and its emulator were built, None: the emulation in Python.
        link: another name for the port; must not exist.
        load_cell: what the device's load channels are connected to.

    Raises:
        ValueError: a name that exists, or a protocol that does not.
    """

    protocol: ProtocolName = "text"
    firmware: Path | None = None
    link: Path | None = None
    load_cell: LoadCell = field(default_factory=LoadCell)

    def __post_init__(self) -> None:
        wrong = []
        if self.protocol not in get_args(ProtocolName):
            wrong.append(f"protocol: expected one of {', '.join(get_args(ProtocolName))}; found {self.protocol!r}")
        if self.link is not None and (self.link.exists() or self.link.is_symlink()):
            wrong.append(f"link: expected a name that is free; found that {self.link} exists")
        if self.link is not None and not self.link.parent.is_dir():
            wrong.append(f"link: expected a name in an existing folder; found {self.link}")
        if wrong:
            raise ValueError("; ".join(wrong))

    @property
    def period(self) -> float:
        """Return the time between two commands of the host [s]."""
        return _PERIODS[self.protocol]


class EmulatedBench:
    """To be closed, best as a context manager.

    Args:
        device: between plant and port.
        bench: the plant.

    Attributes:
        plant: the thruster.
        port: name of the port, the link's where there is one.

    Raises:
        EmulatorFailed: the firmware is not there or does not start.
        OSError: the link cannot be made.
    """

    def __init__(self, device: DeviceSettings, bench: BenchSettings) -> None:
        self.plant = BenchPlant(bench, device.load_cell.counts)
        self._protocol = device.protocol
        self._step = _STEPS["python" if device.firmware is None else "firmware"]
        with ExitStack() as stack:
            served = PtyDevice(_device(device, stack), self.plant, self.plant.read())
            self._served = stack.enter_context(served)
            self.port = self._served.path
            if device.link is not None:
                os.symlink(self._served.path, device.link)
                stack.callback(device.link.unlink, missing_ok=True)
                self.port = str(device.link)
            self._open = stack.pop_all()

    def heard(self) -> bool:
        """Return whether the host has written something whole since the last period, without waiting."""
        data = self._served.listen()
        if self._protocol == "text":
            return data.endswith(b"\n")
        decoder = FrameDecoder(framed_messages.TO_DEVICE)
        return bool(decoder.feed(data)) and not decoder.waiting

    def advance(self, period: float) -> None:
        """Let a period [s], a multiple of the device's step, pass with what the host has written."""
        for _ in range(max(math.floor(period / self._step + 0.5), 1)):
            self._served.advance(self._step)

    @property
    def step(self) -> float:
        """Return the device's step [s]."""
        return self._step

    def close(self) -> None:
        """Take the port away; may be called again."""
        self._open.close()

    def __enter__(self) -> "EmulatedBench":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _device(given: DeviceSettings, stack: ExitStack) -> Device:
    speed = _SPEEDS[given.protocol]
    if given.firmware is None:
        return EmulatedDevice(thrusters=1, loads=_LOADS, line_speed=speed)
    emulator, elf = given.firmware / "emulator", given.firmware / f"firmware_1x{_LOADS}.elf"
    return stack.enter_context(SimavrDevice(emulator, elf, thrusters=1, loads=_LOADS, line_speed=speed))
