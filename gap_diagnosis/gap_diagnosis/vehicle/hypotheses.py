"""What may be wrong: every effect of both libraries on every thruster, pair, axis and sensor that it can act on."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.vehicle.model import Model
from gap_diagnosis.vehicle.onset import Begun, Onset
from gap_diagnosis.vehicle.unknowns import in_brackets
from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY, ActiveVehicleEffect
from rov_sim.vehicle.effects.effect import VehicleEffect
from thruster_model.effects import stages
from thruster_model.effects.effect import Suspected

__all__ = ["WIRING", "Hypothesis", "described", "hypotheses", "sized"]

Array = NDArray[np.float64]
_FURTHER = (0.3, 1.0, 2.0)
"""Sizes, in expected ones, from which what is bent is looked for."""


def described(effect: str) -> Any:
    """Return an effect as its library describes it, that of the vehicle or that of a thruster."""
    return VEHICLE_LIBRARY.get(effect) or stages.LIBRARY[effect]


def sized(parameter: str, size: float, deviation: float, unit: str) -> str:
    """Return a size in words."""
    return f"{parameter} {size:.3g} ± {deviation:.2g}{'' if unit == '1' else ' ' + unit}"


@dataclass(frozen=True, kw_only=True)
class Hypothesis:
    """One effect on one part of the vehicle.

    Attributes:
        effect, thruster, other, axis, sensor, kind: as of an `ActiveVehicleEffect`.
        parameters: those that are fitted; of a size each.
        scale: deviations that are expected of them.
        probe: sizes at which they are tried.
        lower, upper: their range.
        fixed: the other parameters.
        about: of each parameter that is fitted, the value that its size 0 stands for; (): 0 for all.
        carrier: parameter that the later ones multiply (a mass at a place), or "".
        switch: whether it is either on or off.
        grid: sizes to fit from where the neutral one is infinite; it is then screened at its probe alone.
        read_by: sensor without which it cannot be shown, or "".
        watched: sizes of its first parameter that a watch follows.
        sudden: size from half of which on a watch looks for it as a jump within one reading of `read_by`, or 0.
        tolerance: deviation of its only parameter where nothing is wrong, or 0.
        begins: whether it is a failure of a single part, which may begin in mid-dive.
        since: when it begins; None: it is there all along.
    """

    effect: str
    thruster: int | None = None
    other: int | None = None
    axis: str | None = None
    sensor: str | None = None
    kind: str | None = None
    parameters: tuple[str, ...]
    scale: tuple[float, ...]
    probe: tuple[float, ...]
    lower: tuple[float, ...]
    upper: tuple[float, ...]
    fixed: Mapping[str, float] = field(default_factory=dict, hash=False)
    about: tuple[float, ...] = ()
    carrier: str = ""
    switch: bool = False
    grid: tuple[float, ...] = ()
    read_by: str = ""
    watched: tuple[float, ...] = ()
    sudden: float = 0.0
    tolerance: float = 0.0
    begins: bool = False
    since: Onset | None = None

    @property
    def place(self) -> tuple[Any, ...]:
        """Identifier and what it acts on, which a diagnosis must get right."""
        return self.effect, self.thruster, self.other, self.axis, self.sensor, self.kind

    @property
    def error(self) -> tuple[Any, ...]:
        """Place and what is off there, about whatever it is sought: biases of gyro and accelerometer have one place."""
        return self.place, self.parameters

    @property
    def further(self) -> tuple[tuple[float, ...], ...]:
        """Sizes beside small ones from which it is looked for: of delays, lags and drifts, and of what is at a place.

        What they do is bent. What a delay does to a pulse tells nothing of it once it is longer than the pulse's edge,
        and from none a fit ended at 9 ms of 143.
        """
        timed = bool(self.parameters) and not self.grid and self.units[self.parameters[0]] in ("s", "s/s")
        sizes = [share * self.scale[0] for share in _FURTHER] if timed or self.carrier else []
        sizes += [-size for size in sizes if timed and self.lower[0] < 0.0]
        return tuple((size, *(0.0 for _ in self.parameters[1:])) for size in sizes)

    @property
    def of_one_size(self) -> bool:
        """Whether its first parameter tells by itself how much of it there is."""
        return len(self.parameters) == 1 or bool(self.about)

    @property
    def most(self) -> float:
        """Magnitude of the largest size that its first parameter may have."""
        return max(abs(self.lower[0]), abs(self.upper[0]))

    @property
    def units(self) -> dict[str, str]:
        """Unit of each parameter of the effect."""
        return {p.name: p.unit for p in described(self.effect).parameters}

    @property
    def words(self) -> str:
        """Name of it in a sentence."""
        thruster = "" if self.thruster is None else f" of thruster {self.thruster}"
        pair = "" if self.other is None else f" and {self.other}"
        since = "" if self.since is None else f", {self.since.words}"
        return f"{described(self.effect).title}{thruster}{pair}{in_brackets(self.kind, self.axis, self.sensor)}{since}"

    def told(self, sizes: Sequence[float] | Array) -> tuple[float, ...]:
        """Return the values of its parameters, in their units."""
        return tuple(float(about + s) for about, s in zip(self.about or (0.0,) * len(sizes), sizes, strict=True))

    def active(self, sizes: tuple[float, ...]) -> ActiveVehicleEffect:
        """Return it switched on, sizes held within their range."""
        held = zip(self.parameters, self.told(np.clip(sizes, self.lower, self.upper)), strict=True)
        on = ActiveVehicleEffect(
            id=self.effect, sizes={**self.fixed, **dict(held)}, thruster=self.thruster, other=self.other,
            axis=self.axis, sensor=self.sensor, kind=self.kind,
        )  # fmt: skip
        return on if self.since is None else Begun(**vars(on), onset=self.since)


WIRING = ("thruster_swap", "thruster_polarity")
"""Which command drives which thruster, and which way round."""


def hypotheses(model: Model, there: Mapping[str, bool], *, sudden: bool = False) -> list[Hypothesis]:
    """Return all hypotheses that these sensors (`VehicleLog.there`) could show anything of.

    sudden: those instead that only show as they begin.
    """
    shown = [h for h in _all(model, there) if not h.read_by or there.get(h.read_by, False)]
    return [h for h in shown if (h.sudden > 0.0) == sudden]


def _all(model: Model, there: Mapping[str, bool]) -> Iterator[Hypothesis]:
    flows = any(getattr(s.coefficients, "k_Tv", 0.0) for s in model.sets)
    libraries: list[Any] = [*stages.LIBRARY.values(), *VEHICLE_LIBRARY.values()]
    for effect in libraries:
        for suspected in effect.suspected:
            sizes = {name: s for name, s in suspected.sizes.items() if _told(suspected.told_by.get(name), there)}
            if bool(sizes) == bool(suspected.sizes) and (flows or not suspected.flowing):
                for place in _places(effect, suspected, model):
                    yield _made(effect, replace(suspected, sizes=sizes), place)


def _told(sensors: tuple[str, ...] | None, there: Mapping[str, bool]) -> bool:
    """Tell whether one of the sensors is there; None: any tells."""
    return sensors is None or any(there.get(each, False) for each in sensors)


def _places(effect: Any, suspected: Suspected, model: Model) -> Iterator[Mapping[str, Any]]:
    """Yield what an effect is suspected on, by target."""
    if suspected.places is not None:
        yield from suspected.places(model.vehicle)
        return
    thrusters = tuple(range(model.thrusters))
    ranges: dict[str, tuple[Any, ...]] = dict(suspected.only)
    if isinstance(effect, VehicleEffect):
        ranges = {name: effect.choices.get(name, thrusters) for name in effect.needs} | ranges
    elif effect.block != "log":  # a sensor of its own, a limit or a wire differs from thruster to thruster
        singly = suspected.grid or suspected.read_by or not suspected.sizes
        ranges["thruster"] = thrusters if singly else (None, *thrusters)
    for chosen in product(*ranges.values()):
        place = dict(zip(ranges, chosen, strict=True))
        i, j = place.get("thruster"), place.get("other")
        if j is None or (i < j if suspected.alike else i != j):
            yield place


def _made(effect: Any, suspected: Suspected, place: Mapping[str, Any]) -> Hypothesis:
    known = {p.name: p for p in effect.parameters}
    own = [known[name] for name in suspected.sizes]
    least = {p.name: -p.upper if p.both_signs else min(p.lower, p.neutral) for p in own} | dict(suspected.lower)
    about = {p.name: suspected.about.get(p.name, 0.0) for p in own}
    sensor, single = place.get("sensor"), isinstance(effect, VehicleEffect) or place.get("thruster") is not None
    return Hypothesis(
        effect=effect.id,
        parameters=tuple(suspected.sizes),
        scale=tuple(expected for expected, _ in suspected.sizes.values()),
        probe=tuple(probe for _, probe in suspected.sizes.values()),
        lower=tuple(least[p.name] - about[p.name] for p in own),
        upper=tuple(p.upper - about[p.name] for p in own),
        fixed=suspected.fixed,
        about=tuple(about.values()) if suspected.about else (),
        carrier=own[0].name if suspected.carries else "",
        switch=not own,
        grid=suspected.grid,
        read_by={"imu": "accelerometer"}.get(sensor, sensor) if sensor else suspected.read_by,
        watched=suspected.watched,
        sudden=suspected.sudden,
        tolerance=suspected.tolerance,
        begins=single and (bool(suspected.watched) or suspected.begins),
        **place,
    )
