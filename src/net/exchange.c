#include "net/exchange.h"

#include <string.h>

void lum_exchange_init(lum_exchange *out, const lum_exchange_config *config)
{
    memset(out, 0, sizeof *out);
    out->config = *config;
    out->next = config->first;
}

/* Alerts may carry sequence 0, so we skip 0 unless the caller starts there. */
static uint32_t issue(lum_exchange *x)
{
    if (x->next == 0 && x->issued > 0) {
        x->next++;
        x->issued++;
    }
    x->issued++;
    return x->next++;
}

static bool was_issued(const lum_exchange *x, uint32_t sequence)
{
    if (sequence == 0 && x->config.first != 0) {
        return false;
    }
    return (uint32_t)(sequence - x->config.first) < x->issued;
}

static void begin(lum_exchange *x, lum_exchange_ask ask, int64_t now_ns)
{
    x->ask = ask;
    x->tries = 0;
    x->due_ns = now_ns;
    x->looked_ns = now_ns;
    x->has_noticed = false;
    x->is_stale = false;
    x->sequence = issue(x);
}

lum_result lum_exchange_request(lum_exchange *x, int64_t now_ns,
                                const void *tlvs, size_t len)
{
    lum_tlv_writer writer;
    if (x->ask != LUM_ASK_NOTHING) {
        return LUM_E_VALUE;
    }
    if (len > sizeof x->packet - LUM_TLV_PACKET_BYTES) {
        return LUM_E_SPACE;
    }
    begin(x, LUM_ASK_TLV, now_ns);
    const lum_result r =
        lum_tlv_begin(&writer, x->packet, sizeof x->packet, x->sequence);
    if (len > 0) {
        memcpy(x->packet + writer.len, tlvs, len);
    }
    x->packet_len = writer.len + len;
    return r;
}

lum_result lum_exchange_request_time(lum_exchange *x, int64_t now_ns)
{
    if (x->ask != LUM_ASK_NOTHING) {
        return LUM_E_VALUE;
    }
    begin(x, LUM_ASK_TIME, now_ns);
    return LUM_OK;
}

void lum_exchange_give_up(lum_exchange *x)
{
    x->ask = LUM_ASK_NOTHING;
}

static int64_t request_ns(const lum_exchange *x)
{
    if (x->ask == LUM_ASK_NOTHING) {
        return INT64_MAX;
    }
    const int64_t look_ns = x->looked_ns + LUM_EXCHANGE_LOOK_NS;
    if (x->tries == 0) {
        return INT64_MIN;
    }
    return look_ns < x->due_ns ? look_ns : x->due_ns;
}

int64_t lum_exchange_next_ns(const lum_exchange *x)
{
    const int64_t request = request_ns(x);
    if (!x->config.owns) {
        return request;
    }
    const int64_t beat = x->has_beaten ? x->beat_ns : INT64_MIN;
    return beat < request ? beat : request;
}

bool lum_exchange_beat(lum_exchange *x, int64_t now_ns)
{
    const int64_t period = x->config.heartbeat_ns;
    if (!x->config.owns || (x->has_beaten && now_ns < x->beat_ns)) {
        return false;
    }
    if (!x->has_beaten) {
        x->has_beaten = true;
        x->beat_ns = now_ns;
    }
    x->beat_ns += period * ((now_ns - x->beat_ns) / period + 1);
    return true;
}

/* A resend of TLVs keeps its number, so that the sensor sees that it is a
 * repeat; a resend of a time request gets a new one, so that we can tell their
 * answers apart. */
static void try_again(lum_exchange *x, int64_t now_ns)
{
    if (x->ask == LUM_ASK_TIME) {
        if (x->tries > 0) {
            x->sequence = issue(x);
        }
        const lum_timestamp request = {x->sequence, 0};
        lum_timestamp_encode(x->packet, &request);
        x->packet_len = LUM_TIMESTAMP_BYTES;
    }
    if (x->ask == LUM_ASK_TIME || x->tries == 0) {
        x->log[x->tries % LUM_EXCHANGE_TRIES] =
            (lum_exchange_try){x->sequence, now_ns};
    }
    x->tries++;
    x->due_ns = now_ns + x->config.timeout_ns;
}

/* An application that was delayed may no longer want what it asked for. */
static bool is_stale(lum_exchange *x, int64_t now_ns)
{
    x->is_stale = x->is_stale || now_ns - x->looked_ns >= LUM_EXCHANGE_STALE_NS;
    x->looked_ns = now_ns;
    return x->is_stale;
}

