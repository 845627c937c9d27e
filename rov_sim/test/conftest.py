"""Tests of this folder share modules: a graph of the bench, vehicles that move, and runs of them."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
