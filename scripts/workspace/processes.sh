# Sourced by scripts that start the nodes of a graph: each in a process group of its own, as `ros2 run` does not hand
# signals on. A script sets `folder`, in whose log/ the output goes, and `stopping_order`, the names from first to last.

names=() groups=()
start() { # NAME COMMAND...
    local name=$1
    shift
    setsid "$@" >"$folder/log/$name.txt" 2>&1 &
    names+=("$name")
    groups+=($!)
}
# The process itself too: its group is not there in the first instant.
alive() { kill -0 "$1" 2>/dev/null || kill -0 -- "-$1" 2>/dev/null; }
group_of() { # NAME: print its group
    local i
    for i in "${!names[@]}"; do [ "${names[i]}" != "$1" ] || printf '%s\n' "${groups[i]}"; done
}
end() { # NAME...: end their groups together, within 12 s
    local i k name ending=()
    for name in "$@"; do
        for i in "${!names[@]}"; do
            [ "${names[i]}" = "$name" ] || continue
            kill -TERM -- "-${groups[i]}" 2>/dev/null || kill -TERM "${groups[i]}" 2>/dev/null || true
            ending+=("$i")
        done
    done
    for i in "${ending[@]}"; do
        for ((k = 0; k < 100; k++)); do
            alive "${groups[i]}" || break
            sleep 0.1
        done
        if alive "${groups[i]}"; then
            printf '[experiment] %s did not stop in 10 s, it is killed\n' "${names[i]}" >&2
            kill -KILL -- "-${groups[i]}" 2>/dev/null || true
        fi
        wait "${groups[i]}" 2>/dev/null || true
        unset "names[$i]" "groups[$i]"
    done
}
end_all() { # in their order, those of one word together, and then whatever is left
    trap '' INT TERM
    local stage
    for stage in "${stopping_order[@]}"; do
        # shellcheck disable=SC2086
        end $stage
    done
    end "${names[@]}"
    trap 'exit 130' INT
    trap 'exit 143' TERM
}
trap end_all EXIT
trap 'exit 130' INT
trap 'exit 143' TERM
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
        sleep 0.3
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

own_graph() { # a domain of its own unless one is set
    export ROS_DOMAIN_ID=${ROS_DOMAIN_ID:-$((RANDOM % 101 + 1))}
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
