#!/usr/bin/env bash
# nm_gate.sh NM ARCHIVE [BELOW...]: the archive may need nothing but memcpy,
# memmove, memset, memcmp, helpers of the compiler's own library, and what the
# archives below it define.
set -euo pipefail

nm=$1
archive=$2
helpers='__aeabi_[a-z0-9_]+|__(u|)(div|mod|divmod|mul|ashl|ashr|lshr|cmp|neg|clz|ctz|popcount|bswap)[sdt]i[0-9]?|_GLOBAL_OFFSET_TABLE_'

listing=$("$nm" "$archive")
defined=$("$nm" "${@:2}" | awk 'NF == 3 && $2 ~ /[A-TV-Z]/ { print $3 }' | sort -u)
needed=$(awk 'NF == 2 && $1 ~ /[Uvw]/ { print $2 }' <<<"$listing" | sort -u)
if [ -z "$defined" ]; then
    printf '%s defines nothing\n' "$archive" >&2
    exit 1
fi
foreign=$(comm -23 <(printf '%s\n' "$needed") <(printf '%s\n' "$defined") |
    grep -vxE "mem(cpy|move|set|cmp)|$helpers" || true)
if [ -n "$foreign" ]; then
    printf '%s needs more than mem* and compiler helpers:\n%s\n' "$archive" "$foreign" >&2
    exit 1
fi
