#!/usr/bin/env bash
# One table: how fast each part is, against the plain way of doing the same, measured in the same run.
#
# usage: scripts/benchmark.sh
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
"$root/scripts/setup.sh" >&2
. "$root/scripts/env.sh"
exec python "$root/scripts/workspace/benchmark_table.py"
