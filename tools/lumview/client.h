/* The connected browsers: the view that each wants, and the data being sent to
 * it. */
#ifndef LUMVIEW_CLIENT_H
#define LUMVIEW_CLIENT_H

#include "command.h"
#include "feed.h"
#include "frame.h"
#include "status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct lws;

/* libwebsockets writes its own head before each message. */
#define CLIENT_PIECE_BYTES 65536u

struct client_refusal;

struct client {
    struct lws *wsi;
    struct client *next;
    struct feed_view view;
    unsigned frames;                /* shown at once */
    int64_t past_before;            /* it asked for frames before this one */
    uint64_t past;                  /* bit i: that one by i + 1 before */
    struct frame *frame;            /* being sent; NULL: none */
    size_t sent;                    /* bytes of it */
    uint8_t last[FRAME_HEAD_BYTES]; /* head of the frame before */
    bool has_last;
    bool had_hello;
    bool wants_status;
    uint64_t skipped;
    const struct client_refusal *refusal; /* it is to be closed; else NULL */
    char command[COMMAND_BYTES];          /* so far */
    size_t command_len;
};

struct clients {
    const struct options *options;
    struct feed *feed; /* NULL: it is gone; connections may still be closed */
    struct status status;
    struct client *first;
    unsigned char *piece; /* LWS_PRE and CLIENT_PIECE_BYTES; to be freed */
};

/* -1: there is no memory. */
int clients_init(struct clients *clients, const struct options *options);

/* A connection begins, and ends. */
void clients_add(struct clients *clients, struct client *client,
                 struct lws *wsi);
void clients_remove(struct clients *clients, struct client *client);

/* The feed has something new. */
void clients_wake(struct clients *clients);

/* Half a second has passed. */
void clients_tick(struct clients *clients);

/* The socket takes more. -1: the connection is to be closed. */
int clients_write(struct clients *clients, struct client *client);

/* A piece of a message came. What is no command ends the connection. */
void clients_read(struct clients *clients, struct client *client,
                  const char *bytes, size_t len);

#endif
