"""Files and folders are there whole or not at all, whatever ends the writing."""

import os
import resource
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from safe_files.errors import NotWrittenError
from safe_files.whole_files_io import expect_new_folder, new_folder, whole_file, write_whole

CONTENT = "x" * 300_000


def mounted(folder: Path, options: str) -> bool:
    """Mount a small file system there, where this user may."""
    command = ["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)]
    return os.geteuid() == 0 and subprocess.run(command, capture_output=True).returncode == 0


@pytest.fixture
def full_disk(tmp_path: Path) -> Iterator[Path]:
    """A folder with room for 64 kB."""
    disk = tmp_path / "disk"
    disk.mkdir()
    if mounted(disk, "size=64k"):
        yield disk
        subprocess.run(["umount", str(disk)], check=True)
        return
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (65536, before[1]))
    yield disk
    resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture
def read_only(tmp_path: Path) -> Iterator[Path]:
    """A folder in which nothing can be made."""
    folder = tmp_path / "closed"
    folder.mkdir()
    if os.geteuid() != 0:
        folder.chmod(0o555)
        yield folder
        folder.chmod(0o755)
    elif mounted(folder, "ro,size=64k"):
        yield folder
        subprocess.run(["umount", str(folder)], check=True)
    else:
        pytest.skip("this user writes everywhere and may not mount")


def a_file(folder: Path) -> None:
    write_whole(folder / "out.txt", CONTENT)


def replaced(folder: Path) -> None:
    write_whole(folder / "out.txt", CONTENT, replace=True)


def a_folder(folder: Path) -> None:
    with new_folder(folder / "out") as partial:
        write_whole(partial / "first.txt", "short")
        write_whole(partial / "out.txt", CONTENT)


@pytest.mark.parametrize("writing", [a_file, replaced, a_folder])
def test_a_full_disk_is_told_and_nothing_is_left(full_disk: Path, writing: Callable[[Path], None]) -> None:
    with pytest.raises(NotWrittenError, match=r"out.*: cannot be written: (No space left on device|File too large)"):
        writing(full_disk)
    assert list(full_disk.iterdir()) == []


def test_a_full_disk_leaves_the_earlier_file_as_it_was(full_disk: Path) -> None:
    (full_disk / "out.txt").write_text("earlier")
    with pytest.raises(NotWrittenError):
        replaced(full_disk)
    assert [(p.name, p.read_text()) for p in full_disk.iterdir()] == [("out.txt", "earlier")]


@pytest.mark.parametrize("writing", [a_file, replaced, a_folder])
def test_a_read_only_folder_is_told(read_only: Path, writing: Callable[[Path], None]) -> None:
    with pytest.raises(NotWrittenError, match=r"out.*: cannot be written: (Read-only file system|Permission denied)"):
        writing(read_only)
    assert list(read_only.iterdir()) == []


def test_what_is_there_is_kept(tmp_path: Path) -> None:
    (tmp_path / "out.txt").write_text("earlier")
    with pytest.raises(FileExistsError, match="exists and is not overwritten"):
        a_file(tmp_path)
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "x").write_text("earlier")
    with pytest.raises(FileExistsError, match="expected a new or empty folder"):
        a_folder(tmp_path)
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["out", "out.txt", "x"]
    assert {p.read_text() for p in tmp_path.rglob("*") if p.is_file()} == {"earlier"}


def test_a_place_is_refused_before_the_work_as_it_would_be_after_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("earlier")
    (tmp_path / "empty").mkdir()
    for place in (tmp_path, tmp_path / "file"):
        with pytest.raises(FileExistsError, match="expected a new or empty folder"):
            expect_new_folder(place)
    with pytest.raises(NotWrittenError, match=r"file/x: cannot be written: Not a directory; nothing was left there$"):
        expect_new_folder(tmp_path / "file" / "x")
    expect_new_folder(tmp_path / "empty")
    expect_new_folder(tmp_path / "new" / "one")
    assert not (tmp_path / "new").exists()
    monkeypatch.setattr(os, "access", lambda place, how: place != tmp_path)
    with pytest.raises(NotWrittenError, match=r"one: cannot be written: Permission denied; nothing was left there$"):
        expect_new_folder(tmp_path / "new" / "one")


def test_what_comes_while_writing_is_kept_too(tmp_path: Path) -> None:
    with pytest.raises(FileExistsError), whole_file(tmp_path / "out.txt") as partial:
        partial.write_text("mine")
        (tmp_path / "out.txt").write_text("the other's")
    with pytest.raises(OSError, match="cannot be written"), new_folder(tmp_path / "out") as folder:
        (folder / "a").write_text("mine")
        (tmp_path / "out").mkdir()
        (tmp_path / "out" / "b").write_text("the other's")
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["b", "out", "out.txt"]
    assert (tmp_path / "out.txt").read_text() == "the other's"


def test_good_writing_leaves_the_content_alone_with_usual_permissions(tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()  # empty
    for writing in (a_file, replaced, a_folder):
        writing(tmp_path)
    assert (tmp_path / "out.txt").read_text() == (tmp_path / "out" / "out.txt").read_text() == CONTENT
    umask = os.umask(0)
    os.umask(umask)
    assert (tmp_path / "out.txt").stat().st_mode & 0o777 == 0o666 & ~umask
    assert (tmp_path / "out").stat().st_mode & 0o777 == 0o777 & ~umask
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["first.txt", "out", "out.txt", "out.txt"]


WRITER = """
import signal, sys, time
from pathlib import Path
from safe_files.whole_files_io import new_folder, write_whole
if {own}:
    signal.signal(signal.SIGINT, lambda *_: sys.exit("my own"))
with new_folder(Path(sys.argv[1])) as folder:
    write_whole(folder / "a.txt", "half of it")
    print("writing", flush=True)
    time.sleep(60)
"""


def ended(target: Path, number: int, *, own: bool = False) -> tuple[int, str]:
    """Return status and last words of a writer that is sent a signal in the middle."""
    command = [sys.executable, "-c", WRITER.format(own=own), str(target)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stderr is not None
        assert process.stdout.readline() == "writing\n"
        process.send_signal(number)
        status = process.wait(30)
        return status, process.stderr.read()


@pytest.mark.parametrize(("number", "own"), [(signal.SIGTERM, False), (signal.SIGTERM, True), (signal.SIGINT, True)])
def test_a_signal_removes_what_was_under_way_and_is_told(tmp_path: Path, number: int, own: bool) -> None:
    status, told = ended(tmp_path / "out", number, own=own)
    assert status == 128 + number
    assert told == f"{tmp_path / 'out'}: interrupted by {signal.Signals(number).name}; nothing was left there\n"
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_leaves_as_python_has_it(tmp_path: Path) -> None:
    status, told = ended(tmp_path / "out", signal.SIGINT)
    assert status != 0 and told.rstrip().endswith("KeyboardInterrupt")
    assert list(tmp_path.iterdir()) == []


def test_a_kill_leaves_at_most_a_hidden_part(tmp_path: Path) -> None:
    status, _ = ended(tmp_path / "out", signal.SIGKILL)
    assert status == -signal.SIGKILL
    assert not (tmp_path / "out").exists()
    assert [p.name.startswith(".out.") and p.name.endswith(".part") for p in tmp_path.iterdir()] == [True]
    a_folder(tmp_path)  # and it does not stand in the way
    assert (tmp_path / "out" / "out.txt").exists()
