"""Tests of this folder share `spring`, a system of their own."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
