#!/usr/bin/env bash
# The main job, end to end: bench recordings -> runs -> identified thruster models -> report; three control strategies
# compared in simulation; a live experiment on the emulated bench, recorded, replayed and diagnosed; then a thruster
# with a hidden effect -> recordings -> diagnosis -> what was hidden.
#
# usage: scripts/demo.sh              a short synthetic bench campaign, simulated here
#        scripts/demo.sh --vehicle    a vehicle instead: an effect hidden on one thruster of a dive in lockstep, named from
#                                     the dive's recording, and the seal opened
#        scripts/demo.sh PATH...      recordings of a bench (csv, csv.xz with dat or mat beside them), files or folders
#
# Results go to a new folder under runs/ (or under $DEMO_OUT); the last lines printed are the paths of the reports.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
vehicle=false
if [ "${1-}" = --vehicle ]; then
    vehicle=true
    shift
    [ $# -eq 0 ] || { printf '%s: expected nothing after --vehicle\n' "$1" >&2; exit 1; }
fi
for path in "$@"; do
    [ -e "$path" ] || { printf '%s: expected recordings, found nothing there\n' "$path" >&2; exit 1; }
done
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"

mkdir -p "${DEMO_OUT:-$root/runs}"
out=$(mktemp -d "${DEMO_OUT:-$root/runs}/demo-$(date +%Y%m%d-%H%M%S)-XXXX")
if $vehicle; then
    printf '[demo] an effect on one thruster of the vehicle ngs is drawn at random and sealed\n'
    ros2 run gap_diagnosis sealed_vehicle "$out/sealed" --vehicle ngs
    printf '[demo] a dive in lockstep: the plant alone is told\n'
    ROV_EXPERIMENT_READY=1 "$root/scripts/rov_experiment.sh" --vehicle ngs --strategy lookup --composed \
        --effects "$(<"$out/sealed/sealed/effects.txt")" --out "$out/dive"
    printf '[demo] diagnosing it from its recording alone (some minutes)\n'
    ros2 run gap_diagnosis diagnose_vehicle "$out/dive/run" --vehicle ngs --out "$out/diagnosis"
    printf '[demo] opening the seal\n'
    ros2 run gap_diagnosis sealed_vehicle "$out/sealed" --open "$out/diagnosis/diagnosis.json"
    printf '%s\n' "$out/dive/scores/report.html" "$out/diagnosis/report.html"
    exit
fi
if [ $# -eq 0 ]; then
    printf '[demo] recording a synthetic bench campaign\n'
    ros2 run rov_sim bench_campaign --out "$out/recordings" --seed 1
    fit=("$out"/recordings/*/)
    options=()
else
    printf '[demo] importing recordings\n'
    # One unreadable recording must not keep the others away; the importer has said what is wrong with it.
    ros2 run run_bag import_bench "$@" --out "$out/recordings" || true
    [ -d "$out/recordings" ] || { printf '[demo] none of these is a recording of a bench\n' >&2; exit 1; }
    # Fitted: what was recorded to identify the thruster in water. Predicted only: what it did under control.
    mapfile -t fit < <(ros2 run run_bag info "$out/recordings" --list --where 'experiment=open loop')
    mapfile -t others < <(ros2 run run_bag info "$out/recordings" --list --where 'experiment=closed loop')
    options=()
    [ ${#others[@]} -eq 0 ] || options=(--validate "${others[@]}")
    [ ${#fit[@]} -gt 0 ] || { printf '[demo] none of the recordings was made to identify a thruster\n' >&2; exit 1; }
fi
printf '[demo] fitting simplified, HL and HQ to %d runs\n' "${#fit[@]}"
ros2 run thruster_model fit "${fit[@]}" --model simplified hl hq "${options[@]}" --out "$out/fit"

printf '\n[demo] comparing three control strategies on ten simulated thrusters\n'
ros2 run rov_sim bench_study --strategies lookup,hl-ekf,hl-nlo --references step,sine --seeds 10 --out "$out/control"

printf '\n[demo] a live experiment on the emulated bench: recorded, replayed through two observers, diagnosed\n'
"$root/scripts/bench_experiment.sh" --reference triangle --strategy hl-ekf --out "$out/live"
ros2 run thruster_estimation replay "$out/live/run" --estimator ekf nlo --model hl_bench --out "$out/replay"
ros2 run gap_diagnosis diagnose "$out/live/run" --model hl_bench --out "$out/live_diagnosis"

printf '\n[demo] recording a thruster whose unmodelled effect is drawn at random and sealed\n'
ros2 run gap_diagnosis sealed_case "$out/sealed"
printf '[demo] diagnosing it from its recordings alone\n'
ros2 run gap_diagnosis diagnose "$out"/sealed/runs/*/ --model "$out/sealed/model.yaml" --out "$out/diagnosis"
printf '[demo] opening the seal\n'
ros2 run gap_diagnosis sealed_case "$out/sealed" --open "$out/diagnosis/diagnosis.json"
printf '%s\n' "$out/fit/report.html" "$out/control/report.html" "$out/live/scores/report.html" \
    "$out/replay/report.html" "$out/live_diagnosis/report.html" "$out/diagnosis/report.html"
