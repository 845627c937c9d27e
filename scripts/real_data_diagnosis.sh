#!/usr/bin/env bash
# The study behind docs/real_data.md: the thesis' bench recordings diagnosed against the parameter sets.
#
# usage: scripts/real_data_diagnosis.sh PATH [OUT]     PATH: the bench's recordings; writes OUT/table.md, OUT/steady_states.md, the reports
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
[ $# -ge 1 ] && [ -d "$1" ] || { printf 'usage: %s PATH [OUT]: expected a folder of recordings; found %s\n' "$0" "${1:-nothing}" >&2; exit 2; }
out=${2:-$root/runs/real-data-$(date +%Y%m%d-%H%M%S)}
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"
mkdir -p "$out"
ros2 run run_bag import_bench "$1" --out "$out/recordings" >"$out/import.txt"

runs() { ros2 run run_bag info "$out/recordings" --list --where "experiment=$1"; }
diagnose() {  # name, parameter set, runs on standard input
    mapfile -t given
    printf '[real data] %s against %s: %d runs\n' "$1" "$2" "${#given[@]}"
    ros2 run gap_diagnosis diagnose "${given[@]}" --set "$2" --out "$out/$1" >"$out/$1.txt" 2>"$out/$1.log"
}
# The runs of the thesis' Fig. 4.2 and their neighbours: at 2 and 3 V, either direction.
open_loop() { runs 'open loop' | grep -E '[pm][23]V$'; }
for set in simplified hl hq hl_bench; do
    open_loop | diagnose "open_loop_$set" "$set"
done
runs 'closed loop' | diagnose closed_loop hl_bench
# The plant that predicts the scores of the closed-loop runs, each left out in turn: scripts/bench_study.sh.
{ runs 'closed loop'; open_loop; } | diagnose both_loops hl_bench
runs reversal | diagnose reversal hl
runs 'in air' | diagnose in_air hl
# Steady states: two tables of other years, with deviations of readings that repeated runs suggest.
steady() {  # name, parameter set, columns
    ros2 run gap_diagnosis steady_states "$1" --set "$2" --columns "$3" \
        --deviation thrust=0.3 --deviation torque=0.002 --deviation speed=1.5 --deviation axial=0.02 2>>"$out/steady.log"
}
for set in simplified hl; do
    {
        printf '## Steady_State_Data against %s\n\n' "$set"
        steady "$1/tables/Steady_State_Data.csv" "$set" throttle,thrust,torque,speed,axial
        printf '\n## Tach_RPM_Thrust_Data against %s\n\n' "$set"
        steady "$1/tables/Tach_RPM_Thrust_Data.csv" "$set" throttle,-,rpm,-,thrust,-,-
        printf '\n'
    } >>"$out/steady_states.md"
done
ros2 run gap_diagnosis diagnosis_table "$out"/*/diagnosis.json >"$out/table.md"
printf '%s\n' "$out/table.md" "$out/steady_states.md"
