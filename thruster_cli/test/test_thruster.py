"""The command `thruster`: its sub-commands, their help, arguments, statuses and completion."""

import re
import shutil
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest
from typer.testing import CliRunner

from thruster_cli.cli_thruster import PROGRAMS, app

PACKAGE = Path(__file__).resolve().parents[1]


def thruster(*arguments, **environment):
    return CliRunner().invoke(app, list(arguments), prog_name="thruster", env=environment)


def test_help_lists_every_command_with_its_purpose():
    told = " ".join(thruster("--help").stdout.split())
    assert all(f"{name} {program.purpose}" in told for name, program in PROGRAMS.items())


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_help_of_a_command_is_its_programs_with_options_and_an_example_under_this_name(name):
    done = thruster(name, "--help")
    assert done.exit_code == 0
    assert done.stdout.startswith(f"usage: thruster {name} ")
    own, _, vehicle = done.stdout.partition("\nof a vehicle:")
    assert bool(PROGRAMS[name].of_vehicle) == (f"usage: thruster {name} [-h] --vehicle" in vehicle)
    for each in filter(None, (own, vehicle)):
        purpose, _, examples = each.partition("examples:")
        assert re.search(rf"^  thruster {name} \S", examples, re.MULTILINE)
        offered = set(re.findall(r"(?<![\w-])--?[a-z][\w-]*", purpose))
        used = set(re.findall(r"(?<=\s)--?[a-z][\w-]*", examples))
        assert used <= offered, "an example uses an option that is none"


@pytest.mark.parametrize("name", [name for name, program in PROGRAMS.items() if program.of_vehicle])
@pytest.mark.parametrize("vehicle", [("--vehicle", "ngs"), ("--vehicle=ngs",)])
def test_runs_of_a_vehicle_are_for_the_program_of_vehicles(name, vehicle, tmp_path):
    assert thruster(name, *vehicle, "--help").stdout.startswith(f"usage: thruster {name} [-h] --vehicle")
    of = ("-o", str(tmp_path / "none" / "mine.yaml")) if name == "new-set" else (str(tmp_path / "none"),)
    done = thruster(name, *of, *vehicle)
    assert done.exit_code == 1
    assert "none" in done.stderr


def test_arguments_and_the_exit_status_are_passed_on(tmp_path):
    file = tmp_path / "mine.yaml"
    assert thruster("new-set", "hl", "--base", "hl_bench", "-o", str(file)).exit_code == 0
    assert "base: hl_bench" in file.read_text("utf-8")
    again = thruster("new-set", "hl", "-o", str(file))
    assert (again.exit_code, again.stdout) == (1, "")
    assert "exists and is not overwritten" in again.stderr


def test_an_option_that_a_program_does_not_have_is_wrong_usage_under_its_name():
    done = thruster("check", "run", "--set", "hl", "--nothing")
    assert done.exit_code == 2
    assert "thruster check: error: unrecognized arguments: --nothing" in done.stderr


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (("check", "run"), True),
        (("diagnose", "run", "--out", "x"), True),
        (("check", "run", "--vehicle", "ngs", "--nothing"), False),
        (("show",), False),
    ],
)
def test_wrong_usage_without_a_set_says_how_a_vehicle_s_is_named(arguments, told):
    done = thruster(*arguments)
    assert done.exit_code == 2
    assert (f"of a vehicle, its set is named: thruster {arguments[0]} --vehicle SET ..." in done.stderr) == told


def test_a_shell_is_offered_commands_and_a_commands_own_options():
    def offered(words, place):
        asked = {"_THRUSTER_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(place)}
        return thruster(**asked).stdout.split()

    assert offered("thruster di", 1) == ["diagnose"]
    assert offered("thruster new-set --", 2) == ["--base", "--help", "--out", "--vehicle"]
    assert offered("thruster new-set --b", 2) == ["--base"]


def test_the_installed_command_is_on_the_path_and_is_the_one_that_ros_runs(tmp_path):
    installed = shutil.which("thruster")
    assert installed is not None, "scripts/env.sh brings it"
    ran = Path(installed).parent / "../lib/thruster_cli/thruster"
    for command in (installed, str(ran.resolve())):
        done = subprocess.run(
            [command, "new-set", "hx", "-o", "x"], capture_output=True, text=True, timeout=120, cwd=tmp_path
        )
        assert done.returncode == 1
        assert "expected a model, one of simplified, hl" in done.stderr


def test_the_manifest_names_the_packages_whose_programs_are_called():
    named = {element.text for element in ElementTree.parse(PACKAGE / "package.xml").iter("exec_depend")}
    assert {program.module.split(".")[0] for program in PROGRAMS.values()} <= named
