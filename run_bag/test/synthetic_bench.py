"""Recordings in the bench's formats with a known truth.

The rotor is integrated step by step, not by the formula that is fitted.
"""

from __future__ import annotations

import lzma
from pathlib import Path

import numpy as np
from scipy.io import savemat

GAIN = 49.9723
REST = 1.15  # [rad/s]


def rotor(time, throttle, *, gain=51.0, edge=0.85, lag=0.08):
    """Return a rotor that follows gain * (u -+ edge) with a lag, integrated by Euler steps of one sample."""
    target = np.where(np.abs(throttle) > edge, gain * (throttle - np.sign(throttle) * edge), 0.0)
    n, out = 0.0, np.empty_like(time)
    step = time[1] - time[0]
    for i, wanted in enumerate(target):
        n += step * (wanted - n) / lag
        out[i] = n
    return out


def ramp(time, *, start, duration, setting, stop, edge=0.85):
    """Return the throttle of an open-loop run."""
    low = np.sign(setting) * edge
    u = low + np.clip((time - start) / duration, 0, 1) * (setting - low)
    return np.where((time >= start) & (time < stop), u, 0.0)


def load_cell(time, n, last, *, seed=0, thrust_gain=1e-3, reverse=False):
    """Return the 21 columns of a csv."""
    random = np.random.default_rng(seed)
    table = np.zeros((len(time), 21))
    table[:, 0], table[:, 1] = np.arange(len(time)), time
    table[:, 2:8] = 2.5 + random.normal(scale=1e-3, size=(len(time), 6))
    table[:, 8:14] = random.normal(scale=0.2, size=(len(time), 6))
    table[:, 14:20] = random.normal(scale=[0.3, 0.3, 0.3, 0.03, 0.03, 0.03], size=(len(time), 6))
    turn = -1 if reverse else 1
    table[:, 15] -= turn * thrust_gain * n * np.abs(n) + 0.8
    table[:, 18] += turn * 3e-5 * n * np.abs(n)
    table[:, 20] = last
    return table


def tachometer(n, *, seed=1, glitch=None, time=None):
    """Return the tachometer's volts; `glitch` = (time, height) decays within a tenth of a second."""
    random = np.random.default_rng(seed)
    speed = np.abs(n) + REST + random.normal(scale=1.0, size=len(n))
    if glitch is not None:
        since = time - glitch[0]
        speed = speed + np.where(since >= 0, glitch[1] * np.exp(-np.maximum(since, 0) / 0.04), 0.0)
    return speed / GAIN


def write_csv(path: Path, table, header: str = "") -> Path:
    """Write a csv, compressed if its name says so."""
    text = header + "\n".join(",".join(f"{x:.6g}" for x in row) for row in table) + "\n"
    if path.suffix == ".xz":
        path.write_bytes(lzma.compress(text.encode(), preset=0))
    else:
        path.write_text(text)
    return path


def write_dat(path: Path, time, velocity, *, seed=2) -> Path:
    """Write a dat."""
    random = np.random.default_rng(seed)
    lines = []
    for i, (t, v) in enumerate(zip(time, velocity, strict=True)):
        rest = " ".join(f"{x:.4f}" for x in random.normal(scale=0.01, size=3))
        counts = " ".join(str(x) for x in random.integers(20, 90, 4))
        snr = " ".join(f"{x:.1f}" for x in random.normal(8, 2, 4))
        correlation = " ".join(str(x) for x in random.integers(20, 100, 4))
        lines.append(f"{t:.3f} {i + 16} 00100011 {v:.4f} {rest} {counts} {snr} {correlation}")
    path.write_text("\n".join(lines) + "\n")
    return path


def write_mat(path: Path, *, u, n, flow=None, estimate=None, packed=False) -> Path:
    """Write a mat of the controller; `estimate`: None, "scalar" or "full" covariance."""
    count = len(u)
    content = {
        "Td": np.round(5 * np.sign(u)).reshape(-1, 1),
        "nd": (40 * u).reshape(-1, 1),
        "u": u.reshape(-1, 1),
    }
    content["y"] = n.reshape(-1, 1) if flow is None else np.vstack([n, flow])
    if estimate:
        content |= {k: np.linspace(0, i, count + 1).reshape(-1, 1) for i, k in enumerate(("nhat", "vhat", "vahat"))}
        content["P"] = np.full((count + 1, 1), 3.0)
        if estimate == "full":
            content["P"] = np.broadcast_to(np.diag([3.0, 0.2, 0.1])[:, :, None], (3, 3, count + 1)).copy()
    savemat(path, content, do_compression=packed)
    return path


def controlled_recording(folder: Path, *, packed: bool = False) -> Path:
    """Write a short recording with a controller as csv, dat and mat of one name; return the folder."""
    folder.mkdir(exist_ok=True)
    time, grid = np.arange(400) * 0.01, np.arange(76) * 0.04
    u = np.where(grid < 1.5, -2.0, 2.0)
    n = rotor(time, np.where((time >= 0.5) & (time < 3.5), np.where(time < 2.0, -2.0, 2.0), 0.0))
    write_csv(folder / f"CL.csv{'.xz' if packed else ''}", load_cell(time, n, tachometer(n)), "Author,Engineer\n\n")
    write_dat(folder / "CL.dat", time[::4], 0.001 * n[::4])
    measured = np.abs(np.interp(grid + 0.5, time, n))
    write_mat(folder / "CL.mat", u=u, n=measured, flow=0.1 * np.sin(grid), estimate="full", packed=packed)
    return folder


def pool_arrays() -> dict[str, np.ndarray]:
    """Return a recording of four states, two commands and three readings of the imu, as of a pool vehicle's topics."""
    start = 1.4609e9
    states = np.zeros((4, 10), dtype=np.float32)
    states[:, 0], states[:, 2] = 3.0, 0.5
    states[:, 3:6], states[:, 9] = (0.1, -0.2, 0.3), 1.5
    pulses = np.array([[1500, 1500, 1220, 1780, 1500, 1500], [1500, 1500, 1500, 1500, 1900, 1100]], dtype=np.float32)
    imu = np.array([[7.0, 0.1, 0.2, 0.3, 0.0, 0.0, -9.81]] * 3, dtype=np.float32)
    return {
        "sensor_fusion__states": states,
        "sensor_fusion__states__t": start + np.array([0.0, 0.005, 0.01, 3.0]),
        "rovio__thrusters": pulses,
        "rovio__thrusters__t": start + np.array([1.0, 2.0]),
        "rovio__imu__data": imu,
        "rovio__imu__data__t": start + np.array([0.1, 0.2, 0.3]),
    }


def write_pool(path: Path) -> Path:
    """Write such a recording."""
    np.savez_compressed(path, **pool_arrays())
    return path
