"""A recording that is imported by the text of a map, and the map that is proposed for one."""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from run_bag import Run, read_run
from run_bag.importers.cli_recording import main

SWEEP = np.sin(np.arange(0.0, 12.0, 0.02))
COMMAND = "unit: us, stop: 1500, per_volt: 80, hold: previous"


def entries(throttle: str, speed: str) -> str:
    """Return the entries of a pulse's throttle and a speed in rpm that are in these columns or fields."""
    return f"thruster_0/throttle.commanded: {{{throttle}, {COMMAND}}}\nthruster_0/state.n: {{{speed}, unit: rpm}}\n"


def wide(path: Path, columns: Mapping[str, np.ndarray]) -> Path:
    """Write a csv with a column for each signal, all of shape (rows,)."""
    np.savetxt(path, np.column_stack(list(columns.values())), "%.9g", ",", header=",".join(columns), comments="")
    return path


def attempted(tmp_path: Path, text: str, *files: Path, out: str = "run") -> int:
    """Import files by the text of a map into the folder `out`; return the exit status."""
    (tmp_path / "map.yaml").write_text(text)
    return main([*map(str, files), "--map", str(tmp_path / "map.yaml"), "--out", str(tmp_path / out)])


def imported(tmp_path: Path, text: str, *files: Path, out: str = "run") -> Run:
    """Import files by the text of a map; return the run."""
    assert attempted(tmp_path, text, *files, out=out) == 0
    return read_run(tmp_path / out)


def proposal(capsys: pytest.CaptureFixture[str], *files: Path) -> str:
    """Return the text of the map that is proposed for files."""
    assert main([*map(str, files), "--guess"]) == 0
    return capsys.readouterr().out


def proposed(capsys: pytest.CaptureFixture[str], *files: Path) -> tuple[dict[str, str], str]:
    """Return the entries that are proposed for files, by channel, and all that is printed."""
    text = proposal(capsys, *files)
    return dict(re.findall(r"^([^#:\s]+): (.*)", text, re.MULTILINE)), text
