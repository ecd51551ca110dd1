#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Everything that must hold before a change is merged. Stops at the first step that fails.
#
# Runs without data, as on a clone alone. Where TERRAFILL_DATA names a folder, the tests that need data run
# after that; a file that is missing there is a failure.
#
# usage: ci/test.sh           everything
#        ci/test.sh --data    only the tests that need data
set -euo pipefail
case "$*" in
    "" | --data) ;;
    *)
        sed -n 's/^# usage: //p; s/^#        //p' "$0" >&2
        exit 2
        ;;
esac
data=${TERRAFILL_DATA:-}
case "$data" in "" | /*) ;; *) data=$PWD/$data ;; esac
unset TERRAFILL_DATA
cd "$(dirname "$0")/.."

# Nothing is built twice here. What cargo keeps for a second build takes 11 GB, and optimises less.
export CARGO_INCREMENTAL=${CARGO_INCREMENTAL:-0}

section() { printf '\n== %s\n' "$*"; }

target=${CARGO_TARGET_DIR:-target}
mkdir -p "$target"
target=$(cd "$target" && pwd)

log=$target/validation.log
rm -f "$log"

# Runs tests under the validation layer, which writes to $log.
#   $1: name of the output file   $2…: arguments of nextest
run_tests() {
    local output=$target/$1.txt
    shift
    # A device test that is skipped for want of a device would be a check that does not check.
    TERRAFILL_REQUIRE_DEVICE=1 TERRAFILL_VALIDATION=1 TERRAFILL_VALIDATION_LOG=$log \
        cargo nextest run --workspace --locked --color never "$@" 2>&1 | tee "$output"
}

summary() { grep -E '^ *Summary ' "$target/$1.txt"; }

# How many tests a run's summary counts as $2: run, or skipped.
counted() { summary "$1" | sed -nE "s/.* ([0-9]+) (tests? $2|$2).*/\1/p"; }

data_tests() {
    section "tests that need data"
    TERRAFILL_DATA=$data run_tests nextest-data --run-ignored only
}

if [ "${1:-}" = --data ]; then
    [ -n "$data" ] || {
        echo "TERRAFILL_DATA is not set; expected a folder with data" >&2
        exit 2
    }
    data_tests
    exit
fi

section "set-up"
ci/setup.sh --for test

section "scripts"
scripts=(ci/*.sh ci/examples/*.sh .ci/run)
for script in "${scripts[@]}"; do
    bash -n "$script"
    [ -x "$script" ] || {
        echo "$script is not executable" >&2
        exit 1
    }
done
echo "${#scripts[@]} scripts parse"
if command -v python3 >/dev/null; then
    ci/known-slow-downs.sh --check
else
    echo "known-slow-downs.sh: python3 is not installed, not checked"
fi

section "text"
# None of these is needed to build; where one is missing, the line says so.
optional() {
    if command -v "$1" >/dev/null; then
        "$@"
        echo "$1: clean"
    else
        echo "$1: not installed, not run"
    fi
}
optional shellcheck "${scripts[@]}"
optional typos
optional taplo fmt --check
optional cargo-deny --locked check licenses sources

section "format"
cargo fmt --all --check

section "lints"
cargo clippy --workspace --all-targets --locked -- -D warnings

section "build"
cargo build --workspace --tests --bins --locked --quiet

section "dependencies, cycles, data, keys, lines, shaders"
# `cargo xtask` would build what it needs once more, with fewer features than the workspace as a whole.
xtask=$target/debug/xtask
"$xtask" check-deps
# The fuzz targets are a workspace of their own, with a lock file of its own.
cargo metadata --locked --manifest-path crates/ground/core/fuzz/Cargo.toml --format-version 1 >/dev/null
"$xtask" check-cycles
"$xtask" check-data-tests
"$xtask" check-docs
"$xtask" check-keys
"$xtask" check-lines
"$xtask" check-shaders

section "tests"
run_tests nextest

[ -z "$data" ] || data_tests

section "what the Vulkan validation layer saw"
"$xtask" check-validation-log "$log"

section "documentation tests"
# Building the documentation of every crate once more takes a minute, so only where there is an example.
if grep -rqE '^ *//[/!] +(```|~~~)' crates xtask --include='*.rs'; then
    cargo test --workspace --doc --locked --quiet
else
    echo "no example stands in a doc comment"
fi

section "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked --quiet

section "result"
summary nextest
if [ -z "$data" ]; then
    echo "TERRAFILL_DATA is not set: the $(counted nextest skipped) tests that need data were skipped"
    exit
fi
summary nextest-data
if [ "$(counted nextest skipped)" != "$(counted nextest-data run)" ]; then
    echo "not every test that was skipped without data ran with it" >&2
    exit 1
fi
