"""The link on a pseudo-terminal through a real serial library: sessions, unplugging, what an open port cannot be."""

import errno
import os
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest
import serial
from bench_rig import DIALECTS, IDLE

from bench_driver.device import Device, Inputs, Outputs
from bench_driver.dialect import Measurement
from bench_driver.emulated_device import EmulatedDevice
from bench_driver.errors import EmulatorFailed, PortFailed
from bench_driver.link import Link
from bench_driver.link_records import LinkLimits, LinkState
from bench_driver.pty_device_io import PtyDevice
from bench_driver.serial_port_io import SerialPort
from bench_driver.serial_session_io import SerialSession
from bench_driver.simavr_device_io import SimavrDevice

LIMITS = LinkLimits(quiet=0.0)


def still(period: float, outputs: Outputs) -> Inputs:
    return IDLE


class Clock:
    """Time that the test makes."""

    now = 50.0

    def __call__(self) -> float:
        return self.now


def together(session: SerialSession, served: PtyDevice, clock: Clock, steps: int, throttle: float) -> list[Measurement]:
    """Step host and device in turn, 5 ms each time."""
    found = []
    for _ in range(steps):
        session.link.command(clock.now, [throttle])
        found += session.step()
        served.advance(0.005)
        clock.now += 0.005
    return found


@pytest.mark.parametrize("name", list(DIALECTS))
def test_a_session_on_a_port_drives_and_leaves_zero_behind(make_device: Callable[..., Device], name: str) -> None:
    clock, dialect = Clock(), DIALECTS[name]()
    with PtyDevice(make_device(line_speed=dialect.line_speed), still, IDLE) as served:
        with SerialSession(Link(dialect, LIMITS), served.path, clock) as session:
            found = together(session, served, clock, 300, 2.0)
            assert session.link.state is LinkState.READY
            assert served.outputs is not None
            assert served.outputs.throttles[0] == pytest.approx(2.0, abs=0.02)
            assert len(found) >= 25
        served.advance(0.02)
        assert (served.outputs.throttles, served.outputs.enabled) == ((0.0,), (False,))


@pytest.mark.parametrize("name", list(DIALECTS))
def test_an_exception_in_the_hosts_program_leaves_zero_behind(name: str) -> None:
    clock, dialect = Clock(), DIALECTS[name]()
    with PtyDevice(EmulatedDevice(line_speed=dialect.line_speed), still, IDLE) as served:
        with (
            pytest.raises(ZeroDivisionError),
            SerialSession(Link(dialect, LIMITS), served.path, clock) as session,
        ):
            together(session, served, clock, 300, 2.0)
            assert served.outputs is not None and served.outputs.enabled == (True,)
            raise ZeroDivisionError
        served.advance(0.02)
        assert served.outputs.enabled == (False,)


def test_an_unplugged_port_is_noticed_closed_and_opened_again_when_it_is_back(tmp_path: Path) -> None:
    clock, port = Clock(), tmp_path / "port"
    first = PtyDevice(EmulatedDevice(), still, IDLE)
    port.symlink_to(first.path)
    with SerialSession(Link(DIALECTS["text"](), LIMITS), str(port), clock) as session:
        together(session, first, clock, 200, 2.0)
        assert session.link.state is LinkState.READY
        port.unlink()
        first.close()
        for _ in range(300):
            assert session.step() == []
            clock.now += 0.005
        assert session.link.counters["unplugged"] == 1
        assert session.link.state is LinkState.ABSENT
        assert "is the device plugged in?" in session.link.reason
        with PtyDevice(EmulatedDevice(), still, IDLE) as second:
            port.symlink_to(second.path)
            together(session, second, clock, 600, 2.0)
            assert session.link.state is LinkState.READY
            assert second.outputs is not None and second.outputs.throttles[0] == pytest.approx(2.0, abs=0.02)


def test_a_device_that_comes_back_under_its_name_is_opened_at_once_though_the_old_handle_stays(tmp_path: Path) -> None:
    clock, name = Clock(), tmp_path / "port"
    devices = [PtyDevice(EmulatedDevice(line_speed=9600), still, IDLE) for _ in range(2)]
    with devices[0] as old, devices[1] as new:
        name.symlink_to(old.path)
        with SerialSession(Link(DIALECTS["text"](), LIMITS), str(name), clock) as session:
            together(session, old, clock, 300, 2.0)
            assert session.link.state is LinkState.READY
            name.unlink()
            name.symlink_to(new.path)  # the old device stays open, and says nothing more
            before = clock.now
            while session.link.state is LinkState.READY or "silent" not in session.link.counters:
                together(session, new, clock, 1, 2.0)
            while session.link.state is not LinkState.READY:
                assert clock.now - before < 2.0, session.link.reason
                together(session, new, clock, 1, 2.0)
            together(session, new, clock, 100, 2.0)
            assert new.outputs is not None
            assert new.outputs.throttles[0] == pytest.approx(2.0, abs=0.02)


