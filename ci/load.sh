#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Loads one core half of the time, by turns of half a second, until it is ended or the given seconds are over.
# A time gate has to stand that on a shared machine. Run it beside `terrafill gate --self-test`.
#
# usage: ci/load.sh [SECONDS]
set -euo pipefail

end=$((SECONDS + ${1:-600}))
while [ "$SECONDS" -lt "$end" ]; do
    # Hashing works in registers and cache, as much other work does.
    timeout 0.5 sha256sum /dev/zero || true
    sleep 0.5
done
