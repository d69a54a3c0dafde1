# Slurm jobs of a study: in each round an array computes the parts, and a dependent job merges them.
#
#     sh THIS_FILE [OPTIONS OF SBATCH]     for example --partition=short --account=group
#
# Run it again after a failure: the jobs go on from the finished blocks.
set -eu

if [ -e "$run/COMPLETE" ]; then
    # Refuses the run of another study.
    exec "$asperity" run "$study" --out "$run" --resume
fi
case "${1-}" in
part)
    exec "$asperity" run "$study" --shard "$SLURM_ARRAY_TASK_ID/$parts" \
        --out "$run-part-$SLURM_ARRAY_TASK_ID-of-$parts" --threads "$SLURM_CPUS_PER_TASK"
    ;;
merge | finish)
    job=$1
    set --
    part=1
    while [ "$part" -le "$parts" ]; do
        set -- "$@" "$run-part-$part-of-$parts"
        part=$((part + 1))
    done
    set -- "$asperity" merge "$@" --out "$run" --threads "$SLURM_CPUS_PER_TASK"
    [ "$job" = merge ] || exec "$@" --finish
    # Exit code 3: blocks of later rounds are missing.
    "$@" || [ $? -eq 3 ]
    ;;
*)
    merge=
    round=1
    name=$(basename "$run")
    while [ "$round" -le "$rounds" ]; do
        job=merge
        [ "$round" -lt "$rounds" ] || job=finish
        array=$(sbatch --parsable --job-name="$name-parts" "$@" --kill-on-invalid-dep=yes ${merge:+"--dependency=afterok:$merge"} \
            --array="1-$parts" "$0" part)
        # Slurm prints JOB, or JOB;CLUSTER.
        array=${array%%;*}
        merge=$(sbatch --parsable --job-name="$name-$job" "$@" --kill-on-invalid-dep=yes "--dependency=afterok:$array" "$0" "$job")
        merge=${merge%%;*}
        echo "submitted array $array and merge $merge" >&2
        round=$((round + 1))
    done
    ;;
esac
