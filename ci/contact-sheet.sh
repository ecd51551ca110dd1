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
{
    echo '<style>body{margin:6px;width:1000px;background:#fff;color:#111;font:13px/1.25 sans-serif}'
    echo 'div{display:grid;grid-template-columns:repeat(5,1fr);gap:8px}figure{margin:0}img{width:100%}</style><div>'
} >"$folder/sheet.html"
number=0
# The figure and what it shows | what `terrafill render` draws of it.
while IFS='|' read -r caption drawn; do
    number=$((number + 1))
    # The name of a case may have blanks; options stand behind " --".
    options=()
    case "$drawn" in *" --"*) read -ra options <<<"--${drawn#* --}" ;; esac
    "$program" render "${drawn%% --*}" ${options[@]+"${options[@]}"} --size 384 --out "$folder/$number.png" >"$folder/said.txt" 2>&1 || {
        cat "$folder/said.txt" >&2
        exit 1
    }
    echo "<figure><img src='$number.png'><figcaption>$caption</figcaption></figure>" >>"$folder/sheet.html"
done <ci/contact-sheet.txt
echo '</div>' >>"$folder/sheet.html"
NODE_PATH="$tools/node_modules" node - "$chromium" "$folder/sheet.html" "$out" <<'JS'
const [program, page, path] = process.argv.slice(2);
(async () => {
    const browser = await require('puppeteer-core').launch({ executablePath: program, args: ['--no-sandbox'] });
    const tab = await browser.newPage();
    await tab.setViewport({ width: 1012, height: 800 });
    await tab.goto(`file://${page}`);
    await tab.screenshot({ path, type: 'jpeg', quality: 82, fullPage: true });
    await browser.close();
})();
JS
echo "$number pictures: $out"
