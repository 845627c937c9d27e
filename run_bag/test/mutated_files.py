"""Good files, spoiled in many ways, before every reader: what is no sentence of ours is a fault.

`test/all_mutated_files.py` is the long way, with the readers of other packages; the tests take seconds.
"""

import argparse
import random
import shutil
import sys
import tempfile
import time
import traceback
import warnings
from collections.abc import Callable, Mapping
from concurrent.futures import ProcessPoolExecutor
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from foreign_recordings import autopilot_log, ros1_bag, ros2_bag, table, telemetry_log
from rosbags.rosbag2 import CompressionMode, StoragePlugin
from synthetic_bench import controlled_recording, write_pool

from run_bag import RunError, Topic, read_run, write_run
from run_bag.importers import bench
from run_bag.importers.checked_map import read_map
from run_bag.importers.cli_pool import import_pool
from run_bag.importers.cli_recording import import_recording, open_source
from run_bag.importers.guess import guess
from run_bag.importers.options import BenchOptions
from safe_files.errors import YamlError
from safe_files.yaml_io import read_yaml

SLOW = 20.0
"""[s] of a processor that no small file may take."""
MAP = """time: {column: 1, unit: ms}
csv: {separator: ",", decimal: "."}
thruster_0/throttle.commanded: {column: PWM (us), unit: us, stop: 1500, per_volt: 80, hold: previous}
thruster_0/state.n: {column: rpm, unit: rpm, sign: -1, nan: ["-", 1], scale: 1e-3, offset: 017}
thruster_0/state.sign_source: {value: 1}
"""


def _run(path: Path) -> Path:
    stamps = 10**9 + np.arange(50) * 10**7
    topic = Topic(name="thruster_0/throttle", type="thruster_msgs/Throttle", stamps=stamps,
                  fields={"commanded": np.arange(50.0)}, frame="x")  # fmt: skip
    return next(write_run(path, [topic], {"seed": 3}).glob("*.mcap"))


def _text(name: str, content: str) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / name).write_text(content)
        return folder / name

    return write


class Reader(NamedTuple):
    """How a good file is made in a folder, how one is read, and what reading may say of one that is not good."""

    make: Callable[[Path], Path]
    read: Callable[[Path], object]
    refusals: tuple[type[Exception], ...] = (RunError, YamlError)


def _import(path: Path) -> None:
    target, told = path.parent / "out", path.parent / "map.yaml"
    told.write_text(MAP)
    import_recording([path], told, target)
    shutil.rmtree(target)


def _bench(path: Path) -> None:
    """Import the recording whose files lie beside one that is spoiled."""
    (group,) = bench.find([path]).groups or [None]
    if group is not None:  # else it is told why it is no recording
        bench.import_recording(group, path.parent / "out", BenchOptions())
        shutil.rmtree(path.parent / "out")


def _pool(path: Path) -> None:
    import_pool(path, path.parent / "out")
    shutil.rmtree(path.parent / "out")


def _folder(path: Path) -> None:
    read_run(path.parent)


def _guess(path: Path) -> None:
    text = guess([open_source(path, None)])
    if any(line[0] not in "#t" or not line.startswith(("#", "time:")) for line in text.splitlines()):
        _read_back(text, path.parent)


@lru_cache(1000)
def _read_back(text: str, folder: Path) -> None:
    """What is proposed can be read; each proposal is looked at once."""
    (folder / "guessed.yaml").write_text(text)
    read_map(folder / "guessed.yaml")


def _sqlite(folder: Path) -> Path:
    return next(ros2_bag(folder / "q", StoragePlugin.SQLITE3).glob("*.db3"))


def _packed(folder: Path) -> Path:
    return next(ros2_bag(folder / "z", StoragePlugin.SQLITE3, CompressionMode.FILE).glob("*.zstd"))


READERS: dict[str, Reader] = {
    "mcap": Reader(lambda f: _run(f / "m"), read_run),
    "mcap of others": Reader(lambda f: next(ros2_bag(f / "o", StoragePlugin.MCAP).glob("*.mcap")), read_run),
    "metadata.yaml": Reader(lambda f: _run(f / "y").with_name("metadata.yaml"), _folder),
    "sqlite3": Reader(_sqlite, read_run),
    "file-compressed": Reader(_packed, read_run),
    "ros1": Reader(lambda f: ros1_bag(f / "x.bag"), read_run),
    "BIN": Reader(lambda f: autopilot_log(f / "x.BIN"), _guess),
    "tlog": Reader(lambda f: telemetry_log(f / "x.tlog"), _guess),
    "csv": Reader(lambda f: table(f / "x.csv"), _import),
    "csv guessed": Reader(lambda f: table(f / "g.csv", separator=";", comma=True), _guess),
    "bench csv": Reader(lambda f: controlled_recording(f) / "CL.csv", _bench),
    "bench csv.xz": Reader(lambda f: controlled_recording(f, packed=True) / "CL.csv.xz", _bench),
    "bench dat": Reader(lambda f: controlled_recording(f) / "CL.dat", _bench),
    "bench mat": Reader(lambda f: controlled_recording(f) / "CL.mat", _bench),
    "bench mat packed": Reader(lambda f: controlled_recording(f, packed=True) / "CL.mat", _bench),
    "pool npz": Reader(lambda f: write_pool(f / "dive.npz"), _pool),
    "map": Reader(_text("m.yaml", MAP), read_map),
    "yaml": Reader(_text("any.yaml", "a: [1, {b: 2e3}]\nc:\n- 'd'\n- |\n  text\n? e\n: \"\\x41\"\n"), read_yaml),
}


