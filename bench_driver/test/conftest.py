"""Fixtures: the firmware built for its emulator, the recording of a velocimeter, how many streams are mutated."""

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))

from bench_driver.device import Device
from bench_driver.emulated_device import EmulatedDevice
from bench_driver.simavr_device_io import SimavrDevice

FIRMWARE = Path(__file__).resolve().parents[1] / "firmware"
HEADERS = (Path("/usr/include/simavr/sim_avr.h"), Path("/usr/include/libelf.h"))

MakeDevice = Callable[..., Device]


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Callable[[int, int], tuple[Path, Path]]:
    """Return a function that builds the firmware for (thrusters, loads), giving the emulator and the ELF; or skip."""
    missing = [tool for tool in ("make", "cc", "avr-gcc", "avr-objcopy") if shutil.which(tool) is None]
    missing += [str(header) for header in HEADERS if not header.exists()]
    if missing:
        needs = "gcc make gcc-avr avr-libc libsimavr-dev libelf-dev"
        pytest.skip(f"the firmware's tests need {needs}; missing: {', '.join(missing)}")
    folder = tmp_path_factory.mktemp("firmware")

    def made(thrusters: int, loads: int) -> tuple[Path, Path]:
        arguments = [f"BUILD={folder}", f"THRUSTERS={thrusters}", f"LOADS={loads}"]
        done = subprocess.run(["make", "-C", str(FIRMWARE), *arguments], capture_output=True, text=True, timeout=120.0)
        assert done.returncode == 0, done.stderr
        return folder / "emulator", folder / f"firmware_{thrusters}x{loads}.elf"

    return made


@pytest.fixture(params=["python", "firmware"])
def make_device(request: pytest.FixtureRequest) -> Iterator[MakeDevice]:
    """Return a function that makes a device: once emulated in Python, once the firmware on an emulated processor."""
    opened: list[SimavrDevice] = []

    def made(*, thrusters: int = 1, loads: int = 6, line_speed: int = 9600) -> Device:
        if request.param == "python":
            return EmulatedDevice(thrusters=thrusters, loads=loads, line_speed=line_speed)
        emulator, firmware = request.getfixturevalue("build")(thrusters, loads)
        opened.append(SimavrDevice(emulator, firmware, thrusters=thrusters, loads=loads, line_speed=line_speed))
        return opened[-1]

    yield made
    for device in opened:
        device.close()


@pytest.fixture(scope="session")
def mutated_streams() -> int:
    """Return how many streams each decoder gets; MUTATED_STREAMS=1000000 for the long run."""
    return int(os.environ.get("MUTATED_STREAMS", "20000"))
