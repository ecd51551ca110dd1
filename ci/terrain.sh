#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Whether fills do not care how terrain is drawn. Three scenes over real elevation, each on three kinds of surface
# and in three views, are drawn by every volume technique and compared with the reference over the triangles of that
# surface. Views close to the ground are left out, since coarse surfaces are higher there than the eye. The last line
# but one counts the pictures; the exit code is that of `terrafill bench`. Needs the data that the scenes name
# (TERRAFILL_DATA). Further arguments go to `terrafill bench`.
#
# usage: ci/terrain.sh [--out DIR] [--size N] ...
set -euo pipefail
cd "$(dirname "$0")/.."

if [ -z "${TERRAFILL_DATA:-}" ] && [ -d ../shared/data ]; then
    TERRAFILL_DATA=$(cd ../shared/data && pwd)
    export TERRAFILL_DATA
fi
ci/setup.sh --for bench
cargo build --release --locked --package terrafill

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
scenes=()
for scene in san-francisco everest grand-canyon; do
    for kind in tiles grid spiral; do
        surface="kind = \"$kind\""
        if [ "$kind" = grid ]; then
            surface="$surface\nrows = 720"
        fi
        file=$folder/$scene-$kind.toml
        awk 'BEGIN { RS = "\\[\\[views\\]\\]"; ORS = "" }
            NR == 1 { print; next }
            !/name = "(street|valley|bay)"/ { print "[[views]]" $0 }' "bench-scenes/terrain/$scene.toml" |
            sed -e "s/^kind = \"tiles\"/$surface/" -e "s/^name = \"$scene\"/name = \"$scene-$kind\"/" >"$file"
        scenes+=("$file")
    done
done
"${CARGO_TARGET_DIR:-target}/release/terrafill" bench "${scenes[@]}" --study filling --quick \
    --technique vertex --technique compute --technique instanced --technique native "$@"
