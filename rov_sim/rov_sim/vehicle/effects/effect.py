"""An unmodelled effect of a vehicle: one definition, which the simulator switches on and a diagnosis can suspect.

It changes coefficients: those of the vehicle (`VehicleCoefficients`) or those of its sensors (`SensorCoefficients`). At
neutral sizes it changes nothing, bit for bit. Effects of single thrusters are those of `thruster_model`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

from thruster_model.effects.effect import EffectParameter, Suspected, check_suspected

__all__ = ["TARGETS", "Block", "VehicleEffect"]

Block = Literal["body", "water", "thrusters", "sensor"]

TARGETS = ("thruster", "other", "axis", "sensor", "kind")
"""What an effect may act on: a thruster, a second one, an axis, a sensor, one of its kinds."""


@dataclass(frozen=True, kw_only=True)
class VehicleEffect:
    """An unmodelled effect of a vehicle.

    Attributes:
        id: identifier.
        title: what it is physically, in words.
        block: where it enters.
        equation: as a formula.
        parameters: its sizes; all neutral: no effect.
        note: what title, equation and sizes leave open, as a sentence for the reference.
        needs: of `TARGETS`, what it acts on and cannot do without.
        may_take: what it may be narrowed to; without it, all.
        choices: what axis, sensor and kind may be, by target.
        body: (VehicleCoefficients, ActiveVehicleEffect) to VehicleCoefficients.
        sensing: (SensorCoefficients, ActiveVehicleEffect) to SensorCoefficients.
        order: the lower first, by identifier where equal.
        twins: effects that no data can tell from this one.
        suspected: how a diagnosis suspects it; nothing: not at all.
    """

    id: str
    title: str
    block: Block
    equation: str
    parameters: tuple[EffectParameter, ...]
    note: str = ""
    needs: tuple[str, ...] = ()
    may_take: tuple[str, ...] = ()
    choices: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    body: Callable[..., Any] | None = None
    sensing: Callable[..., Any] | None = None
    order: int = 0
    twins: tuple[str, ...] = ()
    suspected: tuple[Suspected, ...] = ()

    def __post_init__(self) -> None:
        taken = {*self.needs, *self.may_take}
        if not self.parameters or not taken <= set(TARGETS) or not set(self.choices) <= taken:
            raise ValueError(f"{self.id}: expected parameters, targets of {', '.join(TARGETS)} and choices among them")
        if (self.body is None) == (self.sensing is None):
            raise ValueError(f"{self.id}: expected either body or sensing")
        check_suspected(self.id, self.parameters, self.suspected)
