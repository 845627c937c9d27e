"""What an unmodelled effect is: one definition, which the simulator switches on and a diagnosis can suspect.

It acts in one of three ways: in the plant, by hooks in the stages of its pipeline; on the command or on what a sensor
reads, sample by sample with a memory of its own; or on the log, on stamps and values that have been recorded.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

__all__ = [
    "AGAINST",
    "ON_COMMAND",
    "ON_SENSOR",
    "STAGES",
    "SUDDEN",
    "WITH",
    "Block",
    "Effect",
    "EffectParameter",
    "Search",
    "Suspected",
    "Trace",
    "check_suspected",
    "size_problems",
]

Block = Literal["log", "command", "rotor", "thrust", "flow", "sensor"]
Search = Literal["slope", "fine", "stairs", "command_lattice", "reading_lattice", "limit", "gates", "turns", "log"]
"""How the sizes of an effect are found in recordings.

slope            by its slope, from the best of a few
fine             its predictions change within a fraction of the distance between these: searched more finely first
stairs           its predictions jump as its size grows: searched, no slope leads there
command_lattice  the step of the command's converter: searched among all that the commands make likely
reading_lattice  the step of a sensor's converter: likewise
limit            one of the command: shares of the largest one recorded
gates            it comes and goes by a state that nothing predicts: when, is read from the recordings
turns            by its slope; but it ends as an unmeasured flow turns, and pushes move that instant by as much as that
                 takes: when, is read from the recordings where they tell
log              it has no trace in predictions: the log betrays it, see `Trace`
"""
Trace = Literal["", "repeats", "spikes", "zeros", "lattice", "stamps"]
"""What an effect does to a log: samples repeated, spikes, readings of exactly zero, of one step's multiples, stamps."""

STAGES: dict[str, tuple[str, ...]] = {
    "ramp": ("u_dot_max", "e"),
    "lag": ("lag", "u", "command", "e"),
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
    "step": ("step", "n", "n_dot", "v", "v_dot", "e"),
    "late": ("late", "step", "e"),
}
"""Where the plant's pipeline lets effects in, and the arguments of a hook there; it returns the first, changed or not.

ramp             rate limit of the acting throttle [V/s]
lag              time constant with which it, u [V], follows the command [V], within that limit [s]
edges            dead-zone edges (delta_u1, delta_u2) [V]; n: rotor speed [rad/s]
drive            gamma(u) [rad/s^2] at the nominal supply; heat: of the motor, 0 to 1; supply: its relative voltage
inflow           ambient flow that reaches thruster and instrument [m/s]
approach         the part of that flow which the propeller meets [m/s]; the instrument still measures all of it
loads            (thrust [N], torque [N m]); v: axial flow [m/s]; gate: 0 while the propeller may draw air, else 1 (or
                 `WITH`, `AGAINST`)
rotor            dn/dt [rad/s^2]
thrust_dynamics  thrust [N], once dn/dt is known
axial, ambient   dv/dt, dU/dt [m/s^2]; past: the ambient flow `memory` seconds ago [m/s]; force: thrust [N]
heat             heat of the motor after dt [s] at the acting throttle u [V]
memory           how far back `past` lies [s]
step             the longest step [s] that integrates from n and v, at most the one given; n_dot, v_dot: how fast these
                 change, infinite where anything may follow
late             how long into each step [s] the command of the step before is still held
"""

