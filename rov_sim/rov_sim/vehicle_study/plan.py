"""A study's plan: what is assumed, why, and the cases in which strategies are compared."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product
from typing import Any, NamedTuple

from rov_sim.vehicle_study.assumptions import Assumptions

__all__ = ["ON_TABLE_3_1", "STRATEGIES", "Assumed", "Case", "Group", "Plan", "seen_by"]

STRATEGIES = (
    "lookup", "dead-zone", "simplified", "hl-ekf", "hl-nlo", "hl-kfnlo", "hq-ekf", "hq-nlo", "hq-kfnlo", "steady-flow",
)  # fmt: skip
"""Strategies of the two comparisons."""
ON_TABLE_3_1 = ("lookup", "simplified", "dead-zone")
"""Strategies that the thesis gives Table 3.1, whatever the truth; no inflow enters them."""


class Assumed(NamedTuple):
    """A value and the reason for it."""

    value: Any
    reason: str


class Case(NamedTuple):
    """A case: its name, the group it belongs to, and what it assumes."""

    name: str
    group: str
    assumptions: Assumptions


@dataclass(frozen=True, kw_only=True)
class Group:
    """Cases in which the same strategies are compared.

    Attributes:
        name: identifier; title: in words.
        strategies: of `STRATEGIES`.
        change: what differs from the plan's assumptions; vary: values of which each combination is a case.
    """

    name: str
    title: str
    strategies: tuple[str, ...]
    change: Mapping[str, Any]
    vary: Mapping[str, tuple[Any, ...]]


@dataclass(frozen=True, kw_only=True)
class Plan:
    """A study.

    Attributes:
        title: in words.
        assumed: value and reason of each field of `Assumptions`.
        groups: of cases.
        seed: of the study: with one seed all strategies of all cases meet the same factors and the same draws.
    """

    title: str
    assumed: Mapping[str, Assumed]
    groups: tuple[Group, ...]
    seed: int = 1

    def __post_init__(self) -> None:
        names = [group.name for group in self.groups]
        wrong = [
            f"groups: expected one '{name}'; found two" for name in sorted({n for n in names if names.count(n) > 1})
        ]
        for group in self.groups:
            wrong += [
                f"group '{group.name}': expected strategies among {', '.join(STRATEGIES)}; found {s!r}"
                for s in group.strategies
                if s not in STRATEGIES
            ]
            both = sorted(set(group.change) & set(group.vary))
            wrong += [f"group '{group.name}': expected {name} to be changed or varied; found both" for name in both]
        if not self.groups:
            wrong.append("groups: expected at least one; found none")
        if wrong:
            raise ValueError("plan: " + "; ".join(wrong))

    def cases(self, group: Group) -> tuple[Case, ...]:
        """Return the cases of a group; ValueError where one assumes what cannot be."""
        found = []
        for values in product(*group.vary.values()):
            varied = dict(zip(group.vary, values, strict=True))
            told = {name: given.value for name, given in self.assumed.items()} | dict(group.change) | varied
            name = "-".join([group.name, *(f"{key}_{_word(value)}" for key, value in varied.items())])
            try:
                found.append(Case(name, group.name, Assumptions(**told)))
            except (TypeError, ValueError) as error:
                raise ValueError(f"group '{group.name}': {error}") from error
        return tuple(found)

    def typical(self, group: Group) -> Case:
        """Return the case of a group that assumes most of what the plan assumes."""
        cases = self.cases(group)
        agreed = [sum(getattr(c.assumptions, k) == a.value for k, a in self.assumed.items()) for c in cases]
        return cases[agreed.index(max(agreed))]

    def computed_as(self, strategy: str, case: Case) -> str:
        """Return the first case of the plan in which the strategy runs as in this one: it is computed there alone."""
        cases = [each for group in self.groups if strategy in group.strategies for each in self.cases(group)]
        wanted = seen_by(strategy, case.assumptions)
        return next(each.name for each in cases if seen_by(strategy, each.assumptions) == wanted)

    @property
    def all_cases(self) -> Mapping[str, Case]:
        """All cases by name."""
        return {case.name: case for group in self.groups for case in self.cases(group)}


def seen_by(strategy: str, given: Assumptions) -> Assumptions:
    """Return the assumptions with a neutral value for what makes no difference to a strategy."""
    if strategy != "dead-zone":
        given = replace(given, speed_gain=1.0)
    if strategy not in ON_TABLE_3_1:
        return replace(given, beliefs="published")
    given = replace(given, inflow="kinematic")
    return replace(given, observers="told") if strategy in ("lookup", "dead-zone") else given


def _word(value: Any) -> str:
    text = f"{value:g}" if isinstance(value, int | float) else str(value)
    return text.replace(".", "p")
