"""One recording whose effect is drawn at random and sealed; opened once it has been diagnosed."""

import argparse
import json
import secrets
import sys
from collections.abc import Sequence
from pathlib import Path

from gap_diagnosis.blind_check.cases import MODELS, draw, plan, recordings
from gap_diagnosis.blind_check.judging import right
from gap_diagnosis.blind_check.sealing import BrokenSealError
from gap_diagnosis.blind_check.store_io import Store, nominal_parameters, write_case
from run_bag.command_line import user_arguments
from safe_files.whole_files_io import expect_new_folder

__all__ = ["main"]


def main(arguments: Sequence[str] | None = None) -> int:
    """Seal a case, or open it beside its diagnosis; return the exit status."""
    parser = argparse.ArgumentParser(prog="sealed_case", description=__doc__)
    parser.add_argument("folder", type=Path, help="of the case: new to seal one, that of a sealed one to open it")
    parser.add_argument("--model", choices=list(MODELS), default="hl", help="thruster model (default hl)")
    parser.add_argument("--seed", type=int, help="of all that is drawn (default: at random)")
    help_open = "open the seal and hold it against this diagnosis.json"
    parser.add_argument("--open", type=Path, metavar="DIAGNOSIS", help=help_open)
    given = parser.parse_args(user_arguments(arguments))
    try:
        return _seal(given.folder, given.model, given.seed) if given.open is None else _open(given.folder, given.open)
    except (BrokenSealError, ValueError, OSError) as error:
        print(f"sealed_case: {error}", file=sys.stderr)
        return 1


def _seal(folder: Path, model: str, seed: int | None) -> int:
    expect_new_folder(folder)
    drawn = secrets.randbelow(2**31) if seed is None else seed
    store, (case_plan,) = Store(folder, drawn), plan(1, drawn, kinds=("effect",), model=model)
    print(f"sealed; SHA-256 of the key: {store.publish([case_plan])}")
    case = draw(case_plan, drawn, nominal_parameters())
    for path in write_case(folder, case, recordings(case, nominal_parameters())):
        print(path)
    return 0


def _open(folder: Path, diagnosis: Path) -> int:
    names = list(Store(folder, 0).hashes())
    if len(names) != 1:
        raise ValueError(f"{folder}: expected one sealed case, found {len(names)}")
    key = Store(folder, 0).key(names[0])
    found = json.loads(diagnosis.read_text("utf-8"))
    sizes = "; ".join(
        f"{name}: {', '.join(f'{parameter} {value:.4g}' for parameter, value in parameters.items())}"
        for name, parameters in key["effects"].items()
    )
    print(f"the seal is unbroken; hidden was {sizes}, beside parameters that are off by 5 % at random")
    claimed = ", ".join(claim["id"] for claim in found["effects"]) or "nothing"
    print(f"the verdict was '{found['verdict']}', claimed {claimed}: {'right' if right(key, found) else 'not right'}")
    if not found["effects"] and not right(key, found):
        print("an effect too small to show in these recordings looks like this: docs/scoreboard.md says what is missed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
