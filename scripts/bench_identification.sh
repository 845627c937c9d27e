#!/usr/bin/env bash
# The study behind docs/bench_identification.md: models fitted to the thesis' bench, against the published parameters,
# on the runs of the fit and with each run left out.
#
# usage: scripts/bench_identification.sh PATH [OUT]     PATH: the bench's recordings; writes OUT/table.md and the report
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
[ $# -ge 1 ] && [ -d "$1" ] || { printf 'usage: %s PATH [OUT]: expected a folder of recordings; found %s\n' "$0" "${1:-nothing}" >&2; exit 2; }
out=${2:-$root/runs/bench-identification-$(date +%Y%m%d-%H%M%S)}
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"
mkdir -p "$out"
ros2 run run_bag import_bench "$1" --out "$out/recordings" >"$out/import.txt"
# The runs of the thesis' Fig. 4.2 and their neighbours: the open-loop ones at 2 and 3 V, either direction.
mapfile -t runs < <(ros2 run run_bag info "$out/recordings" --list --where 'experiment=open loop' | grep -E '[pm][23]V$')
ros2 run thruster_model fit "${runs[@]}" --model simplified hl hq --hold-out --out "$out/fit"
ros2 run thruster_model fit_table "$out/fit" >"$out/table.md"
printf '%s\n' "$out/table.md"
