#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Runs the fuzz targets of crates/core/fuzz with libFuzzer, coverage guided, on the stable toolchain.
#
# usage: ci/fuzz.sh [SECONDS] [TARGET…]
#
# SECONDS of CPU time for each target, 60 if not given, so that a busy machine looks no less far;
# TARGET is geojson or mesh, both if not given. Starts from the seeds, the regressions and whatever
# earlier runs left in target/fuzz. Prints the CPU time, the executions and how often each branch
# was reached; exit 1 on a find or on a branch never reached.
set -euo pipefail
cd "$(dirname "$0")/.."

seconds=${1:-60}
shift || true
case $seconds in
'' | *[!0-9]*)
    echo "SECONDS is \"$seconds\"; expected a whole number" >&2
    exit 2
    ;;
esac
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(geojson mesh)

fuzz=crates/core/fuzz
build=${CARGO_TARGET_DIR:-target}/fuzz
mkdir -p "$build"
build=$(cd "$build" && pwd)
host=$(rustc -vV | sed -n 's/^host: //p')

# What `cargo fuzz build --sanitizer none` passes: LLVM's coverage hooks are in every rustc, only
# the sanitizers are not, and safe Rust has little for them to find. Without `--cfg fuzzing`, which
# has spade walk its whole hull at each step, 50 times the run time. `--target` keeps the hooks out
# of build scripts.
RUSTFLAGS="-Cpasses=sancov-module -Ccodegen-units=1"
for argument in level=4 inline-8bit-counters pc-table trace-compares; do
    RUSTFLAGS+=" -Cllvm-args=-sanitizer-coverage-$argument"
done
export RUSTFLAGS
CARGO_TARGET_DIR=$build cargo build --quiet --release --locked \
    --manifest-path "$fuzz/Cargo.toml" --target "$host"

# What libFuzzer exits with when it is interrupted, as it is here when its time is up.
interrupted=72

# CPU seconds of a process, user and system; nothing once it has ended.
cpu_seconds() {
    ps -o cputimes= -p "$1" | tr -d ' '
}

failed=0
for target in "${targets[@]}"; do
    program=$build/$host/release/$target
    if [ ! -x "$program" ]; then
        echo "no target \"$target\"; there are geojson and mesh" >&2
        exit 2
    fi
    corpus=$build/corpus/$target
    artifacts=$build/artifacts/$target
    counters=$build/$target.counters
    log=$build/$target.log
    mkdir -p "$corpus" "$artifacts"
    rm -f "$counters"
    echo "== $target, $seconds s of CPU time"
    # An input that takes 20 s, or 1 GiB, is a find as well.
    RUST_BACKTRACE=0 TERRAFILL_FUZZ_COUNTERS=$counters "$program" \
        -timeout=20 -rss_limit_mb=1024 -max_len=512 \
        -artifact_prefix="$artifacts/" -print_final_stats=1 \
        "$corpus" "$fuzz/seeds/$target" "$fuzz/regressions/$target" >"$log" 2>&1 &
    fuzzer=$!
    trap 'kill "$fuzzer" 2>/dev/null || true' EXIT
    spent=0
    while used=$(cpu_seconds "$fuzzer") && [ -n "$used" ]; do
        spent=$used
        if [ "$spent" -ge "$seconds" ]; then
            kill -INT "$fuzzer"
            break
        fi
        sleep 1
    done
    code=0
    wait "$fuzzer" || code=$?
    if [ "$code" -ne "$interrupted" ]; then
        # From the panic's message to libFuzzer's, or what libFuzzer says of a slow or large input.
        sed -n '/panicked at/,/^note:/p; /^SUMMARY/p' "$log"
        echo "$target: a find; the input is in $artifacts" >&2
        failed=1
        continue
    fi
    echo "cpu_seconds $spent"
    grep -E '^stat::(number_of_executed_units|average_exec_per_sec|peak_rss_mb)' "$log"
    cat "$counters"
    if awk '$2 == 0 { print "'"$target"': never reached: " $1; found = 1 } END { exit !found }' \
        "$counters" >&2; then
        failed=1
    fi
done
exit $failed
