"""The seal of a dive: what the plant is told is what was sealed, and a seal that was touched is not opened."""

import json
from pathlib import Path

import pytest

from gap_diagnosis.vehicle.cli_sealed_vehicle import judged, main
from rov_sim.vehicle.effects.words import effects_of_words


def test_the_plant_is_told_what_is_sealed_and_the_seal_opens(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "sealed"
    assert main([str(folder), "--vehicle", "ngs", "--seed", "4"]) == 0
    assert "SHA-256" in capsys.readouterr().out
    key = json.loads((folder / "sealed" / "key.json").read_text("utf-8"))
    (effect,) = effects_of_words((folder / "sealed" / "effects.txt").read_text("utf-8").split())
    assert (effect.id, effect.thruster, dict(effect.sizes)) == (key["id"], key["thruster"], key["sizes"])
    claim = {"id": key["id"], "thruster": key["thruster"], "indistinguishable_from": [], "words": "it"}
    diagnosis = tmp_path / "diagnosis.json"
    diagnosis.write_text(json.dumps({"verdict": "effect", "summary": "That.", "effects": [claim]}), "utf-8")
    assert main([str(folder), "--open", str(diagnosis)]) == 0
    assert "right: that effect on that thruster" in capsys.readouterr().out
    (folder / "sealed" / "key.json").write_text(json.dumps({**key, "thruster": 5 - key["thruster"]}), "utf-8")
    assert main([str(folder), "--open", str(diagnosis)]) == 1
    assert "broken" in capsys.readouterr().err


def test_seeds_draw_all_thrusters_and_effects(tmp_path: Path) -> None:
    keys = []
    for seed in range(40):
        main([str(tmp_path / str(seed)), "--seed", str(seed)])
        keys.append(json.loads((tmp_path / str(seed) / "sealed" / "key.json").read_text("utf-8")))
    assert {k["thruster"] for k in keys} == set(range(6)) and len({k["id"] for k in keys}) == 2


@pytest.mark.parametrize(
    ("claims", "said"),
    [
        ([], "not right"),
        ([("thrust_loss", 2, [])], "not right: the thruster, but another effect"),
        ([("thrust_loss", 1, [("throttle_gain", 2)])], "among what the recordings could not tell"),
        ([("throttle_gain", 2, []), ("cg_shift", None, [])], "more was named beside it: cg_shift"),
    ],
)
def test_what_was_named_is_judged(claims: list[tuple[str, int, list[tuple[str, int]]]], said: str) -> None:
    rows = [
        {"id": e, "thruster": t, "words": e, "indistinguishable_from": [{"id": a, "thruster": b} for a, b in near]}
        for e, t, near in claims
    ]
    assert said in judged({"id": "throttle_gain", "thruster": 2, "sizes": {"share": 0.3}}, {"effects": rows})
