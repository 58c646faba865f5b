#include "laser_keeper.h"

#include "lum/laser.h"

#define SECOND_NS INT64_C(1000000000)

#define POLL_NS SECOND_NS

/* A sensor that has just got its first heartbeat may still refuse the laser
 * because of the timeout. */
#define AGAIN_NS     (SECOND_NS / 5)
#define ATTEMPTS_MAX 20u
#define GIVE_UP_NS   (5 * SECOND_NS)

/* A session that was delayed for this long does not send laser on: its
 * heartbeats have ended, and nobody may expect the laser any more. */
#define HELD_UP_NS (LUM_SENSOR_STALE_MS * INT64_C(1000000))

void laser_keeper_begin(struct laser_keeper *keeper, enum laser_fate fate,
                        int64_t now_ns)
{
    *keeper = (struct laser_keeper){.fate = fate,
                                    .off_due = fate == LASER_DOWN,
                                    .began_ns = now_ns,
                                    .tick_ns = now_ns,
                                    .next_ns = now_ns};
}

unsigned laser_keeper_hazards(uint16_t status)
{
    return status & LUM_LASER_HAZARDS & ~(unsigned)LUM_LASER_HEARTBEAT_TIMEOUT;
}

/* Whether a laser that is down comes up by itself when a hazard ends. */
static bool may_come_up(uint16_t status)
{
    return (status & (LUM_LASER_TLV_CMD_ON | LUM_LASER_TLV_CMD_OFF)) !=
           LUM_LASER_TLV_CMD_OFF;
}

/* The laser is down, or cannot be trusted. */
static enum laser_news fall(struct laser_keeper *k, uint16_t status,
                            int64_t now_ns, enum laser_news why)
{
    k->fate = LASER_DOWN;
    k->fell = status;
    k->off_due = may_come_up(status);
    if (k->off_due) {
        k->next_ns = now_ns;
    }
    return why;
}

/* Another program may switch on a laser that we leave alone; if a hazard
 * refuses that, its command must not stay in effect either. */
static enum laser_news follow_down(struct laser_keeper *k, int64_t now_ns)
{
    const bool is_down = lum_laser_is_down(k->status);
    if (!is_down && !k->off_due && !k->off_unseen) {
        k->fate = LASER_UP;
        return LASER_CAME_UP;
    }
    if (is_down ? laser_keeper_hazards(k->status) != 0 && may_come_up(k->status)
                : k->off_unseen) {
        k->off_due = true;
        k->next_ns = now_ns;
    }
    k->off_unseen = k->off_unseen && !is_down;
    return LASER_NO_NEWS;
}

/* The answer to "on". */
static enum laser_news judge_on(struct laser_keeper *k, int64_t now_ns)
{
    if (!lum_laser_is_down(k->status)) {
        k->fate = LASER_UP;
        return LASER_NO_NEWS;
    }
    if (laser_keeper_hazards(k->status) == 0 && k->attempts < ATTEMPTS_MAX) {
        k->next_ns = now_ns + AGAIN_NS;
        return LASER_NO_NEWS;
    }
    return fall(k, k->status, now_ns, LASER_STAYS_DOWN);
}

/* The answer to "off"; without a status it is believed until one comes. */
static void judge_off(struct laser_keeper *k, bool has_status, int64_t now_ns)
{
    k->off_unseen = !has_status;
    k->off_due = has_status && (!lum_laser_is_down(k->status) ||
                                (k->status & LUM_LASER_TLV_CMD_ON) != 0);
    if (k->off_due) {
        k->next_ns = now_ns + AGAIN_NS;
    }
}

static enum laser_news judge_status(struct laser_keeper *k, int64_t now_ns)
{
    if (k->fate == LASER_UP && lum_laser_is_down(k->status)) {
        return fall(k, k->status, now_ns, LASER_WENT_OFF);
    }
    return k->fate == LASER_DOWN ? follow_down(k, now_ns) : LASER_NO_NEWS;
}

