"""The packages as a whole: one version, valid manifests, executables that can be imported."""

import ast
import importlib
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = sorted(path.parent for path in ROOT.glob("*/package.xml"))
PYTHON_PACKAGES = [package for package in PACKAGES if (package / "setup.py").exists()]
DESIGNED = {
    "gap_diagnosis", "rov_sim", "thruster_control", "thruster_estimation", "bench_driver", "thruster_model",
    "run_bag", "safe_files", "system_identification", "thruster_cli", "thruster_runtime", "thruster_msgs",
}  # fmt: skip
DEPENDENCY_TAGS = ("depend", "build_depend", "exec_depend", "buildtool_depend", "test_depend")


def manifest(package: Path) -> ElementTree.Element:
    return ElementTree.parse(package / "package.xml").getroot()


def text(package: Path, tag: str) -> str:
    return (manifest(package).findtext(tag) or "").strip()


def setup_arguments(package: Path) -> dict[str, ast.expr]:
    """Return the keyword arguments of the call of setup() in setup.py, unevaluated."""
    tree = ast.parse((package / "setup.py").read_text(encoding="utf-8"))
    calls = [node for node in ast.walk(tree) if isinstance(node, ast.Call)]
    (setup,) = [call for call in calls if isinstance(call.func, ast.Name) and call.func.id == "setup"]
    return {keyword.arg: keyword.value for keyword in setup.keywords if keyword.arg}


def entry_points(package: Path) -> list[tuple[str, str, str]]:
    """Return (executable, module, function) of each console script of a package."""
    declared = setup_arguments(package).get("entry_points")
    if declared is None:
        return []
    lines = [node.value for node in ast.walk(declared) if isinstance(node, ast.Constant) and "=" in str(node.value)]
    found = [re.fullmatch(r"\s*(\S+)\s*=\s*([\w.]+):(\w+)\s*", line) for line in lines]
    assert all(found), f"{package.name}/setup.py: expected 'name = module:function', got {lines}"
    return [(match[1], match[2], match[3]) for match in found if match]


ENTRY_POINTS = [(package.name, *entry) for package in PYTHON_PACKAGES for entry in entry_points(package)]


def test_every_package_is_one_of_the_design() -> None:
    assert PACKAGES
    assert {package.name for package in PACKAGES} <= DESIGNED


def test_all_packages_have_one_version() -> None:
    versions = {package.name: text(package, "version") for package in PACKAGES}
    assert len(set(versions.values())) == 1, versions


@pytest.mark.parametrize("package", PACKAGES, ids=lambda package: package.name)
def test_the_manifest_is_complete(package: Path) -> None:
    root = manifest(package)
    assert root.tag == "package"
    assert root.get("format") == "3"
    assert text(package, "name") == package.name
    assert re.fullmatch(r"\d+\.\d+\.\d+", text(package, "version"))
    assert text(package, "description").endswith(".")
    assert text(package, "license") == "Apache-2.0"
    maintainer = root.find("maintainer")
    assert maintainer is not None
    assert (maintainer.text, maintainer.get("email")) == ("The maintainers", "maintainers@example.com")
    built_by = root.findtext("export/build_type")
    assert built_by == ("ament_python" if package in PYTHON_PACKAGES else "ament_cmake")
    named = [element.text for tag in DEPENDENCY_TAGS for element in root.findall(tag)]
    assert len(named) == len(set(named)), f"{package.name}/package.xml names a dependency twice: {named}"


@pytest.mark.parametrize("package", PYTHON_PACKAGES, ids=lambda package: package.name)
def test_setup_py_says_what_the_manifest_says(package: Path) -> None:
    said = setup_arguments(package)
    for tag, keyword in (("version", "version"), ("description", "description"), ("license", "license")):
        assert ast.literal_eval(said[keyword]) == text(package, tag), f"{package.name}/setup.py: {keyword}"
    assert "test" in ast.literal_eval(said["extras_require"]), "colcon would run no test and report success"


@pytest.mark.parametrize("package", PYTHON_PACKAGES, ids=lambda package: package.name)
def test_the_package_is_known_to_the_index_and_its_executables_go_where_ros2_run_looks(package: Path) -> None:
    assert (package / "resource" / package.name).exists()
    scripts = f"$base/lib/{package.name}"
    config = (package / "setup.cfg").read_text(encoding="utf-8")
    assert re.search(rf"^script_dir\s*=\s*{re.escape(scripts)}$", config, re.MULTILINE)
    assert re.search(rf"^install_scripts\s*=\s*{re.escape(scripts)}$", config, re.MULTILINE)


def test_every_executable_can_be_imported() -> None:
    for package, executable, module, function in ENTRY_POINTS:
        assert module.split(".")[0] == package, f"{executable} starts another package's module {module}"
        assert callable(getattr(importlib.import_module(module), function)), f"{package} {executable}"
