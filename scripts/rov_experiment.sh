#!/usr/bin/env bash
# One experiment with a vehicle in simulated water: starts the whole graph, records, stops with the throttles at zero
# first, scores, and prints the path of the report.
#
# usage: scripts/rov_experiment.sh [options]
#        scripts/rov_experiment.sh --compare [options]        both comparisons of the thesis' section 5.2: 5.2.1, table
#                                                 against dead-zone compensation on Table 3.1, and 5.2.2, eight
#                                                 strategies on HQ; one report of each
#
#   --vehicle SET        ngs bluerov2_heavy bluerov2 pool_rov or a YAML file (ngs)
#   --truth SET          parameter set of the true thrusters (the vehicle's own)
#   --strategy NAME      lookup dead-zone simplified steady-flow hl-ekf hl-nlo hl-kfnlo hq-ekf hq-nlo hq-kfnlo (hq-ekf)
#   --script FILE        set points of the vehicle, by name or YAML file (surge_and_pitch)
#   --feedback truth|estimator   what is fed back: the truth with noise, or a navigation node's estimate (truth)
#   --rate HZ            of all loops (25); --gain 1/S: K_P and k_I of the outer loop (2); --u-max V: of throttles (5)
#   --allocation pseudo-inverse|direction|least-squares      what is done with a wrench beyond the limits (least-squares)
#   --given-up AXES      whose wrench counts last where not all can be had: pitch, for bluerov2, which cannot pitch
#   --set SET            parameter set that observers and laws believe in (the strategy's own)
#   --seed N             of everything random (0); --no-noise leaves the noise out
#   --effects 'E.P=SIZE E[T2].P=SIZE ...'    unmodelled effects of vehicle, thrusters and sensors
#   --fail 'T2 dead at 12 s'    failures, separated by semicolons; also 'T1 weak 0.5 at 20 s', 'T3 stuck at 5 s',
#                        and of sensors 'velocity lost at 8 s' (imu, velocity, depth, battery)
#   --current 'N E D'    of the water along north, east, down [m/s]
#   --random-wrench 'X Y Z K M N'    standard deviations of a random wrench on the body [N, N m]
#   --sensors FILE       YAML file of the sensors (those of the package)
#   --no-flow            observers are told no ambient flow: they predict it by (4.5) alone
#   --hardware T1=PORT   a thruster that is not simulated: a device at a port; 'emulated', or 'firmware': the board's own
#                        on an emulated processor; may be repeated; real time
#   --watch RUN          a node watches thrusters and sensors, taught by a run of the healthy vehicle (a dive's DIR/run); it
#                        tells the allocator of failures, which the plant does not then
#   --scene              a node draws frames, path and arrows for Foxglove and PlotJuggler; they are recorded too
#   --real-time          by the wall's clock instead of in lockstep
#   --composed           all nodes in one process instead of a process each
#   --network            others on the network may take part, as with THRUSTER_NETWORK=network; else this machine alone
#   --out DIR            new folder for run, scores and logs (a new one under runs/)
#
# ROS_DOMAIN_ID is used where it is set, else one of its own.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
. "$root/scripts/workspace/processes.sh"
strategies=(lookup dead-zone simplified steady-flow hl-ekf hl-nlo hl-kfnlo hq-ekf hq-nlo hq-kfnlo)
compared=(lookup simplified hl-ekf hl-nlo hl-kfnlo hq-ekf hq-nlo hq-kfnlo)


given=() fail='' strategy=hq-ekf truth='' script=surge_and_pitch rate=25 seed=0 out='' feedback=truth
compare=false real_time=false composed=false firmware=false
value() { [ $# -ge 2 ] || refuse "$1: expected a value"; }
while [ $# -gt 0 ]; do
    case "$1" in
    --no-noise | --no-flow | --scene) given+=("$1") ;;
    --real-time) real_time=true ;;
    --composed) composed=true ;;
    --network) export THRUSTER_NETWORK=network ;;
    --compare) compare=true ;;
    --strategy | --truth | --script | --rate | --seed | --feedback | --out)
        value "$@"
        printf -v "${1#--}" '%s' "$2"
        shift
        ;;
    --vehicle | --gain | --u-max | --allocation | --given-up | --set | --parameters | --effects | --fail | --current | --random-wrench | --sensors | --hardware | --watch)
        value "$@"
        [ "$1" != --hardware ] || real_time=true
        [[ "$1=$2" != --hardware=*=firmware ]] || firmware=true
        given+=("${1/--parameters/--set}" "$2")
        [ "$1" != --fail ] || fail=$2
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
one_of "$strategy" "${strategies[@]}" || refuse "--strategy: expected one of ${strategies[*]}; found '$strategy'"
one_of "$feedback" truth estimator || refuse "--feedback: expected truth or estimator; found '$feedback'"
[[ $seed =~ ^[0-9]+$ ]] || refuse "--seed: expected an integer, 0 or more; found '$seed'"
[ -z "$out" ] || [ ! -e "$out" ] || refuse "--out: expected a folder that does not exist; $out does"
if $compare && [ "$strategy $truth" != "hq-ekf " ]; then
    refuse "--compare runs strategies and truths of its own: expected neither here"
