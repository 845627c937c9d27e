"""A report with every kind of content, from made-up thruster data: a pattern to copy."""

import numpy as np

from . import Cell, Column, Report
from .plots import (
    Axis,
    Bars,
    Panel,
    Residual,
    Series,
    Span,
    Track,
    bars,
    curves,
    heat_map,
    needles,
    residuals,
    space,
    time_series,
)

SPEED = Axis(name="rotor speed", unit="rad/s", symbol="n")
THRUST = Axis(name="thrust", unit="N", symbol="T")
FLOW = Axis(name="ambient flow", unit="m/s", symbol="U")
THROTTLE = Axis(name="throttle", unit="V", symbol="u")
YAML = """k_n:
  value: 11.62
  unit: 1/s
  std: 0.11
  source: run 2024-03-11-04
c_u:
  value: 161.0
  unit: rad/(s^2 V)
"""


def example_report() -> Report:
    """Build the report; its numbers are invented."""
    rng = np.random.default_rng(7)
    report = Report(
        "Thruster identification",
        "Example with invented data: HQ model fitted to two flow-tank runs, judged on a third",
        {
            "runs": ["2024-03-11-02", "2024-03-11-04", "2024-03-12-01 (held out)"],
            "parameter set": "HQ",
            "version": "0.4.0",
            "seed": 7,
            "solver": {"method": "trf", "starts": 8, "evaluations": 412, "cost": 1.0274},
        },
    )
    report.warning(
        "Run 2024-03-12-01: 180 of 6 000 flow samples are missing between t = 31.2 s and 33.0 s; "
        "they are left out of the fit."
    )
    report.warning(
        "k_w and k_Uv are correlated by −0.96: this data cannot tell them apart. Add a run with steps of U "
        "at constant throttle."
    )
    report.section("What was found")
    report.paragraph(
        "The re-tuned HQ model predicts rotor speed to 1.1 rad/s and thrust to 0.21 N on data it has not "
        "seen, within a fifth of what the sensors' noise allows. The published set misses thrust at "
        "reversals by up to 2 N.\n\nAll numbers below are free runs driven by the recorded throttle."
    )
    report.key_values(
        {
            "verdict": "re-tuned parameters explain the data",
            "held-out samples": 5820,
            "noise floor of n": "0.9 rad/s",
            "largest residual": "3.1 N at t = 22.4 s",
        }
    )
    report.table(
        [
            Column(name="channel"),
            Column(name="unit"),
            Column(name="as published", digits=3),
            Column(name="re-tuned", digits=3),
            Column(name="HL", digits=3),
            Column(name="noise floor", digits=3),
            Column(name="samples"),
        ],
        [
            ["rotor speed n", "rad/s", Cell(4.21, "worse"), Cell(1.12, "best"), 1.31, 0.9, 6000],
            ["thrust T", "N", Cell(0.842, "worse"), Cell(0.214, "best"), 0.377, 0.19, 6000],
            ["torque Q", "N m", 0.0121, Cell(0.0068, "best"), Cell(0.0133, "worse"), 0.006, 6000],
            ["ambient flow U", "m/s", None, 0.0312, Cell(0.0305, "best"), 0.029, 5820],
        ],
        caption="Root-mean-square error on the held-out run.",
        notes=["Free run, initial state fitted."],
    )

    report.section("Runs and fits")
    t = np.arange(0.0, 60.0, 0.01)
    n = 95.0 * np.sign(np.sin(0.35 * t)) * np.abs(np.sin(0.35 * t)) ** 0.4 + 8.0 * np.sin(2.1 * t)
    n[np.abs(n) < 12.0] = 0.0
    thrust = 6.5e-4 * n * np.abs(n) - 0.02 * n
    flow = 0.25 + 0.12 * np.sin(0.12 * t)
    flow_measured = flow + rng.normal(0.0, 0.02, t.size)
    flow_measured[3120:3300] = np.nan
    volts = n / 24.0 + 0.35 * np.sign(n)
    panels = [
        Panel(
            axis=SPEED,
            series=[
                Series(name="measured", x=t, y=n + rng.normal(0, 0.9, t.size), role="data"),
                Series(name="as published", x=t, y=1.06 * n),
                Series(name="re-tuned", x=t, y=n),
            ],
        ),
        Panel(
            axis=THRUST,
            series=[
                Series(name="measured", x=t, y=thrust + rng.normal(0, 0.2, t.size), role="data"),
                Series(name="as published", x=t, y=1.18 * thrust + 0.3),
                Series(name="re-tuned", x=t, y=thrust),
            ],
        ),
        Panel(
            axis=FLOW,
            series=[
                Series(name="measured", x=t, y=flow_measured, role="data"),
                Series(name="re-tuned", x=t, y=flow, low=flow - 0.03, high=flow + 0.03, color=1),
            ],
        ),
        Panel(axis=THROTTLE, series=[Series(name="measured", x=t, y=volts, role="data")]),
    ]
    report.figure(
        time_series(panels, spans=[Span(10.0, 20.0, "held out"), Span(40.0, 50.0, "held out")]),
        caption="Run 2024-03-12-01: measured channels and free-run predictions.",
        alt="Four panels over 60 s. The re-tuned model follows; the published one is too strong.",
    )
    report.subsection("Steady state")
    speeds = np.linspace(-120, 120, 25)
    fine = np.linspace(-125, 125, 300)
    measured = 6.5e-4 * speeds * np.abs(speeds) + rng.normal(0, 0.15, speeds.size)
    torque = 1.1e-5 * fine * np.abs(fine)
    report.figure(
        [
            curves(
                [
                    Series(
                        name="measured",
                        x=speeds,
                        y=measured,
                        role="data",
                        points=True,
                        low=measured - 0.3,
                        high=measured + 0.3,
                    ),
                    Series(name="as published", x=fine, y=7.7e-4 * fine * np.abs(fine)),
                    Series(name="re-tuned", x=fine, y=6.5e-4 * fine * np.abs(fine)),
                ],
                x=SPEED,
                y=THRUST,
            ),
            curves(
                [
                    Series(name="as published", x=fine, y=1.2 * torque),
                    Series(name="re-tuned", x=fine, y=torque, low=torque - 0.01, high=torque + 0.01),
                ],
                x=SPEED,
                y=Axis(name="torque", unit="N m", symbol="Q"),
            ),
        ],
        caption="Steady-state thrust and torque at U = 0; bars and band are ± 2 standard deviations.",
        alt="Thrust and torque grow with the square of speed; re-tuned curves pass through the points.",
    )
    report.subsection("What is left over")
    left = rng.normal(0, 0.21, t.size) + 0.1 * np.sin(4.0 * t)
    worse = left + 0.18 * thrust
    f = np.geomspace(0.05, 50, 200)
    report.figure(
        residuals(
            [
                Residual(
                    name="as published",
                    time=t,
                    value=worse,
                    frequency=f,
                    density=0.03 + 0.4 / (1 + (f / 0.2) ** 2),
                ),
                Residual(
                    name="re-tuned",
                    time=t,
                    value=left,
                    frequency=f,
                    density=0.03 + 0.03 * np.exp(-((np.log(f / 0.64) / 0.2) ** 2)),
                ),
            ],
            quantity=THRUST,
            noise_floor=0.028,
        ),
        caption="Residuals of thrust and their amplitude spectrum.",
        alt="The re-tuned model leaves white noise but for a line at 0.64 Hz.",
    )

    report.section("Parameters")
    names = ["k_n", "c_u", "δ_u", "k_w", "k_Uv", "c_n^T", "c_nv^T"]
    values = [11.62, 161.0, 0.36, 0.0041, 0.82, 6.5e-4, 1.13e-11]
    report.table(
        [
            Column(name="parameter"),
            Column(name="nominal"),
            Column(name="fitted"),
            Column(name="std. dev.", digits=2),
            Column(name="shift", unit="σ", format="+.1f"),
            Column(name="unit"),
        ],
        [
            [name, 0.95 * v, v, 0.02 * v, Cell(s, "emphasis") if abs(s) > 2 else s, unit]
            for name, v, s, unit in zip(
                names,
                values,
                [1.1, -0.4, 3.2, 0.2, -0.7, -2.8, float("nan")],
                ["1/s", "rad/(s² V)", "V", "1/s", "–", "N s²/rad²", "N s²/(rad m)"],
                strict=True,
            )
        ],
        caption="Parameters before and after, with the shift in their stated deviations.",
    )
    labels = [
        "Coulomb friction of the shaft",
        "speed-dependent dead time",
        "throttle gain",
        "none",
        "unknown",
    ]
    report.figure(
        bars(
            labels,
            [
                Bars(
                    name="as published",
                    value=[0.42, 0.31, 0.17, 0.06, 0.04],
                    low=[0.30, 0.2, 0.1, 0.03, 0.01],
                    high=[0.55, 0.42, 0.25, 0.1, 0.08],
                ),
                Bars(
                    name="re-tuned",
                    value=[0.62, 0.14, 0.04, 0.15, 0.05],
                    low=[0.5, 0.08, 0.02, 0.1, 0.03],
                    high=[0.73, 0.2, 0.08, 0.2, 0.09],
                ),
            ],
            quantity=Axis(name="probability", unit="–"),
            reference=0.5,
        ),
        caption="Probability of each candidate, with 90 % intervals over held-out blocks.",
        alt="Coulomb friction leads with 0.62 after re-tuning.",
    )
    a = rng.normal(size=(9, 7))
    a[:, 4] = -a[:, 3] + 0.2 * a[:, 4]
    report.figure(
        heat_map(np.corrcoef(a.T), columns=names),
        caption="Correlation of the fitted parameters.",
        alt="k_w and k_Uv are almost perfectly anticorrelated; all others are moderate.",
    )
    turn = np.linspace(0.0, 4.0 * np.pi, 300)
    path = np.stack([2.0 * np.sin(turn), 2.0 * np.cos(turn), 1.0 + 0.15 * turn], axis=1)
    ahead = path + 0.5 * np.stack([np.cos(turn), -np.sin(turn), 0.0 * turn], axis=1)
    east, north, depth = (Axis(name=name, unit="m") for name in ("east", "north", "depth"))
    spiral = Track(name="path", x=path[:, 0], y=path[:, 1], z=path[:, 2])
    report.figure(
        space([spiral, needles("forward", path[::20], ahead[::20])], x=east, y=north, z=depth, z_down=True),
        caption="Path of the vehicle, with its forward axis.",
        alt="A spiral of 2 m radius that descends by almost 2 m in two turns to the right, the vehicle facing ahead.",
    )
    report.section("Take it with you")
    report.download("Fitted parameter set", "hq_fitted.yaml", YAML)
    return report
