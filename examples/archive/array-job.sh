#!/usr/bin/env bash
# Diagnoses an archive of recordings on a cluster, each task of an array its share of the files:
#
#     sbatch --array=0-19 array-job.sh recordings        # a folder beside, by a relative path
#     head -n 1 shares/results-0.csv > results.csv
#     tail -q -n +2 shares/results-*.csv | LC_ALL=C sort >> results.csv
#
# The lines are those of `mgpi batch recordings -o results.csv`. A task that was ended goes on where it was when it is
# submitted again; one that is done does nothing. Other engines than SLURM set other variables for the two below.
#SBATCH --cpus-per-task=4
#SBATCH --time=02:00:00
set -euo pipefail

folder=${1%/}
task=${SLURM_ARRAY_TASK_ID:?the number of the task, from 0}
tasks=${SLURM_ARRAY_TASK_COUNT:?how many tasks there are}

# The task's files by links, under the names that they have in the archive.
share=shares/$task
mkdir -p "$share/$folder"
find "$folder" -type f \( -name '*.csv' -o -name '*.tsv' -o -name '*.txt' \) | LC_ALL=C sort |
  awk -v task="$task" -v tasks="$tasks" '(NR - 1) % tasks == task' |
  while read -r file; do
    mkdir -p "$share/$(dirname "$file")"
    ln -sf "$(realpath "$file")" "$share/$file"
  done

results=../results-$task.csv
cd "$share"
if [ ! -e "$results" ] && [ -n "$(find "$folder" -type l)" ]; then
  mgpi batch "$folder" -o "$results"
fi
