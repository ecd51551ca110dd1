#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# What volumes cost: the last steps of every volume technique's ablation in the views of the countries and of
# planet-134, in one run. Prints a table per scene and technique: milliseconds (median of processes; by the GPU's
# clock on hardware, else process CPU time), their ratio to the stencil-pass of the same view, and bytes, draws and
# vertices of each step. Scenes whose data is missing are skipped. PROCESSES [5], SIZE [1024] and STEP [colours: the first one measured] may be set;
# with --tables a run that is there is printed again.
#
# usage: ci/volume-cost.sh [--tables RUN | SCENE...]
set -euo pipefail
cd "$(dirname "$0")/.."

tables() {
    # As the report does: the device's clock on hardware that has one, process CPU time on software.
    metric=fill_gpu_ms clock="the GPU's clock"
    if grep -q '"device_type": "cpu"' "$1/environment.json" ||
        grep -q '"gpu_timestamps": false' "$1/environment.json"; then
        metric=fill_cpu_ms clock="process CPU time"
    fi
    awk -v metric="$metric" -v clock="$clock" '
    # Fields of a line of CSV into part[], quotes taken off.
    function split_csv(line, part,    n, field, quoted, i, c) {
        n = 0; field = ""; quoted = 0
        for (i = 1; i <= length(line); i++) {
            c = substr(line, i, 1)
            if (c == "\"") quoted = !quoted
            else if (c == "," && !quoted) { part[++n] = field; field = "" }
            else field = field c
        }
        part[++n] = field
        return n
    }
    function median(list, n,    i, j, t) {
        for (i = 2; i <= n; i++)
            for (j = i; j > 1 && list[j - 1] > list[j]; j--) { t = list[j]; list[j] = list[j - 1]; list[j - 1] = t }
        return n % 2 ? list[(n + 1) / 2] : (list[n / 2] + list[n / 2 + 1]) / 2
    }
    # Median of the processes, each by the median of its frames.
    function time_of(key,    p, s, n, k, frames, processes) {
        for (p = 0; p < 100; p++) {
            n = 0
            for (s = 1; (key, p, s) in sample; s++) frames[++n] = sample[key, p, s]
            if (n) processes[++k] = median(frames, n)
        }
        return k ? median(processes, k) : ""
    }
    FILENAME ~ /cases.csv$/ {
        split_csv($0, part)
        if (FNR == 1) { for (i in part) column[part[i]] = i; next }
        key = part[column["case"]]
        scene = part[column["scene"]]; view = part[column["view"]]; technique = part[column["technique"]]
        role = "+" part[column["role"]] "+"
        if (part[column["repeats"]] != "") next
        if (technique == "stencil-pass") { yardstick[scene, view] = key; next }
        rung = column["rung"] ? part[column["rung"]] : ""
        if (role !~ /\+(ladder|main)\+/ || view == "") next
        if (rung == "" && role !~ /\+full-plan\+/) next
        has_levels = part[column["boundary-lod-px"]] !~ /^(off)?$/
        plan = "full plan, " (has_levels ? "with levels" : "exact")
        name = rung == "" ? plan : part[column["step"]] (part[column["aside"]] == "yes" ? " (aside)" : "")
        row = sprintf("%03d", rung == "" ? 998 + has_levels : rung)
        table = scene SUBSEP technique
        if (!(table in seen)) { seen[table] = 1; order[++tables] = table }
        rows[table, row] = name; if (row > last[table]) last[table] = row
        if (!((scene, view) in known)) { known[scene, view] = 1; views[scene] = views[scene] " " view }
        of[table, row, view] = key; status[key] = part[column["status"]]; next
    }
    FNR > 1 {
        split_csv($0, part)
        if (part[2] == metric) sample[part[1], part[3], part[4]] = part[5]
        else figure[part[1], part[2]] = part[5]
    }
    END {
        for (t = 1; t <= tables; t++) {
            split(order[t], is, SUBSEP); scene = is[1]; n = split(views[scene], at, " ")
            printf "\n%s, %s\n%-24s", scene, is[2], "step"
            for (v = 1; v <= n; v++) printf "  %24s", at[v] " ms (/stencil)"
            printf "  %10s %7s %9s %7s %9s\n", "bytes", "draws", "vertices", "px off", "out band"
            for (r = 1; r <= 999; r++) {
                row = sprintf("%03d", r)
                if (!((order[t], row) in rows)) continue
                printf "%-24s", rows[order[t], row]
                first = ""; worst = 0; outside = 0
                for (v = 1; v <= n; v++) {
                    key = of[order[t], row, at[v]]; if (first == "") first = key
                    ms = time_of(key); base = time_of(yardstick[scene, at[v]])
                    cell = ms == "" ? (status[key] == "" ? "-" : status[key]) : sprintf("%.3f (%.2f)", ms, base > 0 ? ms / base : 0)
                    printf "  %24s", cell
                    if (figure[key, "mismatched_px"] > worst) worst = figure[key, "mismatched_px"]
                    outside += figure[key, "mismatched_px_outside_band"]
                }
                printf "  %10d %7d %9d %7d %9d\n", figure[first, "geometry_bytes"], figure[first, "draws"], figure[first, "vertices"], worst, outside
            }
        }
        print "\nms: " clock "; bytes, draws and vertices: of the first view; px off: the most of a view; out band: of all views"
    }' "$1/cases.csv" "$1/measurements.csv"
}

if [ "${1:-}" = --tables ]; then
    [ $# -eq 2 ] || {
        sed -n 's/^# usage: //p' "$0" >&2
        exit 2
    }
    tables "$2"
    exit
fi

scenes=("$@")
[ $# -gt 0 ] || scenes=(countries-110m countries-50m planet-134 countries-10m)
if [ -z "${TERRAFILL_DATA:-}" ] && [ -d ../shared/data ]; then
    TERRAFILL_DATA=$(cd ../shared/data && pwd)
    export TERRAFILL_DATA
fi
cargo build --release --locked --package terrafill
program=${CARGO_TARGET_DIR:-target}/release/terrafill
out=out/volume-cost-$(date -u +%Y%m%d-%H%M%S)
ablations=()
for scene in "${scenes[@]}"; do
    ablations+=(--ablation "$scene:${STEP:-colours}")
done
techniques=(--technique vertex --technique instanced --technique compute --technique native)
"$program" bench "${scenes[@]}" "${ablations[@]}" "${techniques[@]}" --quick \
    --processes "${PROCESSES:-5}" --samples 3 --size "${SIZE:-1024}" --out "$out"
tables "$out"
