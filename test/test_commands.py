"""The reference of the commands says what the commands say."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from thruster_cli.cli_thruster import PROGRAMS

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/commands.md"
LONGEST = 600.0
"""[s] Deadline: modules with kernels may have to be compiled first."""
EXECUTABLES = [
    (file.parent.name, name)
    for file in sorted(ROOT.glob("*/setup.py"))
    for name in re.findall(r"(\w+) = [\w.]+:main\"", file.read_text("utf-8"))
    if file.parent.name != "thruster_cli"
]


def sections() -> dict[str, str]:
    """Return the text below each heading of the page."""
    _, *parts = re.split(r"^### ", PAGE.read_text("utf-8"), flags=re.MULTILINE)
    return {heading: text for heading, _, text in (part.partition("\n") for part in parts)}


def test_the_page_is_what_the_commands_say_of_themselves() -> None:
    script = ROOT / "scripts/workspace/commands_page.py"
    made = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=LONGEST, check=True)
    assert made.stdout == PAGE.read_text("utf-8"), f"{script.name} > docs/{PAGE.name} makes it anew"


def test_every_executable_and_every_script_stands_on_the_page() -> None:
    assert len(EXECUTABLES) >= 50
    text = PAGE.read_text("utf-8")
    assert [each for each in EXECUTABLES if f"ros2 run {' '.join(each)}" not in text] == []
    assert [file.name for file in (ROOT / "scripts").glob("*.sh") if f"scripts/{file.name}" not in sections()] == []


@pytest.mark.parametrize("name", PROGRAMS)
def test_every_option_of_a_commands_help_stands_in_its_section(name: str) -> None:
    command = [sys.executable, "-m", "thruster_cli.cli_thruster", name, "--help"]
    told = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST, check=True).stdout
    options = set(re.findall(r"(?<![\w-])--[a-z][\w-]*", told.partition("examples:")[0])) - {"--help"}
    table = [line for line in sections()[f"thruster {name}"].splitlines() if line.startswith("| `")]
    assert {option for option in options if not any(option in re.findall(r"--[\w-]+", row) for row in table)} == set()
