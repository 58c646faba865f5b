#!/usr/bin/env bash
# thresholds.sh [FOLDER [PLAN]]: records the steps of a plan with the laser on, then makes a cloud of each. Run again, it
# does only what is missing. LUM_HOST: the sensor; ALARM: the command that a hazard runs.
set -euo pipefail
folder=${1:-thresholds}
plan=${2:-$(dirname "$0")/../../calib/sweep.yaml}
trap 'if [ $? -eq 4 ]; then ${ALARM:-echo} "hazard: $folder is not done" >&2 || :; exit 4; fi' EXIT

lumctl wait clear --for 60
# If this shell is killed, lumctl gets a signal, and switches the laser off.
setpriv --pdeathsig TERM lumctl sweep -o "$folder" --laser --continue -- "$plan"

for recording in "$folder"/step-*.pcapng; do
    cloud=${recording%.pcapng}.ply
    if [ -e "$recording" ] && [ ! "$cloud" -nt "$recording" ]; then
        lumdump -q -o "$cloud" -- "$recording"
    fi
done
