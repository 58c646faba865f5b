/* Answers on their way to a client: each is delayed or lost, and handed out
 * when it is due. */
#include "replies.h"

#include <string.h>

#define STREAM 101 /* of random numbers */

void replies_init(struct replies *out, double delay_ms, double loss,
                  uint64_t seed)
{
    out->delay_ns = (int64_t)(delay_ms * 1e6);
    out->loss = loss;
    out->first = 0;
    out->count = 0;
    lum_random_init(&out->random, seed, STREAM);
}

bool replies_add(struct replies *replies, int64_t now_ns, lum_device_peer to,
                 const void *bytes, size_t len)
{
    if (lum_random_chance(&replies->random, replies->loss) ||
        replies->count == REPLIES_MAX || len > LUM_DEVICE_REPLY_BYTES) {
        return false;
    }
    struct reply *r =
        &replies->waiting[(replies->first + replies->count) % REPLIES_MAX];
    r->due_ns = now_ns + replies->delay_ns;
    r->to = to;
    r->len = len;
    memcpy(r->bytes, bytes, len);
    replies->count++;
    return true;
}

int64_t replies_next_ns(const struct replies *replies)
{
    return replies->count > 0 ? replies->waiting[replies->first].due_ns
                              : INT64_MAX;
}

const struct reply *replies_take(struct replies *replies, int64_t now_ns)
{
    if (replies_next_ns(replies) > now_ns) {
        return NULL;
    }
    const struct reply *r = &replies->waiting[replies->first];
    replies->first = (replies->first + 1) % REPLIES_MAX;
    replies->count--;
    return r;
}
