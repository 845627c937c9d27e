"""The served device as a program: a port that answers, a clean end."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bench_driver.cli_emulated_device import main
from bench_driver.serial_port_io import SerialPort


def test_a_program_opens_the_port_drives_and_reads(tmp_path: Path) -> None:
    link = tmp_path / "bench"
    command = [sys.executable, "-m", "bench_driver.cli_emulated_device", "--link", str(link), "--tachometer", "321"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as served:
        assert served.stdout is not None
        assert served.stdout.readline() == f"port: {link} (text, 9600 baud)\n"
        answer = b""
        with SerialPort(str(link), 9600) as port:
            until = time.monotonic() + 10.0
            while answer.count(b"\n") < 2 and time.monotonic() < until:
                port.write(b"128\n")
                time.sleep(0.04)
                answer += port.read()
        served.send_signal(signal.SIGTERM)
        said, _ = served.communicate(timeout=10.0)
    assert answer.startswith(b"321,512\n321,512\n")
    assert "throttle [V]: -0.020" in said
    assert served.returncode == 0
    assert not link.is_symlink()


def test_a_firmware_that_is_not_there_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)]
    try:
        assert main(["--firmware", str(tmp_path)]) == 1
    finally:
        for number, handler in zip((signal.SIGINT, signal.SIGTERM), before, strict=True):
            signal.signal(number, handler)
    assert f"{tmp_path}/emulator: expected a file, found none" in capsys.readouterr().err
