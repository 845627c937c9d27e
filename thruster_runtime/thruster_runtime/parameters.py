"""Declare a node's parameters from a table of specifications; refuse wrong ones with all that is wrong, in sentences.

The default is written once, in the table; whoever looks at the running node sees description, unit and range. A node's
core is built from the values, complete. Those marked `live` may be changed while the node runs: the new ones are
checked by the same rules, and the core that they make replaces the present one; the others are fixed at start.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import inf, isfinite, isnan
from typing import Any

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor, SetParametersResult
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from thruster_runtime.errors import StartRefused

__all__ = ["Parameter", "changeable", "declare", "refused"]

FIXED = "fixed at start, as the node is built from it: start it anew with another value"

_KINDS = {bool: "true or false", int: "an integer", float: "a number", str: "a text", tuple: "a list of texts"}


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """One parameter of a node.

    Attributes:
        name: identifier.
        default: of type bool, int, float, str or tuple of str (not empty), which is the parameter's type.
        description: in words, without the unit.
        unit: "" for none.
        lower, upper: what is allowed, both included.
        above: whether `lower` itself is not allowed.
        unset: whether NaN is allowed, for "not given".
        infinite: whether infinity is allowed.
        choices: what a text may be; empty: any.
        live: whether it may be changed while the node runs.
    """

    name: str
    default: bool | int | float | str | tuple[str, ...]
    description: str
    unit: str = ""
    lower: float = -inf
    upper: float = inf
    above: bool = False
    unset: bool = False
    infinite: bool = False
    choices: tuple[str, ...] = ()
    live: bool = False

    def __post_init__(self) -> None:
        if problem := self.problem(self.default):
            raise ValueError(f"default of {problem}")

    def problem(self, value: Any) -> str:
        """Return what is wrong with a value as a sentence, "" where nothing is."""
        kind = type(self.default)
        if kind is tuple:
            texts = isinstance(value, (list, tuple)) and all(type(each) is str for each in value)
            return "" if texts else self._expected(_KINDS[tuple], value)
        numeric = kind in (int, float) and type(value) in (int, kind)
        if not (numeric or type(value) is kind):
            return self._expected(_KINDS[kind], value)
        if self.choices and value not in self.choices:
            return self._expected(f"one of {', '.join(self.choices)}", value)
        if not numeric or (isnan(value) and self.unset):
            return ""
        finite = isfinite(value) or (self.infinite and abs(value) == inf)
        low = value <= self.lower if self.above else value < self.lower
        if not finite or low or value > self.upper:
            return self._expected(self._numbers(), value)
        return ""

    def _expected(self, what: str, value: Any) -> str:
        unit = f" [{self.unit}]" if self.unit else ""
        return f"{self.name}{unit}: expected {what}; found {value!r}"

    def _numbers(self) -> str:
        kind = "an integer" if type(self.default) is int else ("a number" if self.infinite else "a finite number")
        low = f" above {self.lower:g}" if self.above else (f" from {self.lower:g}" if self.lower > -inf else "")
        high = f"{' and' if self.above else ''} up to {self.upper:g}" if self.upper < inf else ""
        return kind + low + high + (", or NaN for none" if self.unset else "")

    @property
    def expected(self) -> str:
        """What is allowed, in words, without the unit."""
        if self.choices:
            return f"one of {', '.join(each or '(empty)' for each in self.choices)}"
        return self._numbers() if type(self.default) in (int, float) else _KINDS[type(self.default)]

    @property
    def descriptor(self) -> ParameterDescriptor:
        """What the running node says about it; rclpy's ranges hold bounds that are allowed, and no NaN."""
        unit = f" [{self.unit}]" if self.unit else ""
        allowed = ", ".join(self.choices) or (self._numbers() if type(self.default) is float else "")
        described = ParameterDescriptor(
            name=self.name,
            description=f"{self.description}{unit}",
            additional_constraints="; ".join(words for words in (allowed, "" if self.live else FIXED) if words),
            read_only=not self.live,
        )
        if type(self.default) is int and isfinite(self.lower) and isfinite(self.upper):
            described.integer_range = [IntegerRange(from_value=int(self.lower), to_value=int(self.upper))]
        if type(self.default) is float and not self.unset and isfinite(self.lower) and isfinite(self.upper):
            described.floating_point_range = [FloatingPointRange(from_value=self.lower, to_value=self.upper)]
        return described


