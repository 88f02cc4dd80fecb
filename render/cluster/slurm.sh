#!/bin/sh
# A command of taut in parts, as an array of Slurm, and their merge, as a job that follows it:
#   slurm.sh 100 render scenes/nunchaku.toml
# The nodes share the folder that it is started in. A part that a signal ends is queued again; given
# again, the whole does what parts had left to do. Options of sbatch have variables: SBATCH_PARTITION,
# SBATCH_TIMELIMIT. TAUT is the program where that is not taut.
taut=${TAUT:-taut}

if [ -z "$SLURM_JOB_ID" ]; then
  count=$1
  usage="usage: $0 COUNT COMMAND..., as in: $0 100 render SCENE"
  case $count in
    --help) echo "$usage"; exit ;;
    '' | *[!0-9]* | 0*) echo "$usage" >&2; exit 2 ;;
  esac
  shift
  if ! command -v sbatch >/dev/null; then
    echo "$0: there is no sbatch: install Slurm (Debian: slurm-wlm)" >&2
    exit 127
  fi
  mkdir -p out/slurm || exit 6
  array=$(sbatch --parsable --requeue --open-mode=append --array="1-$count" --job-name=taut \
    --output=out/slurm/%A.%a.log "$0" "$@") || exit
  merge=$(sbatch --parsable --dependency="afterany:${array%%;*}" --job-name=taut-merge \
    --output=out/slurm/%j.merge.log "$0" "$@") || exit
  echo "parts: job ${array%%;*}, merge: job ${merge%%;*}, logs: out/slurm"
  exit
fi

if [ -z "$SLURM_ARRAY_TASK_ID" ]; then
  exec "$taut" "$@" --merge --quiet
fi
"$taut" "$@" --part "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" --quiet \
  --threads "${SLURM_CPUS_PER_TASK:-1}"
code=$?
if [ "$code" -gt 128 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt 5 ]; then
  echo "ended by a signal ($code), queued again"
  scontrol requeue "${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID"
fi
exit "$code"
