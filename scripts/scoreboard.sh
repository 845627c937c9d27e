#!/usr/bin/env bash
# How often the diagnosis is right, on generators that share no code with it or with each other.
#
# usage: scripts/scoreboard.sh quick DIR              some 200 frozen cases, for each change
#        scripts/scoreboard.sh reported DIR           1,500 cases at full length; may be stopped and started again
#        scripts/scoreboard.sh compare BEFORE AFTER   the cases that two folders answer differently
#        scripts/scoreboard.sh ablate quick           each rule of judgement changed in turn, on cases of a set
#        scripts/scoreboard.sh vehicle DIR [BEFORE]   12 frozen cases of vehicles; against those of another folder
#
# More options of quick and reported, among them --first, --count, --processes and --docs:
# ros2 run gap_diagnosis scoreboard run --help; of vehicle: ros2 run gap_diagnosis blind_vehicle --help
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
usage() { sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; }
case "${1-}" in
quick | reported) command=(scoreboard run "$@") ;;
compare | ablate) command=(scoreboard "$@") ;;
vehicle)
    case "${2-}" in
    "" | -*) printf 'scoreboard.sh: vehicle: expected a folder; found %s\n' "${2:-nothing}" >&2; exit 2 ;;
    esac
    command=(blind_vehicle "$2/vehicles.jsonl" --frozen ${3:+--compare "$3/vehicles.jsonl"})
    ;;
-h | --help) usage; exit ;;
*)
    printf 'scoreboard.sh: expected quick, reported, compare, ablate or vehicle; found %s\n\n' "${1-nothing}" >&2
    usage >&2
    exit 2
    ;;
esac
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"
exec ros2 run gap_diagnosis "${command[@]}"
