#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Makes a report that is committed: measures the scenes that ship, each case in one process, and keeps of the run
# its tables, the reference's pictures and the worst pixels. The report itself is one file beside them.
#
# usage: ci/committed-report.sh reports/NAME [RUN]   RUN: a run that is there already
set -euo pipefail
cd "$(dirname "$0")/.."

[ $# -ge 1 ] || { echo "usage: ci/committed-report.sh reports/NAME [RUN]" >&2; exit 2; }
to=$1
program=${CARGO_TARGET_DIR:-target}/release/terrafill
cargo build --release --locked --package terrafill
run=${2:-out/committed}
if [ $# -lt 2 ]; then
    rm -rf "$run"
    "$program" bench planet-134 california square-10m square-200km hills --quick --out "$run"
fi

rm -rf "$to"
mkdir -p "$to/images"
cp "$run"/{cases,measurements,metrics}.csv "$run"/{environment,plan,schema}.json "$to"
# Shaded pictures are 0.8 MB each and show what the reference's do.
grep -vE ',(image|difference_image),' "$run/notes.csv" >"$to/notes.csv"
cp "$run"/images/*_reference.png "$to/images"
find "$run/images" -name '*_worst.png' -exec cp {} "$to/images" \;
"$program" report "$to" --single-file
du -sh --apparent-size "$to"
