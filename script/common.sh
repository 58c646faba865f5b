# Sourced by the other scripts: the repository's top as working directory, and
# what several of them need.
# shellcheck shell=bash

cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit
jobs=$(nproc 2>/dev/null || echo 2)

die() {
    printf '%s: %s\n' "${0##*/}" "$*" >&2
    exit 2
}

# configure PRESET [ARGUMENT...]: with Ninja, quietly unless it fails.
configure() {
    local preset=$1 log
    shift
    mkdir -p build/log
    log=build/log/configure-$preset.log
    if ! cmake --preset "$preset" -G Ninja "$@" >"$log" 2>&1; then
        cat "$log" >&2
        return 1
    fi
}

# build PRESET [ARGUMENT...]: configure, then build quietly.
build() {
    configure "$@" && quietly cmake --build "build/$1" -j "$jobs"
}

# quietly COMMAND...: its output only if it fails.
quietly() {
    local output
    if ! output=$("$@" 2>&1 </dev/null); then
        printf '%s\n' "$output" >&2
        return 1
    fi
}
