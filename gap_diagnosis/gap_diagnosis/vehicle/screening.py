"""The columns of nuisances, hypotheses and nameless dependences, made by running the filter at each probe."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter
from scipy.spatial.transform import Rotation

from gap_diagnosis.vehicle.filtering import Prepared, filtered
from gap_diagnosis.vehicle.gains import down_of
from gap_diagnosis.vehicle.gram import Column
from gap_diagnosis.vehicle.hypotheses import Hypothesis
from gap_diagnosis.vehicle.log import VehicleLog
from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.turns import rotations
from gap_diagnosis.vehicle.unknowns import Key, acts_in
from gap_diagnosis.vehicle.whitening import whitened
from rov_sim.vehicle.effects.active import ActiveVehicleEffect
from rov_sim.vehicle.effects.body_axes import BODY_AXES, pushed_by
from rov_sim.vehicle.innovations import states_of
from thruster_model.errors import VehicleError

__all__ = ["READINGS", "Screen", "nameless_names"]

Array = NDArray[np.float64]
_TOLD = {
    **{f"gyro {a}": 3 + k for k, a in enumerate("xyz")}, **{f"accelerometer {a}": 6 + k for k, a in enumerate("xyz")},
    "depth": 9,
    **{f"velocity {a}": 10 + k for k, a in enumerate("xyz")},
}  # fmt: skip
"""Columns of `VehicleLog.told` that an error of a reading may be in."""
_ANGLES = {"roll angle": (1.0, 0.0, 0.0), "pitch angle": (0.0, 1.0, 0.0)}
"""Axes of the body about which a told attitude may be turned."""
_PULLED = {"roll angle": "late acceleration along y", "pitch angle": "late acceleration along x"}
"""What pulls them where an attitude follows the accelerometer."""
_LATE = 1.0
"""[s] In which an attitude follows it: a filter of gyro and accelerometer takes some tenths to some seconds. Water that
slides in a hull, and a wake, take as long."""
_TILTS = ("roll angle", "pitch angle")
"""The first two components of the earth's down in axes of the body are a tilt about the other axis each."""
_PROBES = {
    **dict.fromkeys(BODY_AXES[:3], 1.0), **dict.fromkeys(BODY_AXES[3:], 0.1),
    **{place: 0.01 if place.startswith("gyro") else 0.02 for place in _TOLD}, "heading": 0.02,
    **dict.fromkeys(_ANGLES, 0.01),
}  # fmt: skip
"""[N, N m, rad/s, m/s^2, rad, m, m/s] By which nameless dependences are tried, by what they act on."""
READINGS = {**{place: place.split()[0] for place in _TOLD}, **dict.fromkeys(("heading", *_ANGLES), "attitude")}
"""Places of nameless dependences that are errors of a reading, not wrenches, with their sensor (`VehicleLog.there`)."""


