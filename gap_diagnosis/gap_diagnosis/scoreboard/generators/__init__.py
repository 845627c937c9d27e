"""The generators of the scoreboard by name."""

from gap_diagnosis.scoreboard.case import Generator
from gap_diagnosis.scoreboard.generators import lab, propeller, tank

__all__ = ["GENERATORS"]

GENERATORS: dict[str, Generator] = {g.name: g for g in (tank.GENERATOR, lab.GENERATOR, propeller.GENERATOR)}