def test_leaving_a_session_whose_port_is_gone_raises_nothing() -> None:
    clock = Clock()
    served = PtyDevice(EmulatedDevice(), still, IDLE)
    with SerialSession(Link(DIALECTS["text"](), LIMITS), served.path, clock) as session:
        together(session, served, clock, 100, 1.0)
        served.close()
    session.close()


def test_a_port_cannot_be_opened_twice() -> None:
    with (
        PtyDevice(EmulatedDevice(), still, IDLE) as served,
        SerialPort(served.path, 9600),
        pytest.raises(PortFailed, match="in use by another program"),
    ):
        SerialPort(served.path, 9600)


def test_a_port_that_does_not_exist_is_absent() -> None:
    with pytest.raises(PortFailed, match="no such port; is the device plugged in") as caught:
        SerialPort("/dev/ttyACM_none", 9600)
    assert caught.value.absent


def test_a_file_is_no_port(tmp_path: Path) -> None:
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(PortFailed, match="not a serial port"):
        SerialPort(str(tmp_path / "file"), 9600)


def test_missing_permission_says_which_group_to_join(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(path: str, flags: int, *rest: int) -> int:
        raise OSError(errno.EACCES, "Permission denied", path)

    monkeypatch.setattr(serial.serialposix.os, "open", refused)
    with pytest.raises(PortFailed, match=r"adduser \$USER dialout.*udev rule") as caught:
        SerialPort("/dev/ttyACM0", 9600)
    assert not caught.value.absent


def test_reading_and_writing_an_unplugged_port_fail_in_a_sentence() -> None:
    served = PtyDevice(EmulatedDevice(), still, IDLE)
    with SerialPort(served.path, 9600) as port:
        assert port.read() == b""
        served.close()
        with pytest.raises(PortFailed, match=served.path):
            port.read()
        with pytest.raises(PortFailed, match=served.path):
            port.write(b"128\n")


def test_a_port_that_takes_no_bytes_fails_at_the_deadline() -> None:
    near, far = os.openpty()
    try:
        with SerialPort(os.ttyname(far), 9600, deadline=0.02) as port:
            start = time.monotonic()
            with pytest.raises(PortFailed, match=r"took no bytes for 0\.02 s"):
                for _ in range(100):
                    port.write(bytes(4096))
            assert time.monotonic() - start < 2.0
            os.read(near, 1 << 20)  # so that closing has nothing to wait for
    finally:
        os.close(near)
        os.close(far)


def test_in_real_time_states_come_100_times_a_second(make_device: Callable[..., Device]) -> None:
    dialect = DIALECTS["frames"]()
    done = threading.Event()
    with PtyDevice(make_device(line_speed=dialect.line_speed), still, IDLE) as served:
        server = threading.Thread(target=served.run, args=(done.is_set, time.monotonic, done.wait))
        server.start()
        try:
            with SerialSession(Link(dialect, LIMITS), served.path, time.monotonic) as session:
                found: list[Measurement] = []
                until = time.monotonic() + 2.0
                while time.monotonic() < until:
                    session.link.command(time.monotonic(), [1.0])
                    found += session.step()
                    done.wait(0.003)
                last = [measurement for measurement in found if measurement.stamp > until - 1.0]
                assert 90 <= len(last) <= 110
                assert session.link.state is LinkState.READY
        finally:
            done.set()
            server.join(timeout=5.0)
        served.advance(0.02)
        assert served.outputs is not None and served.outputs.enabled == (False,)


def test_an_emulator_that_cannot_run_says_why(tmp_path: Path) -> None:
    with pytest.raises(EmulatorFailed, match="`make` in the firmware's folder"):
        SimavrDevice(tmp_path / "emulator", tmp_path / "firmware.elf")
    (tmp_path / "firmware.elf").write_bytes(b"")
    with (
        SimavrDevice(Path("/bin/true"), tmp_path / "firmware.elf") as device,
        pytest.raises(EmulatorFailed, match="has ended"),
    ):
        device.advance(0.01, IDLE)
