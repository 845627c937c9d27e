"""Pictures of a study for documents: normalised errors, real against simulated scores, the flow as it was read."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from rov_sim.bench_study.experiment import Conditions, Experiment, run_experiment
from rov_sim.bench_study.prediction import Prediction
from rov_sim.bench_study.real_runs import RealRun
from rov_sim.study.pictures_io import BLUE, GREY, RED, plain, pyplot, save
from rov_sim.study.results import Results
from thruster_control.strategies import STRATEGIES

__all__ = ["draw_errors", "draw_prediction"]


def draw_errors(study: Results, file: Path) -> None:
    """Draw the normalised errors with their intervals, a panel a set point."""
    plt = pyplot()
    figure, panels = plt.subplots(1, len(study.references), figsize=(11, 3.4), sharey=True, squeeze=False)
    rows = np.arange(len(study.strategies))[::-1]
    for panel, r in zip(panels[0], study.references, strict=True):
        for row, s in zip(rows, study.strategies, strict=True):
            x = study.normalised(s, r)
            panel.plot([x.low, x.high], [row, row], color=BLUE, linewidth=2)
            panel.plot(x.value, row, "o", color=BLUE, markersize=5)
        panel.axvline(1.0, color=GREY, linewidth=1, linestyle=":")
        panel.set_title(r, fontsize=10)
        panel.set_xlabel("RMSE of thrust over the lookup table's [1]")
        panel.set_xlim(left=0.0)
        plain(panel)
    panels[0][0].set_yticks(rows, study.strategies)
    save(figure, file)


def draw_prediction(runs: Sequence[RealRun], found: Mapping[str, Prediction], given: Conditions, file: Path) -> None:
    """Draw real against simulated scores, one colour for each prediction, and the flow read beside the simulated."""
    plt = pyplot()
    seeing = [run for run in runs if STRATEGIES[run.strategy].observer in ("ekf", "nlo", "kfnlo")]
    figure, panels = plt.subplots(1, 1 + len(seeing), figsize=(4.0 + 2.9 * len(seeing), 3.6), squeeze=False)
    first, *others = panels[0]
    for colour, (title, p) in zip((BLUE, RED, GREY), found.items(), strict=False):
        low, high = np.percentile(p.simulated, (5.0, 95.0), axis=1)
        means = p.simulated.mean(axis=1)
        first.errorbar(p.real, means, yerr=[means - low, high - means], fmt="o", color=colour, markersize=4,
                       linewidth=1, label=title)  # fmt: skip
    top = 1.05 * max(float(np.percentile(p.simulated, 95.0, axis=1).max()) for p in found.values())
    first.plot([0.0, top], [0.0, top], color=GREY, linewidth=1, linestyle=":")
    first.set_xlabel("RMSE of the real run [N]")
    first.set_ylabel("simulated, 5 to 95 % [N]")
    first.legend(fontsize=7, frameon=False)
    plain(first)
    for panel, run in zip(others, seeing, strict=True):
        simulated = run_experiment(Experiment(run.strategy, run.reference, 0), given)
        time = run.period * np.arange(run.y_U.size)
        panel.plot(time, run.y_U, color=RED, linewidth=0.8, label="U as recorded")
        panel.plot(simulated.time, simulated.true("ambient"), color=BLUE, linewidth=1.2, label="U simulated")
        panel.plot(time, 0.02 * run.T_d, color=GREY, linewidth=0.8, linestyle="--", label="T_d / (50 N s/m)")
        panel.set_ylim(-0.25, 0.25)
        panel.set_title(run.name, fontsize=9)
        panel.set_xlabel("time [s]")
        plain(panel)
    if others:
        others[0].set_ylabel("ambient flow U [m/s]")
        others[0].legend(fontsize=7, frameon=False)
    save(figure, file)
