#include "live/contact.h"

#include "core/field.h"
#include "lum/clock.h"

#define NOTHING   ((lum_news_kind)0)
#define SECOND_NS INT64_C(1000000000)

#define SILENCE_NS (LUM_SENSOR_SILENCE_MS * INT64_C(1000000))
#define HELD_UP_NS (LUM_SENSOR_STALE_MS * INT64_C(1000000))

/* A shorter pause of the data is no reason to think of a restart. */
#define PAUSE_NS SECOND_NS

/* For so long after it a pause explains what is seen. */
#define AWAY_NS (5 * SECOND_NS)

/* An answer is asked for each second. */
#define ANSWERS_NS (2 * SECOND_NS)

/* By how much a sensor's clock may differ from this host's: at least that, and
 * a hundredth of the time since. */
#define CLOCK_NS (2 * SECOND_NS)

void lum_contact_begin(lum_contact *c, int64_t now_ns)
{
    *c = (lum_contact){
        .began_ns = now_ns, .passed_ns = now_ns, .data_ns = now_ns};
}

void lum_contact_pass(lum_contact *c, int64_t now_ns)
{
    if (now_ns - c->passed_ns >= HELD_UP_NS) {
        c->pause_ns = now_ns - c->passed_ns;
        c->began_ns = now_ns;
    }
    c->passed_ns = now_ns;
}

/* --- Data --- */

lum_news_kind lum_contact_note_data(lum_contact *c, int64_t now_ns)
{
    const bool is_back = c->quiet != NOTHING;
    if (!c->has_data) {
        c->first_data_ns = now_ns;
    } else if (now_ns - c->data_ns >= PAUSE_NS) {
        c->away_ns = now_ns;
    }
    c->has_data = true;
    c->data_ns = now_ns;
    c->quiet = NOTHING;
    return is_back ? LUM_NEWS_BACK : NOTHING;
}

/* Whether a reading is where the clock should be after a time. */
static bool fits_after(const lum_reading *before, const lum_reading *now,
                       int64_t since_ns, const lum_profile *profile)
{
    const uint64_t unit_ns = profile->clock_unit_ns;
    const uint64_t expected = before->ticks + (uint64_t)since_ns / unit_ns;
    const uint64_t ticks = lum_clock_extend(
        expected, now->ticks, clock_bits(&profile->group[LUM_FIELD_TIMESTAMP]));
    const uint64_t apart =
        ticks > expected ? ticks - expected : expected - ticks;
    return since_ns >= 0 &&
           apart <= (uint64_t)(CLOCK_NS + since_ns / 100) / unit_ns;
}

/* Datagrams may have waited for a program that stood still, and the host's UTC
 * may be set: one of both times is right. */
static bool fits(const lum_reading *before, const lum_reading *now,
                 const lum_profile *profile)
{
    return before->is_there &&
           (fits_after(before, now, now->at_ns - before->at_ns, profile) ||
            fits_after(before, now, now->utc_ns - before->utc_ns, profile));
}

lum_news_kind lum_contact_note_clock(lum_contact *c, const lum_profile *profile,
                                     const lum_group *group, int64_t now_ns,
                                     int64_t utc_ns)
{
    const lum_reading now = {true, group->clock_raw, now_ns, utc_ns};
    const bool goes_on = !c->clock.is_there || fits(&c->clock, &now, profile);
    const bool is_anew = !goes_on && fits(&c->odd, &now, profile);
    if (!goes_on && !is_anew) {
        c->odd = now;
        return NOTHING;
    }
    c->clock = now;
    c->odd.is_there = false;
    c->away_ns = is_anew ? now_ns : c->away_ns; /* it may be too short to see */
    return is_anew ? LUM_NEWS_RESTARTED : NOTHING;
}

bool lum_contact_was_away(const lum_contact *c, int64_t now_ns)
{
    return (c->away_ns != 0 && now_ns - c->away_ns < AWAY_NS) ||
           (c->has_data && now_ns - c->data_ns >= PAUSE_NS);
}

/* Where it answers all the time, it has lost its client rather than its power.
 */
