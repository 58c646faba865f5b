#include "joined.h"

#include "lum/wire.h"

#include <string.h>

#define MAGIC_BYTES 8u

static bool has_magic(const uint8_t *p, size_t len, const uint8_t *magic)
{
    return len >= MAGIC_BYTES && memcmp(p, magic, MAGIC_BYTES) == 0;
}

/* Where the magic comes first from there on; len: nowhere. */
static size_t find_magic(const uint8_t *payload, size_t from, size_t len,
                         const uint8_t *magic)
{
    const uint8_t *const end = payload + len;
    const uint8_t *p = payload + from;
    while ((p = memchr(p, magic[0], (size_t)(end - p))) != NULL) {
        if (has_magic(p, (size_t)(end - p), magic)) {
            return (size_t)(p - payload);
        }
        p++;
    }
    return len;
}

/* Bytes of each datagram of a payload, or len: it is one. */
static size_t find_each(const uint8_t *payload, size_t len)
{
    uint8_t magic[LUM_HEADER_BYTES];
    lum_header_encode(magic, 0);
    /* the last of several begins in the second half, which most lack */
    if (!has_magic(payload, len, magic) ||
        find_magic(payload, len / 2u, len, magic) == len) {
        return len;
    }
    const size_t each = find_magic(payload, MAGIC_BYTES, len, magic);
    for (size_t at = each; at < len; at += each) {
        if (!has_magic(payload + at, len - at, magic)) {
            return len;
        }
    }
    return each >= LUM_HEADER_BYTES ? each : len;
}

/* At least 1, so that an empty record is given once too. */
static size_t begin(const lum_record *record)
{
    const size_t each = record->kind == LUM_RECORD_DATAGRAM
                            ? find_each(record->payload, record->len)
                            : record->len;
    return each != 0 ? each : 1u;
}

bool lum_joined_next(lum_joined *joined, const lum_record *record,
                     lum_record *out)
{
    if (joined->each == 0) {
        *joined = (lum_joined){.each = begin(record)};
    } else if (joined->at >= record->len) {
        *joined = (lum_joined){.each = 0};
        return false;
    }
    const size_t rest = record->len - joined->at;
    *out = *record;
    if (joined->each < record->len) {
        out->kind = LUM_RECORD_JOINED;
        out->payload += joined->at;
        out->len = rest < joined->each ? rest : joined->each;
        out->dropped_fragments =
            joined->at == 0 ? record->dropped_fragments : 0;
    }
    joined->at += joined->each;
    return true;
}
