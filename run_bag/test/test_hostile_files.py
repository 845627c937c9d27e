"""Files that mean ill: a sentence or what is whole in them, never a traceback, within memory and time."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from hostile_mcap import HOSTILE
from mutated_files import READERS, mutate_all

from run_bag import RunError, TooLargeError, read_run
from run_bag.budget import Budget, Limits
from run_bag.cli_info import main as info

REFUSED = {
    "many chunks of 255 MiB": "bytes of unpacked content in a recording of",
    "many real chunks": "bytes of unpacked content",
    "millions of tiny messages": "messages in a recording",
    "millions of empty messages": "messages in a recording",
    "messages of unknown channels": "messages in a recording",
    "bytes as numbers": "values in channels",
    "a hundred thousand metadata records": "records beside the messages",
    "schemas of 60 MiB": "bytes of unpacked content",
}
WATCHED = """
import json, sys, time
sys.path.insert(0, sys.argv[1])
from pathlib import Path
from hostile_mcap import HOSTILE
from run_bag.cli_info import main
import contextlib, io
for name in sys.argv[3:]:
    path = Path(sys.argv[2]) / "x.mcap"
    path.write_bytes(HOSTILE[name]())
    out, err, begin = io.StringIO(), io.StringIO(), time.process_time()
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main([str(path)])
    except BaseException as error:
        status = repr(error)[:300]
    told = [name, status, time.process_time() - begin, out.getvalue(), err.getvalue()[:2000],
            int(Path("/proc/self/status").read_text().split("VmHWM:")[1].split()[0]) / 1024]
    print(json.dumps(told), flush=True)
"""


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """What `info` says of each file, from a process of its own, so that its memory can be measured.

    By VmHWM: the ru_maxrss of a child begins with what its parent had.
    """
    here, folder = str(Path(__file__).parent), str(tmp_path_factory.mktemp("hostile"))
    command = [sys.executable, "-c", WATCHED, here, folder, *HOSTILE]
    done = subprocess.run(command, capture_output=True, text=True, timeout=600, check=True)
    return {line[0]: line[1:] for line in map(json.loads, done.stdout.splitlines())}


@pytest.mark.parametrize("name", HOSTILE)
def test_info_says_a_sentence_or_reads_what_is_whole_in_bounded_time(told, name):
    status, seconds, out, err, _ = told[name]
    assert status in (0, 1), status
    assert seconds < 20.0
    assert "\x1b" not in out + err and "Traceback" not in err
    if name in REFUSED:
        assert status == 1 and REFUSED[name] in err and "RUN_BAG_LARGER=10 raises this limit" in err
    elif status == 0 and name not in ("names with control characters", "stamps of the far future"):
        assert "good.x" in out


def test_no_file_takes_more_than_a_gigabyte(told):
    assert max(line[-1] for line in told.values()) < 1300.0  # with the libraries, and the file as it was made


def test_what_is_left_out_of_a_broken_definition_is_said(tmp_path, capsys):
    (tmp_path / "x.mcap").write_bytes(HOSTILE["a field twice"]())
    assert info([str(tmp_path / "x.mcap")]) == 0
    assert "a/msg/B has the field 'x' twice; the topic was left out" in capsys.readouterr().out


def test_limits_are_raised_by_whoever_has_truly_large_recordings(tmp_path, monkeypatch):
    small = Limits(messages=(3, 0))
    with pytest.raises(TooLargeError, match="at most 3 messages in a recording of 10 bytes"):
        for _ in range(4):
            Budget(10, small).take("messages", 4, "x")
    monkeypatch.setenv("RUN_BAG_LARGER", "10")
    Budget(10, small).take("messages", 30, "x")
    for wrong in ("0.5", "x", "nan"):
        monkeypatch.setenv("RUN_BAG_LARGER", wrong)
        with pytest.raises(TooLargeError, match="RUN_BAG_LARGER: expected a number from 1 to 1000000"):
            Budget(10, small)


def test_one_budget_is_for_all_files_of_a_run(tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    for i in range(3):
        (bag / f"x_{i}.mcap").write_bytes(HOSTILE["bytes as numbers"]()[: 1 << 20])
    with pytest.raises(RunError):
        read_run(bag)


@pytest.mark.parametrize("name", READERS)
def test_mutated_files_give_a_sentence_or_a_run_and_nothing_else(tmp_path, name):
    count, wrong = mutate_all(tmp_path, {name: READERS[name]}, seconds=0.5, seed=1)
    assert count > 5
    assert not wrong, "\n".join(wrong[:5])
