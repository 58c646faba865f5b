#include "lum/live/laser_session.h"

#include "base/sized.h"
#include "live/contact.h"
#include "live/laser_rules.h"
#include "lum/base/time.h"
#include "lum/laser.h"
#include "lum/packet.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NS_PER_MS INT64_C(1000000)

/* A sensor that has just got its first heartbeat still shows that it had none.
 */
#define BEGINNING_NS (1000 * NS_PER_MS)

struct lum_laser_session {
    lum_endpoint sensor;
    const char *interface_name; /* behind it, or NULL */
    lum_layout layout;
    lum_laser_rules laser;
    lum_contact contact;
    uint16_t hazards; /* that were told, and still hold */
    bool is_owner;    /* the session sends heartbeats */
    unsigned texts;   /* that were told */
    bool told_off;    /* that laser off has no answer */
    lum_news left;    /* why the laser was left */
    lum_error link;   /* why sending fails */
    lum_news news[LUM_LASER_SESSION_NEWS];
    size_t first;
    size_t count;
};

/* --- Life --- */

void lum_laser_session_options_default(lum_laser_session_options *out,
                                       const lum_sensor_options *session)
{
    *out =
        (lum_laser_session_options){.struct_size = sizeof *out,
                                    .sensor = session->sensor,
                                    .interface_name = session->interface_name,
                                    .layout = session->layout,
                                    .owns = session->owns,
                                    .give_up_ms = LUM_LASER_SESSION_GIVE_UP_MS,
                                    .attempts = LUM_LASER_SESSION_ATTEMPTS};
}

int lum_laser_session_new(const lum_laser_session_options *options,
                          int64_t now_ns, lum_laser_session **out,
                          lum_error *error)
{
    lum_laser_session_options known;
    if (lum_sized_take(&known, sizeof known, options,
                       "the laser session's options",
                       "lum_laser_session_options", error) != 0) {
        return -1;
    }
    const char *name = known.interface_name;
    const size_t len = name != NULL ? strlen(name) + 1u : 0;
    lum_laser_session *k = calloc(1, sizeof *k + len);
    /* mcdc: tests/unit/test_no_memory.c */
    if (k == NULL) {
        return lum_error_set(error, "out of memory");
    }
    if (len > 0) {
        k->interface_name = memcpy(k + 1, name, len);
    }
    k->sensor = known.sensor;
    k->layout = known.layout;
    k->is_owner = known.owns;
    k->laser.is_owned = known.owns;
    k->laser.attempts_max = known.attempts;
    k->laser.give_up_ns = NS_PER_MS * (int64_t)known.give_up_ms;
    lum_contact_begin(&k->contact, now_ns);
    lum_laser_session_want(k, known.laser, now_ns);
    *out = k;
    return 0;
}

void lum_laser_session_free(lum_laser_session *session)
{
    free(session);
}

/* --- News --- */

/* ns: how long it took, or has taken. */
static lum_news make(const lum_laser_session *k, lum_news_kind kind, int64_t ns)
{
    lum_news news = {.struct_size = sizeof news,
                     .kind = kind,
                     .sensor = k->sensor,
                     .interface_name = k->interface_name,
                     .tlv_status = k->layout.profile.tlv[LUM_TLV_STATUS],
                     .is_owner = k->is_owner,
                     .ns = ns};
    if (k->contact.is_moved) {
        news.to = k->contact.to;
    }
    if (kind == LUM_NEWS_LINK_DOWN) {
        (void)snprintf(news.text, sizeof news.text, "%.255s", k->link.text);
    }
    return news;
}

static lum_news make_hazard(const lum_laser_session *k, unsigned bits)
{
    lum_news news = make(k, bits != 0 ? LUM_NEWS_HAZARD : 0, 0);
    news.status = (uint16_t)bits;
    return news;
}

static void tell(lum_laser_session *k, lum_news news)
{
    if (news.kind != 0) {
        k->news[(k->first + k->count) % LUM_LASER_SESSION_NEWS] = news;
        k->first = (k->first + (k->count == LUM_LASER_SESSION_NEWS)) %
                   LUM_LASER_SESSION_NEWS;
        k->count += k->count < LUM_LASER_SESSION_NEWS;
    }
}

static void tell_laser(lum_laser_session *k, lum_news_kind kind, int64_t now_ns)
{
    lum_news news = make(k, kind, k->laser.stood_ns);
    if (kind != 0) {
        const bool has_come = k->laser.state == LUM_LASER_UP;
        news.status = has_come ? k->laser.status : k->laser.fell;
        news.tries = k->laser.sent;
        news.was_away = lum_contact_was_away(&k->contact, now_ns);
        if (kind == LUM_NEWS_LASER_FELL) {
            const bool is_held =
                k->is_owner &&
                now_ns - k->contact.began_ns < 2 * BEGINNING_NS &&
                lum_laser_rules_hazards(news.status) == 0;
            news.ns = is_held ? k->contact.pause_ns : 0;
        }
        k->contact.pause_ns = 0;
        k->left = news;
        tell(k, news);
    }
}

