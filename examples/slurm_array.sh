#!/usr/bin/env bash
# A run as an array job: each task drives one shard of the episodes into one shared folder.
#
#   sbatch --array=1-8 examples/slurm_array.sh --agent plant --out /shared/runs/plant
#
# All options of `plant-bench score` may follow; --out must lie on a disk that all nodes see.
# Tasks that were stopped or lost: the same command again drives only what is missing.
# Whoever ends last writes the summary. If a task was lost, or a slow disk let none of them see
# that all was there, this writes it without driving anything:
#
#   plant-bench score --agent plant --out /shared/runs/plant
#
#SBATCH --job-name=plant-bench
#SBATCH --array=1-8
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=4      # that many episodes at a time, one thread each
#SBATCH --mem-per-cpu=1G       # docs/notes/scaling.md: what a worker takes
#SBATCH --time=04:00:00
#SBATCH --signal=B:INT@120     # Ctrl-C two minutes before the end; finished episodes are kept
#SBATCH --requeue

set -euo pipefail

# Shards count from 1; the numbers of an array may start anywhere and have a step.
id=${SLURM_ARRAY_TASK_ID:-1}
first=${SLURM_ARRAY_TASK_MIN:-1}
step=${SLURM_ARRAY_TASK_STEP:-1}
count=${SLURM_ARRAY_TASK_COUNT:-1}
last=${SLURM_ARRAY_TASK_MAX:-$((first + step * (count - 1)))}
if ((step < 1 || last != first + step * (count - 1))); then
    echo "slurm_array.sh: expected one range such as --array=1-8 or --array=1-15:2, got $count" \
        "tasks from $first to $last with step $step." >&2
    exit 2
fi
shard=$(((id - first) / step + 1))/$count

# Activate the environment here, for instance: source /shared/venvs/plant-bench/bin/activate
exec plant-bench score --shard "$shard" --workers "${SLURM_CPUS_PER_TASK:-1}" "$@"
