"""The load cell's matrix and mode as a YAML file with units and standard deviations; computed, never shipped."""

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from safe_files.whole_files_io import write_whole
from thruster_model.load_cell.calibration import ROWS
from thruster_model.load_cell.geometry import leg_lines
from thruster_model.load_cell.study import CalibrationStudy, RecoveryStudy

__all__ = ["dump_load_cell", "write_load_cell"]

MODE_UNITS = {"frequency": "Hz", "softening": "Hz", "damping": "1", "leak": "1", "arm_gain": "1"}
MODE_MEANING = {
    "frequency": "natural frequency at 1 N of ringing",
    "softening": "what it loses for each tenfold of amplitude",
    "damping": "damping ratio",
    "leak": "share of the ringing that the moment over its arm shows",
    "arm_gain": "correction of the lever arm",
}


def dump_load_cell(calibrated: CalibrationStudy | None, recovered: RecoveryStudy | None) -> str:
    """Return the YAML text."""
    document: dict[str, Any] = {"frame": "thruster: x forward, torque positive for forward rotation (run_bag README)"}
    if calibrated is not None:
        document["matrix"] = _matrix(calibrated)
    if recovered is not None:
        resonance = recovered.resonance
        document["lever_arm"] = {"value": float(recovered.arm), "unit": "m"}
        document["mode"] = {
            name: {
                "value": float(getattr(resonance.mode, name)),
                "unit": unit,
                "standard_deviation": _finite(resonance.deviation[name]),
                "meaning": MODE_MEANING[name],
            }
            for name, unit in MODE_UNITS.items()
        }
    return yaml.safe_dump(document, sort_keys=False, width=120, allow_unicode=True)


def _matrix(study: CalibrationStudy) -> dict[str, Any]:
    c = study.calibration
    directions, gain, foot = leg_lines(c.matrix)
    units = ["1"] * 3 + ["m"] * 3
    return {
        "meaning": "wrench = value x gauge forces [N], equation (3.2) with H_A = H + H_E",
        "source": "linear least squares over " + ", ".join(study.reproduced),
        "samples": c.samples,
        "condition": _finite(c.condition),
        "rows": {
            row: {
                "value": [float(v) for v in c.matrix[i]],
                "standard_deviation": [_finite(v) for v in c.deviation[i]],
                "unit": units[i],
            }
            for i, row in enumerate(ROWS)
        },
        "legs": [
            {
                "direction": {"value": [round(float(v), 5) for v in directions[i]], "unit": "1"},
                "gain": {"value": round(float(gain[i]), 5), "unit": "1"},
                "foot": {"value": [round(float(v), 5) for v in foot[i]], "unit": "m"},
            }
            for i in range(6)
        ],
    }


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None


def write_load_cell(path: Path, calibrated: CalibrationStudy | None, recovered: RecoveryStudy | None) -> None:
    """Write to a temporary name, then rename; FileExistsError where there is a file."""
    write_whole(path, dump_load_cell(calibrated, recovered))