bool lum_laser_session_next(lum_laser_session *session, lum_news *out)
{
    if (session->count == 0 ||
        !lum_sized_fill(out, &session->news[session->first], sizeof *out)) {
        return false;
    }
    session->first = (session->first + 1u) % LUM_LASER_SESSION_NEWS;
    session->count--;
    return true;
}

/* --- What its user wants --- */

void lum_laser_session_want(lum_laser_session *session, lum_laser_want want,
                            int64_t now_ns)
{
    const lum_laser_state state = want == LUM_WANT_LOOK ? LUM_LASER_UNTOUCHED
                                  : want == LUM_WANT_ON ? LUM_LASER_ASKED
                                                        : LUM_LASER_LEFT;
    session->left = make(session, LUM_NEWS_LASER_LEFT, 0);
    session->told_off = false;
    lum_laser_rules_want(&session->laser, state, want == LUM_WANT_OFF, now_ns);
}

void lum_laser_session_note_owner(lum_laser_session *session, bool is_owned)
{
    session->laser.is_owned = session->is_owner || is_owned;
}

lum_laser_want lum_laser_session_want_of(const char *text)
{
    lum_laser_want want = LUM_WANT_LOOK;
    for (; *text != '\0'; text++) {
        want = *text == 'u' ? LUM_WANT_ON : *text == 'd' ? LUM_WANT_OFF : want;
    }
    return want;
}

lum_result lum_laser_session_command(lum_laser_session *session,
                                     lum_sensor *sensor, const char *text,
                                     int64_t now_ns)
{
    const lum_laser_want want = lum_laser_session_want_of(text);
    const lum_laser_request request = want == LUM_WANT_ON ? LUM_LASER_ASK_ON
                                      : want == LUM_WANT_OFF
                                          ? LUM_LASER_ASK_OFF
                                          : LUM_LASER_ASK_OTHER;
    const lum_result result = lum_sensor_command(sensor, text);
    if (result != LUM_OK) {
        return result;
    }
    if (want != LUM_WANT_LOOK) {
        lum_laser_session_want(session, want, now_ns);
    }
    lum_laser_rules_sent(&session->laser, request, now_ns);
    return result;
}

void lum_laser_session_lend(lum_laser_session *session, int64_t now_ns)
{
    lum_laser_rules_sent(&session->laser, LUM_LASER_ASK_OTHER, now_ns);
}

/* --- What the sensor says --- */

static void tell_text(lum_laser_session *k, const lum_tlv *tlv)
{
    static const char more[] = " (further ones are not shown)";
    lum_news news = make(k, LUM_NEWS_TEXT, 0);
    size_t len = 0;
    k->texts++;
    for (; len < tlv->length && len < sizeof news.text - sizeof more; len++) {
        const uint8_t byte = tlv->value[len];
        news.text[len] = (char)(byte >= ' ' && byte <= '~' ? byte : '?');
    }
    if (k->texts == LUM_LASER_SESSION_TEXTS) {
        memcpy(news.text + len, more, sizeof more);
    }
    tell(k, news);
}

/* Half of the room stays for other news. */
static void take_texts(lum_laser_session *k, lum_tlv_reader tlvs)
{
    const uint16_t debug = k->layout.profile.tlv[LUM_TLV_DEBUG];
    lum_tlv tlv;
    while (k->texts < LUM_LASER_SESSION_TEXTS &&
           k->count < LUM_LASER_SESSION_NEWS / 2u &&
           lum_tlv_next(&tlvs, &tlv) == LUM_OK) {
        if (tlv.type == debug) {
            tell_text(k, &tlv);
        }
    }
}

/* Without an owner the missing heartbeats are no hazard. */
static void take_hazards(lum_laser_session *k, uint16_t status, int64_t now_ns)
{
    const bool begins = now_ns - k->contact.began_ns < BEGINNING_NS;
    const unsigned known = status & LUM_LASER_HAZARDS;
    const unsigned hazards =
        begins || !k->laser.is_owned ? lum_laser_rules_hazards(status) : known;
    tell(k, make_hazard(k, hazards & ~(unsigned)k->hazards));
    k->hazards = (uint16_t)(hazards | (k->hazards & known));
}

