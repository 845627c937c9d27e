"""Failures of thrusters in a recorded run: when they began, when they were told, and what that changed."""

from dataclasses import dataclass
from math import inf, nan

import numpy as np

from rov_sim.vehicle.failure_words import named_failures
from rov_sim.vehicle.live import Failing, FailureKind, Losing
from rov_sim.vehicle.recording_io import VehicleRecording, signal
from rov_sim.vehicle.run_scores_io import RunScores, score_run
from rov_sim.vehicle.scores import DEGREES_OF_FREEDOM
from run_bag.report import Column, Report

__all__ = ["ToldFailure", "add_failures", "failures_in_words", "failures_of", "losses_of"]

_LEAST = 0.5  # s of a stretch that is scored


@dataclass(frozen=True, kw_only=True)
class ToldFailure:
    """One thruster's failure.

    Attributes:
        thruster: index.
        hidden: what the plant was told to do, "" where the run does not say.
        begun: when [s since the run's start], NaN where the run does not say.
        told: when it was first told on rov/thruster_failure [s], infinity: never.
        kind, effectiveness: as it was told.
    """

    thruster: int
    hidden: str
    begun: float
    told: float
    kind: str
    effectiveness: float

    @property
    def words(self) -> str:
        """It in a sentence."""
        name = f"Thruster {self.thruster} (T{self.thruster + 1})"
        told = f"as {self.kind}" if np.isnan(self.effectiveness) else f"as {self.kind}, {self.effectiveness:.2f} left"
        if not self.hidden:
            return f"{name} was reported at {self.told:.1f} s {told}."
        fails = self.hidden.split(maxsplit=1)[1].rpartition(" at ")[0]
        begun = f"{name} was made to fail ({fails}) at {self.begun:.1f} s"
        after = "never reported" if np.isinf(self.told) else f"reported after {self.told - self.begun:.1f} s {told}"
        return f"{begun}; {after}."

    def content(self) -> dict[str, object]:
        """Return it for scores.json; what is not known is None."""
        return {name: None if value in (inf, "") or value != value else value for name, value in vars(self).items()}


def failures_of(recording: VehicleRecording) -> list[ToldFailure]:
    """Return the failures of a run, by the time they began or were told."""
    start = recording.motion.time[0]
    hidden = {
        failing.thruster: (words, start + failing.time)
        for words, failing in _named(recording)
        if isinstance(failing, Failing)
    }
    told: dict[int, tuple[float, int, float]] = {}
    which = signal(recording.run, "rov/thruster_failure.thruster")
    if which is not None:
        kinds = recording.run["rov/thruster_failure.kind"].values
        left = recording.run["rov/thruster_failure.effectiveness"].values
        for time, thruster, kind, share in zip(*which, kinds, left, strict=True):
            told.setdefault(int(thruster), (float(time), int(kind), float(share)))
    found = []
    for i in sorted({*hidden, *told}):
        words, begun = hidden.get(i, ("", nan))
        when, number, share = told.get(i, (inf, 0, nan))
        kind = FailureKind(number).name.lower() if number in list(FailureKind) else str(number)
        found.append(
            ToldFailure(
                thruster=i, hidden=words, begun=begun, told=when, kind=kind if i in told else "", effectiveness=share
            )
        )
    return sorted(found, key=lambda each: min(each.told, each.begun if np.isfinite(each.begun) else inf))


def losses_of(recording: VehicleRecording) -> dict[str, float]:
    """Return the sensors that were made to fall silent, and when [s since the run's start]."""
    start = recording.motion.time[0]
    return {lost.sensor: float(start + lost.time) for _, lost in _named(recording) if isinstance(lost, Losing)}


def _named(recording: VehicleRecording) -> list[tuple[str, Failing | Losing]]:
    """Return what the run says that it was made to do, in its words."""
    return named_failures(str(recording.run.metadata.get("failures", "")))


def failures_in_words(recording: VehicleRecording) -> list[str]:
    """Return a sentence for each failure of a thruster and for each sensor that was made to fall silent."""
    silent = [f"The sensor {name} was made to fall silent at {at:.1f} s." for name, at in losses_of(recording).items()]
    return [*(each.words for each in failures_of(recording)), *silent]


def add_failures(report: Report, recording: VehicleRecording) -> None:
    """Add what failed and what it changed to a report; nothing where nothing failed."""
    found = failures_of(recording)
    if not found:
        return
    report.subsection("Failures")
    rows = [
        [f"{f.thruster}", f.hidden or "not recorded", f.begun, f.told if np.isfinite(f.told) else nan, f.told - f.begun
         if np.isfinite(f.told) else nan, f.kind or "never told", f.effectiveness]
        for f in found
    ]  # fmt: skip
    columns: list[Column | str] = [
        "Thruster", "Made to fail", Column(name="Begun", unit="s"), Column(name="Told", unit="s"),
        Column(name="After", unit="s", digits=3), "Told as", Column(name="Thrust left", unit="1", digits=3),
    ]  # fmt: skip
    report.table(columns, rows, caption="Failures, and when rov/thruster_failure told of them.")
    _before_and_after(report, recording, found[0])


def _before_and_after(report: Report, recording: VehicleRecording, first: ToldFailure) -> None:
    """Add the scores before the first failure, while it was unknown, and once it was told."""
    if not (np.isfinite(first.begun) and np.isfinite(first.told)):
        return
    time = recording.motion.time
    stretches = {
        "before": (float(time[0]), first.begun), "failed, not told": (first.begun, first.told),
        "told": (first.told, float(time[-1])),
    }  # fmt: skip
    scored: dict[str, RunScores] = {
        name: score_run(recording, begin=a, end=b) for name, (a, b) in stretches.items() if b - a > _LEAST
    }
    rows = [
        [each.words, each.unit, *(s.tracking[each.id].rmse if s.tracking else nan for s in scored.values())]
        for each in DEGREES_OF_FREEDOM
    ]
    for name, of in (("|T_d| of the failed thruster", True), ("|T_d| of the others, mean", False)):
        means = [
            [t.thrust.set_point for i, t in s.thrusters.items() if (i == first.thruster) == of] for s in scored.values()
        ]
        rows.append([name, "N", *(float(np.mean(each)) if each else nan for each in means)])
    report.table(
        ["Quantity", "Unit", *scored], rows,
        caption="RMSE of tracking, and mean thrust asked for, before the first failure, until it was told, and then.",
    )  # fmt: skip
