#!/usr/bin/env bash
# The study behind docs/pool_rov.md: attitude rates of a small six-thruster vehicle in a pool, fitted to real recordings and
# predicted on those left out.
#
# usage: scripts/pool_rov.sh PATH [OUT]     PATH: folder with the recordings (*.npz) and the measured thrusts
#                                           (measuredthrust_T200.txt); not part of this repository
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
[ $# -ge 1 ] || { printf 'usage: %s PATH [OUT]\n' "$0" >&2; exit 2; }
shopt -s nullglob
recordings=("$1"/*.npz)
thrusts=$1/measuredthrust_T200.txt
[ ${#recordings[@]} -gt 1 ] && [ -f "$thrusts" ] || {
    printf '%s: expected at least two recordings (*.npz) and measuredthrust_T200.txt; nothing was done\n' "$1" >&2
    exit 2
}
out=${2:-$root/runs/pool-rov-$(date +%Y%m%d-%H%M%S)}
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"
mkdir -p "$out"
ros2 run run_bag import_pool "${recordings[@]}" --out "$out/recordings"
# a recording without any command is moved by something that nothing recorded: it is predicted, never fitted
fitted=() predicted=()
for run in "$out"/recordings/*/; do
    told=$(ros2 run run_bag info "$run")
    if [[ $told == *'no command was logged'* ]]; then predicted+=("$run"); else fitted+=("$run"); fi
done
# two columns, thrust [N] and command (-1 to 1); its supply voltage is not stated and counts as the nominal one
awk 'BEGIN { print "command,force,supply" } $1 ~ /^-?[0-9.]+$/ { print $2 "," $1 ",12" }' "$thrusts" >"$out/thrusts.csv"
cat >"$out/columns.yaml" <<'MAP'
name: T200 as measured for the pool vehicle
source: measuredthrust_T200.txt; supply voltage not stated, 12 V stands for it
command: {column: command, unit: "1", stop: 0}
supply: {column: supply, unit: V}
force: {column: force, unit: N}
MAP
ros2 run thruster_model force_table "$out/thrusts.csv" --map "$out/columns.yaml" --out "$out/table.yaml" \
    --set "$out/thruster.yaml"
ros2 run thruster_model attitude_fit "${fitted[@]}" ${predicted:+--validate "${predicted[@]}"} \
    --vehicle pool_rov --thruster "$out/thruster.yaml" --out "$out/fit" --seed 1
