#!/usr/bin/env bash
# The study behind docs/bench_study.md: the thesis' 24 closed-loop experiments (section 5.1) and two more strategies,
# simulated under several assumptions, and whether the simulator predicts the scores of the real runs.
#
# usage: scripts/bench_study.sh PATH [OUT]     PATH: the bench's recordings; writes OUT/tables/tables.md and two pictures
#        SEEDS=200 FEWER_SEEDS=50 PROCESSES=1: thrusters drawn in the main study and in the others, and processes
#        PLANTS="retuned=…/diagnosis.json" adds plants to predict the real runs with: NAME=YAML or NAME=diagnosis.json
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
[ $# -ge 1 ] && [ -d "$1" ] || { printf 'usage: %s PATH [OUT]: expected a folder of recordings; found %s\n' "$0" "${1:-nothing}" >&2; exit 2; }
out=${2:-$root/runs/bench-study-$(date +%Y%m%d-%H%M%S)}
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"
mkdir -p "$out"
if [ ! -d "$out/recordings" ]; then
    ros2 run run_bag import_bench "$1" --out "$out/recordings" >"$out/import.txt"
fi
# The plant as identified here, from the open-loop runs of the thesis' Fig. 4.2 and their neighbours.
if [ ! -d "$out/fit" ]; then
    mapfile -t open < <(ros2 run run_bag info "$out/recordings" --list --where 'experiment=open loop' | grep -E '[pm][23]V$')
    ros2 run thruster_model fit "${open[@]}" --model hl --out "$out/fit"
fi
study() {  # name, seeds, further options: resumes where it was interrupted
    printf '[bench study] %s\n' "$1"
    ros2 run rov_sim bench_study --seeds "$2" --processes "${PROCESSES:-1}" --seed 1 --real "$out/recordings" \
        --out "$out/$1" "${@:3}"
}
many=${SEEDS:-200} few=${FEWER_SEEDS:-50}
study bench "$many" --strategies all
study bench_quiet "$many" --strategies all --spikes 0
study proper "$few" --strategies all --form proper
study proper_quiet "$few" --strategies all --form proper --spikes 0
study gated "$few" --form gated
study gated_quiet "$few" --form gated --spikes 0
study late "$few" --computation 0.02
study nominal "$few" --deviation 0
study hq_plant "$few" --plant hq
study identified "$few" --plant "$out/fit/hl.yaml"
studies=()
for name in bench proper gated; do
    studies+=(--study "$name=$out/$name" --without-spikes "$name=$out/${name}_quiet")
done
for name in late nominal hq_plant identified; do studies+=(--study "$name=$out/$name"); done
plants=(--plant hl_bench --plant hq)
for plant in ${PLANTS-}; do plants+=(--plant "$plant"); done
rm -rf "$out/tables"
ros2 run rov_sim bench_study_table "${studies[@]}" --real "$out/recordings" "${plants[@]}" \
    --plant "identified=$out/fit/hl.yaml" --seeds "$few" --seed 1 --out "$out/tables"
