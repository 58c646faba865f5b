/* The way of a packet through this host's nftables, as the kernel traces it. */
#ifndef LUMCTL_DOCTOR_TRACE_H
#define LUMCTL_DOCTOR_TRACE_H

#include "lum/base/error.h"
#include "lum/net/socket.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define TRACE_RULE_BYTES 256u
#define TRACE_NAME_BYTES 256u
#define TRACE_IDS_MAX    32u

/* One packet's way, its end so far. */
struct trace_way {
    char id[16];
    bool is_out; /* it left; else it came */
    bool is_dropped;
    bool has_ufw; /* it passed a chain of ufw's */
    char family[16];
    char table[TRACE_NAME_BYTES];
    char chain[TRACE_NAME_BYTES]; /* that drops it */
    char base[TRACE_NAME_BYTES];  /* by which it came into that table */
    char rule[TRACE_RULE_BYTES];  /* empty: the chain's policy drops it */
};

/* All that was traced. */
struct trace_reader {
    const char *table; /* our own: it tells which way a packet goes */
    size_t count;
    struct trace_way ways[TRACE_IDS_MAX];
};

/* Takes a line of `nft monitor trace`; lines of another kind are passed over.
 */
void trace_read(struct trace_reader *reader, const char *line);

/* A packet that was dropped, one that came before one that left; NULL: none. */
const struct trace_way *trace_dropped(const struct trace_reader *reader);

/* Whether a packet of this way was seen at all. */
bool trace_saw(const struct trace_reader *reader, bool is_out);

/* A trace under way. What it adds to the rules, a table that marks the packets
 * between the sensor and one UDP port of this host, belongs to a process of
 * nft: the kernel takes it out when that ends, which it does when this program
 * does, however that comes about. */
struct trace;

/* Starts it. Returns 0, with *out to trace_stop(); -1 with error set. */
int trace_start(const char *interface, lum_endpoint sensor, uint16_t port,
                struct trace **out, lum_error *error);

/* Whether it stands: 1; 0 with error set: not after so many milliseconds; -1
 * with error set: nft or the kernel cannot do it. */
int trace_ready(struct trace *trace, int wait_ms, lum_error *error);

/* Reads what comes in so many milliseconds. */
const struct trace_reader *trace_follow(struct trace *trace, int wait_ms);

/* NULL is allowed. */
void trace_stop(struct trace *trace);

/* 0, or -1 with error set: it cannot be started at all here. */
int trace_allowed(lum_error *error);

#endif
