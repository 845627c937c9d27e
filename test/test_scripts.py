"""The shell scripts: quick when there is nothing to do, one sentence when something is missing."""

import fcntl
import os
import resource
import runpy
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy
import pytest

ROOT = Path(__file__).resolve().parents[1]
TOOLS = (
    "bash", "basename", "cat", "chmod", "cut", "dirname", "env", "find", "flock", "head", "ls", "make",
    "mkdir", "mv", "rm", "sed", "sha256sum", "sleep", "sort", "tr", "xargs",
)  # fmt: skip
LONGEST = 60.0
"""[s] Deadline of a script that has nothing to build."""


def run(
    command: list[str], environment: dict[str, str] | None = None, cwd: Path = ROOT
) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command, env=environment, cwd=cwd, capture_output=True, text=True, timeout=LONGEST, check=False
    )


def script(path: str) -> Callable[..., Any]:
    """Return a look-up of the functions of a Python script of the workspace."""
    return runpy.run_path(str(ROOT / "scripts" / "workspace" / path)).__getitem__


# ---- setup.sh


@pytest.fixture
def clone(tmp_path: Path) -> Path:
    """A copy of what setup.sh reads, in which nothing has been set up."""
    clone = tmp_path / "a clone"
    for name in ("scripts", "requirements", "thruster_msgs"):
        shutil.copytree(ROOT / name, clone / name)
    return clone


@pytest.fixture
def tools(tmp_path: Path) -> Path:
    """A folder for PATH with what every machine has, but neither compiler nor Python."""
    folder = tmp_path / "tools"
    folder.mkdir()
    for name in TOOLS:
        found = shutil.which(name)
        assert found is not None, name
        (folder / name).symlink_to(found)
    return folder


def add_tool(tools: Path, name: str, text: str) -> None:
    (tools / name).write_text(text, encoding="utf-8")
    (tools / name).chmod(0o755)


