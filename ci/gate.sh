#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Whether this tree does more work, errs more or takes longer than another revision. Sets the machine up,
# builds both, runs both by turns on this machine. Exits by the verdict, so: 0 pass, 1 differs, 2 bad input,
# 3 inconclusive, 4 nothing measured, 5 no device, 6 the machine failed. Further arguments go to `terrafill gate`; paths are relative
# to the repository.
#
# usage: ci/gate.sh [--base REVISION] [SCENE...] [--technique T...] [--no-time] [--out DIR]
set -euo pipefail
cd "$(dirname "$0")/.."

has() {
    local wanted=$1 argument
    shift
    for argument in "$@"; do
        case "$argument" in "$wanted" | "$wanted"=*) return 0 ;; esac
    done
    return 1
}

arguments=("$@")
if ! has --base "$@" && ! has --base-run "$@" && ! has --baseline "$@" && ! has --self-test "$@"; then
    against=${GATE_TARGET:-origin/main}
    # Not within the line that uses it: there, a failure would end with 1, as a difference does.
    base=$(git merge-base HEAD "$against" 2>/dev/null) || {
        echo "error: found no merge base of HEAD and $against; fetch the whole history (fetch-depth: 0), or give --base or GATE_TARGET" >&2
        exit 2
    }
    arguments+=(--base "$base")
fi
has --out "$@" || arguments+=(--out "out/gate-$(date -u +%Y%m%d-%H%M%S)")

ci/setup.sh --for bench

cargo build --release --locked --package terrafill
target=${CARGO_TARGET_DIR:-target}
program=$target/release/terrafill

# The base is built in a folder of its own. It has the same libraries, hardly ever others, and building these
# takes longer than all of this workspace: the first base begins with a copy of them.
if has --base "${arguments[@]}" && [ ! -e target/gate/target ]; then
    mkdir -p target/gate/copy/release
    cp -a "$target"/release/{deps,build,.fingerprint} target/gate/copy/release/
    mv target/gate/copy target/gate/target
fi

# exec: nothing stands between the verdict and who asked, so that no exit code becomes another.
exec "$program" gate "${arguments[@]}"
