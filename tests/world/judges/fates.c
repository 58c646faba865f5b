/* Each datagram that was sent is received or lost in exactly one place. */
#include "judge.h"

#include <string.h>

static const char one[] = "one-fate";

/* Longer than any delay that the network makes, or a stopped program lets wait:
 * what is in a buffer then has a reader that lives. */
#define UNDER_WAY_NS (30 * RECORD_S)

static bool may_wait(const struct record *record, const record_datagram *d)
{
    return d->reader != RECORD_NONE &&
           record->tools[d->reader].ended_ns == RECORD_NEVER;
}

void judge_fate(const record_datagram *d, struct verdict *out)
{
    if (d->fates > 1) {
        verdict_broken(out, one, d->fate_ns,
                       "datagram %llu was received or lost %u times",
                       (unsigned long long)d->number, d->fates);
    }
}

void judge_fates(const struct record *record, struct verdict *out)
{
    uint64_t last = 0;
    for (size_t i = 0; i < record->datagram_count; i++) {
        const record_datagram *d = &record->datagrams[i];
        verdict_asked(out, one);
        if (i > 0 && d->number <= last) {
            verdict_broken(
                out, one, d->sent_ns, "datagram %llu comes after number %llu",
                (unsigned long long)d->number, (unsigned long long)last);
        }
        last = d->number;
        judge_fate(d, out);
        if (d->fates == 0 && record->now_ns - d->sent_ns > UNDER_WAY_NS &&
            !may_wait(record, d)) {
            verdict_broken(out, one, d->sent_ns,
                           "datagram %llu was neither received nor lost",
                           (unsigned long long)d->number);
        }
    }
}