def add_python(tools: Path) -> None:
    add_tool(tools, "python3", f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')


def setup_in(clone: Path, tools: Path) -> subprocess.CompletedProcess[str]:
    environment = {"PATH": str(tools), "HOME": str(clone)}
    return run(["bash", "scripts/setup.sh"], environment, clone)


def test_setup_takes_less_than_half_a_second_of_a_processor_when_there_is_nothing_to_do() -> None:
    assert run(["scripts/setup.sh"]).returncode == 0
    durations = []
    for _ in range(3):
        begin = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = run(["scripts/setup.sh"])
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
        durations.append(end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime)
        assert (done.returncode, done.stderr) == (0, "")
        assert done.stdout.startswith("[setup] ready")
    assert min(durations) < 0.5


def test_a_missing_compiler_is_one_sentence_before_anything_is_installed(clone: Path, tools: Path) -> None:
    add_python(tools)
    done = setup_in(clone, tools)
    assert done.returncode == 1
    assert "install g++ and make" in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert not (clone / ".venv").exists()


def test_a_missing_python_and_a_missing_compiler_are_said_together(clone: Path, tools: Path) -> None:
    done = setup_in(clone, tools)
    assert done.returncode == 1
    assert "install g++ and make" in done.stderr
    assert "No usable Python" in done.stderr
    assert len(done.stderr.splitlines()) == 2


def test_another_ros_than_jazzy_is_refused(clone: Path) -> None:
    done = run(["scripts/setup.sh"], {**os.environ, "ROS_DISTRO": "humble"}, clone)
    assert done.returncode == 1
    assert "ROS 2 humble is sourced here, these packages need Jazzy" in done.stderr


def test_a_second_setup_waits_for_the_first(clone: Path, tools: Path) -> None:
    with (clone / ".setup.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        environment = {"PATH": str(tools), "HOME": str(clone)}
        command = ["bash", "scripts/setup.sh"]
        with subprocess.Popen(command, env=environment, cwd=clone, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout is not None
            assert "another setup is at work here" in process.stdout.readline()
            assert process.poll() is None
            fcntl.flock(lock, fcntl.LOCK_UN)
            process.communicate(timeout=LONGEST)
            assert process.returncode == 1  # no compiler


@pytest.mark.parametrize(
    ("fake", "sentence"),
    [
        ("echo 'version not active' >&2; exit 127", "install Python 3.10, 3.11, 3.12 or 3.13"),
        ("echo no /usr/bin/python3 lacks the module venv", "/usr/bin/python3 lacks the module venv"),
        ("echo no /usr/bin/python3 is Python 3.8", "install Python 3.10, 3.11, 3.12 or 3.13"),
    ],
)
def test_a_python_that_cannot_be_used_is_passed_over(tools: Path, fake: str, sentence: str) -> None:
    add_tool(tools, "python3.12", f"#!/bin/sh\n{fake}\n")
    code = '. scripts/workspace/find_python.sh; find_python; echo "$python|$python_trouble"'
    without = run(["bash", "-c", code], {"PATH": str(tools)})
    assert without.stdout.startswith("|")
    assert sentence in without.stdout
    add_python(tools)
    assert run(["bash", "-c", code], {"PATH": str(tools)}).stdout.startswith(sys.executable)


# ---- env.sh


def test_env_brings_the_packages_into_a_strict_shell_in_any_folder(tmp_path: Path) -> None:
    code = f"""
        set -eu
        . "{ROOT}/scripts/env.sh"
        . "{ROOT}/scripts/env.sh"
        echo "$- $ROS_AUTOMATIC_DISCOVERY_RANGE"
        python -c 'import rclpy, thruster_msgs.msg; print(1)'
        ros2 pkg prefix thruster_msgs
    """
    environment = {"PATH": os.environ["PATH"], "HOME": str(tmp_path)}
    done = run(["bash", "-c", code], environment, tmp_path)
    flags, imported, prefix = done.stdout.splitlines()
    assert {"e", "u"} <= set(flags.split()[0])
    assert flags.split()[1] == "LOCALHOST"
    assert imported == "1"
    assert prefix == str(ROOT / "install" / "thruster_msgs")


@pytest.mark.parametrize(
    ("network", "given", "expected"),
    [("", "SUBNET", "LOCALHOST"), ("machine", "SUBNET", "LOCALHOST"), ("network", "SUBNET", "SUBNET"),
     ("network", "LOCALHOST", "SUBNET"), ("network", "SYSTEM_DEFAULT", "SYSTEM_DEFAULT")],
)  # fmt: skip
def test_a_variable_of_our_own_decides_who_takes_part_whatever_a_set_up_of_ros_exports(
    network: str, given: str, expected: str
) -> None:
    code = '. scripts/env.sh; echo "$ROS_AUTOMATIC_DISCOVERY_RANGE"'
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": given, "THRUSTER_NETWORK": network}
    assert run(["bash", "-c", code], environment).stdout == f"{expected}\n"


def test_another_word_for_who_takes_part_is_refused() -> None:
    done = run(["bash", "-c", ". scripts/env.sh"], {**os.environ, "THRUSTER_NETWORK": "all"})
    assert (done.returncode, done.stderr) == (2, "THRUSTER_NETWORK: expected machine or network; found 'all'\n")


@pytest.mark.parametrize(("flag", "words"), [("", "this machine alone"), ("network", "everybody on this network")])
def test_a_script_that_starts_a_graph_says_who_takes_part(flag: str, words: str) -> None:
    code = f"root={ROOT}; . scripts/workspace/processes.sh; stopping_order=(); own_graph"
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "THRUSTER_NETWORK": flag}
    assert f"discovery: {words}" in run(["bash", "-c", code], environment).stdout


def test_env_works_in_zsh(tmp_path: Path) -> None:
    if shutil.which("zsh") is None:
        pytest.skip("no zsh here")
    code = f"""
        set -eu
        . "{ROOT}/scripts/env.sh"
        . "{ROOT}/scripts/env.sh"
        python -c 'import rclpy, thruster_msgs.msg; print(1)'
        ros2 pkg prefix thruster_msgs
    """
    done = run(["zsh", "-f", "-c", code], {"PATH": os.environ["PATH"], "HOME": str(tmp_path)}, tmp_path)
    assert done.stdout.splitlines() == ["1", str(ROOT / "install" / "thruster_msgs")]


def test_env_in_another_shell_says_which_it_is_for(tmp_path: Path) -> None:
    if shutil.which("dash") is None:
        pytest.skip("no dash here")
    done = run(["dash", "-c", f". {ROOT}/scripts/env.sh"], {"PATH": os.environ["PATH"]}, tmp_path)
    assert (done.returncode, done.stderr) == (
        1,
        "scripts/env.sh is for bash and zsh: run one of them, and source it there.\n",
    )


def test_env_without_setup_says_what_to_run(clone: Path) -> None:
    done = run(["bash", "-c", ". scripts/env.sh"], cwd=clone)
    assert done.returncode == 1
    assert f"run {clone}/scripts/setup.sh first" in done.stderr


# ---- the stand-in for ros2


@pytest.fixture
def prefix(tmp_path: Path) -> Path:
    """An installed package `demo` with the executable `speak`."""
    prefix = tmp_path / "prefix"
    index = prefix / "share/ament_index/resource_index/packages"
    index.mkdir(parents=True)
    (index / "demo").touch()
    (prefix / "lib/demo").mkdir(parents=True)
    add_tool(prefix / "lib/demo", "speak", '#!/bin/sh\nprintf "<%s>" "$@"\nexit 7\n')
    add_tool(prefix / "lib/demo", "wait", "#!/bin/sh\necho waiting\nexec sleep 60\n")
    return prefix


def ros2(prefix: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "AMENT_PREFIX_PATH": f"{prefix}/none:{prefix}"}
    return run([str(ROOT / "scripts/stand_in/ros2"), *arguments], environment)


def test_the_stand_in_passes_arguments_and_exit_status(prefix: Path) -> None:
    done = ros2(prefix, "run", "demo", "speak", "a b", "", "--ros-args", "-p", "x:=1", "--prefix")
    assert done.stdout == "<a b><><--ros-args><-p><x:=1><--prefix>"
    assert done.returncode == 7


def test_the_stand_in_puts_a_prefix_before_the_executable(prefix: Path) -> None:
    done = ros2(prefix, "run", "--prefix", "env A=1 echo", "demo", "speak", "x")
    assert done.stdout == f"{prefix}/lib/demo/speak x\n"


def test_the_stand_in_passes_signals(prefix: Path) -> None:
    command = [str(ROOT / "scripts/stand_in/ros2"), "run", "demo", "wait"]
    environment = {**os.environ, "AMENT_PREFIX_PATH": str(prefix)}
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            assert process.stdout.readline() == "waiting\n"
            process.send_signal(signal.SIGTERM)
            assert process.wait(timeout=LONGEST) == -signal.SIGTERM
        finally:
            process.kill()  # leaving the block waits for the process, without a deadline


def test_the_stand_in_lists_packages(prefix: Path) -> None:
    assert ros2(prefix, "pkg", "list").stdout == "demo\n"
    assert ros2(prefix, "pkg", "prefix", "demo").stdout == f"{prefix}\n"
    assert ros2(prefix, "pkg", "executables", "demo").stdout == "demo speak\ndemo wait\n"
    assert ros2(prefix, "pkg", "executables").stdout == "demo speak\ndemo wait\n"


@pytest.mark.parametrize(
    ("arguments", "status", "sentence"),
    [
        (["run", "absent", "speak"], 1, "Package 'absent' not found"),
        (["run", "demo", "peak"], 1, "No executable 'peak' in package 'demo'"),
        (["run", "demo"], 2, "usage: ros2 run"),
        (["topic", "list"], 2, "ros2 topic list: sorry, not in this stand-in"),
        ([], 2, "usage: ros2 run"),
    ],
)
def test_the_stand_in_says_what_it_lacks(prefix: Path, arguments: list[str], status: int, sentence: str) -> None:
    done = ros2(prefix, *arguments)
    assert done.returncode == status
    assert sentence in done.stderr


# ---- the Python parts of setup.sh


@pytest.mark.parametrize("prefix", ["/opt/python/cp312-cp312", "/elsewhere/a clone/.venv"])
def test_header_folders_of_another_place_become_this_machines(prefix: str) -> None:
    localised = script("portable_headers.py")("localised")
    text = f'set(I "{prefix}/include/python3.12;{prefix}/lib/python3.12/site-packages/numpy/_core/include")'
    expected = r'set(I "/inc\1;/np")'
    assert localised(text, r"/inc\1", "/np") == expected
    assert localised(expected, "/other", "/other") == expected


def test_the_installers_cache_keeps_what_another_environment_is_linked_to(tmp_path: Path) -> None:
    cached, installed = tmp_path / "cached.cmake", tmp_path / "installed.cmake"
    text = 'set(I "/opt/python/cp312-cp312/include/python3.12")'
    cached.write_text(text, encoding="utf-8")
    installed.hardlink_to(cached)
    script("portable_headers.py")("localise")([installed], "/usr/include/python3.12", "/np")
    assert installed.read_text(encoding="utf-8") == 'set(I "/usr/include/python3.12")'
    assert cached.read_text(encoding="utf-8") == text


def test_the_systems_numpy_replaces_ours_and_all_else_stays() -> None:
    constrained = script("system_constraints.py")("constrained")
    lines = [
        "# why",
        'numpy==2.4.6; python_version >= "3.11"',
        'numpy==2.2.6; python_version < "3.11"',
        "rich==15.0.0",
    ]
    assert constrained(lines, {"numpy": "1.26.4"}) == ["# why", "rich==15.0.0", "numpy==1.26.4"]


def test_a_package_in_the_environment_itself_is_not_the_systems(tmp_path: Path) -> None:
    system_versions = script("system_constraints.py")("system_versions")
    assert "numpy" in system_versions(tmp_path)
    assert "numpy" not in system_versions(Path(numpy.__file__).parents[1])


def test_each_requirement_has_one_exact_version() -> None:
    names = []
    for file in ("python.txt", "ros-wheels.txt"):
        for line in (ROOT / "requirements" / file).read_text(encoding="utf-8").splitlines():
            if line.strip() and not line.startswith("#"):
                names.append(line.split("[")[0].split("<")[0].strip().lower())
    pinned = (ROOT / "requirements/constraints.txt").read_text(encoding="utf-8").splitlines()
    pins = {line.partition("==")[0] for line in pinned if "==" in line}
    assert set(names) <= pins
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    ("ours", "plain", "unit", "said"),
    [
        (300.0, 100.0, "steps/s", "3 x better"),
        (50.0, 100.0, "x real time", "2 x worse"),
        (50.0, 100.0, "us", "2 x better"),
        (8.0, 2.0, "ns", "4 x worse"),
    ],
)
def test_the_benchmark_says_which_way_is_good(ours: float, plain: float, unit: str, said: str) -> None:
    compared = runpy.run_path(str(ROOT / "scripts/workspace/benchmark_table.py"))["compared"]
    assert compared(ours, plain, unit) == said
