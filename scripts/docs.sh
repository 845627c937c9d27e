#!/usr/bin/env bash
# The pages as a site in build/site: every page is in it, every link leads somewhere, or it says so and ends with status 1.
#
# usage: scripts/docs.sh
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
"$root/scripts/setup.sh" >&2
cd "$root"
. scripts/env.sh
python scripts/workspace/site_source.py build/site_source
PYTHONPATH=scripts/workspace python -m mkdocs build --strict --clean
printf '%s\n' "$root/build/site/index.html"
