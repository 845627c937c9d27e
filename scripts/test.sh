#!/usr/bin/env bash
# The one check, the same for a person and for CI: format, lint, types, pages, tests. Runs all of them, fails when one fails.
#
# usage: scripts/test.sh [--long] [arguments of pytest]      for example: scripts/test.sh thruster_runtime -k executor
#
#   --long      the long studies too, which take an hour more on two cores
#
# Tests run in as many processes as there are processors (four at most); -n 0 for one. The slowest are listed at the end.
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
cd "$root"
scripts/setup.sh || exit 1
. scripts/env.sh

# Shared memory leaves locks behind a killed process.
export FASTDDS_BUILTIN_TRANSPORTS=UDPv4
# Processes side by side gain nothing from threads in linear algebra.
export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1

status=0
check() { # NAME COMMAND...
    printf '[test] %s\n' "$1"
    "${@:2}" && return
    printf '[test] %s: FAILED\n' "$1" >&2
    status=1
}

# What takes a minute of one processor runs beside the tests, and is told after them.
said=$(mktemp -d)
names=() running=()
trap 'kill ${running[@]+"${running[@]}"} 2>/dev/null; rm -rf "$said"' EXIT
beside() { # NAME COMMAND...
    "${@:2}" >"$said/$1" 2>&1 &
    names+=("$1") running+=($!)
}
told() { # NAME PROCESS
    local ended=0
    wait "$2" || ended=$?
    cat "$said/$1"
    return $ended
}

sources=(scripts/workspace) roots=''
for manifest in */package.xml; do
    package=${manifest%/*}
    if [ -d "$package/$package" ]; then
        sources+=("$package/$package")
        roots=$roots${roots:+:}$package
    fi
done

check format ruff format --check --quiet .
check lint ruff check --quiet .
beside types env MYPYPATH="$roots" mypy --no-error-summary "${sources[@]}"
beside pages scripts/docs.sh
printf '[test] tests\n'
chosen=(-m 'not long')
if [ "${1-}" = --long ]; then
    chosen=()
    shift
fi
workers=$(env -u OMP_NUM_THREADS nproc)
python -m pytest -n $((workers < 4 ? workers : 4)) --dist loadscope --no-loadscope-reorder --durations 25 \
    --durations-min 5 "${chosen[@]}" "$@" || status=1
for k in "${!names[@]}"; do
    check "${names[k]}" told "${names[k]}" "${running[k]}"
done
exit $status
