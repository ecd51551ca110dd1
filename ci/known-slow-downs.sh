#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# How near the time gate comes to slow-downs of known size: makes the table of docs/gate.md, there with the gates
# v42 v100 f8 f32 c60000 c150000. Loops that change no pixel are put into the vertex shader of `instanced`, into the
# fragment shader of covers and before the frame's commands. How often each goes round is a number in the program's
# bytes, so all programs share their code. The base goes round as well, and so often that no processor foresees the end:
# whether it does costs, we take it, as much as several rounds. Of fragments an eighth goes round. What a round costs
# comes from gates of four times as much work and more, one before each; single processes of `bench`, another route,
# stand beside it. Needs python3, a software driver and half an hour of a machine that does nothing else.
#
# usage: ci/known-slow-downs.sh OUT [GATES]
#        ci/known-slow-downs.sh --check     whether the loops still find their places, in a second
#   GATES: v, f or c, work in the vertex shader, in the fragment shader or on the CPU, with a number of rounds more
#   than the base   [default: v42 v70 v100 f8 f16 f32 c60000 c100000 c150000]
set -euo pipefail

# Puts the loops into a tree of sources.
add_loops() {
    python3 - "$1" <<'PYTHON'
import pathlib, sys
tree = pathlib.Path(sys.argv[1])
def edit(path, before, after):
    text = (tree / path).read_text()
    assert text.count(before) == 1, f"{path}: found {before!r} {text.count(before)} times, expected once"
    (tree / path).write_text(text.replace(before, after))
# The number must have no bound that a compiler sees: it would make straight code of few rounds, at another cost each.
# Of fragments an eighth goes round, in columns as wide as what a processor shades at once: for all it is too much.
loop = """    var waste = {start};
    let rounds = select(0u,     {mark}u, {here}) + select(0u, {any}, {never});
    for (var i = 0u; i < rounds; i++) {{
        waste = waste * 0.999 + 0.001;
    }}
"""
edit("shaders/instanced/fill.wgsl",
     "    return clip_from_eye_relative(eye_relative_m(position, region_index, height_m));\n",
     loop.format(start="height_m", mark="1000001", here="true", any="region_index", never="height_m < -1e30")
     + "    let same_m = height_m + select(0.0, 1.0, waste > 1e30);\n"
     + "    return clip_from_eye_relative(eye_relative_m(position, region_index, same_m));\n")
edit("shaders/vertex/cover.wgsl", "    return in.colour;\n",
     loop.format(start="in.colour.x", mark="1000002", here="(u32(in.clip.x) & 28u) == 0u", any="bitcast<u32>(in.colour.y)", never="in.clip.x < -1e30")
     + "    return in.colour + vec4<f32>(select(0.0, 1.0, waste > 1e30));\n")
edit("crates/devices/gpu/src/fill.rs", "        let mut counters = Counters::default();\n",
     """        for round in 0..hidden_rounds() {
            std::hint::black_box(round.wrapping_mul(6_364_136_223_846_793_005));
        }
        let mut counters = Counters::default();
""")
with (tree / "crates/devices/gpu/src/fill.rs").open("a") as file:
    file.write("""
#[used]
static HIDDEN: [u8; 24] = *b"HIDDEN-ROUNDS=0001000003";

fn hidden_rounds() -> u64 {
    let digits = &std::hint::black_box(&HIDDEN)[14..];
    digits.iter().fold(0, |sum, digit| 10 * sum + u64::from(digit - b'0'))
}
""")
PYTHON
}

repository=$(realpath "$(dirname "$0")/..")
if [ "${1:-}" = --check ]; then
    tree=$(mktemp -d)
    trap 'rm -rf "$tree"' EXIT
    cd "$repository"
    cp --parents shaders/instanced/fill.wgsl shaders/vertex/cover.wgsl crates/devices/gpu/src/fill.rs "$tree"
    add_loops "$tree"
    echo "the loops find their places"
    exit
fi