static lum_news_kind name_quiet(const lum_contact *c, int64_t now_ns)
{
    if (!c->has_data || c->is_moved || now_ns - c->data_ns < SILENCE_NS ||
        now_ns - c->began_ns < SILENCE_NS) {
        return NOTHING;
    }
    return !c->answers.is_unheard && now_ns - c->answers.heard_ns < ANSWERS_NS
               ? LUM_NEWS_DATA_STOPPED
               : LUM_NEWS_SILENT;
}

/* --- Answers --- */

static lum_news_kind take_answer(lum_contact_answers *a,
                                 const lum_sensor_event *event, int64_t now_ns)
{
    const bool is_again = a->told_unheard;
    a->has_come = true;
    a->heard_ns = now_ns;
    a->is_unheard = false;
    a->told_unheard = false;
    if (event->has_status) {
        a->told_no_status = false;
    } else if (!a->told_no_status) {
        a->told_no_status = true;
        return LUM_NEWS_NO_STATUS;
    }
    return is_again ? LUM_NEWS_ANSWERS : NOTHING;
}

lum_news_kind lum_contact_take(lum_contact *c, const lum_sensor_event *event,
                               int64_t now_ns)
{
    if (event->kind == LUM_SENSOR_ANSWER) {
        return take_answer(&c->answers, event, now_ns);
    }
    if (event->kind == LUM_SENSOR_LINK) {
        c->link_is_down = !event->is_up;
        return event->is_up ? LUM_NEWS_LINK_UP : LUM_NEWS_LINK_DOWN;
    }
    c->answers.is_unheard |= event->kind == LUM_SENSOR_NO_ANSWER;
    return NOTHING;
}

/* Where data stops or stopped, that is told: the request may be of before. */
static lum_news_kind name_unheard(const lum_contact *c, uint64_t dropped,
                                  int64_t now_ns)
{
    if (dropped > c->answers.dropped) {
        return LUM_NEWS_LATE_ANSWERS;
    }
    if (!c->has_data) {
        return LUM_NEWS_NO_ANSWER;
    }
    return lum_contact_was_away(c, now_ns) ? NOTHING : LUM_NEWS_UNHEARD;
}

/* --- Time --- */

/* That no data has come yet. */
static lum_news_kind name_waiting(const lum_contact *c, int64_t now_ns)
{
    if (c->has_data || now_ns - c->began_ns < SILENCE_NS) {
        return NOTHING;
    }
    return c->has_unknown        ? LUM_NEWS_UNKNOWN_LAYOUT
           : c->answers.has_come ? LUM_NEWS_NO_DATA_YET
                                 : LUM_NEWS_NO_ANSWER_YET;
}

lum_news_kind lum_contact_tick(lum_contact *c, bool is_owner, uint64_t dropped,
                               int64_t now_ns)
{
    const lum_news_kind quiet = name_quiet(c, now_ns);
    if (quiet != NOTHING && c->quiet != quiet) {
        c->quiet = quiet;
        return quiet;
    }
    const lum_news_kind waiting = name_waiting(c, now_ns);
    if (is_owner && waiting != NOTHING && !c->told_waiting) {
        c->told_waiting = true;
        return waiting;
    }
    if (c->answers.is_unheard && !c->answers.told_unheard) {
        const lum_news_kind unheard = name_unheard(c, dropped, now_ns);
        c->answers.told_unheard = unheard != NOTHING;
        return unheard;
    }
    if (!c->answers.is_unheard) {
        c->answers.dropped = dropped;
    }
    return NOTHING;
}

lum_news_kind lum_contact_move(lum_contact *c, bool is_moved)
{
    const bool is_news = is_moved && !c->is_moved;
    c->is_moved = is_moved;
    return is_news ? LUM_NEWS_MOVED : NOTHING;
}

lum_news_kind lum_contact_standing(const lum_contact *c, int64_t now_ns)
{
    if (c->is_moved || c->link_is_down) {
        return c->is_moved ? LUM_NEWS_MOVED : LUM_NEWS_LINK_DOWN;
    }
    const lum_news_kind waiting = name_waiting(c, now_ns);
    const lum_news_kind quiet = name_quiet(c, now_ns);
    if (waiting != NOTHING || quiet != NOTHING) {
        return waiting != NOTHING ? waiting : quiet;
    }
    return c->has_data && c->answers.is_unheard ? LUM_NEWS_UNHEARD : NOTHING;
}
