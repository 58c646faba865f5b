# Sourced after common.sh: static libraries for other platforms, made of their
# sources; and zig, from Python's package of it, as a compiler for these platforms.
# shellcheck shell=bash

# zig_folder: where Python's package of it is.
zig_folder() {
    build/venv/bin/python -c 'import os, ziglang; print(os.path.dirname(ziglang.__file__))'
}

# zig_tools DIR TARGET: zig for a target, as cc, ar and ranlib in DIR. They are written
# only if they change, because a build begins anew with another compiler.
zig_tools() {
    local dir=$1 target=$2 zig name arguments
    zig=$(zig_folder)/zig
    mkdir -p "$dir"
    for name in cc ar ranlib; do
        arguments=$name
        [ "$name" != cc ] || arguments="cc -target $target"
        printf '#!/bin/sh\nexec %s %s "$@"\n' "$zig" "$arguments" >"$dir/$name.new"
        chmod +x "$dir/$name.new"
        if cmp -s "$dir/$name.new" "$dir/$name"; then
            rm "$dir/$name.new"
        else
            mv "$dir/$name.new" "$dir/$name"
        fi
    done
}

# compile_static TOOLS ARCHIVE FLAG... -- FILE...: a static library by TOOLScc and
# TOOLSar.
compile_static() {
    local tools=$1 archive=$2
    local -a flags=()
    shift 2
    while [ "$1" != -- ]; do
        flags+=("$1")
        shift
    done
    shift
    rm -rf "$archive" "$archive.objects"
    mkdir -p "$archive.objects"
    # shellcheck disable=SC2016,SC2154 # the inner shell's; of common.sh
    printf '%s\0' "$@" |
        xargs -0 -P "$jobs" -I SOURCE sh -c 'source=$1 objects=$2; shift 2; exec "$@" -c "$source" -o "$objects/${source##*/}.o"' \
            compile SOURCE "$archive.objects" "${tools}cc" -O2 -w "${flags[@]}" || return 1
    "${tools}ar" rcs "$archive" "$archive.objects"/*.o || return 1
    rm -r "$archive.objects"
}

# describe_static ROOT NAME VERSION LIBRARY REQUIRED FLAGS: for pkg-config.
describe_static() {
    mkdir -p "$1/lib/pkgconfig"
    cat >"$1/lib/pkgconfig/$2.pc" <<END
Name: $2
Description: $2, static
Version: $3
Requires: $5
Cflags: -I$1/include $6
Libs: -L$1/lib -l$4
END
}

# write_pkg_config ROOT: a pkg-config that knows only what is in ROOT.
write_pkg_config() {
    printf '#!/bin/sh\nPKG_CONFIG_LIBDIR=%s/lib/pkgconfig exec pkg-config "$@"\n' "$1" >"$1/pkg-config.new"
    chmod +x "$1/pkg-config.new"
    mv "$1/pkg-config.new" "$1/pkg-config"
}

# build_yaml TOOLS SOURCE ROOT
build_yaml() {
    local version
    local -a part
    cp "$2/include/yaml.h" "$3/include/"
    version=$(sed -n 's/^set (YAML_VERSION_[A-Z]* \([0-9]*\))/\1/p' "$2/CMakeLists.txt" | paste -sd.)
    IFS=. read -ra part <<<"$version"
    compile_static "$1" "$3/lib/libyaml.a" -fPIC -fvisibility=hidden "-I$2/include" -DYAML_DECLARE_STATIC \
        "-DYAML_VERSION_STRING=\"$version\"" "-DYAML_VERSION_MAJOR=${part[0]}" \
        "-DYAML_VERSION_MINOR=${part[1]}" "-DYAML_VERSION_PATCH=${part[2]}" -- "$2"/src/*.c || return 1
    describe_static "$3" yaml-0.1 "$version" yaml '' -DYAML_DECLARE_STATIC
}

# build_zlib TOOLS SOURCE ROOT: what unpacks. Its header takes fdopen from macOS, unless
# that is a macro.
build_zlib() {
    cp "$2"/{zlib,zconf}.h "$3/include/"
    compile_static "$1" "$3/lib/libz.a" -fPIC -fvisibility=hidden -Dfdopen=fdopen -- "$2"/{adler32,crc32,inffast,inflate,inftrees,zutil}.c || return 1
    describe_static "$3" zlib "$(sed -n 's/^#define ZLIB_VERSION "\(.*\)"/\1/p' "$2/zlib.h")" z '' ''
}

# build_zstd TOOLS SOURCE ROOT: what unpacks.
build_zstd() {
    local version
    compile_static "$1" "$3/lib/libzstd.a" -fPIC -fvisibility=hidden -DZSTD_DISABLE_ASM -DZSTD_LEGACY_SUPPORT=0 \
        -DZSTDLIB_VISIBLE= -DZSTDERRORLIB_VISIBLE= -- "$2"/lib/common/*.c "$2"/lib/decompress/*.c || return 1
    cp "$2"/lib/zstd.h "$2"/lib/zstd_errors.h "$3/include/" || return 1
    version=$(sed -n 's/^#define ZSTD_VERSION_[A-Z]* *\([0-9]*\)$/\1/p' "$2/lib/zstd.h" | paste -sd.)
    describe_static "$3" libzstd "$version" zstd '' ''
}
