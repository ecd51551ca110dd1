#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Everything that must hold before a change is merged. Stops at the first step that fails.
#
# usage: ci/test.sh
set -euo pipefail
cd "$(dirname "$0")/.."

section() { printf '\n== %s\n' "$*"; }

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

section "dependencies, cycles, shaders"
cargo xtask check-deps
cargo xtask check-cycles
cargo xtask check-shaders

section "tests"
target=${CARGO_TARGET_DIR:-target}
mkdir -p "$target"
target=$(cd "$target" && pwd)
log=$target/validation.log
output=$target/nextest.txt
rm -f "$log"
# A device test that is skipped for want of a device would be a check that does not check.
TERRAFILL_REQUIRE_DEVICE=1 TERRAFILL_VALIDATION=1 TERRAFILL_VALIDATION_LOG=$log \
    cargo nextest run --workspace --locked --color never 2>&1 | tee "$output"

section "what the Vulkan validation layer saw"
cargo xtask check-validation-log "$log"

section "documentation tests"
cargo test --workspace --doc --locked --quiet

section "documentation"
RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked --quiet

section "result"
if [ -z "${TERRAFILL_DATA:-}" ]; then
    echo "TERRAFILL_DATA is not set: tests on real data were skipped"
fi
grep -E '^ *Summary ' "$output"
