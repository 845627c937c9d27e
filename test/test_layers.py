"""The direction of imports: packages point down the list, layers point from node to I/O to maths.

A module's layer follows from its name: `node.py` and `*_node.py` are nodes; `*_io.py`, `cli*.py` and
whatever lies in a folder named `io`, `importers` or `report` is I/O; every other module is maths. A file
`LAYERS` in a package's folder says where this does not hold, one line `layer pattern` each, the pattern
matched against the path inside the package.
"""

import ast
import sys
from collections.abc import Callable, Iterator
from fnmatch import fnmatch
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest

ROOT = Path(__file__).resolve().parents[1]
LAYERS = ("maths", "io", "node")

# What each package may import; in addition its nodes may import thruster_runtime and thruster_msgs.
ALLOWED: dict[str, set[str]] = {
    "thruster_msgs": set(),
    "safe_files": set(),
    "thruster_runtime": {"thruster_msgs", "safe_files"},
    "run_bag": {"safe_files"},
    "system_identification": {"run_bag"},
    "thruster_model": {"system_identification", "run_bag", "safe_files"},
    "bench_driver": set(),
    "thruster_estimation": {"thruster_model", "run_bag", "safe_files"},
    "thruster_control": {"thruster_model"},
    "rov_sim": {"thruster_control", "thruster_estimation", "thruster_model", "run_bag", "safe_files", "bench_driver"},
}
ALLOWED["gap_diagnosis"] = set(ALLOWED) - {"thruster_msgs", "thruster_runtime"}
ALLOWED["thruster_cli"] = set(ALLOWED) - {"thruster_msgs", "thruster_runtime"}

MESSAGES = {
    "builtin_interfaces", "diagnostic_msgs", "geometry_msgs", "nav_msgs", "rcl_interfaces", "rosgraph_msgs",
    "sensor_msgs", "std_msgs", "tf2_msgs", "thruster_msgs", "visualization_msgs",
}  # fmt: skip
OUTSIDE_MATHS = MESSAGES | {
    "rclpy", "thruster_runtime", "serial", "yaml", "time", "datetime", "os", "pathlib", "shutil", "socket",
    "subprocess", "tempfile", "glob", "importlib.resources", "rosbags", "mcap", "argparse", "typer", "rich",
}  # fmt: skip
OUTSIDE_IO = {"rclpy", "thruster_runtime"}

# Exceptions from what maths may import, each with its reason.
MAY_IMPORT = {
    # Compiled equations are kept in a folder of the user; no equation reads anything from there.
    "thruster_model/compilation.py": {"os", "pathlib", "shutil", "tempfile"},
    # Errors name files.
    "run_bag/errors.py": {"pathlib"},
    # The number of threads of linear algebra is read from the environment when NumPy is loaded.
    "gap_diagnosis/__init__.py": {"os"},
    "system_identification/__init__.py": {"os"},
}


class Module(NamedTuple):
    package: str
    path: Path
    """Inside the folder of modules, e.g. report/page.py."""

    @property
    def file(self) -> Path:
        return ROOT / self.package / self.package / self.path

    @property
    def layer(self) -> str:
        return layer_of(self.path, declared_layers(self.package))

    def __str__(self) -> str:
        return f"{self.package}/{self.path}"


def declared_layers(package: str) -> list[tuple[str, str]]:
    """Return the (layer, pattern) lines of the package's LAYERS file."""
    file = ROOT / package / "LAYERS"
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    pairs = [line.split(maxsplit=1) for line in lines if line.strip() and not line.startswith("#")]
    assert all(len(pair) == 2 and pair[0] in LAYERS for pair in pairs), f"{file}: expected 'layer pattern' lines"
    return [(layer, pattern.strip()) for layer, pattern in pairs]


def layer_of(path: Path, declared: list[tuple[str, str]]) -> str:
    """Return the layer of a module; the first declared pattern that fits wins."""
    for layer, pattern in declared:
        if fnmatch(path.as_posix(), pattern):
            return layer
    if path.name == "node.py" or path.name.endswith("_node.py"):
        return "node"
    if path.name.endswith("_io.py") or fnmatch(path.name, "cli*.py"):
        return "io"
    if {"io", "importers", "report"} & set(path.parent.parts):
        return "io"
    return "maths"


def modules() -> Iterator[Module]:
    for manifest in sorted(ROOT.glob("*/package.xml")):
        package = manifest.parent.name
        top = ROOT / package / package
        for file in sorted(top.rglob("*.py")):
            yield Module(package, file.relative_to(top))