static bool may_end(lum_exchange *x, int64_t now_ns, int64_t heard_ns)
{
    if (!x->has_noticed) {
        x->has_noticed = true;
        x->noticed_ns = now_ns;
    }
    return heard_ns >= x->due_ns ||
           now_ns - x->noticed_ns >= x->config.timeout_ns;
}

lum_exchange_step lum_exchange_advance(lum_exchange *x, int64_t now_ns,
                                       int64_t heard_ns,
                                       lum_exchange_found *found)
{
    const bool stale = x->ask != LUM_ASK_NOTHING && is_stale(x, now_ns);
    if (x->ask == LUM_ASK_NOTHING || (x->tries > 0 && now_ns < x->due_ns)) {
        return LUM_EXCHANGE_NOTHING;
    }
    if (x->tries <= x->config.retries && !stale) {
        try_again(x, now_ns);
        return x->tries == 1 ? LUM_EXCHANGE_REQUEST : LUM_EXCHANGE_RESEND;
    }
    if (!may_end(x, now_ns, heard_ns)) {
        return LUM_EXCHANGE_NOTHING;
    }
    *found = (lum_exchange_found){.sequence = x->sequence, .tries = x->tries};
    x->ask = LUM_ASK_NOTHING;
    return LUM_EXCHANGE_GIVEN_UP;
}

/* The try that a sequence number belongs to, or NULL. */
static const lum_exchange_try *find_try(const lum_exchange *x,
                                        lum_exchange_ask ask, uint32_t sequence)
{
    const unsigned logged = ask == LUM_ASK_TLV && x->tries > 1 ? 1u : x->tries;
    if (x->ask != ask) {
        return NULL;
    }
    for (unsigned i = 0; i < logged && i < LUM_EXCHANGE_TRIES; i++) {
        if (x->log[i].sequence == sequence) {
            return &x->log[i];
        }
    }
    return NULL;
}

static lum_exchange_kind take_time(lum_exchange *x, const void *bytes,
                                   size_t len, lum_exchange_found *found)
{
    lum_timestamp answer;
    if (lum_timestamp_decode(bytes, len, &answer) != LUM_OK) {
        return LUM_EXCHANGE_MALFORMED;
    }
    const lum_exchange_try *sent = find_try(x, LUM_ASK_TIME, answer.sequence);
    if (sent == NULL) {
        return LUM_EXCHANGE_DROPPED;
    }
    *found = (lum_exchange_found){.sequence = answer.sequence,
                                  .clock_us = answer.clock_us,
                                  .tries = x->tries,
                                  .sent_ns = sent->sent_ns};
    x->ask = LUM_ASK_NOTHING;
    return LUM_EXCHANGE_TIME;
}

/* Reads all TLVs for the last status; false if they contradict themselves. */
static bool read_status(const lum_exchange *x, lum_exchange_found *found)
{
    lum_tlv_reader reader = found->tlvs;
    lum_tlv tlv;
    lum_result r = LUM_OK;
    while ((r = lum_tlv_next(&reader, &tlv)) == LUM_OK) {
        if (tlv.type == x->config.status_tlv &&
            lum_tlv_u16(&tlv, &found->status) == LUM_OK) {
            found->has_status = true;
        }
    }
    return r == LUM_END;
}

static lum_exchange_kind take_tlvs(lum_exchange *x, const void *bytes,
                                   size_t len, lum_exchange_found *found)
{
    lum_exchange_found read = {0};
    if (lum_tlv_open(bytes, len, &read.sequence, &read.tlvs) != LUM_OK) {
        return LUM_EXCHANGE_MALFORMED;
    }
    const lum_exchange_try *sent = find_try(x, LUM_ASK_TLV, read.sequence);
    if (sent == NULL && was_issued(x, read.sequence)) {
        return LUM_EXCHANGE_DROPPED;
    }
    if (!read_status(x, &read)) {
        return LUM_EXCHANGE_MALFORMED;
    }
    if (sent != NULL) {
        read.tries = x->tries;
        read.sent_ns = sent->sent_ns;
        x->ask = LUM_ASK_NOTHING;
    }
    *found = read;
    return sent != NULL ? LUM_EXCHANGE_ANSWER : LUM_EXCHANGE_ALERT;
}

lum_exchange_kind lum_exchange_take(lum_exchange *x, const void *bytes,
                                    size_t len, lum_exchange_found *found)
{
    uint8_t type = 0;
    if (lum_header_decode(bytes, len, &type) != LUM_OK) {
        return LUM_EXCHANGE_OTHER;
    }
    switch (type) {
    case LUM_TYPE_TIMESTAMP:
        return take_time(x, bytes, len, found);
    case LUM_TYPE_TLV:
        return take_tlvs(x, bytes, len, found);
    default:
        return LUM_EXCHANGE_OTHER;
    }
}