/* The first packet tells most often: nearly all that comes is data. */
static void take_datagrams(lum_laser_session *k, const lum_sensor_event *event,
                           int64_t now_ns)
{
    for (size_t i = 0; i < event->datagram_count; i++) {
        const lum_received *d = &event->datagrams[i];
        lum_group group;
        const lum_packet_kind kind =
            lum_packet_decode(&k->layout, d->bytes, d->len, &group);
        if (kind == LUM_PACKET_DATA) {
            const int64_t ns = now_ns - k->contact.data_ns;
            tell(k, make(k, lum_contact_note_data(&k->contact, now_ns), ns));
            tell(k, make(k,
                         lum_contact_note_clock(&k->contact, &k->layout.profile,
                                                &group, now_ns, d->utc_ns),
                         0));
            return;
        }
        k->contact.has_unknown |= kind >= LUM_PACKET_UNKNOWN_TYPE;
    }
}

void lum_laser_session_take(lum_laser_session *session,
                            const lum_sensor_event *event, int64_t now_ns)
{
    lum_contact_pass(&session->contact, now_ns);
    if (event->kind == LUM_SENSOR_DATAGRAMS) {
        take_datagrams(session, event, now_ns);
    }
    if (event->kind == LUM_SENSOR_ANSWER || event->kind == LUM_SENSOR_ALERT) {
        take_texts(session, event->tlvs);
    }
    if (event->kind == LUM_SENSOR_ANSWER) {
        session->told_off = false;
        if (event->has_status) {
            take_hazards(session, event->status, now_ns);
        }
    } else if (event->kind == LUM_SENSOR_NO_ANSWER &&
               session->laser.request == LUM_LASER_ASK_OFF &&
               !session->told_off) { /* it is sent repeatedly */
        session->told_off = true;
        tell(session, make(session, LUM_NEWS_OFF_UNANSWERED, 0));
    } else if (event->kind == LUM_SENSOR_LINK && !event->is_up) {
        session->link = event->error;
    }
    const lum_news_kind contact =
        lum_contact_take(&session->contact, event, now_ns);
    const lum_news_kind laser =
        lum_laser_rules_take(&session->laser, event, now_ns);
    tell_laser(session, laser, now_ns);
    if (contact != LUM_NEWS_NO_STATUS || laser != LUM_NEWS_LASER_UNSEEN) {
        tell(session, make(session, contact, 0));
    }
}

/* --- Sending --- */

/* Sends what is due, if the session is idle; if it cannot be sent, the next
 * call tries again. Off does not wait, nor does what ends "on": the present
 * request is given up, because it would be repeated. */
static void ask(lum_laser_session *k, lum_sensor *sensor, int64_t now_ns)
{
    const lum_laser_request request = lum_laser_rules_next(&k->laser);
    if (now_ns < k->laser.next_ns) {
        return;
    }
    if (request != k->laser.request && (request == LUM_LASER_ASK_OFF ||
                                        k->laser.request == LUM_LASER_ASK_ON)) {
        lum_sensor_give_up(sensor);
    }
    const char *text = request == LUM_LASER_ASK_ON ? "u" : "d";
    const lum_result result = request == LUM_LASER_ASK_LOOK
                                  ? lum_sensor_request(sensor, NULL, 0)
                                  : lum_sensor_command(sensor, text);
    if (result == LUM_OK) {
        lum_laser_rules_sent(&k->laser, request, now_ns);
    }
}

void lum_laser_session_serve(lum_laser_session *session, lum_sensor *sensor,
                             int64_t now_ns)
{
    lum_contact *contact = &session->contact;
    lum_sensor_counters counters = {.struct_size = sizeof counters};
    const bool is_moved = lum_sensor_moved_to(sensor, &contact->to);
    (void)lum_sensor_count(sensor, &counters);
    lum_contact_pass(contact, now_ns);
    tell_laser(session, lum_laser_rules_tick(&session->laser, now_ns), now_ns);
    tell(session, make(session, lum_contact_move(contact, is_moved), 0));
    const lum_news_kind kind = lum_contact_tick(
        contact, session->is_owner, counters.answers_dropped, now_ns);
    tell(session, make(session, kind, now_ns - contact->data_ns));
    ask(session, sensor, now_ns);
}

/* --- What holds now --- */

/* Why the laser is down; kind 0: nothing shows that it is. */
static lum_news stand_laser(const lum_laser_session *k)
{
    const lum_laser_rules *laser = &k->laser;
    const bool is_off = laser->has_status && !lum_laser_is_on(laser->status);
    if (laser->state != LUM_LASER_LEFT) {
        const bool is_ours = laser->state != LUM_LASER_UNTOUCHED;
        lum_news news =
            make(k, is_off && !is_ours ? LUM_NEWS_LASER_IS_OFF : 0, 0);
        news.status = laser->status;
        return news;
    }
    lum_news news = k->left;
    if (news.kind == LUM_NEWS_LASER_LEFT) {
        news.was_away = laser->off_due || laser->off_unseen;
    }
    return news;
}

