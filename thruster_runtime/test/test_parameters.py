import math
from collections.abc import Iterator
from typing import Any

import pytest
from rcl_interfaces.msg import ParameterType
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter as RosParameter

from thruster_runtime.errors import StartRefused
from thruster_runtime.parameters import Parameter, declare

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
    assert rate.additional_constraints.startswith("a finite number above 0 and up to 1000; fixed at start")
    assert (rate.floating_point_range[0].from_value, rate.floating_point_range[0].to_value) == (0.0, 1000.0)
    assert (index.integer_range[0].from_value, index.integer_range[0].to_value) == (0, 7)
    assert kind.additional_constraints.startswith("step, ramp; fixed at start")
    assert not any(each.successful for each in node.set_parameters([RosParameter("rate", value=50.0)]))


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
