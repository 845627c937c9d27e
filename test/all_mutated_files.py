"""Good files of every kind, spoiled in many ways, before the readers of all packages: the long way.

python test/all_mutated_files.py --jobs 2 [--files 100000] [--seconds 600] [READER...]
"""

import shutil
import sys
from collections.abc import Callable
from functools import cache, lru_cache
from importlib.resources import files
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "run_bag/test"))

from mutated_files import READERS, Reader, main

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.log_io import log_of, read_logs
from run_bag import Channel, Run, Topic, read_run, write_run
from safe_files.errors import YamlError
from thruster_control.errors import ThrusterControlError
from thruster_control.vehicle_set_points_io import load_script
from thruster_model.errors import ThrusterModelError
from thruster_model.force_table_map_io import read_column_map
from thruster_model.force_table_sheets_io import read_force_table
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.vehicle_set_io import load_vehicle_set

VEHICLE, THRUSTERS = "ngs", 6
COLUMNS = Path(__file__).resolve().parents[1] / "thruster_model/config/t200_columns.yaml"
SHEET = "PWM (µs),Voltage (V),Force (Kg f),RPM,Current (A),Power (W)\n" + "".join(
    f"{1500 + 100 * k},{supply},{0.1 * k * abs(k):.2f},{600 * abs(k)},{0.2 * abs(k):.1f},{2 * abs(k)}\n"
    for supply in (10, 12)
    for k in range(-4, 5)
)


@cache
def _dive() -> tuple[Topic, ...]:
    """Two seconds of a vehicle's run, with every sensor."""
    model = load_model(VEHICLE)
    draw = Draw(seed=12, vehicle=VEHICLE, deviations=0.7, kinds=("steps",), duration=2.0)
    return tuple(recorded(draw, model.vehicle, model.sets, model.sensors)[0])


def _bag(folder: Path) -> Path:
    return next(write_run(folder / "dive", _dive()).glob("*.mcap"))


def _read_bag(path: Path) -> None:
    read_logs([path], load_model(VEHICLE))


@lru_cache(1)
def _sound(folder: Path) -> Run:
    return read_run(write_run(folder / "sound", _dive()))


def _numbers(folder: Path) -> Path:
    """Write stamps and values of every channel one after the other: spoiled, they come to the log as if sound."""
    run = _sound(folder)
    (folder / "numbers").write_bytes(b"".join(run[name].stamps.tobytes() + run[name].values.tobytes() for name in run))
    return folder / "numbers"


def _read_numbers(path: Path) -> None:
    run, channels, left = _sound(path.parent), {}, path.read_bytes()
    for name in run:
        size = min(run[name].stamps.size, len(left) // 16)
        if size:
            stamps = np.sort(np.frombuffer(left, np.int64, size))
            values = np.frombuffer(left, np.float64, size, 8 * size)
            channels[name] = Channel(name=name, stamps=stamps, values=values)
        left = left[16 * size :]
    log = log_of(Run(name="spoiled", channels=channels), THRUSTERS)
    assert np.isfinite(log.throttles).all(), "throttles of a log are numbers"


def _copy_of(package: str, name: str) -> Callable[[Path], Path]:
    def copied(folder: Path) -> Path:
        (folder / "mine.yaml").write_text((files(package) / name).read_text("utf-8"), "utf-8")
        return folder / "mine.yaml"

    return copied


def _sheet(folder: Path) -> Path:
    (folder / "sheet.csv").write_text(SHEET, "utf-8")
    return folder / "sheet.csv"


_SETS = (ThrusterModelError, YamlError)
OTHERS = {
    "dive": Reader(_bag, _read_bag),
    "dive's numbers": Reader(_numbers, _read_numbers),
    "parameter set": Reader(_copy_of("thruster_model", "parameter_sets/hl.yaml"), load_parameter_set, _SETS),
    "vehicle set": Reader(_copy_of("thruster_model", f"vehicle_sets/{VEHICLE}.yaml"), load_vehicle_set, _SETS),
    "force table's map": Reader(lambda f: shutil.copy(COLUMNS, f / "map.yaml"), read_column_map, _SETS),
    "force table's sheet": Reader(_sheet, lambda path: read_force_table(path, read_column_map(COLUMNS)), _SETS),
    "set points": Reader(
        _copy_of("thruster_control", "vehicle_scripts/all_axes.yaml"), load_script, (ThrusterControlError, YamlError)
    ),
}
"""Readers of packages above `run_bag`."""

if __name__ == "__main__":
    sys.exit(main(READERS | OTHERS))
