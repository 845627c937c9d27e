"""Results from the shards of a study, and as a table in CSV."""

import csv
import io
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from rov_sim.study.results import Results, merged
from rov_sim.study.store_io import Shard, Store
from safe_files.whole_files_io import write_whole

__all__ = ["finished_shards", "read_results", "write_table"]


def read_results(store: Store, shards: Sequence[Shard]) -> Results:
    """Return the results of finished shards."""
    return merged((shard.strategy, shard.reference, store.load(shard)) for shard in shards)


def finished_shards(folder: Path, strategies: Sequence[str], references: Sequence[str]) -> tuple[str, list[Shard]]:
    """Return the plan's text and all shards of a study's folder, in the order of the names given.

    Raises:
        ValueError: no study, names that are not among the given ones, or strategies with other seeds than the rest.
    """
    file = folder / "plan.json"
    if not file.exists():
        raise ValueError(f"{folder}: expected the folder of a study (plan.json); found none")
    shards = []
    for path in sorted((folder / "shards").glob("*.json")):
        strategy, reference, seeds, _ = path.name.split(".")
        first, last = map(int, seeds.split("-"))
        shards.append(Shard(strategy, reference, first, last))
    shards.sort(key=lambda s: (strategies.index(s.strategy), references.index(s.reference), s.first))
    covered: dict[tuple[str, str], list[tuple[int, int]]] = {}
    for shard in shards:
        covered.setdefault((shard.strategy, shard.reference), []).append((shard.first, shard.last))
    if not covered or len({tuple(blocks) for blocks in covered.values()}) != 1:
        raise ValueError(f"{folder}: expected the same seeds of every strategy and set point; resume the study first")
    return file.read_text("utf-8"), shards


def write_table(study: Results, file: Path, units: Mapping[str, str]) -> None:
    """Write a line for each strategy, reference and seed; `units`: of each score by its name, in the columns' order."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["strategy", "reference", "seed", *(f"{name} [{unit}]" for name, unit in units.items())])
    for (strategy, reference), scores in study.scores.items():
        for seed in range(study.seeds):
            cells = [scores[name][seed] for name in units]
            writer.writerow([strategy, reference, seed, *("" if np.isnan(x) else f"{x:.6g}" for x in cells)])
    write_whole(file, text.getvalue(), replace=True)
