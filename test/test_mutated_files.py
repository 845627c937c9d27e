"""Spoiled files before the readers of packages above `run_bag`; those of `run_bag` are in its own tests."""

from pathlib import Path

import pytest
from all_mutated_files import OTHERS
from mutated_files import mutate_all


@pytest.mark.parametrize("name", OTHERS)
def test_a_spoiled_file_gives_a_sentence_or_what_it_says_and_nothing_else(tmp_path: Path, name: str) -> None:
    count, wrong = mutate_all(tmp_path, {name: OTHERS[name]}, seconds=0.5, seed=1)
    assert count > 5
    assert not wrong, "\n".join(wrong[:5])
