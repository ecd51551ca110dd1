#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Whether readers of JUnit that CI systems use count what the gate found: junitparser (PyPI), junit2json and
# test-results-parser (npm), and Jenkins' schema where JENKINS_XSD names a copy of junit-10.xsd. Needs python3 with
# venv, node with npm, and the package registries. Negative control: the same file with a failure taken out.
#
# usage: ci/junit-readers.sh GATE_FOLDER
set -euo pipefail

[ $# -eq 1 ] && [ -f "$1/gate.junit.xml" ] || {
    echo "usage: $0 FOLDER, of a gate: with gate.junit.xml and gate.json" >&2
    exit 2
}
gate=$(realpath "$1")
cd "$(dirname "$0")/.."
tools=${CARGO_TARGET_DIR:-target}/junit-readers
mkdir -p "$tools"
[ -d "$tools/venv" ] || python3 -m venv "$tools/venv"
"$tools/venv/bin/pip" install --quiet 'junitparser==5.0.3' 'xmlschema==4.1.0'
npm install --silent --no-save --prefix "$tools" junit2json@4.0.0 test-results-parser@0.4.6

cat >"$tools/read.py" <<'PYTHON'
import sys
from junitparser import Error, Failure, JUnitXml, Skipped
cases = [case for suite in JUnitXml.fromfile(sys.argv[1]) for case in suite]
has = lambda case, kinds: any(isinstance(result, kinds) for result in case.result)
print(len(cases), sum(has(c, (Failure, Error)) for c in cases), sum(has(c, Skipped) for c in cases))
PYTHON
cat >"$tools/read.mjs" <<'NODE'
import fs from 'node:fs';
import { parse } from 'junit2json';
import results from 'test-results-parser';
const [reader, file] = process.argv.slice(2);
if (reader === 'junit2json') {
  const suites = (await parse(fs.readFileSync(file, 'utf8'))).testsuite ?? [];
  const cases = suites.flatMap((suite) => suite.testcase ?? []);
  const count = (is) => cases.filter(is).length;
  console.log(cases.length, count((c) => c.failure || c.error), count((c) => c.skipped));
} else {
  const found = results.parse({ type: 'junit', files: [file] });
  console.log(found.total, found.failed + found.errors, found.skipped);
}
NODE

# Tests, failed and skipped, as a reader sees them.
read_by() {
    case $1 in
        junitparser) "$tools/venv/bin/python" "$tools/read.py" "$2" ;;
        *) node "$tools/read.mjs" "$1" "$2" ;;
    esac
}

expected=$(grep -o '<testcase ' "$gate/gate.junit.xml" | wc -l)
expected+=" $(grep -c -E '<(failure|error) ' "$gate/gate.junit.xml" || true)"
expected+=" $(grep -c '<skipped' "$gate/gate.junit.xml" || true)"
broken=$tools/broken.xml
sed '0,/<\/testcase>/s///' "$gate/gate.junit.xml" >"$broken"
for reader in junitparser junit2json test-results-parser; do
    found=$(read_by "$reader" "$gate/gate.junit.xml")
    [ "$found" = "$expected" ] || {
        echo "$reader: found \"$found\" tests, failed and skipped, expected \"$expected\"" >&2
        exit 1
    }
    if [ "$(read_by "$reader" "$broken" 2>&1)" = "$expected" ]; then
        echo "$reader: read a file whose elements do not match, expected an error" >&2
        exit 1
    fi
    echo "$reader: $found"
done
if [ -n "${JENKINS_XSD:-}" ]; then
    "$tools/venv/bin/xmlschema-validate" --schema "$JENKINS_XSD" "$gate/gate.junit.xml"
fi