def declare(node: Node, parameters: Iterable[Parameter]) -> Mapping[str, Any]:
    """Declare the parameters and return their values by name; an integer given for a number is that number.

    Raises:
        StartRefused: with the node's name and one sentence for each parameter that is wrong.
    """
    found, problems, table = {}, [], {each.name: each for each in parameters}
    for each in table.values():
        value = node.declare_parameter(each.name, each.default, ParameterDescriptor(dynamic_typing=True)).value
        if problem := each.problem(value):
            problems.append(problem)
            continue
        found[each.name] = type(each.default)(value)
        node.set_parameters([RosParameter(each.name, value=found[each.name])])
        described = each.descriptor
        described.type = RosParameter.Type.from_parameter_value(found[each.name]).value
        node.set_descriptor(each.name, described)
    if problems:
        raise refused(node, problems)
    _speak_plainly(node, table)
    return found


def _speak_plainly(node: Node, table: Mapping[str, Parameter]) -> None:
    """Let whoever sets a parameter of the running node get our sentences, and give an integer for a number."""

    def as_declared(given: list[RosParameter]) -> list[RosParameter]:
        numbers = [
            type(each.value) is int and type(getattr(table.get(each.name), "default", "")) is float for each in given
        ]
        return [
            RosParameter(each.name, value=float(each.value)) if number else each
            for each, number in zip(given, numbers, strict=True)
        ]

    plain = node._apply_descriptor

    def apply(
        parameter: RosParameter, descriptor: ParameterDescriptor | None = None, check_read_only: bool = True
    ) -> SetParametersResult:
        result = plain(parameter, descriptor, check_read_only)
        if not result.successful and (each := table.get(parameter.name)):
            problem = each.problem(parameter.value) or f"{each.name}: {FIXED}"
            result.reason = f"{node.get_fully_qualified_name()}: parameter {problem}"
        return result

    node._apply_descriptor = apply
    node.add_pre_set_parameters_callback(as_declared)


def changeable(
    node: Node,
    parameters: Iterable[Parameter],
    values: Mapping[str, Any],
    change: Callable[[dict[str, Any]], tuple[Callable[[], None], list[str]]],
) -> None:
    """Let the live ones of a node's declared parameters be changed while it runs.

    Args:
        node: has them.
        parameters: all of its table.
        values: as `declare` returned them.
        change: gets all values as they would be, and returns what makes them count, and a sentence for each
            contradiction; nothing changes where there is one.
    """
    table = {each.name: each for each in parameters}
    now = dict(values)
    ready: list[tuple[dict[str, Any], Callable[[], None]]] = []

    def check(given: list[RosParameter]) -> SetParametersResult:
        mine = [each for each in given if each.name in table]
        if not mine:
            return SetParametersResult(successful=True)
        problems = [problem for each in mine if (problem := table[each.name].problem(each.value))]
        if not problems:
            wanted = {**now, **{each.name: type(table[each.name].default)(each.value) for each in mine}}
            apply, problems = change(wanted)
            ready[:] = [(wanted, apply)]
        name = node.get_fully_qualified_name()
        reason = "; ".join(f"{name}: parameter {problem}" for problem in problems)
        return SetParametersResult(successful=not problems, reason=reason)

    def count(given: list[RosParameter]) -> None:
        if ready and any(each.name in table for each in given):
            wanted, apply = ready.pop()
            now.update(wanted)
            apply()

    node.add_on_set_parameters_callback(check)
    node.add_post_set_parameters_callback(count)


def refused(node: Node, problems: Sequence[str]) -> StartRefused:
    """Return the refusal of a node with one line for each thing that is wrong with its parameters."""
    name = node.get_fully_qualified_name()
    return StartRefused("\n".join(f"{name}: parameter {problem}" for problem in problems))
