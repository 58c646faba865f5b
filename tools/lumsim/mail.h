/* Answers on their way: delayed or lost, by the options. */
#ifndef LUMSIM_MAIL_H
#define LUMSIM_MAIL_H

#include "lum/net/socket.h"
#include "sim/device.h"
#include "sim/random.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define MAIL_MAX 256

struct letter {
    int64_t due_ns;
    lum_device_peer to;
    size_t len;
    uint8_t bytes[LUM_DEVICE_REPLY_BYTES];
};

struct mail {
    int64_t delay_ns;
    double loss; /* a probability */
    lum_random random;
    size_t first;
    size_t count;
    struct letter letters[MAIL_MAX]; /* all wait alike: in order of due_ns */
};

void mail_init(struct mail *out, double delay_ms, double loss, uint64_t seed);

/* Whether it will be sent; otherwise it is lost, by chance or because there is
 * no room. */
bool mail_post(struct mail *mail, int64_t now_ns, lum_device_peer to,
               const void *bytes, size_t len);

/* When the next one leaves; INT64_MAX: none waits. */
int64_t mail_next_ns(const struct mail *mail);

/* The next one that leaves by then, or NULL. Lives until the next post. */
const struct letter *mail_take(struct mail *mail, int64_t now_ns);

/* Forget those that wait. */
void mail_clear(struct mail *mail);

#endif
