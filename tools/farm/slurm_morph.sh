#!/usr/bin/env bash
# Makes the frames of a morph on a Slurm cluster whose machines share this folder: one task plans, an array of tasks makes
# the frames, a last one makes what is left and writes the report and the contact sheet. A task that is killed is queued
# again and goes on where it was.
#
# Usage: tools/farm/slurm_morph.sh [--tasks N] [--report FILE.json] [--sheet FILE.png] [--sbatch OPTION]... \
#          -- INPUT INPUT -o name.####.vdb [options of `slicemorph morph`]
# --tasks: of the array, 4 unless given. --sbatch: an option for all tasks, such as --sbatch=--partition=day; may be given
# again. The program is `slicemorph`, or what SLICEMORPH names. Prints the number of the last task's job.
set -euo pipefail

program=${SLICEMORPH:-slicemorph} tasks=4 report= sheet= options=() sbatch_options=()
fail() { echo "slurm_morph.sh: $*" >&2; exit 2; }
value() { [ $# -ge 2 ] || fail "$1 needs a value"; }

while [ $# -gt 0 ] && [ "$1" != -- ]; do
  case $1 in
    --tasks) value "$@"; tasks=$2; shift 2 ;;
    --report) value "$@"; report=$2; shift 2 ;;
    --sheet) value "$@"; sheet=$2; shift 2 ;;
    --sbatch) value "$@"; sbatch_options+=("$2"); shift 2 ;;
    --sbatch=*) sbatch_options+=("${1#--sbatch=}"); shift ;;
    *) fail "$1: not known; options of morph come behind --" ;;
  esac
done
[ $# -gt 1 ] || fail "behind -- inputs, -o name.####.vdb and options of morph are expected"
shift
[[ $tasks =~ ^[1-9][0-9]*$ ]] || fail "--tasks $tasks: expected a number from 1"
[ -z "$report" ] || [[ $report == *.json ]] || fail "--report $report: expected a name.json"
program=$(command -v "$program") || fail "$program is not there; SLICEMORPH names the program"

output= frames=24 start=1 moving=
while [ $# -gt 0 ]; do
  case $1 in
    -o | --output) value "$@"; output=$2; shift 2; continue ;;
    --frames) value "$@"; frames=$2 ;;
    --start) value "$@"; start=$2 ;;
    --at) value "$@"; commas=${2//[^,]/}; frames=$((${#commas} + 1)) ;;
    --range | --report | --resume | --plan | --weights) fail "$1 is not for the farm: it is set here, or makes one frame" ;;
    *.\#*) moving=1 ;;
  esac
  options+=("$1"); shift
done
[[ $output == *\#* ]] || fail "-o ${output:-is missing}: expected name.####.vdb, with #### for the frame's number"
[[ $frames =~ ^[1-9][0-9]*$ ]] || fail "--frames $frames: expected a number from 1"
[ -z "$moving" ] || [[ " ${options[*]} " == *" --frames "* ]] || fail "inputs that are sequences need --frames"

# Hidden, beside the output: plans, logs and the reports of parts.
hidden=$(dirname "$output")/.$(basename "$output" | tr -d '#').farm
mkdir -p "$hidden"
plan=$hidden/morph${moving:+.####}.plan
quoted() { printf '%q ' "$@"; }
morph=$(quoted "$program" morph --plan "$plan" "${options[@]}" -o "$output" --resume --quiet)
part_report=
[ -z "$report" ] || part_report="--report $(quoted "$hidden")/part.\$SLURM_ARRAY_TASK_ID.json"

submit() { sbatch --parsable --requeue --kill-on-invalid-dep=yes --output "$hidden/%x.%A_%a.log" ${sbatch_options[@]+"${sbatch_options[@]}"} "$@"; }
# What ends by a signal is queued again, three times at most; sbatch itself does so when a machine is lost.
again='code=$?
if [ $code -gt 128 ] && [ "${SLURM_RESTART_COUNT:-0}" -lt 3 ]; then scontrol requeue "$SLURM_JOB_ID" && sleep 600; fi
exit $code'

planned=$(submit --job-name plan --wrap "$(quoted "$program" plan "${options[@]}" -o "$plan" --quiet)
$again")
last=$planned
# The last frame is left to the last task, which so finds the log of all others and merges their figures.
if [ "$frames" -gt 1 ]; then
  [ "$tasks" -le $((frames - 1)) ] || tasks=$((frames - 1))
  last=$(submit --job-name frames --dependency "afterok:$planned" --array "1-$tasks" --wrap "
first=\$(($start + ($frames - 1) * (SLURM_ARRAY_TASK_ID - 1) / $tasks))
end=\$(($start + ($frames - 1) * SLURM_ARRAY_TASK_ID / $tasks - 1))
$morph --range \$first-\$end $part_report
$again")
fi
finish="$morph ${report:+--report $(quoted "$report")} || exit \$?"
[ -z "$sheet" ] || finish+="
$(quoted "$program" render "$output" -o "$hidden/picture.####.png" --contact-sheet "$sheet" --size 256x256 --quiet) || exit \$?"
submit --job-name finish --dependency "afterany:$last" --wrap "$finish
rm -rf $(quoted "$hidden")"
