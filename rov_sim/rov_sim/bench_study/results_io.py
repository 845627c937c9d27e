"""Results from the shards of a study, and as a table in CSV."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from rov_sim.bench_study.controllers import EXTRA, THESIS
from rov_sim.bench_study.experiment import KINDS, SCORES
from rov_sim.bench_study.results import Results, merged
from rov_sim.bench_study.store_io import Shard, Store

__all__ = ["UNITS", "read_results", "read_study", "write_table"]

UNITS = {
    "rmse": "N", "rmse_true": "N", "largest": "N", "overshoot": "1", "settling": "s", "chatter": "V", "n_hat": "rad/s",
    "v_hat": "m/s", "U_hat": "m/s", "v_spread": "m/s", "speed": "rad/s",
}  # fmt: skip


def read_results(store: Store, shards: Sequence[Shard]) -> Results:
    """Return the results of finished shards."""
    return merged((shard.strategy, shard.reference, store.load(shard)) for shard in shards)


def read_study(folder: Path) -> tuple[str, Results]:
    """Return the plan and all results of a study's folder.

    Raises:
        ValueError: no study, or strategies with other seeds than the rest.
    """
    file = folder / "plan.json"
    if not file.exists():
        raise ValueError(f"{folder}: expected the folder of a study (plan.json); found none")
    plan = file.read_text("utf-8")
    shards = []
    for path in sorted((folder / "shards").glob("*.json")):
        strategy, reference, seeds, _ = path.name.split(".")
        first, last = map(int, seeds.split("-"))
        shards.append(Shard(strategy, reference, first, last))
    strategies, references = (*THESIS, *EXTRA), tuple(KINDS)
    shards.sort(key=lambda s: (strategies.index(s.strategy), references.index(s.reference), s.first))
    covered: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for shard in shards:
        covered.setdefault((shard.strategy, shard.reference), []).append((shard.first, shard.last))
    if not covered or len({tuple(blocks) for blocks in covered.values()}) != 1:
        raise ValueError(f"{folder}: expected the same seeds of every strategy and set point; resume the study first")
    return plan, read_results(Store(folder, plan), shards)


def write_table(study: Results, file: Path) -> None:
    """Write a line for each strategy, set point and seed."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["strategy", "reference", "seed", *(f"{name} [{UNITS[name]}]" for name in SCORES)])
    for (strategy, reference), scores in study.scores.items():
        for seed in range(study.seeds):
            cells = [scores[name][seed] for name in SCORES]
            writer.writerow([strategy, reference, seed, *("" if np.isnan(x) else f"{x:.6g}" for x in cells)])
    partial = file.with_name(f".{file.name}")
    partial.write_text(text.getvalue(), "utf-8")
    partial.replace(file)
