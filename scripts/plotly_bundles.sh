#!/usr/bin/env bash
# Fetch the bundles of plotly.js that reports embed, of the version that the Python package plotly brings; needs npm.
#
# usage: scripts/plotly_bundles.sh [VERSION]
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)
. "$root/scripts/env.sh"
version=${1:-$(python -c 'import re; from plotly.offline import get_plotlyjs
print(re.search(r"plotly\.js v([0-9.]+)", get_plotlyjs())[1])')}
folder=$root/run_bag/run_bag/report/plotly_js
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
for bundle in cartesian gl3d; do
    npm pack --silent "plotly.js-$bundle-dist-min@$version"
    tar xzf "plotly.js-$bundle-dist-min-$version.tgz"
    gzip -9nc "package/plotly-$bundle.min.js" >"$bundle.gz"
    mv "$bundle.gz" "$folder/plotly-$bundle.min.js.gz"
    cp package/LICENSE "$folder/LICENSE"
done
sed -i "s/plotly\.js [0-9.]*,/plotly.js $version,/" "$folder/README.md"
printf '%s\n' "$folder now holds plotly.js $version"
