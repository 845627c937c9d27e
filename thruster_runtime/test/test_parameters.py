import math
from collections.abc import Iterator
from typing import Any

import pytest
from rcl_interfaces.msg import ParameterType
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from thruster_runtime.errors import StartRefused
from thruster_runtime.parameters import FIXED, Parameter, changeable, declare

TABLE = (
    Parameter(name="rate", default=25.0, unit="Hz", lower=0.0, above=True, upper=1000.0, description="rate"),
    Parameter(name="gate", default=math.nan, unit="1", lower=0.0, unset=True, infinite=True, description="gate"),
    Parameter(name="index", default=0, lower=0, upper=7, description="index of the thruster"),
    Parameter(name="kind", default="step", choices=("step", "ramp"), description="kind of set point"),
    Parameter(name="wait", default=True, description="whether to wait"),
)


@pytest.fixture
def declared(context: Context) -> Iterator[Any]:
    nodes = []

    def build(**values: Any) -> tuple[Node, Any]:
        overrides = [RosParameter(name, value=value) for name, value in values.items()]
        nodes.append(Node("subject", context=context, parameter_overrides=overrides))
        return nodes[-1], declare(nodes[-1], TABLE)

    yield build
    for node in nodes:
        node.destroy_node()


def test_defaults_stand_where_nothing_is_given(declared: Any) -> None:
    _, values = declared()
    assert {name: value for name, value in values.items() if name != "gate"} == {
        "rate": 25.0, "index": 0, "kind": "step", "wait": True
    }  # fmt: skip
    assert math.isnan(values["gate"])


def test_given_values_count_and_an_integer_given_for_a_number_is_that_number(declared: Any) -> None:
    node, values = declared(rate=100, gate=math.inf, index=3, kind="ramp", wait=False)
    assert values == {"rate": 100.0, "gate": math.inf, "index": 3, "kind": "ramp", "wait": False}
    assert type(values["rate"]) is float
    assert node.get_parameter("rate").type_ == RosParameter.Type.DOUBLE


def test_the_running_node_tells_description_unit_range_and_type_and_does_not_change_them(declared: Any) -> None:
    node, _ = declared()
    rate, index, kind = (node.describe_parameter(name) for name in ("rate", "index", "kind"))
    assert (rate.description, rate.type) == ("rate [Hz]", ParameterType.PARAMETER_DOUBLE)
    assert rate.additional_constraints == f"a finite number above 0 and up to 1000; {FIXED}"
    assert (rate.floating_point_range[0].from_value, rate.floating_point_range[0].to_value) == (0.0, 1000.0)
    assert (index.integer_range[0].from_value, index.integer_range[0].to_value) == (0, 7)
    assert kind.additional_constraints == f"step, ramp; {FIXED}"
    (answer,) = node.set_parameters([RosParameter("rate", value=50.0)])
    assert (answer.successful, answer.reason) == (False, f"/subject: parameter rate: {FIXED}")
    assert rate.read_only


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"rate": 0.0}, "rate [Hz]: expected a finite number above 0 and up to 1000; found 0.0"),
        ({"rate": 1e9}, "rate [Hz]: expected a finite number above 0 and up to 1000; found 1000000000.0"),
        ({"rate": math.nan}, "rate [Hz]: expected a finite number above 0 and up to 1000; found nan"),
        ({"rate": "fast"}, "rate [Hz]: expected a number; found 'fast'"),
        ({"rate": True}, "rate [Hz]: expected a number; found True"),
        ({"gate": -1.0}, "gate [1]: expected a number from 0, or NaN for none; found -1.0"),
        ({"index": 8}, "index: expected an integer from 0 up to 7; found 8"),
        ({"index": 1.0}, "index: expected an integer; found 1.0"),
        ({"kind": "triangle"}, "kind: expected one of step, ramp; found 'triangle'"),
        ({"wait": 1}, "wait: expected true or false; found 1"),
    ],
    ids=str,
)
def test_a_wrong_value_is_refused_with_node_parameter_expected_and_found(
    declared: Any, wrong: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(StartRefused) as refusal:
        declared(**wrong)
    assert str(refusal.value) == f"/subject: parameter {sentence}"


def test_all_that_is_wrong_is_said_at_once(declared: Any) -> None:
    with pytest.raises(StartRefused) as refusal:
        declared(rate=-1.0, index=9)
    assert [line.split(":")[1] for line in str(refusal.value).split("\n")] == [
        " parameter rate [Hz]",
        " parameter index",
    ]


def test_a_table_with_a_default_that_it_would_refuse_cannot_be_written() -> None:
    with pytest.raises(ValueError, match=r"default of rate: expected a finite number from 1; found 0\.0"):
        Parameter(name="rate", default=0.0, lower=1.0, description="rate")


LIVE = (
    Parameter(name="gain", default=1.0, unit="1/s", lower=0.0, upper=10.0, live=True, description="gain"),
    Parameter(name="bias", default=0.5, lower=0.0, upper=10.0, live=True, description="bias, below the gain"),
    Parameter(name="names", default=("a", "b"), description="a list"),
)


@pytest.fixture
def live(context: Context) -> Iterator[tuple[Node, list[dict[str, Any]]]]:
    node = Node("subject", context=context)
    counted: list[dict[str, Any]] = []

    def change(values: dict[str, Any]) -> tuple[Any, list[str]]:
        wrong = [] if values["bias"] < values["gain"] else [f"bias: expected below the gain; found {values['bias']:g}"]
        return (lambda: counted.append(values)), wrong

    changeable(node, LIVE, declare(node, LIVE), change)
    yield node, counted
    node.destroy_node()


def test_a_live_parameter_changes_by_the_same_rules_and_sentences(live: Any) -> None:
    node, counted = live
    (answer,) = node.set_parameters([RosParameter("gain", value=3)])  # an integer for a number
    assert answer.successful and counted[-1]["gain"] == 3.0 and node.get_parameter("gain").value == 3.0
    for wrong, sentence in (
        (11.0, "gain [1/s]: expected a finite number from 0 up to 10; found 11.0"),
        ("fast", "gain [1/s]: expected a number; found 'fast'"),
        (0.25, "bias: expected below the gain; found 0.5"),
    ):
        (answer,) = node.set_parameters([RosParameter("gain", value=wrong)])
        assert (answer.successful, answer.reason) == (False, f"/subject: parameter {sentence}")
    assert len(counted) == 1 and node.get_parameter("gain").value == 3.0


def test_values_that_contradict_each_other_alone_may_be_changed_together(live: Any) -> None:
    node, counted = live
    both = [RosParameter("bias", value=4.0), RosParameter("gain", value=5.0)]
    assert node.set_parameters_atomically(both).successful
    assert [(each["bias"], each["gain"]) for each in counted] == [(4.0, 5.0)]


def test_a_list_of_texts_is_declared(live: Any) -> None:
    assert list(live[0].get_parameter("names").value) == ["a", "b"]
