#include "buffer.h"

#include "le.h"

#include <stdlib.h>

#define ROOM_LEAST ((size_t)256)

void lum_bytes_free(lum_bytes *bytes)
{
    free(bytes->at);
    *bytes = (lum_bytes){0};
}

/* Grows by half, so that what is added in small parts is seldom moved. */
static bool make_room(lum_bytes *b, size_t n)
{
    if (b->failed || n > SIZE_MAX / 4u - b->len) {
        b->failed = true;
        return false;
    }
    if (n <= b->room - b->len) {
        return true;
    }
    const size_t more = b->room + b->room / 2u + ROOM_LEAST;
    const size_t room = b->len + n > more ? b->len + n : more;
    unsigned char *at = realloc(b->at, room);
    if (at == NULL) {
        b->failed = true;
        return false;
    }
    b->at = at;
    b->room = room;
    return true;
}

unsigned char *lum_bytes_extend(lum_bytes *bytes, size_t n)
{
    if (!make_room(bytes, n)) {
        return NULL;
    }
    unsigned char *at = bytes->at + bytes->len;
    bytes->len += n;
    return at;
}

void lum_bytes_put(lum_bytes *bytes, const void *from, size_t n)
{
    unsigned char *to = lum_bytes_extend(bytes, n);
    if (to != NULL && n > 0) {
        memcpy(to, from, n);
    }
}

void lum_bytes_put_u8(lum_bytes *bytes, uint8_t v)
{
    lum_bytes_put(bytes, &v, 1);
}

void lum_bytes_put_u16(lum_bytes *bytes, uint16_t v)
{
    unsigned char number[2];
    (void)lum_put_le16(number, v);
    lum_bytes_put(bytes, number, sizeof number);
}

void lum_bytes_put_u32(lum_bytes *bytes, uint32_t v)
{
    unsigned char number[4];
    (void)lum_put_le32(number, v);
    lum_bytes_put(bytes, number, sizeof number);
}

void lum_bytes_put_u64(lum_bytes *bytes, uint64_t v)
{
    unsigned char number[8];
    (void)lum_put_le64(number, v);
    lum_bytes_put(bytes, number, sizeof number);
}

void lum_bytes_put_text(lum_bytes *bytes, const char *text)
{
    const size_t n = strlen(text);
    lum_bytes_put_u32(bytes, (uint32_t)n);
    lum_bytes_put(bytes, text, n);
}

size_t lum_bytes_begin_u32(lum_bytes *bytes)
{
    lum_bytes_put_u32(bytes, 0);
    return bytes->failed ? 0 : bytes->len - 4u;
}

void lum_bytes_end_u32(lum_bytes *bytes, size_t at)
{
    if (!bytes->failed) {
        (void)lum_put_le32(bytes->at + at, (uint32_t)(bytes->len - at - 4u));
    }
}
