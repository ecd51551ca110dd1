#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# Reports that are committed: one file with the report, and the run that it is made from as `run.tar.gz`.
#
# usage: ci/committed-report.sh rebuild reports/NAME          from its own tables
#        ci/committed-report.sh measure reports/NAME [RUN]    the scenes that ship, or a run that is there already
set -euo pipefail
cd "$(dirname "$0")/.."

case "${1:-} $#" in
    "rebuild 2" | "measure 2" | "measure 3") ;;
    *)
        sed -n 's/^# usage: //p; s/^#        //p' "$0" >&2
        exit 2
        ;;
esac
to=$2
# What a clone should carry of a report; a test refuses more.
max_bytes=2500000
cargo build --release --locked --package terrafill
program=${CARGO_TARGET_DIR:-target}/release/terrafill
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir -p "$to" "$scratch/run/images"

# The report from the tables in $scratch/run. Fills have a summary for programs as well.
report() {
    "$program" report "$scratch/run" --single-file
    for file in index.html result.json summary.csv summary.md; do
        [ ! -e "$scratch/run/$file" ] || cp "$scratch/run/$file" "$to"
    done
}

# Tables of $measured and its pictures, all or few, as $to/run.tar.gz; the same run gives the same archive. Of few,
# only the smallest ones whose bytes are $2 together.
pack() {
    rm -rf "$scratch/run"
    mkdir -p "$scratch/run/images"
    cp "$measured"/{cases,measurements,metrics}.csv "$measured"/{environment,plan,schema}.json "$scratch/run"
    # Not every run has them.
    for file in clocks.csv features.csv inputs.csv budget.json; do
        [ ! -e "$measured/$file" ] || cp "$measured/$file" "$scratch/run"
    done
    if [ "$1" = all ]; then
        cp "$measured/notes.csv" "$scratch/run"
        find "$measured" \( -path '*/images/*.png' -o -path '*/images/*.jpg' \) -exec cp {} "$scratch/run/images" \;
    else
        # Shaded pictures of fills are the largest part of a run and show what the reference's do.
        grep -vE ',(image|difference_image),' "$measured/notes.csv" >"$scratch/run/notes.csv"
        local left=$2 bytes path
        while read -r bytes path; do
            ((left -= bytes)) || true
            [ "$left" -lt 0 ] || cp "$path" "$scratch/run/images"
        done < <(grep -oE 'images/[^"]*\.(png|jpg)' "$scratch/run/notes.csv" | sort -u |
            while read -r path; do find "$measured" -path "*/$path" -printf '%s %p\n' -quit; done | sort -n)
    fi
    tar --sort=name --mtime=@0 --owner=0 --group=0 --numeric-owner -C "$scratch/run" -c . |
        gzip -9n >"$to/run.tar.gz"
}

if [ "$1" = measure ]; then
    measured=${3:-$scratch/measured}
    [ $# -eq 3 ] ||
        "$program" bench planet-134 california square-10m square-200km hills --quick --out "$measured"
    size() { cat "$to"/* | wc -c; }
    pack all
    report
    if [ "$(size)" -gt "$max_bytes" ]; then
        pack few 0
        report
        # A picture is in the archive and, by a third longer, in the page. A tenth is left for what stands around it.
        pack few $(((max_bytes - $(size)) * 9 / 10 * 3 / 7))
        report
    fi
else
    tar -xzf "$to/run.tar.gz" -C "$scratch/run"
    report
fi
du -sh --apparent-size "$to"
