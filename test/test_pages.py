"""Pages and their commands: what a page prints runs as printed, and its links lead somewhere."""

import json
import re
import shutil
import subprocess
import textwrap
from pathlib import Path

import numpy as np
import pytest

from run_bag import read_run
from thruster_model.parameter_set_io import load_parameter_set

ROOT = Path(__file__).resolve().parents[1]
PAGES = [
    ROOT / "README.md",
    ROOT / "CONTRIBUTING.md",
    *sorted((ROOT / "docs").glob("*.md")),
    *ROOT.glob("[!.]*/README.md"),
]
GENERATED = {"commands.md", "models.md", "vehicles.md"}
"""Reference pages that commands print: as long as there are commands, models and vehicles."""
WORDS, WORDS_IN_A_CLAUSE, LINES = 20.5, 45, 150
"""Of a sentence on a page's average, of any clause, and of a page."""
LONGEST = 1800.0
"""[s] From then on something hangs."""


def commands(page: Path) -> str:
    """Return the first block of commands of a page."""
    block = re.search(r"^```bash\n(.*?)^```", page.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    assert block is not None
    return block[1]


def ran(script: str, folder: Path) -> str:
    """Run a script in a folder that looks like the repository's; return what it printed."""
    for name in ("scripts", "docs"):
        (folder / name).symlink_to(ROOT / name)
    bash = ["bash", "-e", "-o", "pipefail", "-c", script]
    done = subprocess.run(bash, cwd=folder, capture_output=True, text=True, timeout=LONGEST)
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def test_the_page_of_a_t200_runs_as_printed_and_finds_what_its_recording_hides(tmp_path: Path) -> None:
    ran(commands(ROOT / "docs/t200.md").replace(". scripts/env.sh\n", ""), tmp_path)
    found = json.loads((tmp_path / "t200/diagnosis/diagnosis.json").read_text("utf-8"))
    assert found["verdict"] in ("effect", "cannot_tell")
    (effect,) = found["effects"]
    assert effect["id"] in ("command_delay", "log_alignment"), "the page says that nothing tells these two apart"
    if effect["id"] == "command_delay":
        assert effect["parameters"]["time"]["value"] == pytest.approx(0.15, abs=0.01)
    overview = (tmp_path / "t200/overview.html").read_text("utf-8")
    assert "./diagnosis/report.html" in overview and "t200" in overview


SLOW = ("thruster check", "thruster fit", "thruster diagnose", "thruster report")


def test_the_page_of_an_own_csv_makes_runs_and_a_set_of_it_as_printed(tmp_path: Path) -> None:
    page = ROOT / "docs/own_csv.md"
    lines = [line for line in commands(page).splitlines()[1:] if not line.startswith(SLOW)]
    ran("\n".join(lines), tmp_path)
    proposed = (tmp_path / "own/map.yaml").read_text("utf-8").replace("unit: rad/s", "unit: '?'")
    shown = re.search(r"^```yaml\n(.*?)^```", page.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    assert shown is not None
    assert shown[1].splitlines() == [line.partition("   #")[0] for line in proposed.splitlines()[1:]]
    parameters = load_parameter_set(str(tmp_path / "own/mine.yaml")).values
    assert parameters == load_parameter_set("simplified").values, "all that it names is still behind a #"
    for number in (1, 2):
        run = read_run(tmp_path / f"own/runs/log_{number}")
        assert 4.0 < run["thruster_0/throttle.commanded"].values.max() < 5.0
        assert 150.0 < run["thruster_0/state.n"].values.max() < 250.0


@pytest.mark.long
def test_the_page_of_an_own_csv_runs_as_printed_and_finds_what_its_logs_hide(tmp_path: Path) -> None:
    said = ran(commands(ROOT / "docs/own_csv.md").replace(". scripts/env.sh\n", ""), tmp_path)
    assert "parameters that a fit would determine: c_u1, c_u2, delta_u1, delta_u2, k_n, each by itself" in said
    assert "usable" in said
    found = json.loads((tmp_path / "own/diagnosis/diagnosis.json").read_text("utf-8"))
    (effect,) = found["effects"]
    assert (found["verdict"], effect["id"]) == ("effect", "coulomb_friction")
    size = effect["parameters"]["deceleration"]
    assert size["value"] == pytest.approx(150.0, abs=3.0 * size["std"])
    assert size["std"] < 3.0
    overview = (tmp_path / "own/overview.html").read_text("utf-8")
    assert "./diagnosis/report.html" in overview and "./fit/report.html" in overview


def test_the_page_of_an_own_dive_makes_runs_of_it_as_printed(tmp_path: Path) -> None:
    page = ROOT / "docs/own_dive.md"
    lines = [line for line in commands(page).splitlines()[1:] if not line.startswith(SLOW)]
    ran("\n".join(lines), tmp_path)
    proposed = (tmp_path / "dive/map.yaml").read_text("utf-8")
    shown = re.search(r"^```yaml\n(.*?)^```", page.read_text("utf-8"), re.MULTILINE | re.DOTALL)
    assert shown is not None
    assert set(shown[1].splitlines()) < {line.partition("   #")[0] for line in proposed.splitlines()}
    for number in (1, 2):
        run = read_run(tmp_path / f"dive/runs/dive_{number}")
        assert 2.0 < np.nanmin(run["rov/depth.depth"].values[:100]) < 4.0  # each sensor reads at instants of its own
        assert np.nanmean(run["rov/imu.linear_acceleration.z"].values[:100]) == pytest.approx(-9.8, abs=0.5)


@pytest.mark.long
def test_the_page_of_an_own_dive_runs_as_printed_and_finds_what_its_logs_hide(tmp_path: Path) -> None:
    said = ran(commands(ROOT / "docs/own_dive.md").replace(". scripts/env.sh\n", ""), tmp_path)
    assert "wiring: Commands move the vehicle as the set states." in said
    found = json.loads((tmp_path / "dive/diagnosis/diagnosis.json").read_text("utf-8"))
    (effect,) = found["effects"]
    assert (found["verdict"], effect["id"], effect["thruster"]) == ("effect", "thrust_loss", 3)
    share = effect["parameters"]["share"]
    assert abs(share["value"] - 0.4) < 3.0 * share["std"]


@pytest.mark.long
def test_the_commands_of_the_readme_run_as_printed(tmp_path: Path) -> None:
    lines = commands(ROOT / "README.md").splitlines()
    own = [line for line in lines if line.startswith("thruster ")]
    assert len(own) >= 6
    ran("\n".join(own), tmp_path)
    assert (tmp_path / "runs/overview.html").is_file() and (tmp_path / "mine.yaml").is_file()
    diagnosis = json.loads((tmp_path / "runs/diagnosis/diagnosis.json").read_text("utf-8"))
    assert "command_delay" in json.dumps(diagnosis["effects"]), "the delay of 0.08 s that the first line switches on"


def test_the_force_table_by_hand_is_a_set(tmp_path: Path) -> None:
    page = (ROOT / "docs/check_and_sets.md").read_text("utf-8")
    (text,) = re.findall(r"^ +base: force_table\n.*?(?=^ +```)", page, re.MULTILINE | re.DOTALL)
    (tmp_path / "mine.yaml").write_text(textwrap.dedent(text))
    own = load_parameter_set(str(tmp_path / "mine.yaml"))
    edges = own.command.throttle([1475.0, 1525.0])
    assert [own.values["delta_u1"], own.values["delta_u2"]] == pytest.approx(list(edges)), "as the page says"


def test_the_scripts_of_the_readme_are_there() -> None:
    named = re.findall(r"^(?:\. )?(scripts/\S+)", commands(ROOT / "README.md"), re.MULTILINE)
    assert len(named) >= 6
    assert [name for name in named if not (ROOT / name).is_file()] == []
    assert shutil.which("thruster") is not None


def sentences(page: Path) -> list[str]:
    """Return the sentences of a page's text; commands, tables and headings are none."""
    text = re.sub(r"^```.*?^```", "\n", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^( {4}|\||#|!\[).*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"^ *([-*]|\d+\.) ", "\n\n", text, flags=re.MULTILINE)
    text = re.sub(r"\]\([^)]*\)", "]", re.sub(r"`[^`]*`", "code", text))
    return [
        each for block in re.split(r"\n\s*\n", text) for each in re.split(r"(?<=[.!?])\**\s+", block) if each.strip()
    ]


def words(text: str) -> int:
    return len(re.findall(r"\w\S*", text))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_a_page_is_short_and_so_are_its_sentences(page: Path) -> None:
    assert page.name in GENERATED or len(page.read_text("utf-8").splitlines()) <= LINES
    found = sentences(page)
    assert sum(map(words, found)) <= WORDS * len(found)
    clauses = [clause for each in found for clause in re.split(r"(?<=[:;])\**\s+", each)]
    assert not [clause for clause in clauses if words(clause) > WORDS_IN_A_CLAUSE]


def anchors(page: Path) -> set[str]:
    """Return the anchors of a page's headings, as the hosts of repositories make them."""
    headings = re.findall(r"^#+ (.*)", page.read_text("utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def test_every_link_of_every_page_leads_to_a_file_and_a_heading_that_are_there() -> None:
    wrong = []
    for page in PAGES:
        text = re.sub(r"^```.*?^```", "", page.read_text("utf-8"), flags=re.MULTILINE | re.DOTALL)
        for target in re.findall(r"\]\(([^)\s]+)\)", text):
            if re.match(r"[a-z]+:", target):
                continue
            path, _, anchor = target.partition("#")
            file = (page.parent / path).resolve() if path else page
            if not file.exists():
                wrong.append(f"{page.relative_to(ROOT)}: {target}: nothing there")
            elif anchor and anchor not in anchors(file):
                wrong.append(f"{page.relative_to(ROOT)}: {target}: no such heading")
    assert not wrong, "\n".join(wrong)
