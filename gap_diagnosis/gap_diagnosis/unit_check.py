"""Readings that contradict the parameter set in a way that no effect explains: units, signs, dead sensors, clocks.

Each channel is compared with the model as stated: `ratio` is the gain that fits it best, `likeness` the correlation
(about zero) with it. A gain far from one is physics where other channels confirm it, by T ~ n^2 and U ~ T; it is a unit
where they do not.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.problem import Problem
from thruster_model.identification.experiment import CHANNELS, SIGNALS

__all__ = ["Likened", "gains_and_likenesses", "unit_problems"]

Array = NDArray[np.float64]
G = 9.80665  # [m/s^2]
FACTORS: dict[float, tuple[str, str]] = {
    2.0 * np.pi: ("in rev/s or in Hz", "speed"),
    np.pi / 30.0: ("in rev/min", "speed"),
    np.pi / 180.0: ("in deg/s", "speed"),
    1.0 / (2.0 * np.pi): ("multiplied by 2 pi twice", "speed"),
    30.0 / np.pi: ("turned from rev/min into rad/s twice", "speed"),
    G: ("in kilogram-force", "thrust"),
    4.4482216: ("in pound-force", "thrust"),
    1e-3 * G: ("in gram-force", "thrust"),
    1.0 / G: ("multiplied by g", "thrust"),
    1e-2: ("in hundredths of its unit", "ambient axial torque"),
    1e3: ("in thousands of its unit", "speed ambient axial thrust torque"),
    1e-3: ("in thousandths of its unit", "speed ambient axial thrust torque"),
}
"""Factors that turn readings into the expected unit: what such readings are, and of which signals."""
_NEAR = 0.25  # logarithm within which a ratio is a factor's
_ALIKE, _FOLLOWS, _OPPOSITE = 0.9, 0.5, -0.8
_DEAD = 0.05  # of the movement that the model predicts
_LATEST = {"ambient": 2.5, "axial": 2.5}  # [s], beyond what sensors and commands delay; others 1.2
_LARGE = 10.0  # [V], from which on a throttle may be in another unit
_IN_VOLTS = "expected V (found per cent, millivolts or microseconds?)"
_BEYOND_ANY_DRIVE = 200.0  # edges of the dead zone: no drive in volts reaches that far


class Likened(NamedTuple):
    """A channel against the model: gain and correlation, both [1], and as if of which unit it is, "" of none known."""

    gain: float
    likeness: float
    as_if: str


class _Compared(NamedTuple):
    """A channel and the model: gain, likeness, and rows of both."""

    ratio: float
    likeness: float
    measured: Array
    predicted: Array
    noise: float

    @property
    def follows(self) -> bool:
        """Whether it goes the model's way; one that a bias carries there, and that moves against it, does not."""
        y, p = self.measured - np.mean(self.measured), self.predicted - np.mean(self.predicted)
        against = float(y @ p) < -_FOLLOWS * np.sqrt(float(y @ y) * float(p @ p))
        return self.likeness > _FOLLOWS and not against


def unit_problems(problem: Problem, least: int = 20) -> list[str]:
    """Return what contradicts the model as stated: channels in other units or signs, dead ones, others' clocks.

    `least`: readings of a channel that it takes to say so.
    """
    predicted = problem.predicted(problem.start())
    found = {name: each for name, each in _compared(problem, predicted).items() if each.measured.size >= least}
    throttle = _throttle_problems(problem, found)
    if throttle or not found:
        return throttle
    flipped = [name for name, each in found.items() if each.likeness < _OPPOSITE]
    contradicted = any(each.follows for each in found.values())  # else the thruster turns the other way
    problems = []
    for name, each in found.items():
        channel = problem_channel(problem, name)
        if name in flipped:
            if contradicted:
                problems.append(
                    f"{channel}: its sign is opposite to what the throttle and the other channels say "
                    f"(correlation with the model {each.likeness:.2f}); expected positive for forward thrust"
                )
        elif sentence := (
            _magnitude(name, each) or _dead(name, found) or _late(problem, predicted, name, each) or _unit(name, found)
        ):
            problems.append(f"{channel}: {sentence}")
    return problems


def gains_and_likenesses(problem: Problem) -> dict[str, Likened]:
    """Return how each channel is against the model as stated, by the channel's name."""
    found = _compared(problem, problem.predicted(problem.start()))
    return {
        problem_channel(problem, name): Likened(
            each.ratio,
            each.likeness,
            next((what for _, what in _units_near(name, each.ratio)), "") if abs(each.likeness) > _ALIKE else "",
        )
        for name, each in found.items()
    }


