#include "client.h"

#include "kernel/process.h"

#include <stdio.h>
#include <string.h>

#define BEAT_NS (200 * WORLD_MS)

static const uint8_t magic[8] = {0xed, 0xfe, 0xf3, 0xa1,
                                 0xef, 0xbe, 0x34, 0x12};

static void beat_on(void *argument)
{
    client *self = argument;
    if (self->beats) {
        client_beat(self);
    }
    (void)world_at(world_now() + BEAT_NS, beat_on, self);
}

static void keep(user_peer *peer, const user_mail *mail, void *argument)
{
    client *self = argument;
    (void)peer;
    if (self->count == self->room) {
        self->room = 2 * self->room + 1024;
        self->mails =
            world_realloc(self->mails, self->room * sizeof(const user_mail *));
    }
    self->mails[self->count] = mail;
    self->count++;
}

client *client_new(world_host *host, uint16_t port, bool beats)
{
    client *self = world_calloc(1, sizeof *self);
    self->sensor = user_ip("10.42.0.37");
    self->port = 5517;
    self->beats = beats;
    self->sequence = 100;
    self->peer = user_peer_new(host, user_address_of(host), port, keep, self);
    (void)world_at(world_now(), beat_on, self);
    return self;
}

void client_send(client *self, const void *bytes, size_t size)
{
    user_send(self->peer, self->sensor, self->port, bytes, size);
}

/* A packet of a kind: two words of it, and a text behind them. */
static size_t make(uint8_t *out, unsigned kind, size_t words,
                   const uint32_t *word)
{
    memset(out, 0, 12);
    memcpy(out, magic, sizeof magic);
    out[8] = (uint8_t)kind;
    for (size_t i = 0; i < 4 * words; i++) {
        out[12 + i] = (uint8_t)(word[i / 4] >> 8 * (i % 4));
    }
    return 12 + 4 * words;
}

void client_beat(client *self)
{
    uint8_t packet[12];
    client_send(self, packet, make(packet, 8, 0, NULL));
}

void client_ask_time(client *self, uint32_t sequence)
{
    uint8_t packet[20];
    client_send(self, packet, make(packet, 6, 2, (uint32_t[]){sequence, 0}));
}

void client_order(client *self, uint32_t sequence, const char *command)
{
    uint8_t packet[256];
    size_t size = make(packet, 7, 1, &sequence);
    if (command != NULL) {
        const size_t length = strlen(command);
        const uint8_t head[4] = {1, 0, (uint8_t)length, 0};
        memcpy(packet + size, head, sizeof head);
        memcpy(packet + size + sizeof head, command, length);
        size += sizeof head + length;
    }
    client_send(self, packet, size);
}

void client_move(client *self, uint32_t address)
{
    uint8_t packet[16];
    const uint32_t swapped = address >> 24 | (address >> 8 & 0xff00u) |
                             (address << 8 & 0xff0000u) | address << 24;
    client_send(self, packet, make(packet, 5, 1, &swapped));
}

/* --- What came --- */

const user_mail *client_find(client *self, client_test *test,
                             const void *argument)
{
    while (self->seen < self->count) {
        const user_mail *mail = self->mails[self->seen];
        self->seen++;
        if (mail->size >= 12 && test(mail, argument)) {
            return mail;
        }
    }
    return NULL;
}

const user_mail *client_wait(client *self, client_test *test,
                             const void *argument)
{
    const user_mail *found = NULL;
    user_until((found = client_find(self, test, argument)) != NULL);
    return found;
}

void client_drain(client *self)
{
    self->seen = self->count;
}

bool is_data(const user_mail *mail, const void *unused)
{
    (void)unused;
    return mail->bytes[8] == 8 && mail->size >= 24;
}

bool is_range(const user_mail *mail, const void *unused)
{
    return is_data(mail, unused) && tag_of(mail) == RANGES;
}

bool is_tlv(const user_mail *mail, const void *unused)
{
    (void)unused;
    return mail->bytes[8] == 7;
}

bool is_answer(const user_mail *mail, const void *sequence)
{
    return (mail->bytes[8] == 6 || mail->bytes[8] == 7) && mail->size >= 16 &&
           u32_at(mail, 12) == *(const uint32_t *)sequence;
}

uint32_t client_clock(client *self)
{
    const uint32_t sequence = ++self->sequence;
    client_ask_time(self, sequence);
    return u32_at(client_wait(self, is_answer, &sequence), 16);
}

const user_mail *client_command(client *self, const char *command)
{
    const uint32_t sequence = ++self->sequence;
    client_order(self, sequence, command);
    return client_wait(self, is_answer, &sequence);
}

void client_take(client *self, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        (void)client_wait(self, is_data, NULL);
    }
}

/* --- Fields --- */

uint32_t u16_at(const user_mail *mail, size_t at)
{
    return mail->bytes[at] | (uint32_t)mail->bytes[at + 1] << 8;
}

uint32_t u32_at(const user_mail *mail, size_t at)
{
    return u16_at(mail, at) | u16_at(mail, at + 2) << 16;
}

int status_in(const user_mail *mail)
{
    for (size_t at = 16; at + 4 <= mail->size; at += 4 + u16_at(mail, at + 2)) {
        if (u16_at(mail, at) == 2) {
            return (int)u16_at(mail, at + 4);
        }
    }
    return -1;
}

const char *said_in(const user_mail *mail)
{
    const char *all = "";
    for (size_t at = 16; at + 4 <= mail->size; at += 4 + u16_at(mail, at + 2)) {
        if (u16_at(mail, at) == 3) {
            all = user_format("%s%.*s ", all, (int)u16_at(mail, at + 2),
                              (const char *)mail->bytes + at + 4);
        }
    }
    return all;
}
