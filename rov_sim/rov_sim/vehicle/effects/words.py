"""Effects of a vehicle as words of a command line: EFFECT.PARAMETER=SIZE, EFFECT[TARGET,...].PARAMETER=SIZE.

A target is a thruster T1, T2, … (the second one is `other`), or axis=…, sensor=…, kind=… as the effect has them:

    supply_sag.share=0.1 coulomb_friction[T2].deceleration=60 sensor_lever_arm[sensor=imu,axis=x].offset=0.05
"""

import re
from collections.abc import Iterable
from typing import Any

from rov_sim.vehicle.effects.active import ActiveVehicleEffect

__all__ = ["effects_of_words"]

_WORD = re.compile(r"(\w+)(?:\[([^\]]*)\])?\.(\w+)=(\S+)")


def effects_of_words(words: Iterable[str]) -> tuple[ActiveVehicleEffect, ...]:
    """Return the effects that words name; parameters of the same effect on the same target belong together.

    Raises:
        ValueError: with each word that names none.
    """
    found: dict[tuple[Any, ...], dict[str, float]] = {}
    wrong = []
    for word in words:
        match = _WORD.fullmatch(word)
        targets = None if match is None else _targets(match[2] or "")
        try:
            if match is None or targets is None:
                raise ValueError
            size = float(match[4])
        except ValueError:
            expected = "EFFECT.PARAMETER=SIZE or EFFECT[T2,axis=x].PARAMETER=SIZE with a number as size"
            wrong.append(f"effect {word!r}: expected {expected}")
            continue
        found.setdefault((match[1], *targets.items()), {})[match[3]] = size
    if wrong:
        raise ValueError("; ".join(wrong))
    return tuple(
        ActiveVehicleEffect(id=name, sizes=sizes, **dict(targets)) for (name, *targets), sizes in found.items()
    )


def _targets(text: str) -> dict[str, Any] | None:
    """Return the targets between the brackets, None where they are none."""
    found: dict[str, Any] = {}
    for part in filter(None, text.split(",")):
        name, sign, value = part.partition("=")
        if sign and name in ("axis", "sensor", "kind") and name not in found:
            found[name] = value
        elif re.fullmatch(r"T[1-9]\d*", part) and "other" not in found:
            found["other" if "thruster" in found else "thruster"] = int(part[1:]) - 1
        else:
            return None
    return found
