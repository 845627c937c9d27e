"""Rows of several thrusters as arguments of kernels, whose types other processes must find again."""

import pickle
import subprocess
import sys

import pytest

from thruster_model import thruster_rows
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.thruster_rows import rows_of, thruster


def test_a_row_is_its_thruster_again() -> None:
    own = load_parameter_set("hq").coefficients
    other = own._replace(k_n=2.0 * own.k_n)
    rows = rows_of([own, other])
    assert thruster(rows, 0) == own and thruster(rows, 1) == other


def test_the_type_of_rows_is_found_again_by_another_process() -> None:
    kind = type(rows_of([load_parameter_set("hq").coefficients]).kind)
    assert pickle.loads(pickle.dumps(kind)) is kind
    code = "import pickle, sys; print(pickle.load(sys.stdin.buffer).__name__)"
    told = subprocess.run([sys.executable, "-c", code], input=pickle.dumps(kind), capture_output=True, check=True)
    assert told.stdout.decode().strip() == kind.__name__


def test_the_module_makes_up_no_other_names() -> None:
    with pytest.raises(AttributeError, match="no attribute 'anything'"):
        _ = thruster_rows.anything
