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
#   --parameters SET     parameter set that observer and law believe in (the strategy's own)
#   --form proper|bench  how the observer is discretised (proper)
#   --effects 'E.P=SIZE ...'    unmodelled effects of the emulated thruster; those of the log, in the set too, act on a
#                        copy of the finished run, run_as_logged beside run
#   --seed N             of the emulated noise (0); --no-noise leaves it out
#   --out DIR            new folder for run, scores and logs (a new one under runs/)
#
# ROS_DOMAIN_ID is used where it is set, else one of its own.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
strategies=(lookup simplified hl-ekf hl-nlo hl-kfnlo hq-ekf hq-nlo hq-kfnlo)
references=(step triangle sine)
others=(steady-flow pi-thrust)
start_delay=1 # s of 0 N before the run

. "$root/scripts/workspace/processes.sh"
# The throttle goes to zero first, the recorder sees it, time stands still last.
stopping_order=('inner_loop driver' 'watch reference observer' recorder bench)

reference='' strategy='' port='' real_time=false protocol=text truth=hl_bench parameters='' form=proper effects=''
seed=0 noise=true out='' all=false firmware=false built=''
while [ $# -gt 0 ]; do
    case "$1" in
    --real-time) real_time=true ;;
    --no-noise) noise=false ;;
    --all) all=true ;;
    --firmware) firmware=true ;;
    --reference | --strategy | --port | --protocol | --truth | --parameters | --form | --effects | --seed | --out)
        [ $# -ge 2 ] || refuse "$1: expected a value"
        name=${1#--}
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
    local reference=$1 strategy=$2 observer='' set='' device=$port time=() lockstep=true
    folder=$3
    mkdir -p "$folder/log"
    case "$strategy" in
    lookup) ;;
    simplified | pi-thrust | steady-flow) observer=speed-ekf set=simplified ;;
    *) observer=${strategy#*-} set=${strategy%%-*} ;;
    esac
    [ -z "$parameters" ] || set=$parameters
    $real_time && lockstep=false
    $lockstep && time=(-p use_sim_time:=true)
    local n=thruster_0 wires=()
    wires=("$n/state" "$n/thrust_setpoint" "$n/throttle")
    [ -z "$observer" ] || wires+=("$n/estimate")
    [ "$observer" = '' ] || [ "$observer" = speed-ekf ] || wires+=("$n/flow")

    local heard=''
    printf -v heard ",'/%s'" "${wires[@]}"
    start recorder ros2 run run_bag recorder --ros-args "${time[@]}" -p "out:=$folder/run" \
        -p "topics:=['.*']" -p "exclude:=['/parameter_events','/rosout']" \
        -p "acknowledge:=['/$n/throttle_sent']" -p "wait_for:=['/$n/throttle_sent'$heard]" \
        -p "about:='{experiment: closed loop, reference: $reference, strategy: $strategy, form: $form}'"
    if [ -z "$device" ]; then
        device=$folder/port
        start bench ros2 run rov_sim emulated_bench --ros-args "${time[@]}" -p "lockstep:=$lockstep" -p "link:='$device'" \
            -p "protocol:=$protocol" -p "firmware:='$built'" -p "parameter_set:='$truth'" -p "effects:='$effects'" -p "noise:=$noise" \
            -p "seed:=$seed" -p "wires:='${wires[*]}'" -p "participants:='recorder/recorded'"
    fi
    if [ -n "$observer" ]; then
        start observer ros2 run thruster_estimation observer --ros-args "${time[@]}" -p "estimator:=$observer" \
            -p "parameter_set:='$set'" -p "form:=$form" -p throttle:=sent -p "wait_for_throttle:=$lockstep"
    fi
    local believed=()
    [ -z "$parameters" ] || believed=(-p "parameter_set:='$parameters'")
    # In real time nobody waits for a set point that stays away: three periods.
    $lockstep || believed+=(-p setpoint_timeout:=0.12)
    start inner_loop ros2 run thruster_control inner_loop --ros-args "${time[@]}" -p "strategy:=$strategy" "${believed[@]}"
    start reference ros2 run thruster_control reference --ros-args "${time[@]}" -p "kind:=$reference" \
        -p "start_delay:=$start_delay.0" -p "wait_for:='recorder/recorded'"
    start watch ros2 run rov_sim experiment_watch --ros-args -p "start_delay:=$start_delay.0"
    # The driver last: it is the only one that reaches the thruster.
    start driver ros2 run bench_driver driver --ros-args "${time[@]}" -p "port:='$device'" -p "protocol:=$protocol" \
        -p "lockstep:=$lockstep"

    local status=0
    watched watch || status=$?
    end_all
    if [ $status -ne 0 ]; then
        cat "$folder/log/watch.txt" >&2
        printf '[experiment] %s, %s: failed; logs in %s\n' "$strategy" "$reference" "$folder/log" >&2
        return 1
    fi
    local run=$folder/run
    [ -n "$port" ] || run=$(ros2 run thruster_model log_effects "$folder/run" --parameters "$truth" --effects "$effects" \
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