@dataclass(frozen=True, kw_only=True, eq=False)
class Screen:
    """A point of the model, at which directions are tried.

    Attributes:
        model: of the vehicle.
        runs: its recordings with gains.
        values: of the nuisances; effects: switched on.
    """

    model: Model
    runs: Sequence[Prepared]
    values: Mapping[Key, float]
    effects: tuple[ActiveVehicleEffect, ...] = ()
    _base: dict[tuple[int, bool], Array] = field(default_factory=dict)

    def residual(self, k: int, *, coarse: bool = False) -> Array:
        """Return whitened innovations of run k at the point, (K, M); coarse: see `filtered`."""
        if (k, coarse) not in self._base:
            run = self.runs[k]
            found = filtered(self.model, run, self.values, self.effects, coarse=coarse)
            self._base[k, coarse] = whitened(run, found)
        return self._base[k, coarse]

    def residuals(self) -> list[Array]:
        """Return those of all runs, flat."""
        return [self.residual(k).ravel() for k in range(len(self.runs))]

    def at(
        self, k: int, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect], *, coarse: bool = False
    ) -> Array | None:
        """Return whitened innovations of run k elsewhere; None: there is no such model; coarse: see `filtered`."""
        try:
            return whitened(self.runs[k], filtered(self.model, self.runs[k], values, effects, coarse=coarse))
        except (VehicleError, ValueError):
            return None

    def _beside(self, k: int, values: Mapping[Key, float], effects: Sequence[ActiveVehicleEffect]) -> Array:
        """Return what is different elsewhere from the point; nothing where there is no such model."""
        here = self.residual(k, coarse=True)
        found = self.at(k, values, effects, coarse=True)
        return np.zeros_like(here) if found is None else found - here

    def of_nuisance(self, key: Key, deviation: float) -> Column:
        """Return the column of a nuisance, over its deviation (it then has the deviation 1)."""
        step = 0.2 * deviation

        def change(k: int) -> Array:
            if not acts_in(key, k):
                return np.zeros_like(self.residual(k))
            moved = {**self.values, key: self.values.get(key, 0.0) + step}
            return self._beside(k, moved, self.effects) / (step / deviation)

        return Column(key, 1.0, change)

    def of_hypothesis(self, h: Hypothesis) -> list[Column]:
        """Return the columns of a hypothesis: one for each parameter over its expected size, or one for a switch."""
        if h.switch:
            return [Column((h, "on"), 0.0, lambda k: self._changed(k, h, ()))]
        if h.carrier:
            return self._carried(h)
        if h.grid:
            return [Column((h, h.parameters[0]), 1.0, lambda k: self._changed(k, h, h.probe))]
        return [Column((h, name), 1.0, self._probe(h, j)) for j, name in enumerate(h.parameters)]

    def _probe(self, h: Hypothesis, j: int) -> Any:
        if j > 0 and h.about:  # where there is no effect it is the same wherever it would begin
            return lambda k: np.zeros_like(self.residual(k))
        sizes = tuple(p if i == j else 0.0 for i, p in enumerate(h.probe))
        return lambda k: self._changed(k, h, sizes) * (h.scale[j] / h.probe[j])

    def _carried(self, h: Hypothesis) -> list[Column]:
        first = (h.probe[0], *(0.0 for _ in h.probe[1:]))
        columns = [Column((h, h.parameters[0]), 1.0, lambda k: self._changed(k, h, first) * (h.scale[0] / h.probe[0]))]
        for j in range(1, len(h.parameters)):
            sizes = tuple(h.probe[0] if i == 0 else h.probe[i] if i == j else 0.0 for i in range(len(h.probe)))
            over = h.scale[0] * h.scale[j] / (h.probe[0] * h.probe[j])

            def change(k: int, sizes: Any = sizes, over: float = over) -> Array:
                return (self._changed(k, h, sizes) - self._changed(k, h, first)) * over

            columns.append(Column((h, h.parameters[j]), 1.0, change))
        return columns

    def _changed(self, k: int, h: Hypothesis, sizes: tuple[float, ...]) -> Array:
        return self._beside(k, self.values, (*self.effects, h.active(sizes)))

    def of_nameless(self, name: Key) -> Column:
        """Return the column of a wrench on an axis, or an error of a reading, that goes with a feature.

        It is over its probe. The feature's mean square is 1 over all runs: where there is less of it there is less of
        what it does; see `features`.
        """
        _, place, feature = name
        told = [features(run, feature) for run in self.runs]
        scale = max(float(np.sqrt(np.mean(np.concatenate(told) ** 2))), 1e-9)

        def change(k: int) -> Array:
            run, extra = self.runs[k], None
            size = _PROBES[place] / scale * told[k]
            if place in BODY_AXES:
                extra = np.zeros((run.log.count, 6))
                extra[:, BODY_AXES.index(place)] = size
            else:
                run = replace(run, log=_misread(run.log, place, size))
            result = filtered(self.model, run, self.values, self.effects, extra, coarse=True)
            return whitened(run, result) - self.residual(k, coarse=True)

        return Column(name, 1.0, change)


def _misread(log: VehicleLog, place: str, size: Array) -> VehicleLog:
    """Return a log whose readings of one kind are larger by so much (K,)."""
    if place == "heading" or place in _ANGLES:
        q = rotations(np.where(np.isfinite(log.attitude), log.attitude, [1.0, 0.0, 0.0, 0.0]))
        turn = Rotation.from_rotvec(np.outer(size, _ANGLES.get(place, (0.0, 0.0, 1.0))))
        turned = q * turn if place in _ANGLES else turn * q
        return replace(log, attitude=np.where(np.isfinite(log.attitude), turned.as_quat()[:, [3, 0, 1, 2]], np.nan))
    told = log.told.copy()
    told[:, _TOLD[place]] += size
    return replace(log, told=told)


