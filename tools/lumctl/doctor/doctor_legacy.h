/* Rules of iptables-legacy, which nftables does not trace: each counts the
 * packets that it drops. */
#ifndef LUMCTL_DOCTOR_LEGACY_H
#define LUMCTL_DOCTOR_LEGACY_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#define LEGACY_MAX        256u
#define LEGACY_NAME_BYTES 32u

/* A rule that drops, or a policy. */
struct legacy_rule {
    uint64_t packets;
    char table[LEGACY_NAME_BYTES];
    char chain[LEGACY_NAME_BYTES];
    char text[200]; /* empty: the chain's policy */
};

struct legacy_rules {
    size_t count;
    struct legacy_rule all[LEGACY_MAX];
};

/* Reads the output of `iptables-legacy-save -c`. Only rules that drop or reject
 * are kept. */
void legacy_read(FILE *in, struct legacy_rules *out);

/* The rule, from the second list, that dropped at least this number of packets
 * in between. Of several, it is the one that dropped the fewest more; NULL:
 * none. */
const struct legacy_rule *legacy_grown(const struct legacy_rules *before,
                                       const struct legacy_rules *after,
                                       uint64_t packets);

#endif
