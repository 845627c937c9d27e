"""Files of the bench and the pool that unpack to far more than they are, or hold what is none: a sentence."""

import io
import lzma
import zipfile
import zlib

import numpy as np
import pytest
from scipy.io import loadmat, savemat
from synthetic_bench import pool_arrays

from run_bag import RecordingError, TooLargeError
from run_bag.importers.bench_files import read_controller, read_load_cell
from run_bag.importers.mat_numbers import read_numbers
from run_bag.importers.pool import read_arrays

LARGE = 300 << 20
"""Bytes of what the small files unpack to."""


def mat_of_zeros(path):
    """Write a mat with one compressed variable of zeros."""
    good = io.BytesIO()
    savemat(good, {"u": np.zeros(3)})
    packer = zlib.compressobj(9)
    packed = b"".join(packer.compress(bytes(1 << 20)) for _ in range(LARGE >> 20)) + packer.flush()
    path.write_bytes(good.getvalue()[:128] + (15).to_bytes(4, "little") + len(packed).to_bytes(4, "little") + packed)


def npz_of_zeros(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as packed, packed.open("x.npy", "w") as file:
        for _ in range(LARGE >> 20):
            file.write(bytes(1 << 20))


def text_of_ones(path):
    path.write_bytes(lzma.compress(b"1" * (1 << 20)) * (LARGE >> 20))


@pytest.mark.parametrize(
    ("name", "write", "read"),
    [
        ("x.csv.xz", text_of_ones, read_load_cell),
        ("x.mat", mat_of_zeros, read_controller),
        ("x.npz", npz_of_zeros, read_arrays),
    ],
)
def test_a_small_file_that_unpacks_to_gigabytes_is_refused_with_a_sentence(tmp_path, name, write, read):
    write(tmp_path / name)
    assert (tmp_path / name).stat().st_size < 1 << 20
    with pytest.raises(TooLargeError, match="bytes of unpacked content in a recording of"):
        read(tmp_path / name)


def test_lines_without_end_and_without_number_are_refused_with_a_sentence(tmp_path):
    (tmp_path / "x.csv").write_text("\n" * 3_000_000)
    with pytest.raises(TooLargeError, match="expected at most 2750000 lines in a recording of 3000000 bytes"):
        read_load_cell(tmp_path / "x.csv")
    (tmp_path / "y.csv").write_text("1," * 1_000_000)
    with pytest.raises(RecordingError, match="line 1: expected at most 4096 characters, found 2000000"):
        read_load_cell(tmp_path / "y.csv")


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ({"u": np.zeros(20), "y": "text", "Td": np.zeros(20)}, "expected y to hold numbers, found text"),
        ({"u": {"a": 1}, "y": np.zeros(20), "Td": np.zeros(20)}, "expected .* to hold numbers|expected .*vector of 1"),
        (
            {"u": np.full(20, np.nan), "y": np.zeros(20), "Td": np.zeros(20)},
            "expected 10 finite samples or more of u, found 20, 20 not finite",
        ),
        ({"u": np.zeros(3), "y": np.zeros(3), "Td": np.zeros(3)}, "10 finite samples or more of u, found 3"),
    ],
)
def test_a_controllers_file_with_other_things_in_it_is_refused_with_a_sentence(tmp_path, content, said):
    savemat(tmp_path / "x.mat", content)
    with pytest.raises(RecordingError, match=said):
        read_controller(tmp_path / "x.mat")


@pytest.mark.parametrize("packed", [False, True])
def test_numbers_of_a_mat_are_those_that_scipy_reads(tmp_path, packed):
    rng = np.random.default_rng(3)
    content = {
        "u": rng.normal(size=20), "P": rng.normal(size=(3, 3, 20)), "y": np.arange(40).reshape(2, 20),
        "x": np.float32(2.5), "k": np.arange(3, dtype=np.int8), "none": np.zeros((0, 3)),
        "said": "text", "z": 1j * np.ones(3),
    }  # fmt: skip
    savemat(tmp_path / "x.mat", content, do_compression=packed)
    found, expected = read_numbers(tmp_path / "x.mat"), loadmat(tmp_path / "x.mat")
    assert (found.pop("said"), found.pop("z")) == ("text", "complex numbers")
    for name, values in found.items():
        np.testing.assert_array_equal(values, expected[name])
    assert len(found) == 6


@pytest.mark.parametrize("at", [128, 136, 144, 152, 160, 168, 176, 184, 192])
def test_a_mat_with_a_damaged_tag_is_refused_with_a_sentence(tmp_path, at):
    path = tmp_path / "x.mat"
    savemat(path, {"u": np.zeros(20)})  # scipy's own reader ends the process on some of these
    good = path.read_bytes()
    for wrong in (8, 10, 11, 14, 200, 13577, 0xFFFF, 0xFFFFFFFF):
        path.write_bytes(good[:at] + wrong.to_bytes(4, "little") + good[at + 4 :])
        with pytest.raises(RecordingError):
            read_controller(path)


def test_a_mat_of_version_four_is_refused_with_a_sentence(tmp_path):
    savemat(tmp_path / "x.mat", {"u": np.zeros(3)}, format="4")
    with pytest.raises(RecordingError, match="expected version 5 to 7"):
        read_controller(tmp_path / "x.mat")


def test_times_that_no_recording_of_the_bench_has_are_refused_with_a_sentence(tmp_path):
    rows = [[0, t, *[0.0] * 19] for t in (0.0, 1e9)]
    (tmp_path / "x.csv").write_text("\n".join(",".join(map(str, row)) for row in rows))
    with pytest.raises(RecordingError, match="expected times within 3600 s, found 0 to 1e\\+09 s"):
        read_load_cell(tmp_path / "x.csv")
    arrays = pool_arrays()
    np.savez(tmp_path / "x.npz", **{**arrays, "rovio__imu__data__t": np.array([0.1, 0.2, 1e300])})
    with pytest.raises(RecordingError, match="expected times from 0 to 9e\\+09 s that never fall"):
        read_arrays(tmp_path / "x.npz")