def imports(source: str, package: str, path: Path) -> set[str]:
    """Return the full names that a module imports, also in functions, but not those for type checkers."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and ast.unparse(node.test).endswith("TYPE_CHECKING"):
            node.body = []
    found = set()
    here = [package, *path.parent.parts]
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            base = here[: len(here) - node.level + 1] if node.level else []
            origin = ".".join([*base, *([node.module] if node.module else [])])
            found |= {f"{origin}.{alias.name}" for alias in node.names}
    return found


def reaches(name: str, forbidden: set[str]) -> bool:
    return any(name == each or name.startswith(each + ".") for each in forbidden)


def module_named(name: str) -> Module | None:
    """Return the module of ours that an imported name lies in, or None for a library's."""
    package, *rest = name.split(".")
    top = ROOT / package / package
    if package not in ALLOWED or not top.is_dir():
        return None
    for length in range(len(rest), -1, -1):
        path = Path(*rest[:length])
        for candidate in (path.with_suffix(".py") if length else None, path / "__init__.py"):
            if candidate is not None and (top / candidate).is_file():
                return Module(package, candidate)
    return None


MODULES = list(modules())


@cache
def imported_by(module: Module) -> set[str]:
    return imports(module.file.read_text(encoding="utf-8"), module.package, module.path)


def foreign_packages(module: Module) -> set[str]:
    """Return the packages that a module imports and must not."""
    ours = {name.split(".")[0] for name in imported_by(module)} & set(ALLOWED) - {module.package}
    for_nodes = {"thruster_runtime", "thruster_msgs"} if module.layer == "node" else set()
    return ours - ALLOWED[module.package] - for_nodes


def outside_its_layer(module: Module) -> set[str]:
    """Return what a module imports that its layer must not know: ROS, the clock, files."""
    forbidden = {"maths": OUTSIDE_MATHS, "io": OUTSIDE_IO, "node": set()}[module.layer]
    return {name for name in imported_by(module) if reaches(name, forbidden - MAY_IMPORT.get(str(module), set()))}


def higher_layers(module: Module) -> set[str]:
    """Return the modules of a higher layer that a module imports."""
    return {
        str(other)
        for other in map(module_named, imported_by(module))
        if other is not None and LAYERS.index(other.layer) > LAYERS.index(module.layer)
    }


def foreign_nodes(module: Module) -> set[str]:
    """Return the nodes of other packages that a module imports."""
    return {
        str(other)
        for other in map(module_named, imported_by(module))
        if other is not None and other.package not in (module.package, "thruster_runtime") and other.layer == "node"
    }


@pytest.mark.parametrize("wrong", [foreign_packages, outside_its_layer, higher_layers, foreign_nodes])
def test_packages_and_layers_import_only_what_lies_below_them(wrong: Callable[[Module], set[str]]) -> None:
    assert len(MODULES) > 300
    found = [f"{module} ({module.layer}) imports {sorted(names)}" for module in MODULES if (names := wrong(module))]
    assert not found, "\n".join(found)


def test_each_kind_of_wrong_import_is_found(monkeypatch: pytest.MonkeyPatch) -> None:
    maths = Module("thruster_control", Path("allocation.py"))
    monkeypatch.setattr(sys.modules[__name__], "imported_by", lambda _: {
        "gap_diagnosis.verdict", "rclpy.node", "thruster_control.inner_loop_node.InnerLoopNode",
        "thruster_estimation.observer_node.ObserverNode", "numpy", "thruster_model.stepper",
    })  # fmt: skip
    assert foreign_packages(maths) == {"gap_diagnosis", "thruster_estimation"}
    assert outside_its_layer(maths) == {"rclpy.node"}
    assert higher_layers(maths) == {"thruster_control/inner_loop_node.py", "thruster_estimation/observer_node.py"}
    assert foreign_nodes(maths) == {"thruster_estimation/observer_node.py"}


def test_the_arrows_between_packages_have_no_circle() -> None:
    done: set[str] = set()
    while left := [package for package in ALLOWED if package not in done]:
        ready = {package for package in left if ALLOWED[package] <= done}
        assert ready, f"circle among {left}"
        done |= ready


def test_the_layer_follows_from_the_name_unless_declared() -> None:
    for path, layer in {
        "thrust.py": "maths", "rotor/torque.py": "maths", "node.py": "node", "ekf_node.py": "node",
        "parameters_io.py": "io", "cli_fit.py": "io", "importers/csv.py": "io", "report/plots/axis.py": "io",
        "special.py": "io",
    }.items():  # fmt: skip
        assert layer_of(Path(path), [("io", "special.py")]) == layer, path


def test_every_form_of_import_is_seen() -> None:
    source = (
        "import os.path\n"
        "from rclpy import node\n"
        "from . import torque\n"
        "from ..effects.drag import extra\n"
        "def f():\n    import yaml\n"
        "if TYPE_CHECKING:\n    import serial\n"
    )
    expected = {"os.path", "rclpy.node", "p.a.torque", "p.effects.drag.extra", "yaml"}
    assert imports(source, "p", Path("a/thrust.py")) == expected
