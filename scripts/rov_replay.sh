#!/usr/bin/env bash
# Plays a recorded dive to its observers and allocator, in lockstep, records what they answer and compares it with what
# they answered then. Equal unless code, parameters or sets have changed since; status 1 where something differs.
#
# usage: scripts/rov_replay.sh DIVE [options]      DIVE: a folder of scripts/rov_experiment.sh, with run/ and nodes/
#
#   --node NAME=FILE.yaml    other parameters of a node, such as observer_0 or allocator; may be repeated
#   --tolerance X        values as near as that, over their size where it is above 1, count as equal (0)
#   --out DIR            new folder for the new run and logs (a new one under runs/)
#
# ROS_DOMAIN_ID is used where it is set, else one of its own.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
. "$root/scripts/workspace/processes.sh"

dive='' out='' tolerance=0
declare -A other=()
value() { [ $# -ge 2 ] || refuse "$1: expected a value"; }
while [ $# -gt 0 ]; do
    case "$1" in
    --tolerance | --out)
        value "$@"
        printf -v "${1#--}" '%s' "$2"
        shift
        ;;
    --node)
        value "$@"
        [[ $2 == ?*=?* && -f ${2#*=} ]] || refuse "--node: expected NAME=FILE.yaml; found '$2'"
        other[${2%%=*}]=${2#*=}
        shift
        ;;
    -h | --help)
        sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
        exit 0
        ;;
    -*) refuse "unknown option '$1'; --help lists them" ;;
    *)
        [ -z "$dive" ] || refuse "expected one dive; found '$dive' and '$1'"
        dive=$1
        ;;
    esac
    shift
done
[[ $tolerance =~ ^[0-9]*\.?[0-9]+([eE][-+]?[0-9]+)?$ ]] || refuse "--tolerance: expected a number, 0 or larger; found '$tolerance'"
[ -n "$dive" ] || refuse "expected a folder of scripts/rov_experiment.sh; found none"
[ -d "$dive/run" ] && [ -f "$dive/nodes/allocator.yaml" ] || refuse "$dive: expected a run/ and nodes/allocator.yaml in it"
[ -z "$out" ] || [ ! -e "$out" ] || refuse "--out: expected a folder that does not exist; $out does"
dive=$(cd "$dive" && pwd -P)
for node in "${!other[@]}"; do
    [ -f "$dive/nodes/$node.yaml" ] || refuse "--node: expected a node of the dive; found '$node'"
done

# ROV_EXPERIMENT_READY: the caller has set up and sourced the workspace.
if [ -z "${ROV_EXPERIMENT_READY-}" ]; then
    "$root/scripts/setup.sh"
    . "$root/scripts/env.sh"
fi
new_folder rov-replay
own_graph
folder=$out
mkdir "$folder/log"

answers=(rov/wrench:rov/odometry) outputs=(rov/wrench) nodes=(allocator)
for file in "$dive"/nodes/inner_loop_*.yaml; do
    i=${file##*_} i=${i%.yaml}
    answers+=("thruster_$i/thrust_setpoint:rov/odometry")
    outputs+=("thruster_$i/thrust_setpoint")
    if ! grep -q 'flow: none' "$dive/nodes/allocator.yaml"; then
        answers+=("thruster_$i/flow:rov/odometry")
        outputs+=("thruster_$i/flow")
    fi
    if [ -f "$dive/nodes/observer_$i.yaml" ]; then
        nodes+=("observer_$i")
        answers+=("thruster_$i/estimate:thruster_$i/state")
        outputs+=("thruster_$i/estimate")
    fi
done
stopping_order=(player "${nodes[*]}" recorder)

start recorder ros2 run run_bag recorder --ros-args -p use_sim_time:=true -p "out:=$folder/run" -p "topics:=['.*']" \
    -p "exclude:=['/parameter_events','/rosout']" -p "acknowledge:=[$(printf "'/%s'," "${outputs[@]}" | sed 's/,$//')]" \
    -p "about:='{experiment: replay}'"
for node in "${nodes[@]}"; do
    package=thruster_estimation executable=observer
    [ "$node" != allocator ] || package=thruster_control executable=allocator
    start "$node" ros2 run "$package" "$executable" --ros-args -r "__node:=$node" \
        --params-file "${other[$node]:-$dive/nodes/$node.yaml}"
done
start player ros2 run run_bag play "$dive/run" --step --timeout 240 --wait-for "${answers[@]}" recorder/recorded:rov/odometry

status=0
watched player || status=$?
end_all
if [ $status -ne 0 ]; then
    cat "$folder/log/player.txt" >&2
    printf '[replay] it failed; logs in %s\n' "$folder/log" >&2
    exit 1
fi
printf '%s\n' "$folder/run"
ros2 run run_bag compare "$dive/run" "$folder/run" --topics "${outputs[@]}" --tolerance "$tolerance" --within
