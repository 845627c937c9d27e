"""The firmware itself as a device: its ELF on an emulated ATmega2560, a child process stepped through its pipes.

Both files are built by `make` in the firmware's folder.
"""

import os
import select
import subprocess
import time
from pathlib import Path
from types import TracebackType

from bench_driver.converter import ZERO_CODE, code_volts
from bench_driver.device import Inputs, Outputs
from bench_driver.errors import EmulatorFailed
from bench_driver.text_protocol import BAUD as TEXT_BAUD

__all__ = ["SimavrDevice"]

_CHANNELS = 16
_FIRST_FLOW = 8
_LAST_LOAD = 15


class SimavrDevice:
    """The firmware, see `Device`; to be closed, best as a context manager.

    Args:
        emulator: the emulator's executable.
        firmware: the firmware's ELF.
        thrusters, loads: the channels that the firmware was compiled for.
        line_speed: see `Device`.
        deadline: longest time that a period may take to compute [s].

    Raises:
        EmulatorFailed: a file is missing, or the emulator ended or did not answer in time.
    """

    def __init__(
        self,
        emulator: Path,
        firmware: Path,
        *,
        thrusters: int = 1,
        loads: int = 6,
        line_speed: int = TEXT_BAUD,
        deadline: float = 30.0,
    ) -> None:
        for file in (emulator, firmware):
            if not file.is_file():
                raise EmulatorFailed(f"{file}: expected a file, found none; `make` in the firmware's folder builds it")
        self.thrusters = thrusters
        self.loads = loads
        self.line_speed = line_speed
        self._deadline = deadline
        self._pending = b""
        # In a session of its own: a signal to the group of the process that uses it must not end it under its hands.
        self._process = subprocess.Popen(
            [str(emulator), str(firmware)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, bufsize=0,
            start_new_session=True,
        )  # fmt: skip

    def advance(self, period: float, inputs: Inputs, data: bytes = b"") -> Outputs:
        """Let a period [s] pass, during which the host's bytes arrive one after the other."""
        inputs.check(self.thrusters, self.loads)
        counts = [0] * _CHANNELS
        counts[: self.thrusters] = inputs.tachometer_counts
        counts[_FIRST_FLOW : _FIRST_FLOW + self.thrusters] = inputs.flow_counts
        for j, count in enumerate(inputs.load_counts):
            counts[_LAST_LOAD - j] = count
        listed = ",".join(map(str, counts))
        answer = self._ask(f"advance {round(1e6 * period)} {self.line_speed} {listed} {data.hex() or '-'}")
        codes, bits, sent = answer.split()
        enabled = tuple(bool(int(bits, 16) >> i & 1) for i in range(self.thrusters))
        return Outputs(
            throttles=tuple(
                _throttle(int(code)) if on else 0.0
                for code, on in zip(codes.split(",")[: self.thrusters], enabled, strict=True)
            ),
            enabled=enabled,
            data=b"" if sent == "-" else bytes.fromhex(sent),
        )

    def reset(self) -> None:
        """Pull the reset line, as a host does that opens the port."""
        self._ask("reset")

    def close(self) -> None:
        """End the emulator."""
        for pipe in (self._process.stdin, self._process.stdout):
            if pipe is not None:
                pipe.close()
        try:
            self._process.wait(timeout=2.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()

    def __enter__(self) -> "SimavrDevice":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _ask(self, request: str) -> str:
        assert self._process.stdin is not None and self._process.stdout is not None
        until = time.monotonic() + self._deadline
        try:
            self._process.stdin.write(request.encode() + b"\n")
        except (BrokenPipeError, ValueError):
            raise EmulatorFailed("the emulator has ended") from None
        while b"\n" not in self._pending:
            left = until - time.monotonic()
            if left <= 0 or not select.select([self._process.stdout], [], [], left)[0]:
                raise EmulatorFailed(f"no answer within {self._deadline:g} s")
            piece = os.read(self._process.stdout.fileno(), 65536)
            if not piece:
                raise EmulatorFailed("the emulator has ended")
            self._pending += piece
        line, self._pending = self._pending.split(b"\n", 1)
        answer = line.decode()
        if answer.startswith("failed"):
            raise EmulatorFailed(answer)
        return answer


def _throttle(code: int) -> float:
    """Return the throttle [V] of a code, the bias' 0 V if the converter is off."""
    return code_volts(ZERO_CODE if code < 0 else code)
