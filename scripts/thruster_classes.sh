#!/usr/bin/env bash
# The study behind docs/thruster_classes.md: every class of thruster model fitted to the thesis' bench and judged on the
# runs that its fit has not seen.
#
# usage: scripts/thruster_classes.sh PATH [OUT]     PATH: the bench's recordings; writes OUT/table.md and OUT/classes.svg
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
[ $# -ge 1 ] && [ -d "$1" ] || { printf 'usage: %s PATH [OUT]: expected a folder of recordings; found %s\n' "$0" "${1:-nothing}" >&2; exit 2; }
out=${2:-$root/runs/thruster-classes-$(date +%Y%m%d-%H%M%S)}
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"
mkdir -p "$out"
ros2 run run_bag import_bench "$1" --out "$out/recordings" >"$out/import.txt"
mapfile -t runs < <(ros2 run run_bag info "$out/recordings" --list --where 'experiment=open loop' | grep -E '[pm][23]V$')
ros2 run thruster_model fit "${runs[@]}" --hold-out --out "$out/fit" --model simplified hl hq two_state airfoil kim_chung \
    four_quadrant bessa yoerger first_order static_dead_band static_quadratic table
ros2 run thruster_model class_table "$out/fit" --picture "$out/classes.svg" >"$out/table.md"
printf '%s\n' "$out/table.md"
