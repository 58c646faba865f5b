#include "live/laser_rules.h"

#include "lum/laser.h"

#define SECOND_NS INT64_C(1000000000)

#define AGAIN_NS (SECOND_NS / 5)

/* Then heartbeats have ended, and nobody may expect the laser any more. */
#define HELD_UP_NS (LUM_SENSOR_STALE_MS * INT64_C(1000000))

#define NOTHING ((lum_news_kind)0)

void lum_laser_rules_want(lum_laser_rules *rules, lum_laser_state state,
                          bool is_off, int64_t now_ns)
{
    rules->state = state;
    rules->off_due = is_off;
    rules->off_unseen = false;
    rules->attempts = 0;
    rules->sent = 0;
    rules->hit = 0;
    rules->began_ns = now_ns;
    rules->tick_ns = now_ns;
    rules->next_ns = now_ns;
}

unsigned lum_laser_rules_hazards(uint16_t status)
{
    return status & LUM_LASER_HAZARDS & ~(unsigned)LUM_LASER_HEARTBEAT_TIMEOUT;
}

/* Whether a laser that is down comes up by itself when a hazard ends. */
static bool may_come_up(uint16_t status)
{
    return (status & (LUM_LASER_TLV_CMD_ON | LUM_LASER_TLV_CMD_OFF)) !=
           LUM_LASER_TLV_CMD_OFF;
}

/* Whether laser off has not done all that it should. */
static bool is_on_in_effect(uint16_t status)
{
    return !lum_laser_is_down(status) || (status & LUM_LASER_TLV_CMD_ON) != 0;
}

/* The laser is down, or cannot be trusted. */
static lum_news_kind fall(lum_laser_rules *rules, uint16_t status,
                          int64_t now_ns, lum_news_kind why)
{
    rules->state = LUM_LASER_LEFT;
    rules->fell = status;
    rules->off_due = may_come_up(status);
    rules->next_ns = rules->off_due ? now_ns : rules->next_ns;
    return why;
}

/* Another program may switch on a laser that we leave alone; if a hazard
 * refuses that, its command must not stay in effect either. */
static lum_news_kind follow_down(lum_laser_rules *rules, int64_t now_ns)
{
    const bool is_down = lum_laser_is_down(rules->status);
    if (lum_laser_is_on(rules->status) && !rules->off_due &&
        !rules->off_unseen) {
        rules->state = LUM_LASER_UP;
        return LUM_NEWS_LASER_CAME_UP;
    }
    const bool is_held = is_down &&
                         lum_laser_rules_hazards(rules->status) != 0 &&
                         may_come_up(rules->status);
    if (is_held || (rules->off_unseen && is_on_in_effect(rules->status))) {
        rules->off_due = true;
        rules->next_ns = now_ns;
    }
    rules->off_unseen = false;
    return NOTHING;
}

/* The answer to "on". */
static lum_news_kind judge_on(lum_laser_rules *rules, int64_t now_ns)
{
    const uint16_t status = (uint16_t)(rules->status | rules->hit);
    if (lum_laser_is_on(status)) {
        rules->state = LUM_LASER_UP;
        return LUM_NEWS_LASER_UP;
    }
    const unsigned final = rules->is_owned ? lum_laser_rules_hazards(status)
                                           : status & LUM_LASER_HAZARDS;
    if (final == 0 && rules->attempts < rules->attempts_max) {
        rules->next_ns = now_ns + AGAIN_NS;
        return NOTHING;
    }
    return fall(rules, status, now_ns, LUM_NEWS_LASER_REFUSED);
}

/* The answer to "off"; without a status it is believed until one comes. A
 * sensor that shows both commands as in effect may do so for ever: it is told
 * once a second. */
static void judge_off(lum_laser_rules *rules, bool has_status, int64_t now_ns)
{
    rules->off_unseen = !has_status;
    rules->off_due = has_status && is_on_in_effect(rules->status);
    if (rules->off_due && (rules->status & LUM_LASER_TLV_CMD_OFF) == 0) {
        rules->next_ns = now_ns + AGAIN_NS;
    }
}

static lum_news_kind judge_status(lum_laser_rules *rules, int64_t now_ns)
{
    if (rules->state == LUM_LASER_UP && !lum_laser_is_on(rules->status)) {
        return fall(rules, rules->status, now_ns, LUM_NEWS_LASER_FELL);
    }
    return rules->state == LUM_LASER_LEFT ? follow_down(rules, now_ns)
                                          : NOTHING;
}

