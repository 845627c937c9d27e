"""Compile what diagnoses need into the cache, by diagnosing short runs:   python -m gap_diagnosis.warm_cache"""

import tempfile
from pathlib import Path

from gap_diagnosis.scoreboard.plans import planned
from gap_diagnosis.scoreboard.running_io import diagnosed
from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.diagnosis_io import diagnosed as diagnosed_vehicle
from gap_diagnosis.vehicle.diagnosis_io import load_model
from gap_diagnosis.vehicle.log_io import read_logs
from run_bag import write_run


def main() -> None:
    """Diagnose a thruster without an effect, with all suspects tried beside it, and a vehicle with some."""
    diagnosed(planned("smoke", ("tank",))[0])
    draw = Draw(seed=0, vehicle="ngs", kinds=("steps",), duration=12.0)
    model = load_model(draw.vehicle)
    with tempfile.TemporaryDirectory() as folder:
        topics = recorded(draw, model.vehicle, model.sets, model.sensors)[0]
        logs, model = read_logs([write_run(Path(folder) / "run", topics)], model)
    diagnosed_vehicle(model, logs, {}, only=lambda h: h.thruster == 0 or h.axis == "heave", how_far=False)


if __name__ == "__main__":
    main()
