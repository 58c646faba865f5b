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

/* The way of one packet, as far as it is known. */
struct trace_way {
    char id[16];
    bool is_out; /* it was sent; else it was received */
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
    const char *table; /* our own table: it shows the direction of a packet */
    size_t count;
    struct trace_way ways[TRACE_IDS_MAX];
};

/* Takes a line of `nft monitor trace`; ignores other kinds of lines. */
void trace_read(struct trace_reader *reader, const char *line);

/* A packet that was dropped: a received one rather than a sent one; NULL:
 * none. */
const struct trace_way *trace_dropped(const struct trace_reader *reader);

/* Whether any packet of this direction was seen. */
bool trace_saw(const struct trace_reader *reader, bool is_out);

/* A trace under way. It adds a table to the rules, which marks the packets
 * between the sensor and one UDP port of this host. The table belongs to a
 * process of nft, and the kernel removes it when this process ends. The process
 * always ends when this program does. */
struct trace;

/* Starts it. Returns 0, with *out to trace_stop(); -1 with error set. */
int trace_start(const char *interface, lum_endpoint sensor, uint16_t port,
                struct trace **out, lum_error *error);

/* 1: it is ready; 0 with error set: not after this number of milliseconds; -1
 * with error set: nft or the kernel cannot do it. */
int trace_ready(struct trace *trace, int wait_ms, lum_error *error);

/* Reads what comes within this number of milliseconds. */
const struct trace_reader *trace_follow(struct trace *trace, int wait_ms);

/* NULL is allowed. */
void trace_stop(struct trace *trace);

/* 0, or -1 with error set: it cannot be started at all here. */
int trace_allowed(lum_error *error);

#endif
