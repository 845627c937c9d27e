"""A module that only pip brings: the first program that misses it says so in one sentence."""

import subprocess
import sys

import pytest

HIDDEN = """
import importlib.abc, sys
class Hidden(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name == {missing!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)
sys.meta_path.insert(0, Hidden())
sys.argv = ["/somewhere/program"]
import {module}
"""


@pytest.mark.parametrize(
    ("missing", "module"),
    [("rosbags", "run_bag.cli_info"), ("mcap", "run_bag.cli_info"), ("numba", "thruster_model.stepper")],
)
def test_a_missing_module_is_one_sentence_with_the_command_that_mends_it(missing: str, module: str) -> None:
    code = HIDDEN.format(missing=missing, module=module)
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120.0, check=False)
    assert done.returncode == 1
    assert done.stderr == (
        f"program: the Python module {missing} is missing; scripts/setup.sh installs it, "
        f"and so does: {sys.executable} -m pip install {missing}\n"
    )


def test_other_errors_keep_their_traceback() -> None:
    code = "import run_bag; import no_such_module"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120.0, check=False)
    assert "Traceback" in done.stderr and "no_such_module" in done.stderr
