"""Journals become bags: whole, cut, damaged, on a disk that is full; and the old file is never lost."""

import contextlib
import errno
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import pytest
from mcap.reader import make_reader
from recording_graph import messages

from run_bag import CannotWriteError, RunError, RunExistsError, read_run, write_run
from run_bag.benchmark import bench_topics
from run_bag.cli_recover import main
from run_bag.finishing import finish, recover
from run_bag.journal import Journal, open_buffered
from run_bag.reader import read_recording
from run_bag.rosbag2 import TopicRecord

PAYLOAD = b"\0\1\0\0" + np.float64(1.5).tobytes()
STATE = TopicRecord(name="/value", type="std_msgs/msg/Float64")


def journal(directory: Path, count: int, **options: Any) -> Journal:
    """Write a journal of so many messages, 1 ms apart, and leave it open but flushed."""
    result = Journal(directory, {"seed": 3}, **options)
    channel = result.add_topic(STATE)
    for i in range(count):
        result.add(channel, PAYLOAD, log_time=10**9 + i * 10**6, publish_time=i, sequence=(1 << 32) + i)
    result.flush()
    return result


def test_every_flushed_message_is_in_a_file_that_was_never_ended(tmp_path: Path) -> None:
    open_one = journal(tmp_path / "a", 100)
    assert len(messages(tmp_path / "a")) == 100  # as a killed process leaves it
    assert open_one.size == open_one.path.stat().st_size
    done = finish(tmp_path / "a")
    assert done.messages == 100 and not done.untouched and "cut off" in done.warnings[0]
    rows = messages(tmp_path / "a")
    assert rows == [("/value", 10**9 + i * 10**6, i, PAYLOAD) for i in range(100)]
    assert read_recording(tmp_path / "a").metadata == {"seed": 3}
    assert finish(tmp_path / "a").untouched


def test_the_last_description_of_a_run_counts(tmp_path: Path) -> None:
    one = journal(tmp_path / "a", 1)
    one.describe({"seed": 4, "nodes": {}})
    one.close()
    finish(tmp_path / "a")
    assert read_recording(tmp_path / "a").metadata == {"seed": 4, "nodes": {}}


def test_a_run_without_messages_is_finished_too(tmp_path: Path) -> None:
    journal(tmp_path / "a", 0).close()
    assert finish(tmp_path / "a").messages == 0
    assert read_recording(tmp_path / "a").warnings == ()


@pytest.mark.parametrize("share", [0.2, 0.5, 0.99])
def test_a_journal_cut_anywhere_is_finished_with_all_its_whole_messages(tmp_path: Path, share: float) -> None:
    one = journal(tmp_path / "a", 500)
    data = one.path.read_bytes()
    one.path.write_bytes(data[: int(len(data) * share)])
    left = messages(tmp_path / "a")
    finish(tmp_path / "a")
    assert messages(tmp_path / "a") == left and len(left) > 500 * share - 50
    assert read_run(tmp_path / "a").warnings == ()


def test_damage_in_the_midst_is_not_overwritten_but_copied_on_request(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = write_run(tmp_path / "a", bench_topics(8_000))
    file = folder / "a_0.mcap"
    with file.open("rb") as opened:
        summary = make_reader(opened).get_summary()
    assert summary is not None
    data = bytearray(file.read_bytes())
    data[summary.chunk_indexes[1].chunk_start_offset + 100] ^= 255
    file.write_bytes(data)
    assert main([str(folder)]) == 1
    assert "not a recording whose end alone is missing" in capsys.readouterr().err
    assert file.read_bytes() == data
    left = messages(folder)
    assert main([str(folder), "--out", str(tmp_path / "b")]) == 0
    assert "is damaged" in capsys.readouterr().out
    assert messages(tmp_path / "b") == left and 0 < len(left) < 32_000
    assert read_run(tmp_path / "b").warnings == ()
    with pytest.raises(RunExistsError):
        recover(folder, tmp_path / "b")


def test_a_bag_of_several_files_becomes_one(tmp_path: Path) -> None:
    one = write_run(tmp_path / "a", bench_topics(100), {"seed": 1})
    (one / "metadata.yaml").unlink()
    other = write_run(tmp_path / "b", bench_topics(50))
    (other / "b_0.mcap").rename(one / "a_1.mcap")
    with pytest.raises(RunError, match="it has 2 files"):
        finish(one)
    assert recover(one, tmp_path / "c").messages == 600
    assert len(read_recording(tmp_path / "c").scans[0].topics) == 4


def test_where_there_is_no_room_for_the_finished_file_the_journal_stays(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one = journal(tmp_path / "a", 100)
    one.close()
    before = one.path.read_bytes()

    def refuse(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("run_bag.finishing.Writer.add_message", refuse)
    with pytest.raises(CannotWriteError, match=r"cannot be finished: No space left on device; .*left as it was"):
        finish(tmp_path / "a")
    assert [p.name for p in (tmp_path / "a").iterdir()] == ["a_0.mcap"] and one.path.read_bytes() == before


class Full:
    """A file on a disk with little room; counts in bytes, writes a part of what does not fit, as disks do."""

    def __init__(self, file: BinaryIO, room: int) -> None:
        self.file, self.room = file, room

    def write(self, data: bytes) -> int:
        taken = self.file.write(data[: max(0, self.room)])
        self.room -= len(data)
        if self.room < 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return taken

    def __getattr__(self, name: str) -> Any:
        return getattr(self.file, name)


def test_a_full_disk_ends_the_recording_with_a_sentence_and_a_readable_file(tmp_path: Path) -> None:
    held: list[Journal] = []

    def fill() -> None:
        one = Journal(tmp_path / "a", {}, lambda path: Full(open_buffered(path), 20_000))  # type: ignore[arg-type,return-value]
        held.append(one)
        channel = one.add_topic(STATE)
        for i in range(10_000):
            one.add(channel, PAYLOAD, log_time=i, publish_time=i)

    with pytest.raises(CannotWriteError, match=r"a_0.mcap: recording stopped: no space is left; .*readable up to"):
        fill()
    held[0].close()
    assert held[0].failed
    assert len(messages(tmp_path / "a")) == held[0].messages > 300


def test_the_disk_itself_may_be_full(tmp_path: Path) -> None:
    """A device that is always full."""
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    raises = pytest.raises(CannotWriteError, match="no space is left")
    # closing tries to write the rest again
    with contextlib.suppress(OSError), Path("/dev/full").open("wb") as full, raises:
        Journal(tmp_path / "a", {"seed": 3}, lambda path: full)


def test_what_exists_is_never_overwritten(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("mine")
    with pytest.raises(RunExistsError, match="a exists"):
        Journal(tmp_path / "a", {})
    assert (tmp_path / "a").read_text() == "mine"
