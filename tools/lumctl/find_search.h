/* A search while it runs. find_links.c opens what it sends and hears by,
 * find_ask.c asks, find_hear.c takes what comes. One thread. */
#ifndef LUMCTL_FIND_SEARCH_H
#define LUMCTL_FIND_SEARCH_H

#include "find.h"

/* Asks and hears ARP on an interface. */
struct listener {
    const struct host_interface *interface;
    struct arp *arp; /* NULL: not allowed */
};

/* Written by find_links.c alone. */
struct find_links {
    lum_socket *sockets[FIND_SOCKETS_MAX];
    const struct host_interface *of[FIND_SOCKETS_MAX]; /* NULL: by routes */
    size_t socket_count;
    lum_socket *socket_of[FIND_RANGES_MAX]; /* NULL: the range has none */
    struct listener listeners[FIND_SOCKETS_MAX];
    size_t listener_count;
    bool has_arp;      /* one of them asks by ARP */
    bool has_no_right; /* to listen to the wire */
};

/* What one address was asked (find_ask.c), and what came (find_hear.c). */
struct question {
    uint32_t sequence; /* of the last time that it was sent */
    int64_t sent_ns;   /* 0: not yet */
    bool is_answered;
    char mac[INTERFACE_MAC_TEXT_BYTES]; /* one that answered ARP for the
                                           address; empty: none */
};

struct search {
    struct ctl *ctl;
    struct find_plan *plan;
    struct find_result *out;
    struct find_links links;
    struct question *questions;
    unsigned index_of[FIND_RANGES_MAX]; /* of a range's first question */
    unsigned total;
    uint32_t sequence; /* the first */
    int64_t progress_ns;
    int64_t alive_ns;
    bool has_line; /* of progress, on the terminal */
};

/* Opens a socket and a listener for each interface of the plan; ranges that
 * they can ask become askable, and left_out names the others. Complains.
 * find_links_close() in any case. */
enum exit_status find_links_open(struct find_links *links,
                                 struct find_plan *plan);
void find_links_close(struct find_links *links);

/* The place of an interface's listener; listener_count: it has none. */
size_t find_links_listener(const struct find_links *links,
                           const struct host_interface *interface);

/* What asks by ARP there; NULL: nothing. */
struct arp *find_links_arp(const struct find_links *links,
                           const struct host_interface *interface);

/* Takes all that has come: findings into s->out, answers to s->questions.
 * EXIT_FAILED, after a complaint: a socket failed. */
enum exit_status find_hear(struct search *s);

#endif
