#!/usr/bin/env bash
# The one check, the same for a person and for CI: format, lint, types, tests. Runs all of them, fails when one fails.
#
# usage: scripts/test.sh [arguments of pytest]      for example: scripts/test.sh thruster_runtime -k executor
set -uo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
cd "$root"
scripts/setup.sh || exit 1
. scripts/env.sh

# Shared memory leaves locks behind a killed process.
export FASTDDS_BUILTIN_TRANSPORTS=UDPv4

status=0
check() { # NAME COMMAND...
    printf '[test] %s\n' "$1"
    "${@:2}" && return
    printf '[test] %s: FAILED\n' "$1" >&2
    status=1
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
check types env MYPYPATH="$roots" mypy --no-error-summary "${sources[@]}"
printf '[test] tests\n'
python -m pytest "$@" || status=1
exit $status
