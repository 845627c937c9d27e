"""Tests of this folder share `thruster_truth`, which writes the equations again."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
