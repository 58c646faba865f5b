/* Answers on their way: delayed or lost, by the options. */
#ifndef LUMSIM_REPLIES_H
#define LUMSIM_REPLIES_H

#include "sim/device.h"
#include "sim/random.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define REPLIES_MAX 256

struct reply {
    int64_t due_ns;
    lum_device_peer to;
    size_t len;
    uint8_t bytes[LUM_DEVICE_REPLY_BYTES];
};

struct replies {
    int64_t delay_ns;
    double loss; /* a probability */
    lum_random random;
    size_t first;
    size_t count;                      /* that wait */
    struct reply waiting[REPLIES_MAX]; /* all wait alike: in order of due_ns */
};

void replies_init(struct replies *out, double delay_ms, double loss,
                  uint64_t seed);

/* Whether it will be sent; otherwise it is lost, by chance or because there is
 * no room. */
bool replies_add(struct replies *replies, int64_t now_ns, lum_device_peer to,
                 const void *bytes, size_t len);

/* When the next one leaves; INT64_MAX: none waits. */
int64_t replies_next_ns(const struct replies *replies);

/* The next one that leaves by then, or NULL. Lives until the next is added. */
const struct reply *replies_take(struct replies *replies, int64_t now_ns);

#endif
