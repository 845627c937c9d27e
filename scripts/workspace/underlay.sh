# Sourced by setup.sh and env.sh, the latter also in zsh: which ROS 2 the workspace stands on, and who may take part.

ros_installation() { # print the prefix of a ROS 2 Jazzy installation, or nothing where there is none
    local prefix
    local -a prefixes
    IFS=: read -r -a prefixes <<<"${AMENT_PREFIX_PATH-}"
    for prefix in "${prefixes[@]}"; do
        # A prefix with a pyvenv.cfg is a virtual environment made by setup.sh, here or in another clone.
        if [ -e "$prefix/share/ament_index/resource_index/packages/rclpy" ] && [ ! -e "$prefix/pyvenv.cfg" ]; then
            printf '%s\n' "$prefix"
            return
        fi
    done
    if [ -e /opt/ros/jazzy/setup.bash ]; then
        printf '%s\n' /opt/ros/jazzy
    fi
}

source_foreign() { # FILE: source a generated file, which may read unset variables or fail on the way
    local flags=$-
    set +eu
    # shellcheck disable=SC1090
    . "$1"
    case $flags in *e*) set -e ;; esac
    case $flags in *u*) set -u ;; esac
}

# A set-up of ROS exports ROS_AUTOMATIC_DISCOVERY_RANGE itself, so that a default of ours would never act: a variable of
# our own decides. This machine alone is the default, as whoever takes part may command a thruster; it is also quicker,
# 0.4 s instead of 2.6 s.
discovery() {
    case ${THRUSTER_NETWORK:-machine} in
    machine) export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST ;;
    network)
        case ${ROS_AUTOMATIC_DISCOVERY_RANGE-} in
        SUBNET | SYSTEM_DEFAULT) ;;
        *) export ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET ;;
        esac
        ;;
    *)
        printf 'THRUSTER_NETWORK: expected machine or network; found %s\n' "'$THRUSTER_NETWORK'" >&2
        return 2
        ;;
    esac
}
