"""Serve a bench on a pseudo-terminal: a driver, or any program that speaks the rig's text, opens it like a real port.

The inputs rest at constant counts; a bench with a thruster and water behind it is the simulator's.
"""

import argparse
import os
import signal
import sys
import threading
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from bench_driver.device import Device, Inputs, Outputs
from bench_driver.emulated_device import EmulatedDevice
from bench_driver.errors import BenchDriverError
from bench_driver.framed_protocol import BAUD as FRAMED_BAUD
from bench_driver.pty_device_io import PtyDevice
from bench_driver.simavr_device_io import SimavrDevice
from bench_driver.text_protocol import BAUD as TEXT_BAUD

__all__ = ["main"]

_SPEEDS = {"text": TEXT_BAUD, "frames": FRAMED_BAUD}
_STEP = {"python": 0.002, "firmware": 0.005}  # s


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return the exit status."""
    given = _parser().parse_args(argv)
    stopped = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: stopped.set())
    try:
        with ExitStack() as stack:
            device = _device(given, stack)
            inputs = Inputs(
                tachometer_counts=(given.tachometer,) * device.thrusters,
                flow_counts=(given.flow,) * device.thrusters,
                load_counts=(given.load,) * device.loads,
            )
            told: tuple[float, ...] | None = None

            def plant(period: float, outputs: Outputs) -> Inputs:
                nonlocal told
                if outputs.throttles != told:
                    told = outputs.throttles
                    print("throttle [V]:", " ".join(f"{u:+.3f}" for u in told), flush=True)
                return inputs

            served = stack.enter_context(PtyDevice(device, plant, inputs))
            if given.link is not None:
                os.symlink(served.path, given.link)
                stack.callback(given.link.unlink, missing_ok=True)
            print(f"port: {given.link or served.path} ({given.protocol}, {device.line_speed} baud)", flush=True)
            kind = "firmware" if given.firmware else "python"
            served.run(stopped.is_set, time.monotonic, stopped.wait, period=_STEP[kind])
    except (BenchDriverError, OSError) as error:
        print(f"emulated_device: {error}", file=sys.stderr)
        return 1
    return 0


def _device(given: argparse.Namespace, stack: ExitStack) -> Device:
    speed = _SPEEDS[given.protocol]
    if not given.firmware:
        return EmulatedDevice(thrusters=given.thrusters, loads=given.loads, line_speed=speed)
    emulator = given.firmware / "emulator"
    elf = given.firmware / f"firmware_{given.thrusters}x{given.loads}.elf"
    return stack.enter_context(
        SimavrDevice(emulator, elf, thrusters=given.thrusters, loads=given.loads, line_speed=speed)
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="emulated_device", description=__doc__)
    parser.add_argument("--protocol", choices=_SPEEDS, default="text", help="what the host will speak (%(default)s)")
    parser.add_argument("--thrusters", type=int, default=1, metavar="N", help="1 to 8 (%(default)s)")
    parser.add_argument("--loads", type=int, default=6, metavar="N", help="channels of the load cell (%(default)s)")
    parser.add_argument("--tachometer", type=int, default=0, metavar="COUNT", help="0 to 1023 (%(default)s)")
    parser.add_argument("--flow", type=int, default=512, metavar="COUNT", help="0 to 1023 (%(default)s: U = 0)")
    parser.add_argument("--load", type=int, default=512, metavar="COUNT", help="0 to 1023 (%(default)s)")
    parser.add_argument("--link", type=Path, metavar="PATH", help="also give the port this name")
    parser.add_argument(
        "--firmware", type=Path, metavar="FOLDER", help="run the firmware built there by make, instead of the emulation"
    )
    return parser


if __name__ == "__main__":
    sys.exit(main())