def nameless_names(model: Model, there: Mapping[str, bool]) -> list[Key]:
    """Return the names of all nameless dependences that are tried: none that an effect of the library is.

    Wrenches, and errors of the readings of those sensors that told anything (`VehicleLog.there`).
    """
    K_t = model.vehicle.configuration
    names = [f"thrust {i}" for i in range(model.thrusters)]
    names += ["uu", "vv", "ww", "rr", "uv", "uw", "ur"]
    names += [f"{a}|{a}|" for a in "uvwpqr"]
    names += ["time", "start or end", "depth", *_TILTS, *(f"late {tilt}" for tilt in _TILTS)]
    named = {(BODY_AXES[a], f"{c}|{c}|") for a, c in enumerate("uvwpqr")}  # its own drag
    named |= {(a, f"thrust {i}") for i in range(model.thrusters) for a in pushed_by(K_t, i)}  # its wake on the hull
    named |= {("roll", "roll angle"), ("pitch", "pitch angle")}  # righting
    named |= {("sway", "roll angle"), ("surge", "pitch angle")}  # weight
    of_body = [("nameless", axis, f) for axis in BODY_AXES for f in names if (axis, f) not in named]
    of_body += [("nameless", axis, f"late {c}") for axis, c in zip(BODY_AXES, "uvwpqr", strict=True)]
    errors: dict[str, tuple[str, ...]] = {
        f"gyro {a}": (f"{c}|{c}|", "time", "rotors") for a, c in zip("xyz", "pqr", strict=True)
    }
    errors |= {f"accelerometer {a}": ("time", "rotors") for a in "xyz"}
    errors |= {f"velocity {a}": (f"{c}|{c}|", "time") for a, c in zip("xyz", "uvw", strict=True)}
    errors |= {"depth": ("u|u|", "time", "rotors"), "heading": ("time",)}
    errors |= {angle: (by, "time") for angle, by in _PULLED.items()}
    return of_body + [("nameless", place, f) for place, of in errors.items() for f in of if there[READINGS[place]]]


def features(prepared: Prepared, feature: str) -> Array:
    """Return a feature of the motion over a run (K,)."""
    states = states_of(np.nan_to_num(prepared.base.states))
    nu = states.nu
    if feature.startswith("late"):
        return _late(prepared, features(prepared, feature.removeprefix("late ")))
    if feature.startswith("thrust"):
        out = states.thrusts[:, int(feature.split()[1])]
    elif feature == "time":
        out = np.linspace(-1.0, 1.0, len(nu))
    elif feature == "start or end":
        out = np.linspace(-1.0, 1.0, len(nu)) ** 2
    elif feature == "depth":
        out = states.position[:, 2] - np.mean(states.position[:, 2])
    elif feature == "rotors":  # what makes a hull vibrate
        out = np.sum(states.speeds**2, axis=1)
    elif feature in _TILTS:
        out = down_of(states.attitude)[:, 1 - _TILTS.index(feature)]
    elif feature.startswith("acceleration"):  # of a body that turns
        felt = np.gradient(nu[:, :3], prepared.log.period, axis=0) + np.cross(nu[:, 3:], nu[:, :3])
        out = felt[:, "xyz".index(feature[-1])]
    elif feature.endswith("|"):
        a = "uvwpqr".index(feature[0])
        out = nu[:, a] * np.abs(nu[:, a])
    elif len(feature) == 1:
        out = nu[:, "uvwpqr".index(feature)]
    else:
        a, b = ("uvwpqr".index(c) for c in feature)
        out = nu[:, a] * nu[:, b]
    return np.asarray(out)


def _late(prepared: Prepared, signal: Array) -> Array:
    """Return a signal (K,) as what follows it within `_LATE` has it."""
    slow = np.exp(-prepared.log.period / _LATE)
    return np.asarray(lfilter([1.0 - slow], [1.0, -slow], signal, zi=[slow * signal[0]])[0])
