#!/usr/bin/env bash
# An array job of four shards on a real Slurm, of which one is requeued while it slices, and a task that meets its time limit: the
# files are those of one machine.
source "$(dirname "${BASH_SOURCE[0]}")/support.sh"
source "$root/tests/cluster/slurm_engine.sh"

# ended_after_requeue JOB: whether it has run before, and has ended now.
ended_after_requeue() {
    [[ "$(scontrol show job "$1")" == *JobState=@(COMPLETED|FAILED)*Restarts=[1-9]* ]]
}

step "Slurm"
start_slurm
script="$root/tools/cluster/slurm_array.sh"
job=$(sbatch --parsable --array=0-3 --cpus-per-task=1 --mem=800 "$script" 4 meshes "${batch_options[@]}")
merge=$(sbatch --parsable --dependency="afterany:$job" --output=merge.txt --wrap 'lamella batch --merge masks')
wait_for 120 "the first mask" files_in masks 1

step "a task is requeued while it slices"
lost=""
find_lost() {
    local task
    for task in 0 1 2 3; do
        if [[ "$(state_of "${job}_$task")" == RUNNING ]]; then
            lost="${job}_$task"
            return 0
        fi
    done
    return 1
}
wait_for 60 "a running task" find_lost
scontrol requeue "$lost"
start_again "$lost"
wait_for 300 "the end of $lost" ended_after_requeue "$lost"
grep -q "DUE TO JOB REQUEUE" "lamella-$lost.txt" || fail "$lost was requeued too late"
wait_for 300 "the end of the merge" eval '[[ "$(state_of "$merge")" == FAILED ]]'
grep -q "^failed .*damaged.stl" merge.txt || fail "the merge does not name the damaged mesh"
rm masks/results.*-of-4.jsonl
same one_machine masks

rm -r masks
step "a task meets its time limit, twice"
lamella make sphere --triangles 1000 --height 150 -o slow.stl > /dev/null
echo '{"path":"slow.stl","spacing":[0.1,0.1,0.1],"subslices":100}' > slow.jsonl
# Slurm looks every half minute, and sends the signal half a minute early: at least 25 s after the start, when the first mesh is done.
job=$(sbatch --parsable --array=0 --cpus-per-task=1 --mem=800 --time=1 --signal=B:USR1@5 "$script" 1 meshes/m0.stl slow.jsonl \
    --output='limit/{stem}.nii.gz' --spacing=0.5,0.5,0.1 --frame=lps)
wait_for 30 "the first mask" files_in limit 1
start_again "${job}_0" 120
wait_for 120 "the end of the task" ended_after_requeue "${job}_0"
[[ "$(scontrol show job "${job}_0")" == *Restarts=1[[:space:]]* ]] || fail "a task that gets nowhere is requeued"
[[ "$(wc -l < limit/results.0-of-1.jsonl)" == 1 ]] || fail "not one mesh is done"
cmp limit/m0.nii.gz one_machine/m0.nii.gz || fail "the first mask"
find limit -name '.*.part' | grep . && fail "a file aside is left by the time limit"

step "words that are wrong"
for words in "" "4x meshes" "1 meshes"; do
    # shellcheck disable=SC2086
    job=$(sbatch --parsable --array=1 --output=wrong.txt --mem=800 --cpus-per-task=1 "$script" $words)
    wait_for 60 "a refusal" eval '[[ "$(state_of "$job")" == FAILED ]]'
done
[[ "$(grep -c "slurm_array.sh: .*(the head of the script" wrong.txt)" == 3 ]] || fail "wrong words are not refused"
stop_slurm
