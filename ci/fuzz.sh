#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Runs the fuzz targets of crates/ground/core/fuzz with libFuzzer, coverage guided, on the stable toolchain.
#
# usage: [TERRAFILL_FUZZ_PROCESSES=N] ci/fuzz.sh [SECONDS] [TARGET…]
#
# SECONDS of CPU time for each target, 60 if not given, so that a busy machine looks no less far;
# TARGET is geojson, mesh, elevation or models, all if not given; N processes share that time and what they find, one
# if not given. Starts from the seeds, the regressions and whatever
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
processes=${TERRAFILL_FUZZ_PROCESSES:-1}
targets=("$@")
[ ${#targets[@]} -gt 0 ] || targets=(geojson mesh elevation models)

fuzz=crates/ground/core/fuzz
build=${CARGO_TARGET_DIR:-target}/fuzz
mkdir -p "$build"
build=$(cd "$build" && pwd)
host=$(rustc -vV | sed -n 's/^host: //p')

# What `cargo fuzz build --sanitizer none` passes: LLVM's coverage hooks are in every rustc, only
# the sanitizers are not, and safe Rust has little for them to find. `--target` keeps the hooks out
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

# CPU seconds of these processes, user and system; fails once one has ended.
cpu_seconds() {
    ps -o stat=,cputimes= -p "$(IFS=,; echo "$*")" |
        awk -v all=$# '$1 !~ /^Z/ { sum += $2; found++ } END { print sum + 0; exit found < all }'
}

# One `name count` a line, added up over files.
sums() {
    awk '!($1 in sum) { names[++count] = $1 }
        { sum[$1] += $2 }
        END { for (i = 1; i <= count; i++) print names[i], sum[names[i]] }' "$@"
}

fuzzers=()
trap '[ ${#fuzzers[@]} -eq 0 ] || kill "${fuzzers[@]}" 2>/dev/null || true' EXIT

failed=0
for target in "${targets[@]}"; do
    program=$build/$host/release/$target
    if [ ! -x "$program" ]; then
        echo "no target \"$target\"; there are geojson, mesh, elevation and models" >&2
        exit 2
    fi
    corpus=$build/corpus/$target
    artifacts=$build/artifacts/$target
    counters=$build/$target.counters
    log=$build/$target.log
    mkdir -p "$corpus" "$artifacts"
    rm -f "$counters".* "$log".*
    echo "== $target, $seconds s of CPU time"
    fuzzers=()
    for ((process = 0; process < processes; process++)); do
        # An input that takes 1 GiB, or for ever, is a find as well. libFuzzer's limit is by the clock:
        # on a busy machine 2 s of CPU time have taken 21.
        RUST_BACKTRACE=0 TERRAFILL_FUZZ_COUNTERS=$counters.$process "$program" \
            -timeout=200 -rss_limit_mb=1024 -max_len=512 \
            -artifact_prefix="$artifacts/" -print_final_stats=1 \
            "$corpus" "$fuzz/seeds/$target" "$fuzz/regressions/$target" >"$log.$process" 2>&1 &
        fuzzers+=($!)
    done
    spent=0
    while used=$(cpu_seconds "${fuzzers[@]}"); do
        spent=$used
        [ "$spent" -lt "$seconds" ] || break
        sleep 1
    done
    kill -INT "${fuzzers[@]}" 2>/dev/null || true
    found=0
    for fuzzer in "${fuzzers[@]}"; do
        code=0
        wait "$fuzzer" || code=$?
        [ "$code" -eq "$interrupted" ] || found=1
    done
    if [ "$found" -ne 0 ]; then
        # From the panic's message to libFuzzer's, or what libFuzzer says of a slow or large input.
        sed -n '/panicked at/,/^note:/p; /^SUMMARY/p' "$log".*
        echo "$target: a find; the input is in $artifacts" >&2
        failed=1
        continue
    fi
    sums "$counters".* >"$counters"
    echo "cpu_seconds $spent"
    grep -hE '^stat::(number_of_executed_units|peak_rss_mb)' "$log".*
    cat "$counters"
    if awk '$2 == 0 { print "'"$target"': never reached: " $1; found = 1 } END { exit !found }' \
        "$counters" >&2; then
        failed=1
    fi
done
exit $failed
