"""Which cases a scoreboard holds. Those for tuning and those that are reported never meet."""

from dataclasses import dataclass

from gap_diagnosis.scoreboard.case import KINDS

__all__ = ["REPORTED", "SETS", "Planned", "planned"]

REPORTED = 100_000
"""Index from which on cases are reported; those below are for tuning."""
SETS: dict[str, tuple[int, bool, dict[str, int]]] = {
    "smoke": (0, False, {"none": 1, "one": 1, "outside": 1}),
    "quick": (0, False, {"none": 14, "one": 24, "two": 8, "many": 12, "outside": 12}),
    "reported": (REPORTED, True, {"none": 150, "one": 100, "two": 50, "many": 50, "outside": 150}),
}
"""By name: first index, whether recordings have their whole length, and cases per class and generator."""


@dataclass(frozen=True, kw_only=True)
class Planned:
    """One case to be run; `whole`: at full length."""

    generator: str
    kind: str
    index: int
    whole: bool

    @property
    def name(self) -> str:
        """Of the case."""
        return f"{self.generator}-{self.kind}-{self.index:05d}"


def planned(name: str, generators: tuple[str, ...]) -> list[Planned]:
    """Return the cases of a set, classes and generators in turn, so that every prefix has some of each."""
    first, whole, counts = SETS[name]
    cases = [
        (index / counts[kind], Planned(generator=generator, kind=kind, index=first + index, whole=whole))
        for generator in generators
        for kind in KINDS
        for index in range(counts.get(kind, 0))
    ]
    return [case for _, case in sorted(cases, key=lambda entry: entry[0])]
