/* What a sensor that answers says of itself: whether its clock runs as this
 * host's does, and which hazard of its status to remove first. */
#include "doctor.h"

#include "../status_report.h"

#include "lum/laser.h"

#include <limits.h>

#define RATE_NS       INT64_C(1000000000)
#define DATA_CLOCK_US INT64_C(250000)
#define DRIFT_MAX_PPB INT64_C(1000000)

/* --- Check: clock --- */

/* Microseconds by which the data's clock is behind the sensor's clock of the
 * timestamps. */
static int64_t data_clock_lag(const struct doctor *d,
                              const lum_clock_estimate *e)
{
    const int64_t sensor_us = (d->stream.clock_ns - e->offset_ns) / 1000;
    return (int32_t)((uint32_t)sensor_us - d->stream.clock_us);
}

static void look_at_data_clock(const struct doctor *d,
                               const lum_clock_estimate *e,
                               struct doctor_finding *out)
{
    if (!d->stream.has_clock || d->lacks[DOCTOR_NEEDS_DATA] != NULL) {
        return;
    }
    const int64_t lag = data_clock_lag(d, e);
    const int64_t allowed = DATA_CLOCK_US + e->error_ns / 1000;
    if (lag < -allowed || lag > allowed) {
        doctor_wrong(
            out,
            "the clock in the data is %.3f s away from the clock in the "
            "timestamps: the profile's timestamp may have a wrong offset",
            1e-6 * (double)lag);
        doctor_fix(out,
                   "%s --profile FILE doctor    # group.timestamp corrected in "
                   "it",
                   session_ctl(d->ctl, d->sensor).text);
    } else {
        doctor_add(out, "; the data has the same clock, %.1f ms behind",
                   1e-3 * (double)lag);
    }
}

/* Billionths by which this host's clock runs faster than the sensor's, and the
 * error. The estimate of the offset assumes good clocks; this does not. */
struct rate {
    int64_t ppb;
    int64_t error_ppb;
};

static struct rate rate_of(const struct doctor_session *s)
{
    const int64_t host_ns = s->late.sent_ns - s->early.sent_ns;
    const int64_t sensor_ns =
        1000 * (int64_t)(s->late.clock_us - s->early.clock_us);
    const int64_t error_ns =
        doctor_round_trip_ns(&s->early) + doctor_round_trip_ns(&s->late) + 1000;
    const double scale = 1e9 / (double)(host_ns > 0 ? host_ns : 1);
    return (struct rate){(int64_t)((double)(host_ns - sensor_ns) * scale),
                         (int64_t)((double)error_ns * scale)};
}

/* Asks for timestamps at a sufficient distance from the early ones. No
 * heartbeats are sent, so that no data is under way at the same time. */
static void wait_for_rate(struct doctor *d)
{
    lum_error error = {""};
    if (d->session.handle != NULL &&
        doctor_open(d, false, &error) == LUM_NET_OK &&
        doctor_rest_until(d, d->session.early.sent_ns + RATE_NS)) {
        doctor_ask_times(d);
    }
}

static void look_at_rate(const struct doctor_session *s,
                         struct doctor_finding *out)
{
    const struct rate rate = rate_of(s);
    const int64_t drift = rate.ppb < 0 ? -rate.ppb : rate.ppb;
    if (s->late.sent_ns - s->early.sent_ns < RATE_NS / 2) {
        return;
    }
    if (drift - rate.error_ppb > DRIFT_MAX_PPB) {
        doctor_wrong(out,
                     "the sensor's clock runs %.0f ppm %s than this host's; "
                     "1000 are allowed: one of the two is wrong",
                     1e-3 * (double)drift, rate.ppb > 0 ? "slower" : "faster");
        doctor_fix(out, "timedatectl timesync-status    # is this host's "
                        "clock in order? Then the sensor's is not");
    } else {
        doctor_add(out, ", and runs at this host's rate within %.0f ppm%s",
                   1e-3 * (double)(drift + rate.error_ppb),
                   rate.error_ppb > DRIFT_MAX_PPB
                       ? ", as far as such slow answers show"
                       : "");
    }
}

void doctor_check_clock(struct doctor *d, struct doctor_finding *out)
{
    lum_clock_estimate e;
    wait_for_rate(d);
    if (lum_clock_sync_estimate(&d->session.clock, &e) != LUM_OK) {
        doctor_unseen(out, "not looked at: no timestamps");
        return;
    }
    if (e.resets > 0) {
        doctor_wrong(
            out,
            "the sensor's clock began again during the check: it restarts");
        doctor_fix(out,
                   "%s time --watch    # look at its power supply until that "
                   "stops",
                   session_ctl(d->ctl, d->sensor).text);
        return;
    }
    doctor_fine(out, "the sensor's clock stands at %.6f s, known to %.3f ms",
                1e-6 * (double)(uint32_t)e.clock_us, 1e-6 * (double)e.error_ns);
    look_at_rate(&d->session, out);
    if (out->result == DOCTOR_FINE) {
        look_at_data_clock(d, &e, out);
    }
}

/* --- Check: status --- */

/* Of what is to be done about hazards, the first. */
static struct report_bit first_fix(uint16_t status)
{
    struct report_bit first = {"", UINT_MAX, ""};
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        const struct report_bit r = report_bit(bit);
        if (((unsigned)status >> bit & 1u) != 0 && r.rank != 0 &&
            r.rank < first.rank) {
            first = r;
        }
    }
    return first;
}

static void say_hazard(struct doctor *d, bool is_owned,
                       struct doctor_finding *out)
{
    d->has_hazard = true;
    doctor_wrong(out, "hazard, 0x%04x, %s", (unsigned)d->session.status,
                 report_line(d->session.status, is_owned).text);
    doctor_fix(out, "%s", first_fix(d->session.status).fix);
}

void doctor_check_status(struct doctor *d, struct doctor_finding *out)
{
    if (!d->session.has_status && !doctor_ask_status(d)) {
        doctor_wrong(out, "the sensor answers timestamps, but no status poll");
        return;
    }
    if (!d->session.has_status) {
        doctor_note(out,
                    "the sensor's answers have no status: tlv.status (%u) of "
                    "the profile may be another number",
                    (unsigned)d->ctl->layout.profile.tlv[LUM_TLV_STATUS]);
        return;
    }
    /* A session of the doctor's own begins after the status was asked for. */
    const bool is_owned = d->session.handle == NULL &&
                          session_is_owned(d->ctl, d->session.status);
    if (report_has_hazard(d->session.status, is_owned)) {
        say_hazard(d, is_owned, out);
        return;
    }
    doctor_fine(out, "no hazard, 0x%04x, %s", (unsigned)d->session.status,
                report_line(d->session.status, is_owned).text);
}
