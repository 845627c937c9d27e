"""Pictures of a study for documents: errors by strategy with intervals, and one run of each strategy."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from rov_sim.study.pictures_io import BLUE, GREY, RED, plain, pyplot, save
from rov_sim.study.results import Results
from rov_sim.vehicle_study.plan import Plan
from rov_sim.vehicle_study.runs_io import first_runs

__all__ = ["draw_errors", "draw_runs"]

_ERRORS = {"surge": "surge", "pitch_rate": "pitch rate", "pitch": "pitch", "v_hat": "v̂"}
_MOTIONS = (("surge [m/s]", 0), ("pitch rate [rad/s]", 1), ("pitch [rad]", 2))
_COLOURS = (BLUE, RED, "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#999933", "#882255")


def draw_errors(study: Results, plan: Plan, file: Path) -> None:
    """Draw the normalised errors of the typical case of the first two groups, a panel each score, a row a strategy."""
    plt = pyplot()
    groups = plan.groups[:2]
    heights = [len(group.strategies) + 1.5 for group in groups]
    figure, panels = plt.subplots(
        len(groups), len(_ERRORS), figsize=(11, 0.36 * sum(heights) + 0.8), squeeze=False, sharex="col",
        gridspec_kw={"height_ratios": heights},
    )  # fmt: skip
    for row, group in zip(panels, groups, strict=True):
        case = plan.typical(group).name
        at = np.arange(len(group.strategies))[::-1]
        for panel, (name, title) in zip(row, _ERRORS.items(), strict=True):
            for y, s in zip(at, group.strategies, strict=True):
                x = study.mean(s, case, name)
                panel.plot([100 * x.low, 100 * x.high], [y, y], color=BLUE, linewidth=2)
                panel.plot(100 * x.value, y, "o", color=BLUE, markersize=5)
            panel.set_xscale("log")
            panel.set_ylim(-0.7, len(group.strategies) - 0.3)
            panel.set_yticks(at, group.strategies if panel is row[0] else [])
            panel.set_title(f"{title}" if row is panels[0] else "", fontsize=10)
            plain(panel)
        row[0].set_ylabel(group.name)
    for panel in panels[-1]:
        panel.set_xlabel("error over mean set point [%]", fontsize=8)
    panels[-1][-1].set_xlabel("error over mean |v| [%]", fontsize=8)
    save(figure, file)


def draw_runs(plan: Plan, contents: Mapping[str, str], file: Path) -> None:
    """Draw surge, pitch rate and pitch of seed 0 in the typical case of the first two groups, as Figs. 5.9 and 5.11."""
    plt = pyplot()
    groups = plan.groups[:2]
    figure, panels = plt.subplots(
        len(_MOTIONS), len(groups), figsize=(5.6 * len(groups), 6.4), squeeze=False, sharex=True, sharey="row"
    )
    for column, group in enumerate(groups):
        runs = first_runs(plan, group, contents)
        for row, (title, k) in enumerate(_MOTIONS):
            panel = panels[row][column]
            for (s, run), colour in zip(runs.items(), _COLOURS, strict=False):
                moved = (run.record.velocity[:, 0], run.record.velocity[:, 4], run.angles()[:, 1])[k]
                panel.plot(run.time, moved, color=colour, linewidth=0.9, label=s)
            w = run.wanted()
            wanted = (w.velocity[:, 0], w.attitude_rate[:, 1], w.attitude[:, 1])[k]  # type: ignore[call-overload]
            panel.plot(run.time, wanted, color=GREY, linewidth=1.2, linestyle="--", label="set point")
            plain(panel)
            if column == 0:
                panel.set_ylabel(title)
        panels[0][column].set_title(group.title, fontsize=10)
        panels[-1][column].set_xlabel("time [s]")
        panels[0][column].legend(fontsize=6, frameon=False, ncols=2)
    save(figure, file)
