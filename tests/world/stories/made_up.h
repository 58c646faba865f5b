/* A made-up sensor, which answers as a story says. */
#ifndef STORIES_MADE_UP_H
#define STORIES_MADE_UP_H

#include "user.h"

enum {
    MADE_UP_SET_IP = 5,
    MADE_UP_TIME = 6,
    MADE_UP_TLV = 7,
    MADE_UP_HEARTBEAT = 8
};

/* Bits of its status. */
enum {
    MADE_UP_TIMEOUT = 0x0010,
    MADE_UP_FAN = 0x0040,
    MADE_UP_OFF = 0x0200,
    MADE_UP_ON = 0x0800
};
#define NO_STATUS (-1)

/* A packet that came. */
typedef struct made_up_packet {
    unsigned kind;
    uint32_t sequence; /* of time stamps and TLVs */
    const char *text;  /* of a command; "": none */
    size_t before;     /* of its kind, that came before */
    int64_t t_ns;      /* when it came */
    uint32_t from;
    uint16_t port;
    const uint8_t *bytes;
    size_t size;
} made_up_packet;

#define MADE_UP_PACKETS 4096

typedef struct made_up {
    user_peer *peer;
    user_peer *answers_by; /* the same, unless a story says another */
    void (*answer)(struct made_up *self, const made_up_packet *packet);
    /* For heartbeats; NULL: nothing. */
    void (*beat)(struct made_up *self, const made_up_packet *packet);
    int status;       /* of plain answers; MADE_UP_OFF at first */
    int64_t delay_ns; /* of answers */
    size_t state;     /* the story's */
    void (*hears)(user_peer *peer, const user_mail *mail, void *argument);
    void *argument;    /* of hears() */
    const void *facts; /* the story's */
    made_up_packet packets[MADE_UP_PACKETS];
    size_t count;
} made_up;

/* At port 5517. answer NULL: made_up_plain. */
made_up *made_up_new(world_host *host, const char *address,
                     void (*answer)(made_up *self,
                                    const made_up_packet *packet));

/* Tells of every datagram that comes, before it is answered. */
void made_up_hears(made_up *self,
                   void (*hears)(user_peer *peer, const user_mail *mail,
                                 void *argument),
                   void *argument);

/* Answers: nothing; a time stamp, and a status without anything else. */
void made_up_silent(made_up *self, const made_up_packet *packet);
void made_up_plain(made_up *self, const made_up_packet *packet);

/* A time stamp of a clock. */
void made_up_send_time(made_up *self, const made_up_packet *packet,
                       uint32_t clock_us);
/* A TLV packet with a sequence, a status unless that is NO_STATUS, and what the
 * sensor says, unless that is NULL. */
void made_up_send(made_up *self, const made_up_packet *packet,
                  uint32_t sequence, int status, const char *said);
/* The same as an answer. */
void made_up_say(made_up *self, const made_up_packet *packet, int status,
                 const char *said);
/* Any bytes. */
void made_up_send_bytes(made_up *self, const made_up_packet *packet,
                        const void *bytes, size_t size);

/* How many of a kind came. */
size_t made_up_heard(const made_up *self, unsigned kind);
/* The texts of the commands that came, with a comma behind each: all of them,
 * and each once however often it was sent. */
const char *made_up_texts(const made_up *self);
const char *made_up_commands(const made_up *self);
/* How often a command came, repeats included. */
size_t made_up_tries(const made_up *self, const char *text);
/* Of a kind: how many different sequences. */
size_t made_up_sequences(const made_up *self, unsigned kind);

#endif
