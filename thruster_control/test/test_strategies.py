"""The named strategies: what each is made of, that each runs, and what is refused."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from thruster_control.inner_loop import Status
from thruster_control.settings import (
    FlowLaw,
    ForceTableLaw,
    Gains,
    Limits,
    SimplifiedLaw,
    SteadyFlowLaw,
    TableLaw,
    ThrustLaw,
)
from thruster_control.strategies import STRATEGIES, settings_for, strategy
from thruster_control.strategies_io import load_strategy
from thruster_model.errors import ParameterSetError
from thruster_model.parameter_set_io import load_parameter_set

HQ = load_parameter_set("hq").coefficients


def test_the_names_are_the_thesis_strategies_and_the_baselines() -> None:
    observed = {f"{model}-{observer}" for model in ("hl", "hq") for observer in ("ekf", "nlo", "kfnlo")}
    assert (
        set(STRATEGIES) == {"lookup", "simplified", "dead-zone", "steady-flow", "pi-thrust", "force-table"} | observed
    )
    assert all(name == each.name for name, each in STRATEGIES.items())


@pytest.mark.parametrize(
    ("name", "law", "parameter_set", "observer"),
    [
        ("lookup", TableLaw, "simplified", "none"),
        ("simplified", SimplifiedLaw, "simplified", "speed-ekf"),
        ("dead-zone", SimplifiedLaw, "simplified", "speed-ekf"),
        ("steady-flow", SteadyFlowLaw, "kim_chung", "speed-ekf"),
        ("hl-nlo", FlowLaw, "hl", "nlo"),
        ("hq-kfnlo", FlowLaw, "hq", "kfnlo"),
        ("pi-thrust", ThrustLaw, "simplified", "speed-ekf"),
        ("force-table", ForceTableLaw, "force_table", "none"),
    ],
)
def test_each_is_made_of_its_law_its_set_and_its_observer(
    name: str, law: type, parameter_set: str, observer: str
) -> None:
    each = STRATEGIES[name]
    assert (type(each.law), each.parameter_set, each.observer) == (law, parameter_set, observer)


@pytest.mark.parametrize("name", sorted(set(STRATEGIES) - {"force-table"}))
def test_each_gives_the_wanted_sign_of_thrust_on_a_thruster_of_the_hq_model(closed_loop, name: str) -> None:  # type: ignore[no-untyped-def]
    ready = load_strategy(name)
    T_d = np.repeat([6.0, -6.0], 75)
    run = closed_loop(T_d, ready.settings, ready.coefficients, HQ)
    assert set(run.status[1:]) <= {Status.RUNNING, Status.LIMITED}
    assert 2.0 < run.thrust[74] < 9.0 and -9.0 < run.thrust[-1] < -2.0


def test_everything_can_be_changed_and_the_registry_stays_as_it_is() -> None:
    law = FlowLaw(Gains(k_P=8.0), Limits(u_max=2.0))
    ready = load_strategy("hq-ekf", parameter_set="hl_bench", law=law, observer="nlo")
    assert (ready.settings, ready.strategy.observer) == (law, "nlo")
    assert ready.coefficients == load_parameter_set("hl_bench").coefficients
    assert STRATEGIES["hq-ekf"].parameter_set == "hq"
    with pytest.raises(FrozenInstanceError):
        STRATEGIES["hq-ekf"].observer = "nlo"  # type: ignore[misc]


def test_a_lookup_s_own_table_is_kept_and_a_missing_one_made_from_its_set() -> None:
    made = load_strategy("lookup", parameter_set="hl").settings
    kept = load_strategy("lookup", law=made).settings
    assert kept.table is made.table
    assert made.table[1, -1] == pytest.approx(12.17, abs=0.01)


@pytest.mark.parametrize(
    ("name", "changes", "said"),
    [
        ("hq-ukf", {}, "expected one of lookup, simplified"),
        ("hq-ekf", {"observer": "ukf"}, "observer: expected one of none"),
        ("force-table", {"parameter_set": "hq"}, "expected a set with a table of force; found ThrusterCoefficients"),
        ("hq-ekf", {"parameter_set": "kim_chung"}, "expected a set of the thesis' common form; found SteadyFlowCoeff"),
        (
            "steady-flow",
            {"parameter_set": "hq"},
            "expected a parameter set with steady flow; found ThrusterCoefficients",
        ),
        ("pi-thrust", {"parameter_set": "airfoil"}, "expected a set with a thrust map; found AirfoilCoefficients"),
        ("simplified", {"law": SimplifiedLaw(Gains(k_P=-1.0))}, "k_P: expected a finite number"),
    ],
)
def test_what_does_not_go_together_is_refused(name: str, changes, said: str) -> None:  # type: ignore[no-untyped-def]
    with pytest.raises(ValueError, match=said):
        load_strategy(name, **changes)


def test_an_unknown_parameter_set_is_refused() -> None:
    with pytest.raises(ParameterSetError, match="expected a YAML file or one of the known sets"):
        load_strategy("hq-ekf", parameter_set="nowhere")


def test_settings_need_no_file() -> None:
    assert settings_for(strategy("hq-ekf"), HQ) == FlowLaw()