fi

# ROV_EXPERIMENT_READY: the caller has set up and sourced the workspace.
if [ -z "${ROV_EXPERIMENT_READY-}" ]; then
    "$root/scripts/setup.sh"
    . "$root/scripts/env.sh"
fi
new_folder rov-experiment
own_graph

if $firmware; then
    build_firmware --hardware
    given+=(--firmware "$out/firmware")
fi

# ---- one experiment

run_one() { # STRATEGY TRUTH FOLDER NAME: record FOLDER/NAME
    local strategy=$1 truth=$2 name=$4 time=() lockstep=true line node nodes=() loops=() others=() benches=() acknowledged='' options=()
    folder=$3
    mkdir -p "$folder/log" "$folder/nodes"
    $real_time && lockstep=false && options=(--real-time)
    $lockstep && time=(-p use_sim_time:=true)
    local listed
    listed=$(ros2 run rov_sim rov_graph --out "$folder/nodes" --strategy "$strategy" --truth "$truth" --script "$script" \
        --rate "$rate" --seed "$seed" --feedback "$feedback" "${options[@]}" "${given[@]}") || {
        rmdir "$folder/log" "$folder/nodes" "$folder" 2>/dev/null || true # nothing has begun: the name is free again
        return 2
    }
    mapfile -t nodes <<<"$listed"
    for line in "${nodes[@]}"; do
        node=${line%% *}
        [[ $node != inner_loop_* ]] || loops+=("$node")
        [[ $node != inner_loop_* ]] || acknowledged+="${acknowledged:+,}'/thruster_${node##*_}/throttle'"
    done
    # The throttles go to zero first, the recorder sees it, time stands still last.
    for line in "${nodes[@]}"; do
        node=${line%% *}
        case $node in
        plant | emulated_bench_*) benches+=("$node") ;;
        inner_loop_*) ;;
        driver_*) loops+=("$node") ;;
        *) others+=("$node") ;;
        esac
    done
    stopping_order=("composed ${loops[*]}" "watch ${others[*]}" recorder "${benches[*]}")

    start recorder ros2 run run_bag recorder --ros-args "${time[@]}" -p "out:=$folder/$name" \
        -p "topics:=['.*']" -p "exclude:=['/parameter_events','/rosout']" -p "acknowledge:=[$acknowledged]" \
        -p "wait_for:=[$acknowledged,'/rov/setpoint','/rov/wrench','/rov/truth']" \
        -p "about:='{experiment: vehicle, strategy: $strategy, truth: $truth, feedback: $feedback, rate: $rate, seed: $seed${fail:+, failures: \"$fail\"}}'"
    start watch ros2 run rov_sim experiment_watch --ros-args -p vehicle:=true -p begin:=240.0 -p stall:=40.0 -p deadline:=3600.0
    ! $composed || start composed ros2 run thruster_runtime compose "$folder/nodes/composed.yaml"
    local package executable renamed other arguments
    for line in "${nodes[@]}"; do
        read -r node package executable renamed <<<"$line"
        if $composed && [ -z "$renamed" ]; then continue; fi
        arguments=(-r "__node:=$node" --params-file "$folder/nodes/$node.yaml")
        for other in $renamed; do arguments+=(-r "$other"); done
        start "$node" ros2 run "$package" "$executable" --ros-args "${arguments[@]}"
    done

    local status=0
    watched watch || status=$?
    end_all
    if [ $status -ne 0 ]; then
        cat "$folder/log/watch.txt" >&2
        printf '[experiment] %s on %s: failed; logs in %s\n' "$strategy" "${truth:-its own thrusters}" "$folder/log" >&2
        return 1
    fi
}

if ! $compare; then
    run_one "$strategy" "$truth" "$out" run
    ros2 run rov_sim score_vehicle "$out/run" --out "$out/scores"
    exit
fi
failed=0
compare_all() { # FOLDER TRUTH STRATEGY...
    local place=$1 truth=$2 each runs=()
    shift 2
    for each in "$@"; do
        if run_one "$each" "$truth" "$place/$each" "$each"; then
            runs+=("$place/$each/$each")
        else
            failed=$((failed + 1))
            end_all
        fi
    done
    [ ${#runs[@]} -eq 0 ] || ros2 run rov_sim score_vehicle "${runs[@]}" --out "$place/scores"
}
compare_all "$out/5.2.1" simplified lookup dead-zone
compare_all "$out/5.2.2" hq "${compared[@]}"
[ $failed -eq 0 ] || { printf '[experiment] %d of 10 experiments failed\n' "$failed" >&2; exit 1; }