static enum laser_news take_answer(struct laser_keeper *k,
                                   const lum_sensor_event *event,
                                   int64_t now_ns)
{
    const enum laser_request request = k->request;
    k->request = LASER_ASK_LOOK;
    if (event->has_status) {
        k->has_status = true;
        k->status = event->status;
    }
    if (request == LASER_ASK_OFF) {
        judge_off(k, event->has_status, now_ns);
        return LASER_NO_NEWS;
    }
    if (request == LASER_ASK_ON && k->fate == LASER_ASKED) {
        return event->has_status ? judge_on(k, now_ns)
                                 : fall(k, 0, now_ns, LASER_UNSEEN);
    }
    return event->has_status ? judge_status(k, now_ns) : LASER_NO_NEWS;
}

/* An alert may be older than the known status, so the sensor is asked, and the
 * alert's command bits are not used. A hazard counts at once: it may be over
 * before the answer. An alert never makes us switch the laser on sooner. */
static enum laser_news take_alert(struct laser_keeper *k,
                                  const lum_sensor_event *event, int64_t now_ns)
{
    if (k->fate == LASER_ASKED) {
        return LASER_NO_NEWS;
    }
    k->next_ns = now_ns;
    if (event->has_status && k->fate == LASER_UP &&
        laser_keeper_hazards(event->status) != 0) {
        (void)fall(k, event->status, now_ns, LASER_WENT_OFF);
        k->off_due = true;
        return LASER_WENT_OFF;
    }
    return LASER_NO_NEWS;
}

/* "On" is sent again until it is given up, because it may have been received;
 * "off" is sent repeatedly. */
static enum laser_news take_no_answer(struct laser_keeper *k, int64_t now_ns)
{
    const enum laser_request request = k->request;
    k->request = LASER_ASK_LOOK;
    if (request == LASER_ASK_ON && k->fate == LASER_ASKED &&
        now_ns - k->began_ns >= GIVE_UP_NS) {
        return fall(k, 0, now_ns, LASER_UNANSWERED);
    }
    return LASER_NO_NEWS;
}

enum laser_news laser_keeper_take(struct laser_keeper *keeper,
                                  const lum_sensor_event *event, int64_t now_ns)
{
    switch (event->kind) {
    case LUM_SENSOR_ANSWER:
        return take_answer(keeper, event, now_ns);
    case LUM_SENSOR_ALERT:
        return take_alert(keeper, event, now_ns);
    case LUM_SENSOR_NO_ANSWER:
        return take_no_answer(keeper, now_ns);
    case LUM_SENSOR_IDLE:
    case LUM_SENSOR_CANCELLED:
    case LUM_SENSOR_DATAGRAMS:
    case LUM_SENSOR_TIME:
    case LUM_SENSOR_LINK:
    case LUM_SENSOR_FAILED:
        break;
    }
    return LASER_NO_NEWS;
}

enum laser_news laser_keeper_tick(struct laser_keeper *keeper, int64_t now_ns)
{
    const int64_t since_ns = now_ns - keeper->tick_ns;
    keeper->tick_ns = now_ns;
    if (keeper->fate == LASER_ASKED && since_ns >= HELD_UP_NS) {
        keeper->held_up_ns = since_ns;
        return fall(keeper, 0, now_ns, LASER_HELD_UP);
    }
    return LASER_NO_NEWS;
}

enum laser_request laser_keeper_next(const struct laser_keeper *keeper)
{
    if (keeper->fate == LASER_ASKED) {
        return LASER_ASK_ON;
    }
    return keeper->off_due ? LASER_ASK_OFF : LASER_ASK_LOOK;
}

void laser_keeper_sent(struct laser_keeper *keeper, enum laser_request request,
                       int64_t now_ns)
{
    keeper->request = request;
    keeper->attempts += request == LASER_ASK_ON ? 1u : 0u;
    keeper->next_ns = now_ns + POLL_NS;
}

void laser_keeper_ask(struct laser_keeper *keeper, lum_sensor *sensor,
                      int64_t now_ns)
{
    const enum laser_request request = laser_keeper_next(keeper);
    if (now_ns < keeper->next_ns) {
        return;
    }
    if (request == LASER_ASK_OFF && keeper->request != LASER_ASK_OFF) {
        lum_sensor_give_up(sensor);
    }
    if (lum_sensor_is_waiting(sensor)) {
        return;
    }
    const lum_result r =
        request == LASER_ASK_LOOK
            ? lum_sensor_request(sensor, NULL, 0)
            : lum_sensor_command(sensor, request == LASER_ASK_ON ? "u" : "d");
    if (r == LUM_OK) {
        laser_keeper_sent(keeper, request, now_ns);
    }
}
