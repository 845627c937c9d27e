"""What holds for every file of the repository."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]


def text_files() -> list[Path]:
    """Return the files that are tracked or would be, without binary ones."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    try:
        listed = subprocess.run(command, cwd=ROOT, capture_output=True, check=True, timeout=60.0).stdout
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("no git repository here")
    paths = [ROOT / name for name in listed.decode().split("\0") if name]
    return [path for path in paths if path.is_file() and b"\0" not in path.read_bytes()[:8192]]


def test_no_file_names_a_path_of_one_machine() -> None:
    # Assembled, so that this file does not name one itself.
    homes = [
        str(ROOT),
        str(Path.home()),
        "/" + "root",
        *(f"/{top}/" + r"[\w.-]+" for top in ("home", "Users")),
    ]
    # A tag that ends, such as that of an XML's root, is no path.
    one_machine = re.compile(r"(?<![\w.$}/<-])(" + "|".join(homes) + r")(?![\w.-])")
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()[:120]}"
        for path in text_files()
        for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), start=1)
        if one_machine.search(line)
    ]
    assert not found, "\n".join(found)


def test_every_shell_script_is_valid_bash_and_those_that_are_run_are_executable() -> None:
    scripts = [*ROOT.glob("scripts/**/*.sh"), ROOT / "scripts/stand_in/ros2", ROOT / ".ci/run"]
    assert scripts
    for script in scripts:
        subprocess.run(["bash", "-n", str(script)], check=True, timeout=60.0)
        run_directly = script.read_text(encoding="utf-8").startswith("#!")
        assert bool(script.stat().st_mode & 0o111) == run_directly, f"{script.name}: mode and first line disagree"
