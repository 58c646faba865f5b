/* A program that speaks to a sensor by its packets alone, and keeps all that
 * comes back. */
#ifndef STORIES_CLIENT_H
#define STORIES_CLIENT_H

#include "user.h"

typedef struct client {
    user_peer *peer;
    uint32_t sensor; /* its address; changed by a story */
    uint16_t port;
    bool beats; /* a heartbeat each 0.2 s */
    uint32_t sequence;
    const user_mail **mails; /* all that came */
    size_t count, room;
    size_t seen; /* of them, that the story has looked at */
} client;

/* On the bench's host, at a port; it beats from the beginning, or not. */
client *client_new(world_host *host, uint16_t port, bool beats);

/* Packets: a heartbeat, a request for a time stamp, a TLV with a command (NULL:
 * none), an order to another address. */
void client_beat(client *self);
void client_ask_time(client *self, uint32_t sequence);
void client_order(client *self, uint32_t sequence, const char *command);
void client_move(client *self, uint32_t address);
void client_send(client *self, const void *bytes, size_t size);

/* What came since the story looked last: the first for which a test is true, or
 * NULL. What is found counts as looked at. */
typedef bool client_test(const user_mail *mail, const void *argument);
const user_mail *client_find(client *self, client_test *test,
                             const void *argument);
/* Waits for it. */
const user_mail *client_wait(client *self, client_test *test,
                             const void *argument);
/* All that came counts as looked at. */
void client_drain(client *self);

bool is_data(const user_mail *mail, const void *unused);
bool is_range(const user_mail *mail, const void *unused);
bool is_tlv(const user_mail *mail, const void *unused);
/* An answer with a sequence. */
bool is_answer(const user_mail *mail, const void *sequence);

/* The sensor's clock, asked and answered. */
uint32_t client_clock(client *self);
/* The answer to a command; NULL: to a poll. */
const user_mail *client_command(client *self, const char *command);
/* Waits for so many data packets more. */
void client_take(client *self, size_t count);

/* Fields of answers: the status, -1 without one; what was said, in one text. */
int status_in(const user_mail *mail);
const char *said_in(const user_mail *mail);
uint32_t u32_at(const user_mail *mail, size_t at);
uint32_t u16_at(const user_mail *mail, size_t at);

/* Of data packets. */
enum {
    ANGLES = 2,
    RANGES = 3
};
#define tag_of(MAIL)   ((MAIL)->bytes[12])
#define eye_of(MAIL)   ((MAIL)->bytes[13])
#define line_of(MAIL)  u16_at(MAIL, 14)
#define count_of(MAIL) u16_at(MAIL, 16)
#define first_of(MAIL) u16_at(MAIL, 18)
#define clock_of(MAIL) u32_at(MAIL, 20)

#endif
