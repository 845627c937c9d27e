"""One table of topics, types and units: the messages' README, the definitions and the code agree with it."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from run_bag.definitions import definitions
from run_bag.importers.axes import unit_in_map
from run_bag.importers.conversions import CONVERSIONS
from run_bag.importers.csv_source import CsvSource
from run_bag.importers.guess import guess
from run_bag.importers.guess_rules import BY_UNIT, LOGS, OF_BENCH, OF_TYPE, THRUSTER, VEHICLE
from run_bag.known_topics import KNOWN, KNOWN_VEHICLE, topic_rows, topic_type
from run_bag.layout import layout
from run_bag.topics_table import channels, topics
from run_bag.units import UNITS, unit_of
from thruster_model.identification.experiment import CHANNELS

ROOT = Path(__file__).resolve().parents[1]
FIELD = re.compile(r"^(?:float64|uint8|uint32|bool)(?:\[\d*\])? (\w+)(?=\s|$)", re.MULTILINE)


class OneOfEach:
    """Lengths for a walk over a definition: one element in every sequence, no text."""

    def string(self, path: str, offset: int) -> bytes:
        return b""

    def length(self, path: str, offset: int) -> int:
        return 1


def test_the_readme_s_table_of_topics_is_the_table_of_the_code() -> None:
    text = (ROOT / "thruster_msgs" / "README.md").read_text("utf-8")
    table = "| topic | type | content |\n|---|---|---|\n" + topic_rows()
    assert table in text, "print(run_bag.known_topics.topic_rows()) gives the rows"


def test_the_page_of_channels_and_units_is_what_the_tables_of_the_code_say() -> None:
    script = ROOT / "scripts/workspace/channels_page.py"
    made = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=600.0, check=True)
    page = (ROOT / "docs/channels.md").read_text("utf-8")
    assert made.stdout == page, f"{script.name} > docs/channels.md makes it anew"
    assert all(f"`{unit}`" in page for taken in CONVERSIONS.values() for unit in taken)


def rows_of(heading: str) -> list[list[str]]:
    """Return the cells of the table below a line of the page of channels that begins so."""
    page = (ROOT / "docs/channels.md").read_text("utf-8")
    (table,) = re.findall(rf"^{re.escape(heading)}.*\n\n\|.*\n\|.*\n((?:\|.*\n)+)", page, re.MULTILINE)
    return [[cell.strip().replace("`", "") for cell in row.strip("|").split("|")] for row in table.splitlines()]


def test_words_of_columns_that_the_page_lists_are_proposed_as_their_channels(tmp_path: Path) -> None:
    rows = rows_of("Of columns of one thruster")
    assert len(rows) >= 8
    for channel, words in rows:
        for word in words.split(", "):
            (tmp_path / "x.csv").write_text(f"time,{word}\n" + "".join(f"{0.1 * k},{k}.5\n" for k in range(9)))
            assert f"\nthruster_0/{channel}: {{column: {word}," in guess([CsvSource(tmp_path / "x.csv")]), word


def test_words_of_topics_that_the_page_lists_are_proposed_as_their_channels() -> None:
    rows = rows_of("Of topics of a bench")
    assert len(rows) >= 5
    for channel, message, words in rows:
        kind, path = message.split(", ")
        package = "sensor_msgs" if kind == "JointState" else "geometry_msgs"
        for word in words.split(", "):
            rule = next(
                rule for rule in (*OF_BENCH, *OF_TYPE)
                if re.fullmatch(rule.types, f"{package}/msg/{kind}") and re.search(rule.topics, f"one/{word}")
                and re.fullmatch(rule.path, path if "." in path else f"{path}[0]")
            )  # fmt: skip
            assert rule.channel.replace("{i}", "0").replace("{part}", "force.x") == f"thruster_0/{channel}", word


def test_the_channels_of_a_map_have_units_and_are_all_that_a_proposal_or_a_fit_names() -> None:
    listed = {c.name: c for c in channels()}
    for c in listed.values():
        topic, _, path = c.name.replace("<i>", "0").partition(".")
        for part in c.parts or ("",):
            assert unit_in_map(topic_type(topic) or "", f"{path}.{part}".rstrip("."), topic), c.name
    proposed = {rule.channel for rule in (*LOGS, *THRUSTER, *VEHICLE)} | set(BY_UNIT.values())
    named = {re.sub(r"\.\{(axis|angle|part)\}$", "", name).replace("{i}", "<i>") for name in proposed}
    assert named | {f"thruster_<i>/{channel}" for channel in CHANNELS.values()} <= set(listed)


@pytest.mark.parametrize(
    ("topic", "kind"),
    [
        ("/rov/thruster_failure", "thruster_msgs/msg/ThrusterFailure"),
        ("thruster_3/throttle_sent", "thruster_msgs/msg/Throttle"),
        ("daq/thruster_12/load", "geometry_msgs/msg/WrenchStamped"),
        ("/clock", "rosgraph_msgs/msg/Clock"),
        ("thruster_x/load", None),
        ("other/thruster_0/load", None),
    ],
)
def test_topics_are_known_by_name_with_any_thruster_s_number(topic: str, kind: str | None) -> None:
    assert topic_type(topic) == kind


def test_thrusters_and_vehicle_have_their_own_lists() -> None:
    assert KNOWN["throttle_sent"] == KNOWN["throttle"] and "rov/thruster_failure" in KNOWN_VEHICLE


@pytest.mark.parametrize("topic", topics(), ids=lambda t: t.name)
def test_every_numeric_field_of_a_known_topic_has_its_unit(topic) -> None:
    if topic.type.split("/")[0] in ("visualization_msgs",) or topic.name in ("rov/path",):
        pytest.skip("drawn for viewers: no channels are made of it")
    fields = definitions().fields(topic.type)
    paths = [f.path for f in layout(fields, topic.type, OneOfEach()).fields]
    own = [re.sub(r"\[\d+\]", "", p) for p in paths if "header.stamp" not in p and not p.endswith(".sec.nanosec")]
    lacking = [p for p in own if not unit_of(topic.type, p, topic.name) and not unit_of(topic.type, f"{p}[0]")]
    assert not lacking


@pytest.mark.parametrize("name", sorted(p.stem for p in (ROOT / "thruster_msgs" / "msg").glob("*.msg")))
def test_every_field_of_our_messages_is_in_the_table(name: str) -> None:
    text = (ROOT / "thruster_msgs" / "msg" / f"{name}.msg").read_text("utf-8")
    table = {re.sub(r"\[\d+\]", "", path) for path in UNITS[f"thruster_msgs/msg/{name}"]}
    assert set(FIELD.findall(text)) == table


def test_covariances_have_the_units_of_their_rows_and_columns() -> None:
    assert unit_of("nav_msgs/msg/Odometry", "twist.covariance[3]") == "m rad/s^2"
    assert unit_of("nav_msgs/msg/Odometry", "pose.covariance[35]") == "rad^2"
    assert unit_of("thruster_msgs/msg/ThrusterEstimate", "covariance[4]") == "m^2/s^2"
    assert unit_of("geometry_msgs/msg/Vector3Stamped", "vector.x") == ""
    assert unit_of("geometry_msgs/msg/Vector3Stamped", "vector.x", "rov/attitude") == "rad"