size_t lum_laser_session_standing(const lum_laser_session *session,
                                  int64_t now_ns, lum_news *out, size_t room)
{
    const size_t size = out->struct_size;
    const lum_laser_rules *laser = &session->laser;
    const lum_news_kind kind = lum_contact_standing(&session->contact, now_ns);
    const int64_t away_ns = now_ns - session->contact.data_ns;
    lum_news all[3] = {
        make(session, kind, away_ns - away_ns % INT64_C(1000000000))};
    size_t count = 0;
    if (session->contact.answers.is_unheard) { /* no more than that is known */
        const bool is_due = laser->off_due || laser->off_unseen;
        all[1] = make(session, is_due ? LUM_NEWS_OFF_UNANSWERED : 0, 0);
    } else if (kind != LUM_NEWS_SILENT && kind != LUM_NEWS_DATA_STOPPED) {
        all[1] = stand_laser(session);
        all[2] = make_hazard(session, laser->status & LUM_LASER_HAZARDS);
    }
    for (size_t i = 0; i < 3; i++) {
        lum_news *to = (void *)((unsigned char *)out + count * size);
        if (all[i].kind != 0 && count < room) {
            to->struct_size = size;
            (void)lum_sized_fill(to, &all[i], sizeof all[i]);
            count++;
        }
    }
    return count;
}

bool lum_laser_session_darkness(const lum_laser_session *session, lum_news *out)
{
    const lum_laser_rules *laser = &session->laser;
    const unsigned hazards = lum_laser_rules_hazards(laser->status);
    const lum_news news =
        hazards != 0 ? make_hazard(session, hazards) : stand_laser(session);
    return laser->has_status && !lum_laser_is_on(laser->status) &&
           news.kind != 0 && lum_sized_fill(out, &news, sizeof news);
}

lum_result lum_laser_session_look(const lum_laser_session *session,
                                  lum_laser_session_view *out)
{
    const lum_contact *c = &session->contact;
    const lum_laser_session_view view = {
        .struct_size = sizeof view,
        .laser = session->laser.state,
        .is_off_due = session->laser.off_due || session->laser.off_unseen,
        .has_status = session->laser.has_status,
        .status = session->laser.status,
        .has_answered = c->answers.has_come,
        .is_unheard = c->answers.is_unheard,
        .has_data = c->has_data,
        .has_unknown = c->has_unknown,
        .is_silent = c->quiet != 0,
        .first_data_ns = c->first_data_ns,
        .data_ns = c->data_ns};
    return lum_sized_fill(out, &view, sizeof view) ? LUM_OK : LUM_E_VALUE;
}

/* --- The end --- */

static lum_news_kind name_end(lum_laser_off off, uint16_t status)
{
    static const lum_news_kind kinds[] = {
        [LUM_LASER_OFF_SEEN] = LUM_NEWS_ENDED_OFF,
        [LUM_LASER_OFF_UNKNOWN] = LUM_NEWS_ENDED_UNKNOWN,
        [LUM_LASER_OFF_REFUSED] = LUM_NEWS_ENDED_ON,
        [LUM_LASER_OFF_UNSEEN] = LUM_NEWS_ENDED_UNSEEN};
    return off == LUM_LASER_OFF_REFUSED && lum_laser_is_down(status)
               ? LUM_NEWS_ENDED_IN_EFFECT
               : kinds[off];
}

static void tell_end(lum_laser_session *k, lum_laser_off off,
                     uint32_t goes_on_ms)
{
    const bool is_over = off == LUM_LASER_OFF_SEEN ||
                         off == LUM_LASER_OFF_UNSEEN || goes_on_ms == 0;
    lum_news news =
        make(k, is_over ? name_end(off, k->laser.status) : LUM_NEWS_OFF_GOES_ON,
             NS_PER_MS * (int64_t)goes_on_ms);
    news.status = k->laser.status;
    news.tries = off == LUM_LASER_OFF_REFUSED ? 1u : 0u;
    tell(k, news);
}

lum_laser_off lum_laser_session_end(lum_laser_session *session,
                                    lum_sensor *sensor, uint32_t ms,
                                    uint32_t goes_on_ms,
                                    const lum_cancel *cancel)
{
    lum_laser_rules *laser = &session->laser;
    lum_contact *contact = &session->contact;
    lum_laser_off off = LUM_LASER_OFF_UNKNOWN;
    lum_laser_session_want(session, LUM_WANT_OFF, lum_time_monotonic_ns());
    if (sensor != NULL) {
        off = lum_sensor_laser_off(sensor, ms, cancel, &laser->status);
        contact->is_moved = lum_sensor_moved_to(sensor, &contact->to);
    }
    laser->has_status |=
        off == LUM_LASER_OFF_SEEN || off == LUM_LASER_OFF_REFUSED;
    laser->off_due &= off != LUM_LASER_OFF_SEEN;
    tell_end(session, off, goes_on_ms);
    return off;
}
