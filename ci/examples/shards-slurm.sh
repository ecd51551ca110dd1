#!/usr/bin/env bash
# SPDX-License-Identifier: MIT OR Apache-2.0
#
# One run over the nodes of a Slurm cluster, a shard to each task of an array, joined by a last job.
# Each task takes a whole node: another job on it would be in the times.
#
# Balanced by an earlier run: ci/examples/shards-slurm.sh 4 out/new --shard-by duration:$PWD/out/last/all
#
# TERRAFILL names the program where it is not target/release/terrafill.
#
# usage: ci/examples/shards-slurm.sh SHARDS FOLDER [bench option...]
set -euo pipefail

[ $# -ge 2 ] || {
    echo "usage: $0 SHARDS FOLDER [bench option...]" >&2
    exit 2
}
shards=$1 folder=$(realpath -m "$2")
shift 2
cd "$(dirname "$0")/../.."
program=$(printf %q "$(realpath "${TERRAFILL:-target/release/terrafill}")")
mkdir -p "$folder"
quoted=$(printf %q "$folder")

options=$(printf ' %q' "$@")
[ $# -gt 0 ] || options=
# One after another in a list: `merge` refuses what is missing, so a shard that broke off is noticed.
parts=
for shard in $(seq "$shards"); do
    parts+=" $quoted/shard-$shard"
done

array=$(sbatch --parsable --exclusive --array="1-$shards" --output="$folder/shard-%a.log" \
    --wrap="$program bench --shard \$SLURM_ARRAY_TASK_ID/$shards --out $quoted/shard-\$SLURM_ARRAY_TASK_ID$options")
sbatch --dependency="afterany:$array" --output="$folder/merge.log" \
    --wrap="$program merge$parts --out $quoted/all"
