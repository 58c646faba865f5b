#include "made_up.h"

#include "kernel/process.h"

#include <string.h>

#define PORT  5517u
#define CLOCK 5000000u

static const uint8_t magic[8] = {0xed, 0xfe, 0xf3, 0xa1,
                                 0xef, 0xbe, 0x34, 0x12};

static void put16(uint8_t *to, unsigned value)
{
    to[0] = (uint8_t)value;
    to[1] = (uint8_t)(value >> 8);
}

static void put32(uint8_t *to, uint32_t value)
{
    put16(to, value & 0xffffu);
    put16(to + 2, value >> 16);
}

static uint32_t get32(const uint8_t *from)
{
    return from[0] | (uint32_t)from[1] << 8 | (uint32_t)from[2] << 16 |
           (uint32_t)from[3] << 24;
}

static bool is_numbered(unsigned kind)
{
    return kind == MADE_UP_TIME || kind == MADE_UP_TLV;
}

static const char *text_of(const user_mail *mail)
{
    return mail->bytes[8] == MADE_UP_TLV && mail->size > 20
               ? user_format("%.*s", (int)(mail->size - 20),
                             (const char *)mail->bytes + 20)
               : "";
}

static void hear(user_peer *peer, const user_mail *mail, void *argument)
{
    made_up *self = argument;
    if (self->hears != NULL) {
        self->hears(peer, mail, self->argument);
    }
    if (mail->size < 12 || memcmp(mail->bytes, magic, sizeof magic) != 0 ||
        self->count == MADE_UP_PACKETS) {
        return;
    }
    const unsigned kind = mail->bytes[8];
    const bool has_sequence = is_numbered(kind) && mail->size >= 16;
    made_up_packet *packet = &self->packets[self->count];
    *packet =
        (made_up_packet){.kind = kind,
                         .sequence = has_sequence ? get32(mail->bytes + 12) : 0,
                         .text = text_of(mail),
                         .before = made_up_heard(self, kind),
                         .t_ns = world_now(),
                         .from = mail->from,
                         .port = mail->port,
                         .bytes = mail->bytes,
                         .size = mail->size};
    self->count++;
    if (has_sequence) {
        self->answer(self, packet);
    } else if (kind == MADE_UP_HEARTBEAT && self->beat != NULL) {
        self->beat(self, packet);
    }
}

made_up *made_up_new(world_host *host, const char *address,
                     void (*answer)(made_up *self,
                                    const made_up_packet *packet))
{
    made_up *self = world_calloc(1, sizeof *self);
    self->answer = answer != NULL ? answer : made_up_plain;
    self->status = MADE_UP_OFF;
    self->peer = user_peer_new(host, address, PORT, hear, self);
    self->answers_by = self->peer;
    return self;
}

void made_up_hears(made_up *self,
                   void (*hears)(user_peer *peer, const user_mail *mail,
                                 void *argument),
                   void *argument)
{
    self->hears = hears;
    self->argument = argument;
}

/* --- Answers --- */

void made_up_silent(made_up *self, const made_up_packet *packet)
{
    (void)self;
    (void)packet;
}

void made_up_plain(made_up *self, const made_up_packet *packet)
{
    if (packet->kind == MADE_UP_TIME) {
        made_up_send_time(self, packet, CLOCK);
    } else {
        made_up_say(self, packet, self->status, NULL);
    }
}

void made_up_send_time(made_up *self, const made_up_packet *packet,
                       uint32_t clock_us)
{
    uint8_t bytes[20] = {0};
    memcpy(bytes, magic, sizeof magic);
    bytes[8] = MADE_UP_TIME;
    put32(bytes + 12, packet->sequence);
    put32(bytes + 16, clock_us);
    made_up_send_bytes(self, packet, bytes, sizeof bytes);
}

void made_up_send(made_up *self, const made_up_packet *packet,
                  uint32_t sequence, int status, const char *said)
{
    uint8_t bytes[1400] = {0};
    size_t size = 16;
    memcpy(bytes, magic, sizeof magic);
    bytes[8] = MADE_UP_TLV;
    put32(bytes + 12, sequence);
    if (status != NO_STATUS) {
        put16(bytes + size, 2);
        put16(bytes + size + 2, 2);
        put16(bytes + size + 4, (unsigned)status);
        size += 6;
    }
    if (said != NULL) {
        put16(bytes + size, 3);
        put16(bytes + size + 2, (unsigned)strlen(said));
        memcpy(bytes + size + 4, said, strlen(said));
        size += 4 + strlen(said);
    }
    made_up_send_bytes(self, packet, bytes, size);
}

void made_up_say(made_up *self, const made_up_packet *packet, int status,
                 const char *said)
{
    made_up_send(self, packet, packet->sequence, status, said);
}

/* What is on its way for a while. */
typedef struct late {
    user_peer *by;
    uint32_t to;
    uint16_t port;
    size_t size;
    uint8_t bytes[1400];
} late;

static void send_late(void *argument)
{
    const late *l = argument;
    user_send(l->by, l->to, l->port, l->bytes, l->size);
}

void made_up_send_bytes(made_up *self, const made_up_packet *packet,
                        const void *bytes, size_t size)
{
    if (self->delay_ns == 0) {
        user_send(self->answers_by, packet->from, packet->port, bytes, size);
        return;
    }
    late *l = world_calloc(1, sizeof *l);
    l->by = self->answers_by;
    l->to = packet->from;
    l->port = packet->port;
    l->size = size;
    memcpy(l->bytes, bytes, size);
    (void)world_at(world_now() + self->delay_ns, send_late, l);
}

/* --- What came --- */

size_t made_up_heard(const made_up *self, unsigned kind)
{
    size_t count = 0;
    for (size_t i = 0; i < self->count; i++) {
        count += self->packets[i].kind == kind;
    }
    return count;
}

static bool came_before(const made_up *self, size_t i)
{
    const made_up_packet *packet = &self->packets[i];
    for (size_t k = 0; k < i; k++) {
        if (self->packets[k].kind == packet->kind &&
            self->packets[k].sequence == packet->sequence) {
            return true;
        }
    }
    return false;
}

static const char *list(const made_up *self, bool once)
{
    const char *all = "";
    for (size_t i = 0; i < self->count; i++) {
        const char *text = self->packets[i].text;
        if (*text != '\0' && !(once && came_before(self, i))) {
            all = user_format("%s%s,", all, text);
        }
    }
    return all;
}

const char *made_up_texts(const made_up *self)
{
    return list(self, false);
}

const char *made_up_commands(const made_up *self)
{
    return list(self, true);
}

size_t made_up_tries(const made_up *self, const char *text)
{
    size_t count = 0;
    for (size_t i = 0; i < self->count; i++) {
        count += strcmp(self->packets[i].text, text) == 0;
    }
    return count;
}

size_t made_up_sequences(const made_up *self, unsigned kind)
{
    size_t count = 0;
    for (size_t i = 0; i < self->count; i++) {
        count += self->packets[i].kind == kind && !came_before(self, i);
    }
    return count;
}
