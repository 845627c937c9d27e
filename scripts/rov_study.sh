#!/usr/bin/env bash
# The study behind docs/rov_study.md: the thesis' closed-loop simulations of a whole vehicle (section 5.2) on many
# vehicles, and the cases that its claims may depend on. Resumes where it was interrupted.
#
# usage: scripts/rov_study.sh [OUT]      writes OUT/tables.md, OUT/scores.csv, OUT/report.html and two pictures
#        SEEDS=200 PROCESSES=2 PLAN=thesis: vehicles drawn, processes, plan by its name or as a YAML file
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
[ $# -le 1 ] || { printf 'usage: %s [OUT]\n' "$0" >&2; exit 2; }
out=${1:-$root/runs/rov-study-$(date +%Y%m%d-%H%M%S)}
"$root/scripts/setup.sh"
. "$root/scripts/env.sh"
mkdir -p "$(dirname "$out")"
ros2 run rov_sim rov_study --plan "${PLAN:-thesis}" --seeds "${SEEDS:-200}" --processes "${PROCESSES:-2}" --seed 1 --out "$out"