def problem_channel(problem: Problem, signal: str) -> str:
    """Return the name of the channel of a signal."""
    found = next(each for each in problem.series if each.signal == signal)
    return problem.recordings[found.recording].channel(signal)


def _compared(problem: Problem, predicted: Array) -> dict[str, _Compared]:
    result = {}
    for signal, all_rows in problem.signal_rows.items():
        own = [s for s in problem.series if s.signal == signal]
        rows = all_rows[problem.known[all_rows]]
        y, p = problem.measured[rows], predicted[rows]
        power = float(p @ p)
        if power <= 0.0 or float(y @ y) <= 0.0:
            continue
        levels = [problem.recordings[s.recording].experiment.measurements[signal].noise for s in own]
        likeness = float(y @ p) / np.sqrt(power * float(y @ y))
        result[signal] = _Compared(float(y @ p) / power, likeness, y, p, float(np.median(levels)))
    return result


def _witness(name: str, found: Mapping[str, _Compared]) -> float | None:
    """Return the ratio that another channel, if it is alive, leads to expect of this one."""
    # T ~ n^2, Q ~ n^2, U ~ T
    others = {
        "speed": (("thrust", 0.5), ("torque", 0.5), ("ambient", 0.5)),
        "thrust": (("ambient", 1.0), ("axial", 1.0)),
        "torque": (("thrust", 1.0), ("speed", 2.0)),
        "ambient": (("thrust", 1.0), ("speed", 2.0)),
        "axial": (("speed", 1.0),),
    }[name]
    for other, power in others:
        each = found.get(other)
        if each is not None and abs(each.likeness) > _FOLLOWS:
            return float(abs(each.ratio) ** power)
    return None


def _unit(name: str, found: Mapping[str, _Compared]) -> str:
    each, witness = found[name], _witness(name, found)
    if abs(each.likeness) < _ALIKE:
        return ""
    for factor, what in _units_near(name, each.ratio):
        if witness is None and 1.0 / 30.0 < each.ratio < 1.0 and name != "speed":
            continue  # a lost thrust looks the same where nothing else tells
        if witness is not None and abs(np.log(abs(each.ratio) / witness)) < 0.5 * abs(np.log(factor)):
            continue
        return (
            f"readings are {abs(each.ratio):.3g} times what the model says, as if {what}; expected {SIGNALS[name].unit}"
        )
    if witness is not None and abs(each.ratio) > max(5.0 * witness, 2.5):
        return (
            f"readings are {abs(each.ratio):.3g} times what the model says while other channels say {witness:.2g}: "
            f"another unit, or another thruster than the parameter set's; expected {SIGNALS[name].unit}"
        )
    return ""


def _units_near(name: str, ratio: float) -> Iterator[tuple[float, str]]:
    """Yield the factors that bring a channel's readings near the model's, and what such readings are."""
    for factor, (what, of) in FACTORS.items():
        if name in of.split() and abs(np.log(abs(ratio) * factor)) <= _NEAR:
            yield factor, what


def _magnitude(name: str, each: _Compared) -> str:
    """Return what is wrong where a channel has lost its sign."""
    large = 0.2 * float(np.max(np.abs(each.predicted)))
    forward, back = each.predicted > large, each.predicted < -large
    if min(np.mean(forward), np.mean(back)) < 0.05 or np.mean(each.measured[back] < 0.0) > 0.1:
        return ""
    p, y = np.abs(each.predicted), np.abs(each.measured)
    if float(y @ p) < 0.95 * np.sqrt(float(y @ y) * float(p @ p)) or np.mean(each.measured[back] > 0.0) < 0.9:
        return ""
    return (
        "readings stay positive while the throttle reverses, as if of a sensor without sign; expected negative ones "
        "in reverse, or a channel marked as unsigned"
    )


