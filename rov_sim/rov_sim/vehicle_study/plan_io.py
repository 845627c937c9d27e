"""Plans as YAML files, and as the plain text that lies beside results, goes to workers and is compared when resuming.

title: ...
assumed:
  gain: {value: 2.0, unit: 1/s, reason: ...}
groups:
  flow:
    title: ...
    strategies: [lookup, hq-ekf]
    change: {truth: hq}
    vary: {rate: [25, 100]}
"""

import json
from collections.abc import Mapping
from dataclasses import fields
from functools import lru_cache
from importlib import resources
from pathlib import Path
from typing import Any

from rov_sim.vehicle_study.assumptions import Assumptions, unit_of
from rov_sim.vehicle_study.plan import Assumed, Group, Plan
from safe_files.yaml_io import yaml_mapping

__all__ = ["available_plans", "load_plan", "parse_plan", "plan_of", "plan_text"]

_KEYS = {"title", "strategies", "change", "vary"}


def available_plans() -> tuple[str, ...]:
    """Return the names of the plans that come with the package."""
    folder = resources.files("rov_sim.vehicle_study") / "plans"
    return tuple(sorted(f.name.removesuffix(".yaml") for f in folder.iterdir() if f.name.endswith(".yaml")))


def load_plan(name_or_path: str, seed: int = 1) -> Plan:
    """Return the plan of that name in the package or, failing that, of that YAML file; ValueError with all problems."""
    if name_or_path in available_plans():
        text = (resources.files("rov_sim.vehicle_study") / "plans" / f"{name_or_path}.yaml").read_text("utf-8")
        return parse_plan(text, origin=f"{name_or_path}.yaml", seed=seed)
    path = Path(name_or_path)
    if not path.is_file():
        known = ", ".join(available_plans())
        raise ValueError(f"{path}: expected a YAML file or one of the known plans ({known}); found neither")
    return parse_plan(path.read_text("utf-8"), origin=str(path), seed=seed)


def parse_plan(text: str, *, origin: str, seed: int = 1) -> Plan:
    """Return the plan that a YAML text describes; `origin` names it in errors."""
    document = yaml_mapping(text, lambda where, why: ValueError(f"{where}: {why[0]}"), origin)
    if set(document) != {"title", "assumed", "groups"}:
        raise ValueError(f"{origin}: expected the keys title, assumed and groups; found {document!r:.80}")
    known = [field.name for field in fields(Assumptions)]
    assumed, wrong = {}, _unknown("assumed", document["assumed"], known)
    for name in known:
        entry = document["assumed"].get(name)
        if not isinstance(entry, Mapping) or set(entry) != {"value", "unit", "reason"}:
            wrong.append(f"assumed '{name}': expected value, unit and reason; found {entry!r}")
        elif entry["unit"] != unit_of(name):
            wrong.append(f"assumed '{name}': expected the unit {unit_of(name)!r}; found {entry['unit']!r}")
        else:
            assumed[name] = Assumed(entry["value"], str(entry["reason"]))
    groups = []
    for name, entry in document["groups"].items():
        if not isinstance(entry, Mapping) or not {"title", "strategies"} <= set(entry) <= _KEYS:
            wrong.append(f"group '{name}': expected title, strategies, change, vary; found {entry!r:.80}")
            continue
        change, vary = entry.get("change") or {}, entry.get("vary") or {}
        wrong += _unknown(f"group '{name}'", {**change, **vary}, known)
        varied = {key: tuple(values) for key, values in vary.items()}
        groups.append(
            Group(name=name, title=entry["title"], strategies=tuple(entry["strategies"]), change=change, vary=varied)
        )
    if wrong:
        raise ValueError("\n".join(f"{origin}: {each}" for each in wrong))
    plan = Plan(title=document["title"], assumed=assumed, groups=tuple(groups), seed=seed)
    assert plan.all_cases
    return plan


def plan_text(plan: Plan, contents: Mapping[str, str]) -> str:
    """Return the plan as JSON, the same text for the same plan; `contents`: of all sets that it names."""
    told = {
        "title": plan.title,
        "assumed": {name: list(each) for name, each in plan.assumed.items()},
        "groups": [
            {
                "name": group.name,
                "title": group.title,
                "strategies": list(group.strategies),
                "change": dict(group.change),
                "vary": {name: list(values) for name, values in group.vary.items()},
            }
            for group in plan.groups
        ],
        "seed": plan.seed,
        "contents": dict(contents),
    }
    return json.dumps(told, indent=1)


@lru_cache(maxsize=4)
def plan_of(text: str) -> tuple[Plan, Mapping[str, str]]:
    """Return the plan that such a text describes, and the contents of its sets."""
    told: Mapping[str, Any] = json.loads(text)
    groups = tuple(
        Group(
            name=each["name"],
            title=each["title"],
            strategies=tuple(each["strategies"]),
            change=each["change"],
            vary={name: tuple(values) for name, values in each["vary"].items()},
        )
        for each in told["groups"]
    )
    assumed = {name: Assumed(*each) for name, each in told["assumed"].items()}
    return Plan(title=told["title"], assumed=assumed, groups=groups, seed=told["seed"]), told["contents"]


def _unknown(where: str, found: Mapping[str, Any], known: list[str]) -> list[str]:
    return [f"{where}: expected names among {', '.join(known)}; found {name!r}" for name in found if name not in known]
