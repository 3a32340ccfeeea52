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
#SBATCH --signal=B:INT@120     # to this script, which becomes plant-bench: Ctrl-C two minutes before the time is up: finished episodes stay
#SBATCH --requeue

set -euo pipefail

# Shards count from 1; an array may count from anything (--array=0-7 too).
first=${SLURM_ARRAY_TASK_MIN:-1}
shard=$((SLURM_ARRAY_TASK_ID - first + 1))/${SLURM_ARRAY_TASK_COUNT:-1}

# Activate the environment here, for instance: source /shared/venvs/plant-bench/bin/activate
exec plant-bench score --shard "$shard" --workers "${SLURM_CPUS_PER_TASK:-1}" "$@"