[ $# -ge 1 ] && [ ! -e "$1" ] || {
    echo "usage: $0 OUT [GATES], OUT a folder that is not there yet" >&2
    exit 2
}
mkdir -p "$1"
out=$(realpath "$1")
shift
gates=("$@")
[ ${#gates[@]} -gt 0 ] || gates=(v42 v70 v100 f8 f16 f32 c60000 c100000 c150000)
cd "$repository"
target=$(realpath "${CARGO_TARGET_DIR:-target}")

cargo build --release --locked --package terrafill
gate=$out/gate-program
cp "$target/release/terrafill" "$gate"

# The program with the loops: a tree of its own, whose libraries are copies.
tree=$out/tree
git worktree add --detach --force "$tree" HEAD >/dev/null
trap 'git worktree remove --force "$tree"' EXIT
add_loops "$tree"
mkdir -p "$out/target/release"
cp -a "$target"/release/{deps,build,.fingerprint} "$out/target/release/"
(cd "$tree" && CARGO_TARGET_DIR=$out/target cargo build --release --locked --package terrafill)

# One program for each number of rounds: v, f or c with the number.
program() {
    python3 - "$out/target/release/terrafill" "$1" "$out/$1" <<'PYTHON'
import os, sys
built, name, to = sys.argv[1:]
rounds = {"v": 64, "f": 64, "c": 1000}
if name != "none":
    rounds[name[0]] += int(name[1:])
program = open(built, "rb").read()
# Numbers of WGSL have no leading zeros, so they are padded with spaces.
marks = [("v", b"    1000001u", b"    %7du"), ("f", b"    1000002u", b"    %7du"),
         ("c", b"HIDDEN-ROUNDS=0001000003", b"HIDDEN-ROUNDS=%010d")]
for kind, mark, text in marks:
    text = text % rounds[kind]
    assert program.count(mark) > 0 and len(mark) == len(text), (kind, rounds)
    program = program.replace(mark, text)
open(to, "wb").write(program)
os.chmod(to, 0o755)
PYTHON
}
many=(v400 f256 c600000)
for name in none "${many[@]}" "${gates[@]}"; do
    [ -e "$out/$name" ] || program "$name"
done
for round in 1 2; do
    for name in none "${many[@]}" none; do
        run=$out/cost-$name-$round
        [ ! -e "$run" ] || run=$run-again
        taskset -c 0 "$out/$name" bench california --technique instanced --size 256 --quick --samples 60 \
            --out "$run" >/dev/null 2>&1
    done
done
# gate NEW OUT: a slow-down ends a gate with 1.
gate() {
    "$gate" gate california --technique instanced --base "$out/none" --new "$out/$1" --out "$out/$2" \
        >/dev/null 2>&1 || [ -e "$out/$2/gate.json" ]
    echo "$2: done" >&2
}
for name in "${gates[@]}"; do
    # How fast the machine is changes within minutes.
    for large in "${many[@]}"; do
        [ "${large:0:1}" != "${name:0:1}" ] || gate "$large" "many-$large-$name"
    done
    gate "$name" "gate-$name"
done

python3 - "$out" "${many[*]}" "${gates[@]}" <<'PYTHON'
import csv, glob, json, statistics as st, sys
out, many, gates = sys.argv[1], sys.argv[2].split(), sys.argv[3:]
def medians(run):
    samples = {}
    for row in csv.DictReader(open(f"{run}/measurements.csv")):
        if row["metric"] == "fill_cpu_ms" and row["sample"] != "0" and "(again)" not in row["case"]:
            samples.setdefault(row["case"], []).append(float(row["value"]))
    return {case: st.median(values) for case, values in samples.items()}
def alone(name):
    runs = [medians(run) for run in glob.glob(f"{out}/cost-{name}-*")]
    return {case: st.median(run[case] for run in runs) for case in runs[0]}
def frames(folder):
    return [case for case in json.load(open(f"{folder}/gate.json"))["time"]["cases"] if case["span"] == "frame"]
# Percent of the base for a round: the base is the same program in all gates.
none, a_round, by_process = alone("none"), {}, {}
for name in many:
    kind, rounds, slow = name[0], int(name[1:]), alone(name)
    found = {}
    for folder in glob.glob(f"{out}/many-{name}-*"):
        for case in frames(folder):
            if "/instanced/" in case["case"]:
                found.setdefault(case["case"], []).append(case["percent"] / rounds)
    a_round[kind] = {case: st.fmean(values) for case, values in found.items()}
    by_process[kind] = [100 * (slow[case] / none[case] - 1) / rounds / cost for case, cost in a_round[kind].items()]
rows, baselines, called = [], 0, 0
for name in gates:
    kind, rounds = name[0], int(name[1:])
    for case in frames(f"{out}/gate-{name}"):
        if case["case"] not in a_round[kind]:
            baselines, called = baselines + 1, called + (case["pace"] in ("slower", "faster"))
            continue
        expected = a_round[kind][case["case"]] * rounds
        rows.append((kind, expected, case["percent"], case.get("interval_percent"), case["pace"]))
print("| work in | cases that were decided | expected, % | gate less expected, mean | rms | largest "
      "| 5 % or more, called slower | a round by single processes |\n|---|---|---|---|---|---|---|---|")
for kind, words in (("v", "vertex"), ("f", "fragment"), ("c", "CPU")):
    own = [row for row in rows if row[0] == kind]
    decided = [row for row in own if row[3]]
    if not decided:
        continue
    off = [row[2] - row[1] for row in decided]
    large = [row for row in own if row[1] >= 5]
    least, most = min(row[1] for row in decided), max(row[1] for row in decided)
    rms = st.fmean(x * x for x in off) ** 0.5
    print(f"| {words} | {len(decided)} | {least:.1f} … {most:.1f} | {st.fmean(off):+.2f} | {rms:.2f} "
          f"| {max(off, key=abs):+.2f} | {sum(row[4] == 'slower' for row in large)} of {len(large)} "
          f"| {st.median(by_process[kind]):.2f} × |")
decided = [row for row in rows if row[3]]
within = sum(abs(row[2] - row[1]) <= 1 for row in decided)
small = [row for row in decided if row[1] <= 13]
print(f"\n{within} of {len(decided)} estimates within 1 % of what was expected, of changes up to 13 % "
      f"{sum(abs(row[2] - row[1]) <= 1 for row in small)} of {len(small)}; "
      f"of {baselines} baseline passes {called} called")
PYTHON
