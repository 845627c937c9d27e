#!/usr/bin/env bash
# How often the diagnosis is right, on generators that share no code with it or with each other.
#
# usage: scripts/scoreboard.sh quick DIR              some 200 frozen cases, for each change
#        scripts/scoreboard.sh reported DIR           1,500 cases at full length; may be stopped and started again
#        scripts/scoreboard.sh compare BEFORE AFTER   the cases that two folders answer differently
#
# More options, among them --processes and --docs: ros2 run gap_diagnosis scoreboard run --help
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
case "${1-}" in
quick | reported) command=(run "$@") ;;
compare) command=("$@") ;;
*)
    sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
    exit 2
    ;;
esac
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"
exec ros2 run gap_diagnosis scoreboard "${command[@]}"
