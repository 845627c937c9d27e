"""What `fit` writes `diagnose` takes, for every class of thruster model."""

import json
from pathlib import Path

import numpy as np
import pytest

from gap_diagnosis import cli_diagnose
from rov_sim import cli_bench_campaign
from thruster_model import cli_fit
from thruster_model.effects.stages import LIBRARY
from thruster_model.models import MODELS
from thruster_model.parameter_set_io import load_parameter_set

SHORT = ("table",)
"""Classes that every check goes through; each costs a compilation of its own."""


def programme(path: Path) -> Path:
    """Write rest, steps of all sizes both ways, and a ramp through the dead zone."""
    time = np.arange(0.0, 16.0, 0.05)
    steps = np.array([3.6, 2.0, -1.3, -3.6, 0.0, -2.5, 2.8])[np.clip((time - 1.5) / 1.2, 0, 6).astype(int)]
    u = np.select([time < 1.5, time < 9.9], [0.0, steps], 3.2 * np.sin(2.0 * np.pi * (time - 9.9) / 6.0))
    path.write_text("time_s,throttle_V\n" + "".join(f"{t:.2f},{x:.4f}\n" for t, x in zip(time, u, strict=True)))
    return path


CLASSES = [name if name in SHORT else pytest.param(name, marks=pytest.mark.long) for name in MODELS]


@pytest.mark.parametrize("model", CLASSES)
def test_diagnose_takes_what_fit_has_written(model: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--set", model, "--spread", "0.03", "--programme", str(programme(tmp_path / "programme.csv"))]
    assert cli_bench_campaign.main([*words, "--out", str(tmp_path / "runs")]) == 0
    runs = sorted(str(path) for path in (tmp_path / "runs").iterdir() if path.is_dir())
    assert cli_fit.main([*runs, "--model", model, "--start", model, "--out", str(tmp_path / "fit")]) == 0
    fitted = tmp_path / f"fit/{model}.yaml"
    assert load_parameter_set(str(fitted)).model_name == model
    others = [name for name in LIBRARY if name not in ("command_delay", "load_cell_resonance")]
    capsys.readouterr()
    status = cli_diagnose.main([*runs, "--set", str(fitted), "--out", str(tmp_path / "out"), "--without", *others])
    assert status == 0, capsys.readouterr().err
    found = json.loads((tmp_path / "out/diagnosis.json").read_text("utf-8"))
    assert found["provenance"]["parameter_set"] == load_parameter_set(str(fitted)).name
    total = found["gap"]["total"]
    assert all(np.isfinite(value) for value in total.values() if isinstance(value, float)), total
