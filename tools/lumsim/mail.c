#include "mail.h"

#include <string.h>

#define STREAM 101 /* of random numbers */

void mail_init(struct mail *out, double delay_ms, double loss, uint64_t seed)
{
    out->delay_ns = (int64_t)(delay_ms * 1e6);
    out->loss = loss;
    out->first = 0;
    out->count = 0;
    lum_random_init(&out->random, seed, STREAM);
}

bool mail_post(struct mail *mail, int64_t now_ns, lum_device_peer to,
               const void *bytes, size_t len)
{
    if (lum_random_chance(&mail->random, mail->loss) ||
        mail->count == MAIL_MAX || len > LUM_DEVICE_REPLY_BYTES) {
        return false;
    }
    struct letter *l = &mail->letters[(mail->first + mail->count) % MAIL_MAX];
    l->due_ns = now_ns + mail->delay_ns;
    l->to = to;
    l->len = len;
    memcpy(l->bytes, bytes, len);
    mail->count++;
    return true;
}

int64_t mail_next_ns(const struct mail *mail)
{
    return mail->count > 0 ? mail->letters[mail->first].due_ns : INT64_MAX;
}

const struct letter *mail_take(struct mail *mail, int64_t now_ns)
{
    if (mail_next_ns(mail) > now_ns) {
        return NULL;
    }
    const struct letter *l = &mail->letters[mail->first];
    mail->first = (mail->first + 1) % MAIL_MAX;
    mail->count--;
    return l;
}

void mail_clear(struct mail *mail)
{
    mail->count = 0;
}
