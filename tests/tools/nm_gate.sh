#!/usr/bin/env bash
# nm_gate.sh [--division] NM ARCHIVE [BELOW...]: the archive may need nothing but
# memcpy, memset, memcmp, what the archives below it define, and of the
# compiler's own library shifts, comparisons and products of 64 bits; with
# --division, quotients of 64 bits too. Where a target has no unit for floating
# point and no instruction to divide, as Cortex-M0+, all of either are calls, so
# that an archive for it that passes has none.
set -euo pipefail

helpers='__aeabi_(lmul|llsl|llsr|lasr|lcmp|ulcmp)|__gnu_thumb1_case_[a-z]+|__(mul|ashl|ashr|lshr|cmp|ucmp)di[23]'
if [ "${1:-}" = --division ]; then
    helpers+='|__aeabi_u?ldivmod|__u?(div|mod|divmod)di[34]'
    shift
fi
nm=$1
archive=$2

# Position-independent code of 32 bits names the table of its addresses.
allowed="memcpy|memset|memcmp|$helpers|_GLOBAL_OFFSET_TABLE_"
listing=$("$nm" "$archive")
defined=$("$nm" "${@:2}" | awk 'NF == 3 && $2 ~ /[A-TV-Z]/ { print $3 }' | sort -u)
needed=$(awk 'NF == 2 && $1 ~ /[Uvw]/ { print $2 }' <<<"$listing" | sort -u)
if [ -z "$defined" ]; then
    printf '%s defines nothing\n' "$archive" >&2
    exit 1
fi
foreign=$(comm -23 <(printf '%s\n' "$needed") <(printf '%s\n' "$defined") | grep -vxE "$allowed" || true)
if [ -n "$foreign" ]; then
    printf '%s needs what a freestanding library may not:\n%s\n' "$archive" "$foreign" >&2
    exit 1
fi
