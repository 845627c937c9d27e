"""Thrusters as rows: each is itself again, and the kernels that were compiled for them are found by other processes."""

import subprocess
import sys

import numpy as np
import pytest

from thruster_model import thruster_rows
from thruster_model.parameter_set_io import load_parameter_set
from thruster_model.thruster_rows import rows_of, thruster

SETS = ("hq", "table")
TYPE = (
    "import sys; import numba; from numba.core import serialize;"
    "from thruster_model.parameter_set_io import load_parameter_set as load;"
    "from thruster_model.thruster_rows import rows_of;"
    "own = [numba.typeof(rows_of([load(name).coefficients] * 2)) for name in sys.argv[1:]];"
)


@pytest.mark.parametrize("name", SETS)
def test_a_thruster_of_the_rows_is_the_one_that_was_given(name):
    first = load_parameter_set(name).coefficients
    second = first._replace(**{first._fields[0]: 2.0 * np.asarray(first[0])})
    rows = rows_of([first, second])
    for i, given in enumerate((first, second)):
        found = thruster(rows, i)
        assert type(found) is type(given)
        for a, b in zip(found, given, strict=True):
            np.testing.assert_array_equal(a, b)


def test_the_type_of_rows_that_another_process_has_written_is_the_same_type_here():
    """Numba finds a compiled kernel by it: were it another one, each process would compile for itself."""
    write = subprocess.run(
        [sys.executable, "-c", TYPE + "sys.stdout.buffer.write(serialize.dumps(own))", *SETS],
        capture_output=True, check=True, timeout=300,
    )  # fmt: skip
    read = TYPE + "import pickle; assert pickle.loads(sys.stdin.buffer.read()) == own; assert own[0] != own[1]"
    subprocess.run([sys.executable, "-c", read, *SETS], input=write.stdout, check=True, timeout=300)


def test_a_name_that_is_none_of_its_classes_is_no_attribute():
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        thruster_rows.nothing  # noqa: B018
