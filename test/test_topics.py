"""The topics of the vehicle: one list in the messages' README, one in the code that reads and imports recordings."""

import re
from pathlib import Path

import pytest

from run_bag.known_topics import KNOWN_VEHICLE, topic_type
from run_bag.units import UNITS

ROOT = Path(__file__).resolve().parents[1]
ROW = re.compile(r"^\| `(rov/\w+)` \| `(\w+)/(\w+)` \|", re.MULTILINE)
FIELD = re.compile(r"^(?:float64|uint8)(?:\[\d+\])? (\w+) ", re.MULTILINE)


def listed() -> dict[str, str]:
    text = (ROOT / "thruster_msgs" / "README.md").read_text("utf-8")
    return {topic: f"{package}/msg/{kind}" for topic, package, kind in ROW.findall(text)}


def test_recordings_know_every_topic_of_the_vehicle_that_the_readme_lists() -> None:
    assert listed() == KNOWN_VEHICLE
    assert topic_type("/rov/thruster_failure") == "thruster_msgs/msg/ThrusterFailure"


@pytest.mark.parametrize("name", ["VehicleSetpoint", "ThrusterFailure", "Depth"])
def test_every_field_of_the_vehicle_s_messages_has_its_unit_in_recordings(name: str) -> None:
    text = (ROOT / "thruster_msgs" / "msg" / f"{name}.msg").read_text("utf-8")
    assert set(FIELD.findall(text)) == set(UNITS[f"thruster_msgs/msg/{name}"])
