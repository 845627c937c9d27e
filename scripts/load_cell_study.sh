#!/usr/bin/env bash
# The study behind docs/load_cell.md: the load cell of the thesis' bench calibrated from its own recordings, its
# structural mode identified, and the thrust recovered that the thesis' scores leave out as ringing.
#
# usage: scripts/load_cell_study.sh PATH [OUT]     PATH: the bench's recordings; writes OUT/load_cell and two pictures
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
[ $# -ge 1 ] && [ -d "$1" ] || { printf 'usage: %s PATH [OUT]: expected a folder of recordings; found %s\n' "$0" "${1:-nothing}" >&2; exit 2; }
out=${2:-$root/runs/load-cell-$(date +%Y%m%d-%H%M%S)}
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"
mkdir -p "$out"
ros2 run run_bag import_bench "$1" --out "$out/recordings" >"$out/import.txt"
ros2 run thruster_model load_cell "$out"/recordings/*/ --out "$out/load_cell" | tee "$out/summary.txt"
python - "$out" <<'PYTHON'
import re
import sys
from pathlib import Path

from run_bag.report.browser_check import missing_browser, screenshot

out = Path(sys.argv[1])
page = out / "load_cell/report.html"
if missing := missing_browser():
    sys.exit(f"no pictures: {missing}")
text = page.read_text("utf-8")
for name, caption in (("load_cell_mode", "Frequency and damping"), ("load_cell_step", "CLLookupStep: the load cell")):
    figure = re.findall(r'id="(figure-\d+)"', text[: text.index(caption)])[-1]
    screenshot(page, out / f"{name}.png", width=1366, height=700, full_page=False, scroll_to=figure)
    print(out / f"{name}.png")
PYTHON
