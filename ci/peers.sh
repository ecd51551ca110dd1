#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Measures what users would pick instead in the same run as the techniques: CesiumJS, in headless Chromium, on
# the countries. Fetches CesiumJS by npm into the target folder, builds, and writes a report whose section
# "What users would pick instead" has the times, their ratios and the pixels that differ. Needs node, npm,
# Chromium and the countries (TERRAFILL_DATA). Where something is missing it names it and ends with 4: nothing
# was measured. Further arguments go to `terrafill bench`.
#
# usage: ci/peers.sh [--quick|--full] [SCENE...] [--processes N] [--out DIR]
#        default scenes: countries-110m countries-50m; default processes: 5, the fewest for an interval;
#        --full measures CesiumJS on finer tiles as well, which tells errors of its globe from others
set -euo pipefail
here=$PWD
cd "$(dirname "$0")/.."

# A fixed version: figures must not change with what npm offers today.
cesium=cesium@1.145.0

missing=()
for need in node npm; do
    command -v "$need" >/dev/null || missing+=("$need")
done
CHROMIUM=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)}
export CHROMIUM
[ -n "$CHROMIUM" ] || missing+=("Chromium (CHROMIUM names another browser)")
if [ -z "${TERRAFILL_DATA:-}" ] && [ -d ../shared/data ]; then
    TERRAFILL_DATA=$(cd ../shared/data && pwd)
    export TERRAFILL_DATA
fi
target=${CARGO_TARGET_DIR:-$PWD/target}
export TERRAFILL_PEERS=$target/peers
if [ ${#missing[@]} -eq 0 ]; then
    mkdir -p "$TERRAFILL_PEERS"
    npm install --prefix "$TERRAFILL_PEERS" --no-save --no-audit --no-fund --silent "$cesium" || missing+=("$cesium (npm could not fetch it)")
fi
if [ ${#missing[@]} -gt 0 ]; then
    printf 'peers: skipped, missing: %s\n' "${missing[@]}" >&2
    exit 4
fi

cargo build --release --locked --package terrafill
scenes=() options=() out=$here/out/peers-$(date -u +%Y%m%d-%H%M%S) processes=5
while [ $# -gt 0 ]; do
    case "$1" in
        --out) out=$2; shift ;;
        --processes) processes=$2; shift ;;
        --quick | --full) options+=("$1") ;;
        --*) options+=("$1" "${2:-}"); shift ;;
        *) scenes+=("$1") ;;
    esac
    shift
done
case "$out" in /*) ;; *) out=$here/$out ;; esac
[ ${#scenes[@]} -gt 0 ] || scenes=(countries-110m countries-50m)
exec "$target/release/terrafill" bench "${scenes[@]}" --study filling --technique vertex --technique cesium \
    --processes "$processes" --out "$out" ${options[@]+"${options[@]}"}
