"""The supply of a thruster on a bench, where an autopilot's log has it as its battery."""

from __future__ import annotations

from collections.abc import Sequence

from .guessed_channels import Found
from .guessed_values import moves
from .sources import Source

__all__ = ["supply_of_bench"]

_SUPPLY, _VOLTAGE, _CURRENT = "thruster_0/state.supply_voltage", "rov/battery.voltage", "rov/battery.current"


def supply_of_bench(
    found: Sequence[Found], left: Sequence[tuple[Source, str]]
) -> tuple[list[Found], list[tuple[Source, str]]]:
    """Return channels and what is left, of one thruster without a vehicle with the battery as its supply.

    A battery that was measured goes before what a driver tells of its supply without measuring it. Its current is left:
    nothing reads one.
    """
    by_channel = {each.channel: each for each in found}
    alone = {each.channel.partition("/")[0] for each in found if each.topic != "rov/battery"} == {"thruster_0"}
    battery, driver = by_channel.get(_VOLTAGE), by_channel.get(_SUPPLY)
    measured = battery is not None and moves(battery.source, battery.name)
    if not alone or battery is None or not measured or (driver and moves(driver.source, driver.name)):
        return list(found), list(left)
    gone = [each for each in (driver, by_channel.get(_CURRENT)) if each is not None]
    kept = [each._replace(channel=_SUPPLY) if each == battery else each for each in found if each not in gone]
    return kept, [*left, *((each.source, each.name) for each in gone)]
