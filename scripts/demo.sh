#!/usr/bin/env bash
# The main job, end to end: why do a simulator and recordings of a thruster disagree?
#
# usage: scripts/demo.sh                          a thruster with a hidden effect, recorded here; 2 to 3 minutes
#        scripts/demo.sh PATH... [--set SET]      the thesis' recordings (csv, csv.xz with dat or mat beside them), files
#                                                 or folders, against the parameter set of a simulator (hl)
#        scripts/demo.sh --vehicle                an effect hidden on one thruster of a vehicle's dive in lockstep
#
# Results go to a new folder under runs/ (or under $DEMO_OUT); the last line printed is the page that links them all.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
paths=() set=hl vehicle=false
while [ $# -gt 0 ]; do
    case "$1" in
    -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" && exit 0 ;;
    --set)
        [ $# -ge 2 ] || { printf 'demo.sh: --set: expected a parameter set\n' >&2; exit 2; }
        set=$2
        shift
        ;;
    --vehicle) vehicle=true ;;
    -*) printf "demo.sh: unknown option '%s'; --help lists them\n" "$1" >&2 && exit 2 ;;
    *)
        [ -e "$1" ] || { printf '%s: expected recordings, found nothing there\n' "$1" >&2; exit 1; }
        paths+=("$1")
        ;;
    esac
    shift
done
if $vehicle && [ ${#paths[@]} -gt 0 ]; then
    printf 'demo.sh: --vehicle: expected no recordings beside it\n' >&2
    exit 2
fi
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"

mkdir -p "${DEMO_OUT:-$root/runs}"
out=$(mktemp -d "${DEMO_OUT:-$root/runs}/demo-$(date +%Y%m%d-%H%M%S)-XXXX")
step() { printf '\n[demo %s] %s\n' "$1" "$2"; }
check() { # RUN...: what it refuses and its last line; a fit and a diagnosis say the former again
    thruster check "$@" --set "$set" >"$out/check.txt" || true
    grep '^!' "$out/check.txt" || true
    tail -n 1 "$out/check.txt"
    printf '%s: all of it\n' "$out/check.txt"
}

if $vehicle; then
    step 1/4 'hide: an effect on one thruster of the vehicle ngs is drawn at random and sealed'
    ros2 run gap_diagnosis sealed_vehicle "$out/sealed" --vehicle ngs
    step 2/4 'dive: the whole graph in lockstep, recorded; the plant alone is told'
    ROV_EXPERIMENT_READY=1 "$root/scripts/rov_experiment.sh" --vehicle ngs --strategy lookup --composed \
        --effects "$(<"$out/sealed/sealed/effects.txt")" --out "$out/dive"
    step 3/4 'diagnose: which effect on which thruster, from the recording alone (some minutes)'
    ros2 run gap_diagnosis diagnose_vehicle "$out/dive/run" --vehicle ngs --out "$out/diagnosis"
    step 4/4 'open the seal'
    ros2 run gap_diagnosis sealed_vehicle "$out/sealed" --open "$out/diagnosis/diagnosis.json"
    title='Demo: a vehicle with a hidden effect'
elif [ ${#paths[@]} -gt 0 ]; then
    step 1/4 'import: the recordings become runs, every sample kept, every decision written into the run'
    # One unreadable recording must not keep the others away; the importer has said what is wrong with it.
    ros2 run run_bag import_bench "${paths[@]}" --out "$out/recordings" || true
    [ -d "$out/recordings" ] || { printf '[demo] none of these is a recording of a bench\n' >&2; exit 1; }
    # What was recorded to identify the thruster in water, else all of it.
    mapfile -t runs < <(ros2 run run_bag info "$out/recordings" --list --where 'experiment=open loop')
    [ ${#runs[@]} -gt 0 ] || runs=("$out/recordings"/*/)
    step 2/4 "check: what ${#runs[@]} runs are good for"
    check "${runs[@]}"
    step 3/4 'fit: how far re-tuned parameters alone get'
    thruster fit "${runs[@]}" --model simplified hl hq --out "$out/fit"
    step 4/4 "diagnose: why the recordings and a simulator with the set $set disagree"
    thruster diagnose "${runs[@]}" --set "$set" --out "$out/diagnosis"
    title='Demo: your recordings'
else
    step 1/5 'record: a thruster whose unmodelled effect is drawn at random and sealed'
    ros2 run gap_diagnosis sealed_case "$out/sealed"
    set=$out/sealed/model.yaml runs=("$out"/sealed/runs/*/)
    step 2/5 'check: what the recordings are good for, before any fit'
    check "${runs[@]}"
    step 3/5 'fit: how far re-tuned parameters alone get'
    thruster fit "${runs[@]}" --model hl --start "$set" --out "$out/fit"
    step 4/5 'diagnose: why simulator and recordings disagree, from the recordings alone; then the seal is opened'
    thruster diagnose "${runs[@]}" --set "$set" --out "$out/diagnosis"
    ros2 run gap_diagnosis sealed_case "$out/sealed" --open "$out/diagnosis/diagnosis.json"
    step 5/5 'control: the diagnosed thruster on the emulated bench, live, its thrust tracked and scored'
    truth=$out/diagnosis/with_effect.yaml
    [ -e "$truth" ] || truth=$set # no effect was claimed
    BENCH_EXPERIMENT_READY=1 "$root/scripts/bench_experiment.sh" --reference step --strategy hl-ekf --truth "$truth" --out "$out/live"
    title='Demo: a thruster with a hidden effect'
fi
printf '\n[demo] all of it on one page:\n'
thruster report "$out" --title "$title"
