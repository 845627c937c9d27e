"""Results of a study on disk: one file per shard, written whole, so that nothing that was finished is lost.

DIR/plan.json      the plan; a folder with another plan is refused
DIR/shards/S.json  scores of one strategy on one reference (a set point, or a case of settings), a block of seeds
"""

import json
from collections.abc import Iterable, Mapping
from math import isfinite
from pathlib import Path
from typing import NamedTuple

from safe_files.whole_files_io import write_whole

__all__ = ["BLOCK", "Scores", "Shard", "Store", "scores_of", "shards_of"]

BLOCK = 25
"""Seeds in a shard."""
Scores = dict[str, list[float | None]]
"""Of each score the values over the seeds, None for one that does not exist."""


class Shard(NamedTuple):
    """A strategy, what it is tried on, and seeds first <= seed < last; names without a dot."""

    strategy: str
    reference: str
    first: int
    last: int

    @property
    def file(self) -> str:
        """Name of its file."""
        return f"{self.strategy}.{self.reference}.{self.first:06d}-{self.last:06d}.json"


def shards_of(strategies: Iterable[str], references: Iterable[str], seeds: int) -> list[Shard]:
    """Return the shards of a study; a later study of more seeds has all full ones of an earlier."""
    blocks = [(first, min(first + BLOCK, seeds)) for first in range(0, seeds, BLOCK)]
    references = tuple(references)
    return [Shard(s, r, *block) for s in strategies for r in references for block in blocks]


def scores_of(names: Iterable[str], runs: Iterable[Mapping[str, float]]) -> Scores:
    """Return the scores of runs, seed by seed, each under its name."""
    found = list(runs)
    return {name: [run[name] if isfinite(run[name]) else None for run in found] for name in names}


class Store:
    """The folder of one study: `plan`, its text; `names`, of the scores that each seed has.

    Raises:
        FileExistsError: there is something else, or a study with another plan.
    """

    def __init__(self, folder: Path, plan: str, names: Iterable[str]) -> None:
        self.folder, self.plan, self.names = folder, plan, frozenset(names)
        file = folder / "plan.json"
        if folder.exists() and not folder.is_dir():
            raise FileExistsError(f"{folder}: expected a folder; found a file")
        if file.exists():
            if file.read_text("utf-8") != plan:
                raise FileExistsError(f"{folder}: expected this plan or a new folder; found a study of another plan")
        elif folder.exists() and any(folder.iterdir()):
            raise FileExistsError(f"{folder}: expected a study or a new or empty folder; found other files")
        (folder / "shards").mkdir(parents=True, exist_ok=True)
        if not file.exists():
            _write(file, plan)

    def has(self, shard: Shard) -> bool:
        """Return whether the shard is finished."""
        return (self.folder / "shards" / shard.file).exists()

    def save(self, shard: Shard, scores: Scores) -> None:
        """Keep a finished shard."""
        _write(self.folder / "shards" / shard.file, json.dumps(scores, allow_nan=False))

    def load(self, shard: Shard) -> Scores:
        """Return a finished shard's scores.

        Raises:
            ValueError: the file is not what was written.
        """
        file = self.folder / "shards" / shard.file
        found = json.loads(file.read_text("utf-8"))
        if set(found) != self.names or {len(v) for v in found.values()} != {shard.last - shard.first}:
            raise ValueError(f"{file}: expected {shard.last - shard.first} values of each score; found something else")
        return dict(found)


def _write(file: Path, text: str) -> None:
    write_whole(file, text, replace=True)