def mutated(data: bytes, rng: random.Random) -> bytes:
    """Return data with one to a few spoiled places."""
    result = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 5))):
        kind, at = rng.randrange(8), rng.randrange(max(1, len(result)))
        length = rng.choice((1, 2, 4, 8, 40))
        if kind == 0:
            del result[at:]
        elif kind == 1:
            del result[at : at + length]
        elif kind == 2:
            result[at:at] = bytes(rng.randrange(256) for _ in range(length))
        elif kind == 3:
            result[at:at] = result[at : at + length] * rng.choice((1, 2, 100))
        elif kind == 4:
            result[at : at + length] = rng.choice((b"\xff", b"\0", b"\x7f", b"{", b"[", b'"', b"-", b"9")) * length
        elif kind == 5:
            other = rng.randrange(max(1, len(result)))
            result[at : at + length] = result[other : other + length]
        elif kind == 6 and result:
            result[at] ^= 1 << rng.randrange(8)
        else:
            result[at : at + length] = bytes(rng.randrange(256) for _ in range(length))
    return bytes(result)


def mutate_all(
    folder: Path,
    readers: Mapping[str, Reader],
    *,
    seed: int,
    seconds: float = float("inf"),
    files: float = float("inf"),
) -> tuple[int, list[str]]:
    """Spoil and read, each reader for some seconds or files; return how many were read, and what was no sentence."""
    total, wrong = 0, []
    for name, reader in readers.items():
        own = folder / name.replace(" ", "_")
        own.mkdir()
        path = reader.make(own)
        good, rng = path.read_bytes(), random.Random(f"{seed} {name}")
        reader.read(path)  # as it is, it must be read
        end, cut, count = time.monotonic() + seconds, rng.randrange(len(good)), 0
        while count < files and time.monotonic() < end:
            # every third one is cut, at one place after the other
            cut = (cut + 1 + len(good) // 997) % len(good)
            data = good[:cut] if count % 3 == 0 else mutated(good, rng)
            path.write_bytes(data)
            begin = time.process_time()
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("error", RuntimeWarning)  # a reader's user sees no library's
                    reader.read(path)
            except reader.refusals as error:
                if not str(error).strip():
                    wrong.append(f"{name}, {count}: no sentence")
            except Exception:  # noqa: BLE001 (faults are what is looked for)
                (own / f"fault_{len(wrong)}").write_bytes(data)
                wrong.append(f"{name}, {count}: {traceback.format_exc()}")
            if time.process_time() - begin > SLOW:
                wrong.append(f"{name}, {count}: {time.process_time() - begin:.1f} s")
            count += 1
        total += count
    return total, wrong


_OF_MAIN: dict[str, Reader] = {}
"""The readers of `main`, in its processes too."""


def _part(folder: Path, name: str, seed: int, files: int, end: float) -> tuple[int, list[str]]:
    if (seconds := end - time.monotonic()) <= 0.0:
        return 0, []
    (own := folder / f"{seed}_{name}".replace(" ", "_")).mkdir()
    done = mutate_all(own, {name: _OF_MAIN[name]}, seed=seed, files=files, seconds=seconds)
    if not done[1]:
        shutil.rmtree(own)
    return done


def main(readers: Mapping[str, Reader] = READERS) -> int:
    """Spoil and read as the command line says; return 0, or 1 where something was no sentence."""
    parser = argparse.ArgumentParser(description="Spoil good files and read them.")
    parser.add_argument("readers", nargs="*", metavar="READER", help=", ".join(readers))
    parser.add_argument("--files", type=int, default=100_000, help="for each reader (100000)")
    parser.add_argument("--seconds", type=float, default=float("inf"), help="for each reader, at most (no limit)")
    parser.add_argument("--jobs", type=int, default=1, help="processes side by side (1)")
    parser.add_argument("--seed", type=int, default=1, help="of the first thousand files of each; then counted on (1)")
    parser.add_argument("--keep", type=Path, help="folder for the files at fault; must not exist")
    given = parser.parse_args()
    names = given.readers or list(readers)
    if unknown := sorted(set(names) - set(readers)):
        parser.error(f"expected readers of {', '.join(readers)}; found {', '.join(unknown)}")
    _OF_MAIN.update(readers)
    parts = [min(1000, given.files - k) for k in range(0, given.files, 1000)]
    faults = 0
    with tempfile.TemporaryDirectory() as temporary, ProcessPoolExecutor(given.jobs) as pool:
        folder = given.keep or Path(temporary)
        folder.mkdir(exist_ok=given.keep is None)
        for name in names:
            end = time.monotonic() + given.seconds
            tasks = [pool.submit(_part, folder, name, given.seed + k, files, end) for k, files in enumerate(parts)]
            counts, wrongs = zip(*(task.result() for task in tasks), strict=True)
            count, wrong = sum(counts), [each for some in wrongs for each in some]
            sys.stdout.write("\n".join([*wrong, f"{name}: {count} files, {len(wrong)} faults"]) + "\n")
            sys.stdout.flush()
            faults += len(wrong)
    return 1 if faults else 0
