# Sourced by steps that run pytest.
# shellcheck shell=bash

more_follows=false

# run_pytest LOG PYTHON ARGUMENT...: its output, what was left out, and our last line.
run_pytest() {
    local log=$1 python=$2 status=0
    shift 2
    mkdir -p "${log%/*}"
    : >"$log.begun"
    "$python" -B -m pytest -q -rs --durations=12 -p no:cacheprovider "$@" >"$log" 2>&1 || status=$?
    cat "$log"
    grep -qE '(passed|failed|skipped|errors?|no tests ran)\b.* in [0-9]' "$log" || tell_last_words "$log.begun"
    tell_pytest "$log"
    return "$status"
}

# use_lowest_ray: of the extras, Ray in the lowest version that pyproject.toml allows.
use_lowest_ray() {
    [ -e build/ray-lowest/installed.txt ] || {
        printf 'the lowest Ray that the package allows is not installed: script/setup --all\n'
        exit 77
    }
    export PYTHONPATH=$PWD/build/ray-lowest
    printf 'Ray %s\n' "$(cat build/ray-lowest/installed.txt)"
}

# tell_last_words BEGUN: who uses Ray is ended by it without a word. Its logs that are older than that file are of others.
tell_last_words() {
    local log
    printf '\npytest ended before its end\n'
    for log in "${TMPDIR:-/tmp}"/*/ray/session_latest/logs/{raylet,gcs_server,runtime_env_agent}*; do
        [ ! "$log" -nt "$1" ] || { printf -- '--- %s\n' "${log##*/}" && tail -n 12 "$log"; }
    done
}

tell_pytest() {
    local passed failed left=0
    passed=$(sed -nE 's/.*\b([0-9]+) passed.*/\1/p' "$1")
    failed=$(sed -nE 's/.*\b([0-9]+) (failed|errors?)\b.*/\1/p' "$1")
    if ! $more_follows; then
        sed -n 's/^SKIPPED \[[0-9]*\] /not run: /p' "$1"
        left=$(sed -nE 's/.*\b([0-9]+) skipped.*/\1/p' "$1")
    fi
    printf '%d passed, %d failed, %d skipped\n' "${passed:-0}" "${failed:-0}" "${left:-0}"
}
