# Sourced by scripts that start the nodes of a graph: each in a process group of its own, as `ros2 run` does not hand
# signals on. A script sets `folder`, in whose log/ the output goes, and `stopping_order`, words of names that end together,
# from first to last: first of all what commands a throttle, which so becomes zero at once.

# Nodes end when this script is gone, however it went.
export THRUSTER_ENDS_WITH=$$

names=() groups=() patience=300 interrupted=false # tenths of a second that a stage may take to end
start() { # NAME COMMAND...
    local name=$1
    shift
    setsid "$@" >"$folder/log/$name.txt" 2>&1 &
    names+=("$name")
    groups+=($!)
}
# The process itself too: its group is not there in the first instant.
alive() { kill -0 "$1" 2>/dev/null || kill -0 -- "-$1" 2>/dev/null; }
nap() { # SECONDS: unlike a plain sleep, a signal ends it at once
    sleep "$1" &
    wait $! || true
}
group_of() { # NAME: print its group
    local i
    for i in "${!names[@]}"; do [ "${names[i]}" != "$1" ] || printf '%s\n' "${groups[i]}"; done
}
descendants() { # PID: print those of a process, which may have left its group
    local task child
    for task in "/proc/$1/task/"*/children; do
        [ -r "$task" ] || continue
        for child in $(<"$task"); do printf '%s\n' "$child" && descendants "$child"; done
    done 2>/dev/null
}
tell() { # SIGNAL GROUP
    local below
    below=$(descendants "$2")
    # shellcheck disable=SC2086
    kill "-$1" -- "-$2" $below 2>/dev/null || kill "-$1" "$2" $below 2>/dev/null || true
}
end() { # NAME...: end them together, and wait for that as long as there is patience
    local i k name ending=()
    for name in "$@"; do
        for i in "${!names[@]}"; do
            [ "${names[i]}" = "$name" ] || continue
            tell TERM "${groups[i]}"
            ending+=("$i")
        done
    done
    for ((k = 0; k < patience; k++)); do
        for i in "${!ending[@]}"; do
            alive "${groups[ending[i]]}" || {
                wait "${groups[ending[i]]}" 2>/dev/null || true
                unset "names[${ending[i]}]" "groups[${ending[i]}]" "ending[$i]"
            }
        done
        [ ${#ending[@]} -gt 0 ] || return 0
        nap 0.1
    done
}
end_all() { # in their order, those of one word together, and then whatever is left
    local stage i
    trap '' INT TERM
    ! $interrupted || patience=9
    for stage in "${stopping_order[@]}"; do
        # shellcheck disable=SC2086
        end $stage
    done
    patience=9
    end "${names[@]}"
    for i in "${!names[@]}"; do
        printf '[experiment] %s did not stop, it is killed\n' "${names[i]}" >&2
        [ "${names[i]}" != recorder ] || printf '[experiment] ros2 run run_bag recover makes its run whole\n' >&2
        tell KILL "${groups[i]}"
        unset "names[$i]" "groups[$i]"
    done
    patience=300
    trap 'interrupted=true; exit 130' INT
    trap 'interrupted=true; exit 143' TERM
}
trap end_all EXIT
trap 'interrupted=true; exit 130' INT
trap 'interrupted=true; exit 143' TERM
check_alive() {
    local i
    for i in "${!names[@]}"; do
        alive "${groups[i]}" || {
            printf '[experiment] %s has ended: ' "${names[i]}" >&2
            tail -n 3 "$folder/log/${names[i]}.txt" >&2
            return 1
        }
    done
}
watched() { # NAME: wait until this one is over; its exit status, or 1 as soon as another one has ended
    local group status=0
    group=$(group_of "$1")
    # The watch has deadlines of its own; here others that end are noticed.
    while alive "$group"; do
        check_alive || { alive "$group" || break; return 1; }
        nap 0.3
    done
    wait "$group" || status=$?
    return $status
}

# ---- of the command line

refuse() {
    printf '%s: %s\n' "$(basename "$0" .sh)" "$1" >&2
    exit 2
}
one_of() { # WORD CHOICE...
    local word=$1 choice
    shift
    for choice in "$@"; do [ "$choice" != "$word" ] || return 0; done
    return 1
}

# ---- of the graph

own_graph() { # a domain of its own unless one is set; says who takes part
    [ -n "${ROS_DOMAIN_ID-}" ] || ROS_DOMAIN_ID=$(python3 -m thruster_runtime.domains)
    export ROS_DOMAIN_ID
    . "$root/scripts/workspace/underlay.sh"
    discovery || exit 2
    case $ROS_AUTOMATIC_DISCOVERY_RANGE in
    LOCALHOST) printf '[experiment] discovery: this machine alone (--network opens it), domain %s\n' "$ROS_DOMAIN_ID" ;;
    *) printf '[experiment] discovery: everybody on this network may take part, domain %s\n' "$ROS_DOMAIN_ID" ;;
    esac
    # After a node that was killed, shared memory would leave locks behind that delay the next graph.
    export FASTDDS_BUILTIN_TRANSPORTS=${FASTDDS_BUILTIN_TRANSPORTS:-UDPv4}
    # Linear algebra of a few states gains nothing from threads, which take the other nodes' time.
    export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
}
new_folder() { # PREFIX: make the folder `out`, a new one under runs/ where it is not given
    if [ -z "$out" ]; then
        mkdir -p "$root/runs"
        out=$(mktemp -d "$root/runs/$1-$(date +%Y%m%d-%H%M%S)-XXXX")
    else
        mkdir -p "$(dirname "$out")"
        mkdir "$out"
    fi
    out=$(cd "$out" && pwd -P)
}
build_firmware() { # OPTION: build it in $out/firmware; what is missing is said as a matter of the option
    make -C "$root/bench_driver/firmware" "BUILD=$out/firmware" >"$out/firmware.txt" 2>&1 || {
        tail -n 2 "$out/firmware.txt" >&2
        refuse "$1: the firmware could not be built ($out/firmware.txt); Debian: gcc-avr avr-libc libsimavr-dev libelf-dev"
    }
}
