/* The state of a framer's sensors as bytes, so that reading goes on in the
 * middle of a capture; written and read by the same functions. */
#include "framer_state.h"

#include "clock_line.h"
#include "framer_internal.h"

#include <string.h>

/* --- Options and clocks --- */

bool lum_framer_gives(const lum_framer *framer, size_t sensor)
{
    return lum_framer_makes_frames(framer) &&
           (!framer->choice.only_first || sensor == 0);
}

bool lum_framer_is_skipping(const lum_framer *framer)
{
    return framer->has_from;
}

lum_demux *lum_framer_sensors(lum_framer *framer)
{
    return framer->demux;
}

void lum_framer_restart(lum_framer *framer)
{
    lum_line_threads_settle(framer->threads);
    lum_draft_drop(&framer->out);
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        lum_sensor_stream_free(framer->sensors[i]);
        framer->sensors[i] = NULL;
    }
    lum_demux_restart(framer->demux);
    lum_raw_watch_restart(framer->watch);
    framer->in_hand = IN_HAND_NOTHING;
    framer->is_flushing = false;
    framer->has_from = false;
    lum_line_points_forget(&framer->line);
}

void lum_framer_pack_options(const lum_framer *framer, lum_pack *pack)
{
    lum_framer_choice c = framer->choice;
    uint32_t eyes = c.eyes;
    lum_demux_pack_options(framer->demux, pack);
    lum_pack_u32(pack, &eyes);
    lum_pack_bool(pack, &c.has_range);
    lum_pack_i64(pack, &c.frame_first);
    lum_pack_i64(pack, &c.frame_last);
    lum_pack_bool(pack, &c.drop_incomplete);
    lum_pack_bool(pack, &c.only_first);
}

/* Of a rig also which member it is: no data has shown it yet. */
static void pack_clock(lum_framer *framer, size_t i, lum_pack *pack)
{
    uint32_t way =
        framer->sensors[i] != NULL ? (uint32_t)framer->sensors[i]->way : 0;
    if (framer->member_count != 0) {
        lum_pack_u32(pack, &way);
    }
    if (!lum_pack_check(pack, way == 0 || way < framer->member_count)) {
        return;
    }
    const lum_sensor_stream *s = lum_sensor_stream_at(framer, i, way);
    if (s == NULL) {
        pack->has_failed = true;
    } else if (s->clock != NULL) {
        (void)lum_clock_fit_pack(s->clock, pack);
    }
}

/* Before the first record only sensors are known whose clock was given. */
bool lum_framer_pack_clocks(lum_framer *framer, lum_pack *pack)
{
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX && !pack->has_failed; i++) {
        bool is_known = framer->sensors[i] != NULL;
        lum_pack_bool(pack, &is_known);
        if (is_known) {
            pack_clock(framer, i, pack);
        }
    }
    return !pack->has_failed;
}

/* --- One sensor --- */

/* Numbers go round 32 bits, and times are those of a capture. */
static void pack_number(lum_pack *p, int64_t *number)
{
    lum_pack_i64(p, number);
    (void)lum_pack_check(p, *number >= 0 && *number <= UINT32_MAX);
}

static void pack_time(lum_pack *p, int64_t *time_ns)
{
    lum_pack_i64(p, time_ns);
    (void)lum_pack_check(p, *time_ns >= -(INT64_C(1) << 62) &&
                                *time_ns < INT64_C(1) << 62);
}

static void pack_pace(lum_pack *p, lum_pace *pace)
{
    lum_pack_bool(p, &pace->has_frame);
    lum_pack_bool(p, &pace->has_begin);
    pack_number(p, &pace->frame);
    pack_number(p, &pace->first);
    pack_time(p, &pace->first_ns);
    pack_time(p, &pace->last_ns);
}

/* Frames under way are there again, but empty. */
static void pack_drafts(lum_framer *f, lum_sensor_stream *s, lum_pack *p)
{
    for (size_t i = 0; i < LUM_DRAFTS_MAX && !p->has_failed; i++) {
        lum_draft *d = &s->drafts.draft[i];
        bool is_used = d->is_used;
        int64_t number = d->number;
        lum_pack_bool(p, &is_used);
        if (is_used) {
            pack_number(p, &number);
        }
        if (is_used && lum_pack_is_reading(p) && !p->has_failed &&
            !lum_sensor_stream_begin(f, s, d, number, false)) {
            p->has_failed = true;
        }
    }
}

static void pack_own(lum_sensor_stream *s, lum_pack *p)
{
    lum_under_way_state *u = &s->under_way;
    lum_pack_bool(p, &s->has_joined);
    pack_number(p, &s->joined);
    lum_pack_bool(p, &s->has_done);
    pack_number(p, &s->done);
    lum_pack_bool(p, &s->has_range);
    pack_number(p, &s->first);
    pack_number(p, &s->last);
    lum_pack_u64(p, &s->lines_late);
    lum_pack_bool(p, &u->has_joined[LUM_EYE_BLUE]);
    lum_pack_bool(p, &u->has_joined[LUM_EYE_GREEN]);
    pack_pace(p, &s->pace);
    lum_pause_pack(&s->pause, p);
}

bool lum_framer_pack_sensor(lum_framer *framer, size_t sensor, uint32_t from,
                            lum_pack *pack)
{
    lum_sensor_stream *s =
        lum_pack_is_reading(pack)
            ? lum_sensor_stream_at(framer, sensor,
                                   lum_sensor_stream_way(framer, sensor))
            : framer->sensors[sensor];
    if (s == NULL) {
        pack->has_failed = true;
        return false;
    }
    if (lum_demux_pack_sensor(framer->demux, sensor, from, pack)) {
        pack_own(s, pack);
        pack_drafts(framer, s, pack);
    }
    if (s->clock != NULL && !pack->has_failed) {
        (void)lum_clock_fit_pack(s->clock, pack);
    }
    return !pack->has_failed;
}

/* --- Lines of the frame before --- */

void lum_framer_get_lines(const lum_framer *framer, size_t sensor,
                          uint32_t out[LUM_EYES])
{
    const lum_sensor_stream *s = framer->sensors[sensor];
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        out[eye] = s != NULL ? s->before.lines[eye] : 0;
    }
}

void lum_framer_set_lines(lum_framer *framer, size_t sensor, int64_t frame,
                          const uint32_t lines[LUM_EYES])
{
    lum_sensor_stream *s = framer->sensors[sensor];
    if (s != NULL) {
        s->before.has_next = true;
        s->before.next_from = frame;
        memcpy(s->before.next, lines, sizeof s->before.next);
    }
}
