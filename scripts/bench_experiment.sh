#!/usr/bin/env bash
# One thrust-tracking experiment on the bench, real or emulated: starts the graph, records, stops with the throttle at
# zero first, scores, and prints the path of the report.
#
# usage: scripts/bench_experiment.sh --reference step|triangle|sine --strategy NAME [options]
#        scripts/bench_experiment.sh --all [options]          the thesis' 8 strategies on the 3 set points
#
#   --strategy NAME      lookup simplified steady-flow hl-ekf hl-nlo hl-kfnlo hq-ekf hq-nlo hq-kfnlo pi-thrust
#   --port PORT          a real device, e.g. /dev/ttyACM0, in real time; without it the emulated bench
#   --firmware           the emulated bench runs the firmware itself, built here, on an emulated processor
#   --real-time          the emulated bench by the wall's clock instead of in lockstep
#   --protocol text|frames      what the device speaks (text)
#   --truth SET          parameter set of the emulated thruster (hl_bench)
#   --set SET            parameter set that observer and law believe in (the strategy's own)
#   --form proper|bench  how the observer is discretised (proper)
#   --effects 'E.P=SIZE ...'    unmodelled effects of the emulated thruster; those of the log, in the set too, act on a
#                        copy of the finished run, run_as_logged beside run
#   --seed N             of the emulated noise (0); --no-noise leaves it out
#   --network            others on the network may take part, as with THRUSTER_NETWORK=network; else this machine alone
#   --out DIR            new folder for run, scores and logs (a new one under runs/)
#
# ROS_DOMAIN_ID is used where it is set, else one of its own.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
strategies=(lookup simplified hl-ekf hl-nlo hl-kfnlo hq-ekf hq-nlo hq-kfnlo)
references=(step triangle sine)
others=(steady-flow pi-thrust)

. "$root/scripts/workspace/processes.sh"
# The throttle goes to zero first, the recorder sees it, time stands still last.
stopping_order=('inner_loop driver' 'experiment_watch reference observer' recorder emulated_bench)

reference='' strategy='' port='' real_time=false protocol=text truth=hl_bench set='' form=proper effects=''
seed=0 noise=true out='' all=false firmware=false built=''
while [ $# -gt 0 ]; do
    case "$1" in
    --real-time) real_time=true ;;
    --no-noise) noise=false ;;
    --network) export THRUSTER_NETWORK=network ;;
    --all) all=true ;;
    --firmware) firmware=true ;;
    --reference | --strategy | --port | --protocol | --truth | --set | --parameters | --form | --effects | --seed | --out)
        [ $# -ge 2 ] || refuse "$1: expected a value"
        name=${1#--}
        [ "$name" != parameters ] || name=set
        printf -v "$name" '%s' "$2"
        shift
        ;;
    -h | --help)
        sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
        exit 0
        ;;
    *) refuse "unknown option '$1'; --help lists them" ;;
    esac
    shift
done
if $all; then
    [ -z "$reference$strategy" ] || refuse "--all runs every reference and strategy: expected neither here"
else
    one_of "$reference" "${references[@]}" || refuse "--reference: expected one of ${references[*]}; found '$reference'"
    one_of "$strategy" "${strategies[@]}" "${others[@]}" ||
        refuse "--strategy: expected one of ${strategies[*]} ${others[*]}; found '$strategy'"
fi
one_of "$protocol" text frames || refuse "--protocol: expected text or frames; found '$protocol'"
one_of "$form" proper bench || refuse "--form: expected proper or bench; found '$form'"
[[ $seed =~ ^[0-9]+$ ]] || refuse "--seed: expected an integer, 0 or more; found '$seed'"
[ -z "$port" ] || [ -e "$port" ] || refuse "--port: expected a serial port; found nothing at $port"
[ -z "$port" ] || [ -c "$port" ] || refuse "--port: expected a serial port; found no device at $port"
[ -z "$port" ] || real_time=true
[ -z "$port" ] || ! $firmware || refuse "--firmware: expected the emulated bench; found the device at $port"
[ -z "$out" ] || [ ! -e "$out" ] || refuse "--out: expected a folder that does not exist; $out does"

# BENCH_EXPERIMENT_READY: the caller has set up and sourced the workspace.
if [ -z "${BENCH_EXPERIMENT_READY-}" ]; then
    "$root/scripts/setup.sh"
    . "$root/scripts/env.sh"
fi
new_folder bench-experiment
own_graph

if $firmware; then
    build_firmware --firmware
    built=$out/firmware
fi

# ---- one experiment

run_one() { # REFERENCE STRATEGY FOLDER
    local reference=$1 strategy=$2 options=()
    folder=$3
    mkdir -p "$folder/log"
    ! $real_time || options+=(--real-time)
    $noise || options+=(--no-noise)
    local listed name package executable
    listed=$(ros2 run rov_sim bench_graph --out "$folder" --reference "$reference" --strategy "$strategy" --port "$port" \
        --firmware "$built" --protocol "$protocol" --truth "$truth" --effects "$effects" --set "$set" \
        --form "$form" --seed "$seed" "${options[@]}") || return 2
    while read -r name package executable; do
        start "$name" ros2 run "$package" "$executable" --ros-args -r "__node:=$name" --params-file "$folder/nodes/$name.yaml"
    done <<<"$listed"

    local status=0
    watched experiment_watch || status=$?
    end_all
    if [ $status -ne 0 ]; then
        cat "$folder/log/experiment_watch.txt" >&2
        printf '[experiment] %s, %s: failed; logs in %s\n' "$strategy" "$reference" "$folder/log" >&2
        return 1
    fi
    local run=$folder/run
    [ -n "$port" ] || run=$(ros2 run thruster_model log_effects "$folder/run" --set "$truth" --effects "$effects" \
        --seed "$seed" --out "$folder/run_as_logged")
    ros2 run rov_sim score_experiment "$run" --reference "$reference" --strategy "$strategy" \
        --out "$folder/scores"
}

if ! $all; then
    run_one "$reference" "$strategy" "$out"
    exit
fi
failed=0
for strategy in "${strategies[@]}"; do
    for reference in "${references[@]}"; do
        run_one "$reference" "$strategy" "$out/$strategy-$reference" || { failed=$((failed + 1)); end_all; }
    done
done
[ $failed -eq 0 ] || { printf '[experiment] %d of 24 experiments failed\n' "$failed" >&2; exit 1; }