def _dead(name: str, found: Mapping[str, _Compared]) -> str:
    """Return what is wrong where a channel does not answer the throttle although others, that need it to, do."""
    each = found[name]
    moves = float(np.std(each.predicted))
    needed = {"speed": ("thrust", "torque"), "thrust": ("ambient",), "torque": ("thrust",)}.get(name, ())
    alive = [o for o in needed if o in found and abs(found[o].likeness) > _ALIKE and abs(found[o].ratio) > 0.3]
    if not alive or moves < 10.0 * each.noise or float(np.std(each.measured)) > _DEAD * moves:
        return ""
    unit = SIGNALS[name].unit
    if abs(each.ratio) > 1e-4 and abs(each.likeness) > 0.6:
        return ""  # it follows, in another unit
    scatter, mean = float(np.std(each.measured)), float(np.mean(each.measured))
    return (
        f"readings scatter by {scatter:.3g} {unit} about {mean:.3g} {unit} and do not follow the throttle; "
        f"expected them to move by {moves:.3g} {unit}, since the {alive[0]} does"
    )


def _late(problem: Problem, predicted: Array, name: str, each: _Compared) -> str:
    """Return what is wrong where a channel fits the model only seconds earlier or later."""
    if abs(each.likeness) > 0.8:
        return ""
    measured, model = np.where(problem.known, problem.measured, 0.0), predicted
    own = [s for s in problem.series if s.signal == name]
    time = problem.recordings[own[0].recording].experiment.measurements[name].time
    period = float(np.median(np.diff(time)))
    best, at = 0.0, 0
    for lag in range(-round(5.0 / period), round(5.0 / period) + 1):
        pairs = [_shifted(measured[s.rows], model[s.rows], lag) for s in own]
        y, p = np.concatenate([a for a, _ in pairs]), np.concatenate([b for _, b in pairs])
        likeness = float(y @ p) / max(np.sqrt(float(y @ y) * float(p @ p)), 1e-300) if y.size > 50 else 0.0
        if likeness > best:
            best, at = likeness, lag
    if best < 0.95 or abs(at) * period < _LATEST.get(name, 1.2):
        return ""
    return (
        f"readings come {abs(at) * period:.1f} s {'later' if at > 0 else 'earlier'} than the model says; "
        "expected stamps on the clock of the throttle"
    )


def _shifted(measured: Array, model: Array, lag: int) -> tuple[Array, Array]:
    """Return samples and the model's `lag` samples before them."""
    if lag >= 0:
        return measured[lag:], model[: model.size - lag]
    return measured[:lag], model[-lag:]


def _throttle_problems(problem: Problem, found: Mapping[str, _Compared]) -> list[str]:
    """Return what is wrong with the throttle: constant while the thruster moves, or in another unit than volts."""
    name = f"thruster_{problem.recordings[0].thruster}/throttle.commanded"
    speed = found.get("speed")
    commands = [r.experiment.throttle for r in problem.recordings]
    if speed is not None and max(float(np.std(u[u.size // 5 :])) for u in commands) < 1e-6:
        scatter, moves = float(np.std(speed.measured)), float(np.std(speed.predicted))
        turns = min(np.mean(speed.measured > 0.2 * scatter), np.mean(speed.measured < -0.2 * scatter)) > 0.1
        if turns and scatter > max(10.0 * speed.noise, 3.0 * moves):
            level = float(commands[0][-1])
            return [
                f"{name}: constant at {level:g} V while {CHANNELS['speed']} runs from {np.min(speed.measured):.3g} to "
                f"{np.max(speed.measured):.3g} rad/s; expected the commands that made it"
            ]
    largest = max(float(np.max(np.abs(u))) for u in commands)
    edge = max(abs(problem.parameter_set.values.get(key, 0.0)) for key in ("delta_u1", "delta_u2"))
    beyond = []
    if edge > 0.0 and largest > _BEYOND_ANY_DRIVE * edge:
        times = f"{largest / edge:.3g} times the dead zone's edge ({edge:g} V)"
        beyond = [f"{name}: readings of up to {largest:.4g} are {times}; {_IN_VOLTS}"]
    if largest < _LARGE or not found or max(each.ratio for each in found.values()) > 0.3:
        return beyond
    for factor in np.geomspace(3.0, 3000.0, 60):
        scaled = tuple(replace(r, experiment=r.experiment.scaled(1.0 / factor)) for r in problem.recordings)
        posed = replace(problem, recordings=scaled)
        again = _compared(posed, posed.predicted(posed.start()))
        again = {key: each for key, each in again.items() if key in found}
        if again and all(e.likeness > _ALIKE and abs(np.log(e.ratio)) < 0.4 for e in again.values()):
            told = f"about {factor:.2g} times what all other channels say"
            return [f"{name}: readings of up to {largest:.4g} are {told}; {_IN_VOLTS}"]
    return beyond
