"""A mass on a spring behind the protocol `System`: two parameters, two suspected effects, pushed at random."""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numba
import numpy as np

from system_identification.suspects import Suspect
from system_identification.system import Linear, Series, SizeSlot

DT = 0.02
NOMINAL = {"stiffness": 30.0, "damping": 1.5}
SLOTS = {
    "cubic": SizeSlot("cubic", "share", -1.5, 1.5, "1/m^2"),
    "friction": SizeSlot("friction", "force", 0.0, 2.0, "N"),
    "scale": SizeSlot("scale", "share", -0.3, 0.3, "1"),
}


@numba.njit
def rate(position, speed, force, stiffness, damping, cubic, friction):
    spring = stiffness * position * (1.0 + cubic * position**2)
    return force - spring - damping * speed - friction * np.tanh(speed / 0.05)


@numba.njit
def integrated(force, stiffness, damping, cubic, friction):
    states = np.zeros((force.size, 2))
    for k in range(force.size - 1):
        x, v, f = states[k, 0], states[k, 1], force[k]
        a = rate(x, v, f, stiffness, damping, cubic, friction)
        v2 = v + 0.5 * DT * a
        b = rate(x + 0.5 * DT * v, v2, f, stiffness, damping, cubic, friction)
        v3 = v + 0.5 * DT * b
        c = rate(x + 0.5 * DT * v2, v3, f, stiffness, damping, cubic, friction)
        v4 = v + DT * c
        d = rate(x + DT * v3, v4, f, stiffness, damping, cubic, friction)
        states[k + 1, 0] = x + DT * (v + 2.0 * v2 + 2.0 * v3 + v4) / 6.0
        states[k + 1, 1] = v + DT * (a + 2.0 * b + 2.0 * c + d) / 6.0
    return states


def motion(force, stiffness, damping, cubic=0.0, friction=0.0, push=0.0):
    """Return position and velocity (N, 2) by Runge and Kutta's method; the push is held over a step."""
    return integrated(force + push, stiffness, damping, cubic, friction)


@dataclass(frozen=True, kw_only=True, eq=False)
class Spring:
    """Runs of a mass on a spring, position read every 0.04 s."""

    forces: tuple
    readings: tuple
    slots: tuple = ()
    noise: float = 0.01
    jumps: bool = False
    gates: tuple = ()
    nuisances: int = 2
    parameters: int = 2
    signal_names: tuple = ("position",)
    deviations: dict = field(default_factory=lambda: {"stiffness": 1.5, "damping": 0.075})

    @property
    def local(self):
        return np.zeros(self.nuisances + len(self.slots), dtype=bool)

    @property
    def conventions(self):
        return np.zeros(self.nuisances, dtype=bool)

    @property
    def shared_conventions(self):
        return np.zeros(self.nuisances, dtype=bool)

    @property
    def series(self):
        sizes = np.cumsum([0, *(r.size for r in self.readings)])
        return [Series(i, "position", a, b) for i, (a, b) in enumerate(pairwise(sizes))]

    @property
    def times(self):
        return np.concatenate([2.0 * DT * np.arange(r.size) for r in self.readings])

    @property
    def measured(self):
        return np.concatenate(self.readings)

    @property
    def known(self):
        return np.isfinite(self.measured)

    @property
    def levels(self):
        return {"position": self.noise}

    @property
    def single(self):
        return {"position": self.noise}

    @property
    def pushed(self):
        return ("position",)

    @property
    def spread(self):
        return np.ones(self.measured.size)

    def movable(self):
        return np.ones(self.nuisances + len(self.slots), dtype=bool)

    def bounded(self, x):
        sizes = [np.clip(v, s.lower / s.width, s.upper / s.width) for v, s in zip(x[2:], self.slots, strict=True)]
        return np.concatenate((np.clip(x[:2], -8.0, 8.0), sizes))

    def _states(self, x):
        values = {n: NOMINAL[n] + u * self.deviations[n] for n, u in zip(NOMINAL, x, strict=False)}
        sizes = {slot.effect: v * slot.width for slot, v in zip(self.slots, x[2:], strict=True)}
        own = {k: v for k, v in sizes.items() if k != "scale"}
        return [motion(f, **values, **own) for f in self.forces], sizes.get("scale", 0.0), values

    def predicted(self, x):
        states, scale, _ = self._states(np.asarray(x))
        return np.concatenate([(1.0 + scale) * s[::2, 0][: r.size] for s, r in zip(states, self.readings, strict=True)])

    def residuals(self, x):
        return self.measured - self.predicted(x)

    def sensitivities(self, x, columns=None):
        columns = range(x.size) if columns is None else columns
        steps = np.eye(x.size) * 1e-3
        found = [(self.predicted(x + steps[k]) - self.predicted(x - steps[k])) / 2e-3 for k in columns]
        return np.stack(found, axis=1)

    def linear(self, x, apart=None):
        _, scale, values = self._states(np.asarray(x))
        a = np.array([[0.0, 1.0], [-values["stiffness"], -values["damping"]]])
        step = np.eye(2) + a * DT + a @ a * DT**2 / 2.0 + a @ a @ a * DT**3 / 6.0
        gain = DT * (np.eye(2) + a * DT / 2.0 + a @ a * DT**2 / 6.0)
        runs = []
        for each, force in zip(self.series, self.forces, strict=True):
            count = each.last - each.first
            runs.append(
                Linear(
                    dt=DT,
                    transition=np.repeat(step[None], force.size, axis=0),
                    push=np.repeat((gain @ np.array([[0.0], [1.0]]))[None], force.size, axis=0),
                    unforeseen=np.zeros((force.size, 2)),
                    rows=np.arange(each.first, each.last),
                    places=2 * np.arange(count),
                    readings=np.repeat(np.array([[1.0 + scale, 0.0]]), count, axis=0),
                    signals=np.zeros(count, dtype=np.int64),
                )
            )
        return runs

    def with_effects(self, slots, gates=()):
        return replace(self, slots=tuple(slots))

    def tried(self, x, suspect):
        posed = self.with_effects((*self.slots, *suspect.slots))
        return np.array([posed.predicted(np.concatenate((x, sizes))) for sizes in suspect.grid])


def suspects(_=None):
    """Return the three effects as suspects."""
    grid = np.array([[0.1], [0.3], [0.6], [1.0]])
    both = np.vstack((-0.5 * grid, 0.5 * grid))
    return [
        Suspect(effect=name, channel="", slots=(slot,), grid=grid if slot.lower == 0.0 else both)
        for name, slot in SLOTS.items()
    ]


def recorded(seed, *, push=1.0, noise=0.01, runs=3, stiffness=1.03, damping=0.96, **effects):
    """Return a recorded spring whose parameters are a little off; `push`: deviation of the random force [N]."""
    rng = np.random.default_rng(seed)
    forces, readings = [], []
    count = 1000
    for _ in range(runs):
        force = np.repeat(rng.uniform(-12.0, 12.0, count // 40), 40)
        walk = np.zeros(count)
        keep = np.exp(-DT / 1.5)
        for k in range(1, count):
            walk[k] = keep * walk[k - 1] + np.sqrt(1.0 - keep**2) * push * rng.standard_normal()
        scale = effects.get("scale", 0.0)
        own = {k: v for k, v in effects.items() if k != "scale"}
        states = motion(force, stiffness * NOMINAL["stiffness"], damping * NOMINAL["damping"], push=walk, **own)
        forces.append(force)
        readings.append((1.0 + scale) * states[::2, 0] + noise * rng.standard_normal(count // 2))
    return Spring(forces=tuple(forces), readings=tuple(readings), noise=noise)