WITH, AGAINST = 2.0, -1.0
"""Gates that say whether the propeller works with the flow through it or against it; under others the states do."""
SUDDEN = 2.0
"""By how much faster rotor and flow may change than they did at first, where a `step` begins."""
ON_COMMAND = ("memory", "u", "step", "e")
"""Arguments of `Effect.sample` on the command [V], once every `step` [s]; it returns what reaches the plant [V]."""
ON_SENSOR = ("memory", "x", "outputs", "step", "e")
"""Arguments of `Effect.sample` on a reading x, once every `step` [s]; `outputs`: `effects.chains.Outputs`."""


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
class Suspected:
    """How a diagnosis of a vehicle suspects an effect: on everything that it can act on, unless this says otherwise.

    Attributes:
        sizes: by parameter that is fitted, the deviation expected of it and the size by which it is probed; none: the
            effect is either on, at `fixed`, or off.
        fixed: the other parameters, where not neutral.
        about: by parameter that is fitted beside the first one, the value about which it is looked for.
        lower: by parameter, where its range begins, if not where it does otherwise.
        grid: sizes to begin at where the neutral one is infinite.
        carries: whether the first parameter, a mass at a place, multiplies the later ones.
        only: by target, what it is suspected on; None among them: on all at once.
        places: from a vehicle set, what it is suspected on in that vehicle, in place of all that.
        alike: whether a pair of thrusters is the same the other way round.
        flowing: whether only thrusters that have an axial flow can have it.
        read_by: sensor without which it cannot be shown.
        told_by: by parameter, sensors of which one must be there for it to be fitted; any, where not named.
        watched: sizes of its first parameter that a watch follows on line: a failure that may begin in mid-dive.
        begins: whether it may begin in mid-dive although no watch follows it.
        sudden: size from half of which on a watch looks for it as a jump within one reading of `read_by`; a diagnosis
            does not look for it then. 0: no jump.
        tolerance: deviation of its only parameter where nothing is wrong, as things are calibrated and mounted by hand;
            0: there it is exact.
    """

    sizes: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)
    about: Mapping[str, float] = field(default_factory=dict)
    lower: Mapping[str, float] = field(default_factory=dict)
    grid: tuple[float, ...] = ()
    carries: bool = False
    only: Mapping[str, tuple[str | None, ...]] = field(default_factory=dict)
    places: Callable[[Any], Iterable[Mapping[str, Any]]] | None = None
    alike: bool = False
    flowing: bool = False
    read_by: str = ""
    told_by: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    watched: tuple[float, ...] = ()
    begins: bool = False
    sudden: float = 0.0
    tolerance: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Effect:
    """An unmodelled effect.

    Attributes:
        id: identifier.
        title: what it is physically, in words.
        block: where it enters.
        equation: as a formula.
        parameters: its sizes; the first one is zero (or neutral) exactly where there is no effect.
        note: what title, equation and sizes leave open, as a sentence for the reference.
        hooks: by stage of the plant, functions of that stage's arguments.
        sample: what it does to a sample of the command or of a sensor, see `ON_COMMAND`, `ON_SENSOR`.
        floats: how many floats of memory that takes, from (step, e); all zero before the first sample.
        begin: of the command, (memory, u, step, e): sets the memory as if u [V] had come out for long.
        draws: whether it scatters: the first float of its memory is then the seed, 0 for none.
        logged: what it does to what is recorded: (signal, stamps, values, rng, sizes by name) to (stamps, values).
        taken: when samples with these stamps were taken: (signal, stamps, sizes by name) to stamps; for effects of the
            log that do not scatter.
        channel: the signals whose sensor or log it concerns, separated by spaces; "" where it concerns none or any.
        reads: a signal that it takes beside those; without it in a model it changes nothing. "" where it takes none.
        order: place in the chain of its block or stage; the lower first, by identifier where equal.
        twins: effects that no data can tell from this one; "id:channel" where they concern several channels.
        search: how its sizes are found.
        tries: how many sizes of each parameter are tried first; where it is empty, a few.
        jumps: whether predictions jump as a state passes a threshold.
        apart: whether each parameter is an effect of its own, on the channel of its name.
        steady: whether it shows in steady states, and is not one of time.
        trace: what it does to a log.
        entails: effects that its log shows as well.
        suspected: how a diagnosis of a vehicle suspects it; nothing: not at all.
    """

    id: str
    title: str
    block: Block
    equation: str
    parameters: tuple[EffectParameter, ...]
    note: str = ""
    hooks: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    sample: Callable[..., Any] | None = None
    floats: Callable[..., Any] | None = None
    begin: Callable[..., Any] | None = None
    draws: bool = False
    logged: Callable[..., Any] | None = None
    taken: Callable[..., Any] | None = None
    channel: str = ""
    reads: str = ""
    order: int = 0
    twins: tuple[str, ...] = ()
    search: Search = "slope"
    tries: tuple[int, ...] = ()
    jumps: bool = False
    apart: bool = False
    steady: bool = True
    trace: Trace = ""
    entails: tuple[str, ...] = ()
    suspected: tuple[Suspected, ...] = ()

    def __post_init__(self) -> None:
        unknown = set(self.hooks) - set(STAGES)
        if unknown or not self.parameters or not (self.hooks or self.sample or self.logged):
            raise ValueError(f"{self.id}: expected parameters and hooks, sample or logged; unknown stages {unknown}")
        if (self.logged is not None) != (self.block == "log"):
            raise ValueError(f"{self.id}: expected logged for an effect of the log, and for no other")
        check_suspected(self.id, self.parameters, self.suspected)

    def field_of(self, parameter: str) -> str:
        """Return the name of a parameter's field in `EffectValues`."""
        return f"{self.id}_{parameter}"


def check_suspected(effect: str, parameters: Iterable[EffectParameter], suspected: Iterable[Suspected]) -> None:
    """Raise a ValueError where an effect is suspected by sizes that are none of its parameters."""
    known = {p.name for p in parameters}
    for each in suspected:
        unknown = {*each.sizes, *each.fixed, *each.lower, *each.about} - known
        if unknown or not (each.sizes or each.fixed):
            found = f"found {', '.join(sorted(unknown)) or 'none'}"
            raise ValueError(f"{effect}: suspected: expected parameters among {', '.join(sorted(known))}; {found}")


def size_problems(effect: str, parameters: Iterable[EffectParameter], sizes: Mapping[str, float]) -> list[str]:
    """Return what is wrong with the sizes of an effect, one sentence each: unknown names, sizes beyond the range."""
    key, problems = f"key 'effects.{effect}", []
    definitions = {p.name: p for p in parameters}
    for name, value in sizes.items():
        if name not in definitions:
            problems.append(f"{key}': expected parameters {', '.join(definitions)}; found '{name}'")
            continue
        d = definitions[name]
        lowest = -d.upper if d.both_signs else d.lower
        if not (value == d.neutral or lowest <= value <= d.upper):
            expected = f"expected {d.neutral:g} or {lowest:g} to {d.upper:g} {d.unit}"
            problems.append(f"{key}.{name}': {expected}; found {value!r}")
    return problems
