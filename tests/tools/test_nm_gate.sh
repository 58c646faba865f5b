#!/usr/bin/env bash
# test_nm_gate.sh: what nm_gate.sh lets pass and what it does not, of listings as
# nm writes them.
set -euo pipefail

gate=$(dirname "$0")/nm_gate.sh
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
status=0

# expect PASS|FAIL SYMBOL [--division]: of a library that needs the symbol.
expect() {
    local is=FAIL
    printf '00000000 T lum_a\n         U %s\n' "$2" >"$work/listing"
    if "$gate" "${@:3}" cat "$work/listing" 2>"$work/said"; then
        is=PASS
    elif ! grep -qx "$2" "$work/said"; then
        is='a failure that does not name it'
    fi
    if [ "$is" != "$1" ]; then
        printf '%s: %s, and %s is right\n' "${*:2}" "$is" "$1"
        status=1
    fi
}

for symbol in lum_a memcpy memset memcmp __aeabi_lmul __aeabi_llsl __aeabi_ulcmp __gnu_thumb1_case_uqi __muldi3 __cmpdi2; do
    expect PASS "$symbol"
done
for symbol in memmove malloc __aeabi_fmul __aeabi_dadd __aeabi_i2f __aeabi_uidiv __aeabi_idivmod __mulsf3 __adddf3 \
    __udivsi3 __stack_chk_fail sin; do
    expect FAIL "$symbol"
    expect FAIL "$symbol" --division
done
for symbol in __aeabi_ldivmod __aeabi_uldivmod __divdi3 __umoddi3 __udivmoddi4; do
    expect FAIL "$symbol"
    expect PASS "$symbol" --division
done

printf '' >"$work/listing"
if "$gate" cat "$work/listing" 2>/dev/null; then
    printf 'a library of nothing passes\n'
    status=1
fi
[ "$status" -ne 0 ] || printf 'nm_gate.sh refuses what it should\n'
exit "$status"
