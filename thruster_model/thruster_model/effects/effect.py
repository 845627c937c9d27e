"""What an unmodelled effect is: one definition, which the simulator switches on and a diagnosis can suspect."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

__all__ = ["STAGES", "Block", "Effect", "EffectParameter"]

Block = Literal["log", "command", "rotor", "thrust", "flow", "sensor"]

STAGES: dict[str, tuple[str, ...]] = {
    "edges": ("edges", "n", "p", "e"),
    "drive": ("drive", "n", "heat", "supply", "p", "e"),
    "inflow": ("ambient", "p", "e"),
    "approach": ("water", "p", "e"),
    "loads": ("loads", "n", "v", "ambient", "gate", "p", "e"),
    "rotor": ("n_dot", "n", "drive", "p", "e"),
    "thrust_dynamics": ("force", "n_dot", "p", "e"),
    "axial": ("v_dot", "v", "ambient", "force", "p", "e"),
    "ambient": ("u_dot", "ambient", "past", "force", "p", "e"),
    "heat": ("heat", "u", "dt", "p", "e"),
    "memory": ("delay", "e"),
    "step": ("step", "e"),
}
"""Where the plant's pipeline lets effects in, and the arguments of a hook there; it returns the first, changed or not.

edges            dead-zone edges (delta_u1, delta_u2) [V]; n: rotor speed [rad/s]
drive            gamma(u) [rad/s^2] at the nominal supply; heat: of the motor, 0 to 1; supply: its relative voltage
inflow           ambient flow that reaches thruster and instrument [m/s]
approach         the part of that flow which the propeller meets [m/s]; the instrument still measures all of it
loads            (thrust [N], torque [N m]); v: axial flow [m/s]; gate: 0 while the propeller may draw air, else 1
rotor            dn/dt [rad/s^2]
thrust_dynamics  thrust [N], once dn/dt is known
axial, ambient   dv/dt, dU/dt [m/s^2]; past: the ambient flow `memory` seconds ago [m/s]; force: thrust [N]
heat             heat of the motor after dt [s] at the acting throttle u [V]
memory           how far back `past` lies [s]
step             the longest step [s] that integrates
"""


@dataclass(frozen=True, kw_only=True)
class EffectParameter:
    """One size of an effect: at `neutral` there is exactly no effect; `lower` to `upper` is the plausible range.

    `both_signs` tells that the range counts with either sign.
    """

    name: str
    unit: str
    meaning: str
    lower: float
    upper: float
    neutral: float = 0.0
    both_signs: bool = False


@dataclass(frozen=True, kw_only=True)
class Effect:
    """An unmodelled effect.

    Attributes:
        id: identifier.
        title: what it is physically, in words.
        block: where it enters.
        equation: as a formula.
        parameters: its sizes; the first one is zero (or neutral) exactly where there is no effect.
        hooks: by stage of the plant, functions of that stage's arguments.
        samples: what it does to the throttle's samples, to a sensor's samples or to stamps, outside the integration;
            None where it acts in the plant.
        channel: the signals whose sensor or log it concerns, separated by spaces; "" where it concerns none or any.
        order: place in the chain of its block or stage; the lower first, by identifier where equal.
        twins: effects that no data can tell from this one.
    """

    id: str
    title: str
    block: Block
    equation: str
    parameters: tuple[EffectParameter, ...]
    hooks: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    samples: Callable[..., Any] | None = None
    channel: str = ""
    order: int = 0
    twins: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        unknown = set(self.hooks) - set(STAGES)
        if unknown or not self.parameters or bool(self.hooks) == (self.samples is not None):
            raise ValueError(f"{self.id}: expected parameters and either hooks or samples; unknown stages {unknown}")

    def field_of(self, parameter: str) -> str:
        """Return the name of a parameter's field in `EffectValues`."""
        return f"{self.id}_{parameter}"
