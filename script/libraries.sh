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

# compile_static COMPILER AR ARCHIVE FLAG... -- FILE...: a static library. Each function has a
# section, so that a linker can leave out what nobody calls.
compile_static() {
    local compiler=$1 ar=$2 archive=$3
    local -a flags=()
    shift 3
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
            compile SOURCE "$archive.objects" "$compiler" -O2 -w -ffunction-sections -fdata-sections "${flags[@]}" || return 1
    "$ar" rcs "$archive" "$archive.objects"/*.o || return 1
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

# build_yaml COMPILER AR SOURCE ROOT
build_yaml() {
    local version
    local -a part
    cp "$3/include/yaml.h" "$4/include/"
    version=$(sed -n 's/^set (YAML_VERSION_[A-Z]* \([0-9]*\))/\1/p' "$3/CMakeLists.txt" | paste -sd.)
    IFS=. read -ra part <<<"$version"
    compile_static "$1" "$2" "$4/lib/libyaml.a" -fPIC -fvisibility=hidden "-I$3/include" -DYAML_DECLARE_STATIC \
        "-DYAML_VERSION_STRING=\"$version\"" "-DYAML_VERSION_MAJOR=${part[0]}" \
        "-DYAML_VERSION_MINOR=${part[1]}" "-DYAML_VERSION_PATCH=${part[2]}" -- "$3"/src/*.c || return 1
    describe_static "$4" yaml-0.1 "$version" yaml '' -DYAML_DECLARE_STATIC
}

# build_zlib COMPILER AR SOURCE ROOT: what unpacks. Its header takes fdopen from macOS, unless
# that is a macro.
build_zlib() {
    cp "$3"/{zlib,zconf}.h "$4/include/"
    compile_static "$1" "$2" "$4/lib/libz.a" -fPIC -fvisibility=hidden -Dfdopen=fdopen -- "$3"/{adler32,crc32,inffast,inflate,inftrees,zutil}.c || return 1
    describe_static "$4" zlib "$(sed -n 's/^#define ZLIB_VERSION "\(.*\)"/\1/p' "$3/zlib.h")" z '' ''
}

# build_zstd COMPILER AR SOURCE ROOT: what unpacks.
build_zstd() {
    local version
    compile_static "$1" "$2" "$4/lib/libzstd.a" -fPIC -fvisibility=hidden -DZSTD_DISABLE_ASM -DZSTD_LEGACY_SUPPORT=0 \
        -DZSTDLIB_VISIBLE= -DZSTDERRORLIB_VISIBLE= -- "$3"/lib/common/*.c "$3"/lib/decompress/*.c || return 1
    cp "$3"/lib/zstd.h "$3"/lib/zstd_errors.h "$4/include/" || return 1
    version=$(sed -n 's/^#define ZSTD_VERSION_[A-Z]* *\([0-9]*\)$/\1/p' "$3/lib/zstd.h" | paste -sd.)
    describe_static "$4" libzstd "$version" zstd '' ''
}
