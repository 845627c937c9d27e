"""Cases of the blind check, drawn from (seed, index, kind) alone: what is hidden and how it is recorded."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gap_diagnosis.blind_check.catalogue import EFFECTS, OUTSIDE, Kind, Spread, acting_in
from gap_diagnosis.blind_check.generator import GeneratedRun, Truth, generate
from gap_diagnosis.blind_check.recording import Colour
from gap_diagnosis.blind_check.signals import POOR, closed_loop_campaign, poor_campaign, rich_campaign

__all__ = ["ALL_CHANNELS", "KINDS", "MODELS", "Case", "Plan", "draw", "plan", "recordings"]

Array = NDArray[np.float64]

KINDS = {
    "effect": 0.5, "none": 0.05, "nuisance": 0.07, "pair": 0.04, "left_out": 0.04, "outside": 0.05, "coloured": 0.02,
    "poor": 0.01, "closed_loop": 0.01, "few_channels": 0.01, "sweep": 0.2,
}  # fmt: skip
"""Kinds of case, with their share of a mixed check. A sweep is an effect down to sizes that nobody can find."""
MODELS = {"hl": 0.7, "hq": 0.2, "simplified": 0.1}
ALL_CHANNELS = ("n", "ambient", "thrust", "torque")

_SPREAD, _CLIP = 0.05, 2.5
_SWEPT_FROM = 0.01  # of the plausible maximum
_UNSEEN_WITHOUT_LOAD = tuple(name for name in EFFECTS if name.startswith("load_cell"))


@dataclass(frozen=True, kw_only=True)
class Plan:
    """One case to be drawn; `effect`, `model`: fixed ones, or drawn."""

    index: int
    kind: str
    effect: str | None = None
    model: str | None = None

    @property
    def name(self) -> str:
        """Name of the case; it tells nothing about what is hidden."""
        return f"case_{self.index:05d}"


@dataclass(frozen=True, kw_only=True)
class Case:
    """What is hidden in a case.

    Attributes:
        seed, plan: what it was drawn from.
        model: hl, hq or simplified.
        effects, outside: sizes by id and parameter, of the library's effects and of others.
        excluded: effects taken out of the diagnosis' library.
        factors: true over nominal parameter, by name.
        excitation: rich, closed_loop, or one of `signals.POOR`.
        channels: that are recorded besides the throttle.
        colour: coloured disturbances, or none.
    """

    seed: int
    plan: Plan
    model: str
    effects: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    outside: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    excluded: tuple[str, ...] = ()
    factors: Mapping[str, float]
    excitation: str = "rich"
    channels: tuple[str, ...] = ALL_CHANNELS
    colour: Colour | None = None

    def described(self) -> dict[str, Any]:
        """Return the content as JSON-able values."""
        colour = self.colour
        return {
            "case": self.plan.name,
            "seed": self.seed,
            "kind": self.plan.kind,
            "model": self.model,
            "effects": {name: dict(sizes) for name, sizes in self.effects.items()},
            "outside": {name: dict(sizes) for name, sizes in self.outside.items()},
            "excluded": list(self.excluded),
            "factors": dict(self.factors),
            "excitation": self.excitation,
            "channels": list(self.channels),
            "colour": None
            if colour is None
            else {"outputs": colour.outputs, "rotor": colour.rotor, "memory": colour.memory},
        }


def plan(
    count: int,
    seed: int,
    *,
    kinds: Sequence[str] = (),
    effects: Sequence[str] = (),
    model: str | None = None,
) -> list[Plan]:
    """Return the cases of a check: kinds in their shares in every prefix, effects in turn, each round in another order.

    Args:
        count: number of cases.
        seed: of the order of effects.
        kinds: kinds to choose from; empty: all.
        effects: effects of the library to play with; empty: all.
        model: a fixed model, or drawn for each case.

    Raises:
        ValueError: an unknown kind, effect or model.
    """
    shares = {kind: KINDS[kind] for kind in _known(kinds, KINDS, "kind")}
    pool = [name for name in _known(effects, EFFECTS, "effect") if model is None or model not in EFFECTS[name].inert_in]
    if model is not None:
        _known((model,), MODELS, "model")
    rng = np.random.default_rng([seed, 1])
    queues: dict[str, list[str]] = {}
    done = dict.fromkeys(shares, 0)
    total = sum(shares.values())
    plans = []
    for index in range(count):
        kind = max(shares, key=lambda k: shares[k] / total * (index + 1) - done[k])
        done[kind] += 1
        effect = None
        if kind in ("effect", "sweep", "left_out", "outside"):
            queue = queues.setdefault(kind, [])
            if not queue:
                queue += [str(name) for name in rng.permutation(_choice_of(kind, pool, model))]
            effect = queue.pop()
        plans.append(Plan(index=index, kind=kind, effect=effect, model=model))
    return plans


def _choice_of(kind: str, pool: Sequence[str], model: str | None) -> list[str]:
    if kind == "outside":
        return [name for name in OUTSIDE if model is None or model not in OUTSIDE[name].inert_in]
    return [name for name in pool if kind != "left_out" or not EFFECTS[name].twins]


def _known(given: Sequence[str], table: Mapping[str, Any], what: str) -> tuple[str, ...]:
    unknown = [name for name in given if name not in table]
    if unknown:
        raise ValueError(f"{what}: expected {', '.join(table)}; found {', '.join(unknown)}")
    return tuple(given) or tuple(table)


def draw(plan: Plan, seed: int, nominal: Mapping[str, Mapping[str, float]]) -> Case:
    """Return the case of a plan.

    Args:
        plan: which one.
        seed: of the check.
        nominal: parameters of the simulator's set by model and name.
    """
    rng = np.random.default_rng([seed, 2, plan.index, list(KINDS).index(plan.kind)])
    kind = plan.kind
    table = OUTSIDE if kind == "outside" else EFFECTS
    model = plan.model or _model(rng, table[plan.effect].inert_in if plan.effect else (), kind)
    names = [plan.effect] if plan.effect else _names(kind, model, rng)
    shifted = ("throttle", "speed", *(("flow",) if model != "simplified" else ()))  # no flow there to be late
    shifted += ("load",) if kind != "few_channels" else ()
    sizes = {name: _sizes(name, table[name], shifted, rng, sweep=kind == "sweep") for name in names}
    spread = {name: 1.0 + _SPREAD * _clipped_normal(rng) for name in nominal[model] if name != "u_dot_max"}
    colour = None
    if kind == "coloured":
        colour = Colour(
            outputs=float(rng.uniform(0.5, 2.0)),
            rotor=float(rng.uniform(10.0, 50.0)),
            memory=float(rng.uniform(0.3, 1.0)),
        )
    return Case(
        seed=seed,
        plan=plan,
        model=model,
        effects={} if kind == "outside" else sizes,
        outside=sizes if kind == "outside" else {},
        excluded=tuple(names) if kind == "left_out" else (),
        factors=dict.fromkeys(spread, 1.0) if kind == "none" else spread,
        excitation=str(rng.choice(POOR)) if kind == "poor" else "closed_loop" if kind == "closed_loop" else "rich",
        channels=("n", "ambient") if kind == "few_channels" else ALL_CHANNELS,
        colour=colour,
    )


def _model(rng: np.random.Generator, inert: tuple[str, ...], kind: str) -> str:
    shares = {m: s for m, s in MODELS.items() if m not in inert and not (kind == "few_channels" and m == "simplified")}
    total = sum(shares.values())
    return str(rng.choice(list(shares), p=[share / total for share in shares.values()]))


def _names(kind: str, model: str, rng: np.random.Generator) -> list[str]:
    """Return the effects of a case whose plan names none."""
    pool = list(acting_in(model, EFFECTS))
    if kind == "pair":
        first, second = (str(name) for name in rng.choice(pool, 2, replace=False))
        while second in EFFECTS[first].twins or first in EFFECTS[second].twins or second == first:
            second = str(rng.choice(pool))
        return [first, second]
    shares = {"coloured": 0.5, "poor": 0.5, "closed_loop": 0.75, "few_channels": 0.75, "effect": 1.0, "sweep": 1.0}
    if rng.random() >= shares.get(kind, 0.0):
        return []
    if kind == "few_channels":
        pool = [name for name in pool if name not in _UNSEEN_WITHOUT_LOAD]
    return [str(rng.choice(pool))]


def _sizes(
    name: str, kind: Kind, shifted: tuple[str, ...], rng: np.random.Generator, *, sweep: bool
) -> dict[str, float]:
    """Return the sizes of an effect; `shifted`: the channels of which one may have late stamps."""
    size = kind.size
    if sweep and size.law == "log" and not size.falls:
        size = replace(size, lower=_SWEPT_FROM * size.upper)
    if name == "log_alignment":
        return {str(rng.choice(shifted)): _one(size, rng)}
    return {spread.name: _one(spread, rng) for spread in (size, *kind.more)}


def _one(spread: Spread, rng: np.random.Generator) -> float:
    share = float(rng.random())
    if spread.law == "log":
        value = math.exp(math.log(spread.lower) + share * math.log(spread.upper / spread.lower))
    else:
        value = spread.lower + share * (spread.upper - spread.lower)
    if not spread.signed or rng.random() < 0.5:
        return value
    return -value * (1.0 if spread.most_negative is None else spread.most_negative / spread.upper)


def _clipped_normal(rng: np.random.Generator) -> float:
    return float(np.clip(rng.standard_normal(), -_CLIP, _CLIP))


def recordings(case: Case, nominal: Mapping[str, Mapping[str, float]]) -> list[GeneratedRun]:
    """Return the recordings of a case, the same ones each time."""
    parameters = {name: value * case.factors.get(name, 1.0) for name, value in nominal[case.model].items()}
    truth = Truth(
        model=case.model, parameters=parameters, effects=case.effects, outside=case.outside, colour=case.colour
    )
    rng = np.random.default_rng([case.seed, 3, case.plan.index])
    if case.excitation == "rich":
        programme = rich_campaign(rng)
    elif case.excitation == "closed_loop":
        programme = closed_loop_campaign(rng)
    else:
        programme = poor_campaign(case.excitation, rng)
    seed = int(rng.integers(2**63))
    return generate(truth, programme, closed_loop=case.excitation == "closed_loop", seed=seed)
