#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Draws what the figures of the two globe papers show, each by `terrafill render`, and puts the pictures onto one sheet
# with the number of the figure beneath: docs/globe-figures.jpg. Needs a release build, TERRAFILL_DATA, node, npm and
# Chromium.
#
# usage: ci/contact-sheet.sh [OUT.jpg]   [default: docs/globe-figures.jpg]
set -euo pipefail
out=${1:-$(dirname "$0")/../docs/globe-figures.jpg}
out=$(realpath -m "$out")
cd "$(dirname "$0")/.."
program=${CARGO_TARGET_DIR:-target}/release/terrafill
chromium=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)}
for need in "$program" "$chromium" node npm; do
    command -v "$need" >/dev/null || {
        echo "contact-sheet: \"$need\" is not there; needed: a release build, Chromium, node and npm" >&2
        exit 1
    }
done
tools=${CARGO_TARGET_DIR:-target}/pages
mkdir -p "$tools"
npm install --prefix "$tools" --no-save --no-audit --no-fund --silent puppeteer-core@24.43.1

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# Twelve columns of this many pixels, and gaps between them.
column=109
gap=8
width=$((12 * column + 11 * gap))
{
    echo "<style>body{margin:6px;width:${width}px;background:#fff;color:#111;font:14px/1.25 sans-serif}"
    echo "div{display:grid;grid-template-columns:repeat(12,${column}px);gap:${gap}px;align-items:start}"
    echo 'figure{margin:0}img{width:100%;display:block}</style><div>'
} >"$folder/sheet.html"
number=0
# How many columns wide, with x2 where it is drawn at twice the size | the figure and what it shows | what `terrafill render` draws of it.
while IFS='|' read -r columns caption drawn; do
    number=$((number + 1))
    # As many pixels as the sheet has for it, so that lines of a pixel stay so; or twice as many.
    times=1
    case "$columns" in *x2) times=2 ;; esac
    columns=${columns%x2}
    size=$((times * (columns * column + (columns - 1) * gap)))
    # The name of a case may have blanks; options stand behind " --".
    options=()
    case "$drawn" in *" --"*) read -ra options <<<"--${drawn#* --}" ;; esac
    "$program" render "${drawn%% --*}" ${options[@]+"${options[@]}"} --size "$size" --out "$folder/$number.png" >"$folder/said.txt" 2>&1 || {
        cat "$folder/said.txt" >&2
        exit 1
    }
    echo "<figure style='grid-column:span $columns'><img src='$number.png'><figcaption>$caption</figcaption></figure>" >>"$folder/sheet.html"
done <ci/contact-sheet.txt
echo '</div>' >>"$folder/sheet.html"
NODE_PATH="$tools/node_modules" node - "$chromium" "$folder/sheet.html" "$out" "$((width + 12))" <<'JS'
const [program, page, path, width] = process.argv.slice(2);
(async () => {
    const browser = await require('puppeteer-core').launch({ executablePath: program, args: ['--no-sandbox'] });
    const tab = await browser.newPage();
    await tab.setViewport({ width: Number(width), height: 800 });
    await tab.goto(`file://${page}`);
    await tab.screenshot({ path, type: 'jpeg', quality: 60, fullPage: true });
    await browser.close();
})();
JS
echo "$number pictures: $out"
