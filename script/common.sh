# Sourced by the other scripts: sets the repository's top as working directory,
# and has functions that several of them need.
# shellcheck shell=bash

cd "$(dirname "${BASH_SOURCE[0]}")/.." || exit
jobs=$(nproc 2>/dev/null || echo 2)

die() {
    printf '%s: %s\n' "${0##*/}" "$*" >&2
    exit 2
}

# What a compiler made once is taken from ccache, where that is installed: also in another clone, because paths below the
# top count as relative, and after another compiler of the same name, because its content counts. It takes the headers
# that the compiler lists: running the preprocessor first made the build of the fuzzers a quarter longer. Only the builds of
# our scripts use it.
if command -v ccache >/dev/null; then
    export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=true CCACHE_COMPILERCHECK=content CCACHE_DEPEND=true
fi

# quick_builds PRESET: what makes CMake build faster: the cache, and mold or lld for the sanitizers, whose programs are
# large. The release build is linked as a user's own.
quick_builds() {
    local linker found=
    [ "$1" != macos ] || return 0 # zig has a cache and a linker of its own
    if command -v ccache >/dev/null; then
        printf '%s\n' -DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache
    fi
    case $1 in
    asan | tsan | fuzz)
        for linker in mold ld.lld; do
            [ -n "$found" ] || ! command -v "$linker" >/dev/null || found=${linker#ld.}
        done
        printf '%s\n' "-DLUM_LINKER=$found" # also none, where an earlier run found one that is gone
        ;;
    esac
}

# configure PRESET [ARGUMENT...]: with Ninja, quietly unless it fails. LUM_CONFIGURED names those where this was done, and
# where others may be building.
configure() {
    local preset=$1 log
    local -a quick
    shift
    [[ " ${LUM_CONFIGURED:-} " != *" $preset "* ]] || [ ! -f "build/$preset/build.ninja" ] || return 0
    mkdir -p build/log
    log=build/log/configure-$preset.log
    mapfile -t quick < <(quick_builds "$preset")
    if ! cmake --preset "$preset" -G Ninja "${quick[@]}" "$@" >"$log" 2>&1; then
        cat "$log" >&2
        return 1
    fi
}

# build PRESET [ARGUMENT...]: configure, then build quietly.
build() {
    configure "$@" && quietly cmake --build "build/$1" -j "$jobs" -- --quiet
}

# is_built DIR PART: whether the build has it, by CMake's record.
is_built() {
    grep -qxF "$2: yes" "$1/summary.txt"
}

# left_out DIR: the parts that the build could not have, a line each: PART: WHY.
left_out() {
    sed -n 's/: NO, /: /p' "$1/summary.txt"
}

# why_left_out DIR PART: also if it was switched off.
why_left_out() {
    sed -n "s/^$2: [Nn][Oo], //p" "$1/summary.txt"
}

# tell_left_out DIR: as a step of script/test.
tell_left_out() {
    local lines
    lines=$(left_out "$1")
    if [ -z "$lines" ]; then
        printf '1 passed, 0 failed\n'
    else
        printf '%s\n' "$lines" | sed 's/^/not run: /'
        printf '0 passed, 0 failed, %d skipped\n' "$(wc -l <<<"$lines")"
    fi
}

# quietly COMMAND...: its output only if it fails.
quietly() {
    local output
    if ! output=$("$@" 2>&1 </dev/null); then
        printf '%s\n' "$output" >&2
        return 1
    fi
}

# each SELF ARGUMENT... <ITEMS: runs SELF ARGUMENT... ITEM for every line, as
# many at a time as there are processors. SELF prints ok or FAIL first; the last
# line counts. One that ends with an error but prints nothing is a failure too.
each() {
    local output good bad status=0
    output=$(xargs -r -P "$jobs" -n 1 "$@" 2>&1 </dev/stdin) || status=$?
    good=$(grep -c '^ok ' <<<"$output" || true)
    bad=$(grep -c '^FAIL ' <<<"$output" || true)
    if [ "$bad" -eq 0 ] && [ "$status" -ne 0 ]; then
        bad=1
    fi
    printf '%s\n%d passed, %d failed\n' "$output" "$good" "$bad"
    [ "$bad" -eq 0 ] && [ "$good" -gt 0 ]
}

# report NAME COMMAND...: the output that `each` expects for one item.
report() {
    local name=$1 output
    shift
    if output=$("$@" 2>&1 </dev/null); then
        printf 'ok    %s\n' "$name"
    else
        printf 'FAIL  %s\n%s\n' "$name" "$output"
        return 1
    fi
}

# modestly COMMAND...: in place of this script. Chromium puts what it draws in software before everything else on the machine,
# where it may.
modestly() {
    if [ "$(id -u)" -eq 0 ]; then
        exec setpriv --bounding-set -sys_nice "$@"
    fi
    exec "$@"
}

# need PROGRAM PACKAGE: if it is missing, the script says so and exits with 77.
need() {
    command -v "$1" >/dev/null || {
        printf '%s needs %s (Debian: %s)\n' "${0##*/}" "$1" "$2"
        exit 77
    }
}