static lum_news_kind take_answer(lum_laser_rules *rules,
                                 const lum_sensor_event *event, int64_t now_ns)
{
    const lum_laser_request request = rules->request;
    rules->request = LUM_LASER_ASK_LOOK;
    if (event->has_status) {
        rules->has_status = true;
        rules->status = event->status;
    }
    if (request == LUM_LASER_ASK_OFF && rules->state == LUM_LASER_LEFT) {
        judge_off(rules, event->has_status, now_ns);
        return NOTHING;
    }
    if (request == LUM_LASER_ASK_ON && rules->state == LUM_LASER_ASKED) {
        return event->has_status
                   ? judge_on(rules, now_ns)
                   : fall(rules, 0, now_ns, LUM_NEWS_LASER_UNSEEN);
    }
    return event->has_status ? judge_status(rules, now_ns) : NOTHING;
}

/* An alert may be older than the known status, so the sensor is asked, and the
 * alert's command bits are not used. A hazard counts, since it may be over
 * before the answer. An alert never makes us switch the laser on sooner. */
static lum_news_kind take_alert(lum_laser_rules *rules,
                                const lum_sensor_event *event, int64_t now_ns)
{
    const unsigned hazards =
        event->has_status ? lum_laser_rules_hazards(event->status) : 0;
    if (rules->state == LUM_LASER_ASKED) {
        rules->hit |= rules->request == LUM_LASER_ASK_ON ? hazards : 0;
        return NOTHING;
    }
    rules->next_ns = now_ns;
    if (rules->state == LUM_LASER_UP && hazards != 0) {
        (void)fall(rules, event->status, now_ns, LUM_NEWS_LASER_FELL);
        rules->off_due = true;
        return LUM_NEWS_LASER_FELL;
    }
    return NOTHING;
}

/* "On" is sent again until it is given up, because it may have been received;
 * "off" is sent repeatedly. */
static lum_news_kind take_no_answer(lum_laser_rules *rules,
                                    const lum_sensor_event *event,
                                    int64_t now_ns)
{
    const lum_laser_request request = rules->request;
    rules->request = LUM_LASER_ASK_LOOK;
    if (request != LUM_LASER_ASK_ON || rules->state != LUM_LASER_ASKED) {
        return NOTHING;
    }
    rules->sent += event->tries;
    return now_ns - rules->began_ns >= rules->give_up_ns
               ? fall(rules, 0, now_ns, LUM_NEWS_LASER_UNANSWERED)
               : NOTHING;
}

lum_news_kind lum_laser_rules_take(lum_laser_rules *rules,
                                   const lum_sensor_event *event,
                                   int64_t now_ns)
{
    const lum_sensor_event_kind kind = event->kind;
    return kind == LUM_SENSOR_ANSWER      ? take_answer(rules, event, now_ns)
           : kind == LUM_SENSOR_ALERT     ? take_alert(rules, event, now_ns)
           : kind == LUM_SENSOR_NO_ANSWER ? take_no_answer(rules, event, now_ns)
                                          : NOTHING;
}

lum_news_kind lum_laser_rules_tick(lum_laser_rules *rules, int64_t now_ns)
{
    const int64_t since_ns = now_ns - rules->tick_ns;
    rules->tick_ns = now_ns;
    if (rules->state == LUM_LASER_ASKED && since_ns >= HELD_UP_NS) {
        rules->stood_ns = since_ns;
        return fall(rules, 0, now_ns, LUM_NEWS_LASER_HELD_UP);
    }
    return NOTHING;
}

lum_laser_request lum_laser_rules_next(const lum_laser_rules *rules)
{
    if (rules->state == LUM_LASER_ASKED) {
        return LUM_LASER_ASK_ON;
    }
    return rules->off_due ? LUM_LASER_ASK_OFF : LUM_LASER_ASK_LOOK;
}

void lum_laser_rules_sent(lum_laser_rules *rules, lum_laser_request request,
                          int64_t now_ns)
{
    rules->request = request;
    rules->attempts += request == LUM_LASER_ASK_ON ? 1u : 0u;
    if (request != LUM_LASER_ASK_OTHER || !rules->off_due) {
        rules->next_ns = now_ns + SECOND_NS;
    }
}
