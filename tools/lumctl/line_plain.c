#include "line_plain.h"

#include "line_input.h"

#include <string.h>

static void drop_taken(struct line_plain *p)
{
    p->len -= p->taken;
    memmove(p->bytes, p->bytes + p->taken, p->len);
    p->taken = 0;
}

/* Cuts the first line off, whose end is at `end`. */
static enum line_event hand_out(struct line_plain *p, size_t end,
                                const char **out)
{
    p->bytes[end] = '\0';
    if (end > 0 && p->bytes[end - 1] == '\r') {
        p->bytes[end - 1] = '\0';
    }
    p->taken = end + 1;
    if (p->is_cut) {
        p->is_cut = false;
        return LINE_TOO_LONG;
    }
    *out = p->bytes;
    return LINE_READY;
}

static void read_more(struct line_plain *p)
{
    if (p->len == LINE_BYTES - 1) {
        p->is_cut = true;
        p->len = 0;
    }
    const int n = line_input_read(p->bytes + p->len, LINE_BYTES - 1 - p->len);
    if (n < 0) {
        p->has_ended = true;
    } else {
        p->len += (size_t)n;
    }
}

enum line_event line_plain_take(struct line_plain *p, const char **out)
{
    drop_taken(p);
    const char *end = memchr(p->bytes, '\n', p->len);
    if (end == NULL && !p->has_ended) {
        read_more(p);
        end = memchr(p->bytes, '\n', p->len);
    }
    if (end != NULL) {
        return hand_out(p, (size_t)(end - p->bytes), out);
    }
    if (!p->has_ended) {
        return LINE_NONE;
    }
    if (p->len == 0 && !p->is_cut) {
        return LINE_END;
    }
    const size_t rest = p->len;
    p->len++;
    return hand_out(p, rest, out);
}
