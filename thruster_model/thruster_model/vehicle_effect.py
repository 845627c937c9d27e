"""An effect that is switched on in a vehicle: which one, how large, and what part of the vehicle it is about.

What effects there are and which target each takes is known where the vehicle is simulated; here is only the entry.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

__all__ = ["ActiveVehicleEffect"]


@dataclass(frozen=True, kw_only=True)
class ActiveVehicleEffect:
    """One effect with the sizes of its parameters.

    Attributes:
        id: of the vehicle's or of the thrusters' library.
        sizes: by parameter, in its unit; what is not named is neutral.
        thruster: index of the thruster it is about, from 0; None: all, or none in particular.
        other: index of the second thruster of a pair.
        axis: such as `surge`, or two of them, `surge-pitch`, for a coupling.
        sensor: such as `imu`.
        kind: where an effect has several.
    """

    id: str
    sizes: Mapping[str, float] = field(default_factory=dict)
    thruster: int | None = None
    other: int | None = None
    axis: str | None = None
    sensor: str | None = None
    kind: str | None = None

    def __post_init__(self) -> None:
        sizes = {str(name): float(value) for name, value in self.sizes.items()}
        object.__setattr__(self, "sizes", MappingProxyType(sizes))

    @property
    def words(self) -> str:
        """The effect and its target, for sentences."""
        parts = [self.id, self.kind, self.sensor, self.axis]
        parts += [f"thruster {i}" for i in (self.thruster, self.other) if i is not None]
        return " ".join(part for part in parts if part)
