"""The reference of vehicles in the documentation is the one that the code gives."""

from pathlib import Path

from rov_sim.cli_reference import reference
from rov_sim.vehicle.effects.active import VEHICLE_LIBRARY

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_page_is_up_to_date() -> None:
    assert (DOCS / "vehicles.md").read_text("utf-8") == reference()


def test_every_effect_is_listed() -> None:
    assert all(f"`{name}`" in reference() for name in VEHICLE_LIBRARY)


def test_a_frame_s_motors_push_the_ways_that_ardusub_gives() -> None:
    assert "| `bluerov1` | forward; forward; up; up; up; starboard |" in reference()
    assert (
        "| `vectored` | backward and starboard; backward and port; forward and starboard; forward and port; down;"
        in (reference())
    )


def test_what_an_effect_s_row_leaves_open_stands_below_the_table() -> None:
    noted = [effect for effect in VEHICLE_LIBRARY.values() if effect.note]
    assert noted and all(f"\n- `{effect.id}`: {effect.note}.\n" in reference() for effect in noted)
