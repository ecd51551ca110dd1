#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# From nothing to a report. Sets the machine up, builds, measures the main question on every scene
# whose data is here, and says where the report is. --full measures everything, --quick just enough to
# see that it works. Further arguments go to `terrafill bench`.
#
# usage: ci/bench.sh [--quick|--full] [SCENE...] [--study S...] [--technique T...] [--out DIR]
set -euo pipefail
here=$PWD
cd "$(dirname "$0")/.."

ci/setup.sh --for bench

if [ -z "${TERRAFILL_DATA:-}" ] && [ -d ../shared/data ]; then
    TERRAFILL_DATA=$(cd ../shared/data && pwd)
    export TERRAFILL_DATA
fi

cargo build --release --locked --package terrafill
program=${CARGO_TARGET_DIR:-target}/release/terrafill

# --out is read here too: it is relative to where the caller stands, and the report is looked for.
out=
arguments=()
while [ $# -gt 0 ]; do
    case "$1" in
        --out)
            [ $# -ge 2 ] || {
                echo "bench: --out needs a folder" >&2
                exit 2
            }
            out=$2
            shift
            ;;
        --out=*) out=${1#--out=} ;;
        *) arguments+=("$1") ;;
    esac
    shift
done
case "$out" in
    "") out=$PWD/out/bench-$(date -u +%Y%m%d-%H%M%S) ;;
    /*) ;;
    *) out=$here/$out ;;
esac

status=0
"$program" bench ${arguments[@]+"${arguments[@]}"} --out "$out" || status=$?
# With a report, its place was the last thing said.
if [ ! -e "$out/index.html" ]; then
    echo "bench: no report was written to $out" >&2
    [ "$status" -ne 0 ] || status=1
fi
exit "$status"
