#!/usr/bin/env bash
# Slices many meshes as an array job of Slurm: task I does shard I of N.
#
#     job=$(sbatch --parsable --array=0-63 tools/cluster/slurm_array.sh 64 meshes -o 'masks/{stem}.nii.gz' --like scan.nii.gz --frame lps)
#     sbatch --dependency=afterany:"$job" --wrap 'lamella batch --merge masks'
#
# The first number is N; what follows it are words of lamella batch. The second line joins the results of all shards when the
# last has ended, and fails if one has not done its part.
#
# - N is not read from --array: to do two shards again, the same line with --array=3,17.
# - A task that is requeued, or was killed, goes on after the meshes that it had done.
# - Before its time is over a task ends its batch, and is requeued if any mesh was done or failed since it began.
# - Memory and processors are those that Slurm grants: --mem and --cpus-per-task, here or before the script's name.
# - Exit status: that of lamella batch, which is 5 if some meshes failed; results.I-of-N.jsonl says which.
#SBATCH --job-name=lamella
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=lamella-%A_%a.txt
#SBATCH --signal=B:USR1@120
#SBATCH --cpus-per-task=2
#SBATCH --mem=8G
set -uo pipefail

stop() {
    echo "slurm_array.sh: $1 (the head of the script shows its use)" >&2
    exit 2
}

# Three quarters of the memory for the batch: the rest is for files that the system keeps in memory.
grants() {
    local megabytes="${SLURM_MEM_PER_NODE:-0}" processors="${SLURM_CPUS_PER_TASK:-1}"
    if ((megabytes == 0 && ${SLURM_MEM_PER_CPU:-0} > 0)); then
        megabytes=$((SLURM_MEM_PER_CPU * processors))
    fi
    echo "--jobs=$processors"
    if ((megabytes > 0)); then
        echo "--memory=$((megabytes * 3 / 4))M"
    fi
}

# The folder of results, as lamella batch takes it from its words: --results, or what the first --output names before a {.
results_folder() {
    local word folder="" before=""
    for word in "$@"; do
        case "$word" in
            --results=*) echo "${word#*=}" && return ;;
            -o?*) folder="${folder:-${word#-o}}" ;;
            --output=*) folder="${folder:-${word#*=}}" ;;
        esac
        case "$before" in
            --results) echo "$word" && return ;;
            --output | -o) folder="${folder:-$word}" ;;
        esac
        before="$word"
    done
    dirname "${folder%%\{*}."
}

ended_meshes() { wc -l 2> /dev/null < "$results" || echo 0; }

shards="${1:-}"
[[ "$shards" =~ ^[1-9][0-9]*$ ]] || stop "'$shards' is no number of shards"
shift
shard="${SLURM_ARRAY_TASK_ID:-}"
[[ -n "$shard" ]] || stop "this is no task of an array job"
((shard < shards)) || stop "task $shard of $shards shards, which count from 0"
mapfile -t granted < <(grants)
results="$(results_folder "$@")/results.$shard-of-$shards.jsonl"
before=$(ended_meshes)

lamella batch "$@" "${granted[@]}" --shard="$shard/$shards" &
batch=$!
out_of_time=false
interrupted=true
trap 'interrupted=true; kill -TERM "$batch" 2> /dev/null' TERM INT
trap 'interrupted=true; out_of_time=true; kill -TERM "$batch" 2> /dev/null' USR1
# A signal ends `wait` at once, and the batch in its own time.
while "$interrupted"; do
    interrupted=false
    wait "$batch"
    status=$?
done
if "$out_of_time" && (($(ended_meshes) > before)); then
    scontrol requeue "$SLURM_JOB_ID"
fi
exit "$status"
