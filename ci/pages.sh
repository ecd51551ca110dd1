#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Opens every page of a report in headless Chromium and checks what needs a browser. With all that is folded
# opened, axe finds nothing serious, nothing scrolls sideways at 1400, 800 and 390 pixels, no picture is broken,
# and the console stays empty. Links into what is folded, filters, sorting, keyboard and the wipe slider
# work. The first page loads in 1 s, prints on at most 12 pages, and has at most 300 kB unless it is a single file,
# which holds all the others. Needs node, npm and Chromium; where one is absent it says so and checks
# nothing. A page with every fault is checked first, and each of its faults must be found.
#
# usage: ci/pages.sh RUN [RUN...]   folders with a report, as `bench` or `report` leaves them, such as reports/*/
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)

[ $# -gt 0 ] || { echo "usage: ci/pages.sh RUN [RUN...]" >&2; exit 2; }

chromium=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)}
for need in node npm; do
    command -v "$need" >/dev/null || { echo "pages: skipped, $need is not installed"; exit 0; }
done
[ -n "$chromium" ] || { echo "pages: skipped, Chromium is not installed (CHROMIUM=… names another)"; exit 0; }

# Fixed versions: what axe finds must not change from one day to the next.
tools=${CARGO_TARGET_DIR:-$here/../target}/pages
mkdir -p "$tools"
if ! npm install --prefix "$tools" --no-save --no-audit --no-fund --silent \
    axe-core@4.14.1 puppeteer-core@24.43.1; then
    echo "pages: skipped, npm could not install axe-core and puppeteer-core"
    exit 0
fi
NODE_PATH="$tools/node_modules" CHROMIUM="$chromium" exec node "$here/pages.js" "$@"
