"""Draw an effect on one thruster of a vehicle and seal it for a dive; open it beside the diagnosis."""

import argparse
import json
import secrets
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gap_diagnosis.blind_check.sealing import BrokenSealError, Seal, seal, unseal
from run_bag.command_line import user_arguments
from safe_files.whole_files_io import new_folder, write_whole
from thruster_model.errors import ThrusterModelError
from thruster_model.vehicle_set_io import available_vehicles, load_vehicle_set

__all__ = ["main"]

HIDDEN = {"thrust_loss": ("share", 0.25, 0.6), "throttle_gain": ("share", 0.25, 0.5)}
"""Effects that are hidden: parameter, least and largest size. A dive of some minutes shows each of them."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Seal an effect, or open it; return the exit status."""
    parser = argparse.ArgumentParser(prog="sealed_vehicle", description=__doc__)
    parser.add_argument("folder", type=Path, help="of the seal: new to seal, that of a seal to open it")
    sets = ", ".join(available_vehicles())
    parser.add_argument("--vehicle", default="ngs", help=f"set of the vehicle: {sets} or YAML (default %(default)s)")
    parser.add_argument("--seed", type=int, help="of what is drawn (default: at random)")
    parser.add_argument("--open", type=Path, metavar="DIAGNOSIS", help="open the seal beside this diagnosis.json")
    given = parser.parse_args(user_arguments(arguments))
    try:
        return _seal(given.folder, given.vehicle, given.seed) if given.open is None else _open(given.folder, given.open)
    except (BrokenSealError, ThrusterModelError, ValueError, KeyError, OSError) as error:
        print(f"sealed_vehicle: {error}", file=sys.stderr)
        return 1


def _seal(folder: Path, vehicle: str, seed: int | None) -> int:
    layout = load_vehicle_set(vehicle).layout
    rng = np.random.default_rng(secrets.randbelow(2**31) if seed is None else seed)
    effect = str(rng.choice(list(HIDDEN)))
    parameter, least, largest = HIDDEN[effect]
    thruster, size = int(rng.integers(len(layout))), round(float(rng.uniform(least, largest)), 3)
    key: dict[str, Any] = {"id": effect, "thruster": thruster, "sizes": {parameter: size}}
    sealed = seal(key, b"", secrets.token_hex(16))
    with new_folder(folder) as new:
        (new / "sealed").mkdir()
        write_whole(new / "sealed" / "key.json", sealed.key)
        # what the plant is told, and nobody else
        write_whole(new / "sealed" / "effects.txt", f"{effect}[T{thruster + 1}].{parameter}={size}\n")
        write_whole(new / "hash.txt", f"{sealed.hash}\n")
    print(f"sealed; SHA-256 of the key: {sealed.hash}")
    return 0


def _open(folder: Path, diagnosis: Path) -> int:
    found = json.loads(diagnosis.read_text("utf-8"))
    content = Seal((folder / "sealed" / "key.json").read_bytes(), b"")
    key = unseal(folder.name, content, (folder / "hash.txt").read_text("utf-8").strip())
    sizes = ", ".join(f"{name} {size:g}" for name, size in key["sizes"].items())
    print(f"the seal is unbroken; hidden was {key['id']} on thruster {key['thruster']}, {sizes}")
    print(f"the verdict was '{found['verdict']}': {found['summary']}")
    print(judged(key, found))
    return 0


def judged(key: dict[str, Any], found: dict[str, Any]) -> str:
    """Return whether a diagnosis named what was hidden."""
    claims = found["effects"]
    right = [c for c in claims if (c["id"], c["thruster"]) == (key["id"], key["thruster"])]
    near = [
        c for c in claims if any((r["id"], r["thruster"]) == (key["id"], key["thruster"])
        for r in c["indistinguishable_from"])
    ]  # fmt: skip
    if right and len(claims) == 1:
        return "right: that effect on that thruster, and nothing else"
    if right:
        return "right, but more was named beside it: " + ", ".join(c["words"] for c in claims if c not in right)
    if near:
        return "not right, but among what the recordings could not tell from what was named"
    if any(c["thruster"] == key["thruster"] for c in claims):
        return "not right: the thruster, but another effect"
    return "not right"


if __name__ == "__main__":
    sys.exit(main())
