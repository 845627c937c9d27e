"""An effect that a vehicle set switches on: which one, how large, and what part of the vehicle it is about.

What effects there are and which target each takes is known where the vehicle is simulated; here is only the entry.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

__all__ = ["EffectEntry"]


@dataclass(frozen=True, kw_only=True)
class EffectEntry:
    """One effect with the sizes of its parameters.

    Attributes:
        id: of the vehicle's or of the thrusters' library.
        sizes: by parameter, in its unit; what is not named is neutral.
        thruster: index of the thruster it is about, from 0; None: all, or none in particular.
        other: index of the second thruster of a pair.
        axis: such as `surge`, or two of them, `surge-pitch`, for a coupling.
        sensor: such as `imu`.
        kind: where an effect has several.
        units: of the sizes, as stated.
    """

    id: str
    sizes: Mapping[str, float] = field(default_factory=dict)
    thruster: int | None = None
    other: int | None = None
    axis: str | None = None
    sensor: str | None = None
    kind: str | None = None
    units: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        sizes = {str(name): float(value) for name, value in self.sizes.items()}
        object.__setattr__(self, "sizes", MappingProxyType(sizes))
        object.__setattr__(self, "units", MappingProxyType(dict(self.units)))
