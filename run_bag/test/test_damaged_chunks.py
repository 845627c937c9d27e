"""One bad byte in a compressed chunk: what is lost, and what is said about it."""

import struct

import pytest

from run_bag import read_run, write_run
from run_bag.benchmark import bench_topics


def chunks(data):
    """Return (begin, end) of the contents of every chunk of a finished file."""
    found, position = [], 8
    while position < len(data):
        opcode, length = struct.unpack_from("<BQ", data, position)
        if opcode == 6:
            found.append((position + 9, position + 9 + length))
        if opcode == 15:
            return found
        position += 9 + length
    raise AssertionError("no end mark")


@pytest.mark.parametrize("offset", [32, 45, 49, 100, -30])  # name and head of the compression, contents
def test_one_bad_byte_in_a_chunk_costs_that_chunk_alone_and_the_loss_is_placed(tmp_path, offset):
    folder = write_run(tmp_path / "a", bench_topics(20_000))
    whole = len(read_run(folder)["thruster_0/state.n"])
    file = folder / "a_0.mcap"
    data = file.read_bytes()
    spans = chunks(data)
    assert len(spans) > 3
    start = struct.unpack_from("<Q", data, spans[0][0])[0]
    for number in (0, len(spans) // 2, len(spans) - 1):  # the first one holds the descriptions of the channels
        begin, end = spans[number]
        bad = bytearray(data)
        bad[begin + offset if offset > 0 else end + offset] ^= 0x55
        file.write_bytes(bytes(bad))
        run = read_run(folder)
        lost = whole - len(run["thruster_0/state.n"])
        assert 0 < lost < 2 * whole / len(spans)
        first, last = ((t - start) / 1e9 for t in struct.unpack_from("<QQ", data, begin))
        (sentence,) = [w for w in run.warnings if "metadata.yaml counts" in w]
        assert f"are lost, between {first:.3f} s and {last:.3f} s" in sentence
        assert "the last 0.000 s" not in sentence and ("the last" in sentence) == (number == len(spans) - 1)
        (damage,) = [w for w in run.warnings if "is damaged" in w]
        assert f"chunk at byte {begin - 9} " in damage and damage.endswith("left out")
