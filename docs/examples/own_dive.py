"""Write two dives as a stranger's logger would, for docs/own_dive.md: python3 docs/examples/own_dive.py FOLDER

The vehicle is one of the blind check of vehicles: its numbers are drawn, and one of its thrusters has an effect that no
set has. The log has names and units of its own: pulses, degrees, g, and an altitude in place of a depth.
"""

import csv
import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.blind.draws import Draw
from gap_diagnosis.vehicle.blind.recording_io import recorded
from gap_diagnosis.vehicle.diagnosis_io import load_model

VEHICLE = "ngs"
HIDDEN = (("thrust_loss", {"thruster": 3}, {"share": 0.4}),)
G = 9.80665


def write_log(topics, path):
    """Write each topic's rows with the time of its own, as a logger that writes what comes."""
    at = {topic.name: topic for topic in topics}
    thrusters = sum(name.endswith("/throttle") for name in at)
    imu, depth = at["rov/imu"], at["rov/depth"]
    angles = Rotation.from_quat(np.column_stack([imu.fields[f"orientation.{a}"] for a in "xyzw"])).as_euler("ZYX")
    columns = {f"pwm_{i + 1}": (at[f"thruster_{i}/throttle"], "commanded", 80.0, 1500.0) for i in range(thrusters)}
    columns |= {f"gyro_{a}_dps": (imu, f"angular_velocity.{a}", 180.0 / np.pi, 0.0) for a in "xyz"}
    columns |= {f"acc_{a}_g": (imu, f"linear_acceleration.{a}", 1.0 / G, 0.0) for a in "xyz"}
    columns["altitude_m"] = (depth, "depth", -1.0, 0.0)
    values = {name: (t.stamps, scale * np.asarray(t.fields[f]) + zero) for name, (t, f, scale, zero) in columns.items()}
    values |= {name: (imu.stamps, np.degrees(angles[:, 2 - k])) for k, name in enumerate(("roll", "pitch", "yaw"))}
    start = min(stamps[0] for stamps, _ in values.values())
    times = np.unique(np.concatenate([stamps for stamps, _ in values.values()]))
    cells = {name: dict(zip(stamps.tolist(), told.tolist(), strict=True)) for name, (stamps, told) in values.items()}
    with path.open("w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        rows.writerow(["time_s", *cells])
        for t in times.tolist():
            row = [told.get(t) for told in cells.values()]
            rows.writerow([f"{(t - start) * 1e-9:.4f}", *("" if x is None else f"{x:.5f}" for x in row)])


if __name__ == "__main__":
    out = Path(sys.argv[1])
    out.mkdir(parents=True)
    believed = load_model(VEHICLE)
    dives = Draw(seed=5, vehicle=VEHICLE, effects=HIDDEN, kinds=("pulses", "steps"), duration=50.0)
    for number, topics in enumerate(recorded(dives, believed.vehicle, believed.sets, believed.sensors), 1):
        write_log(topics, out / f"dive_{number}.csv")
    sys.stdout.write(f"{out}: dive_1.csv, dive_2.csv\n")
