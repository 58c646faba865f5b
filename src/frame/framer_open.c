/* A framer made from its options and views, which are checked, and freed. */
#include "framer_internal.h"

#include "base/sized.h"

#include <stdlib.h>
#include <string.h>

/* Frames whose memory is kept: in each view one that is handed out and one that
 * has already begun. */
#define SPARE_MAX (2u * LUM_VIEWS_MAX)

/* --- Views --- */

static int check_view(const lum_view *given, lum_checked_view *out,
                      lum_error *error)
{
    lum_view *v = &out->asked;
    if (lum_sized_take(v, sizeof *v, given, "a view", "lum_view", error) != 0) {
        return -1;
    }
    out->window = v->smooth_window > 1u ? v->smooth_window : 0;
    if ((v->columns & ~LUM_COLUMNS_ALL) != 0) {
        return lum_error_set(error, "view.columns has unknown bits; use a "
                                    "subset of LUM_COLUMNS_ALL");
    }
    if (v->selection.edges < LUM_EDGES_RISING ||
        v->selection.edges > LUM_EDGES_BOTH ||
        v->selection.returns < LUM_RETURNS_ALL ||
        v->selection.returns > LUM_RETURNS_NUMBER) {
        return lum_error_set(error, "view.selection.edges or .returns is out "
                                    "of range; lum_view_default() sets them");
    }
    if (out->window != 0 && lum_smooth_init(&out->smooth, v->smooth_window,
                                            v->smooth_order) != LUM_OK) {
        return lum_error_set(error,
                             "a view cannot smooth with window %lu and order "
                             "%lu; the window is odd and at most %u, the order "
                             "below it and at most %u",
                             (unsigned long)v->smooth_window,
                             (unsigned long)v->smooth_order,
                             LUM_SMOOTH_WINDOW_MAX, LUM_SMOOTH_ORDER_MAX);
    }
    return 0;
}

/* A caller of another version has views of another size. */
static int check_views(const lum_view *given, size_t count,
                       lum_checked_views *out, lum_error *error)
{
    const uint8_t *at = (const uint8_t *)given;
    if (count > LUM_VIEWS_MAX) {
        return lum_error_set(error, "%zu views; at most %u are possible", count,
                             LUM_VIEWS_MAX);
    }
    out->count = count;
    for (size_t i = 0; i < count; i++) {
        size_t size = 0;
        memcpy(&size, at, sizeof size);
        if (size <= sizeof size || size != given->struct_size) {
            return lum_error_set(error, "struct_size of a view is not set; "
                                        "set it to sizeof(lum_view), as "
                                        "lum_view_default() does");
        }
        if (check_view((const lum_view *)(const void *)at, &out->view[i],
                       error) != 0) {
            return -1;
        }
        at += size;
    }
    return 0;
}

int lum_framer_set_views(lum_framer *framer, const lum_view *views,
                         size_t view_count, lum_error *error)
{
    lum_checked_views checked;
    if (check_views(views, view_count, &checked, error) != 0) {
        return -1;
    }
    framer->views = checked;
    lum_line_points_forget(&framer->line);
    return 0;
}

static int set_first_views(lum_framer *f, const lum_framer_options *o,
                           lum_error *error)
{
    lum_view view;
    lum_view_default(&view);
    return o->views != NULL
               ? lum_framer_set_views(f, o->views, o->view_count, error)
               : lum_framer_set_views(f, &view, 1, error);
}

/* --- Other options --- */

static int make_projector(lum_projector *out, const lum_projector *projector,
                          const lum_calibration *given,
                          const lum_layout *layout, lum_error *error)
{
    lum_calibration calibration;
    lum_calibration_fault fault = LUM_CALIBRATION_FINE;
    unsigned eye = 0;
    if (projector != NULL) {
        *out = *projector;
        return 0;
    }
    lum_calibration_default(&calibration);
    if (given != NULL) {
        calibration = *given;
    }
    if (lum_calibration_check(&calibration, &fault, &eye) != LUM_OK ||
        lum_projector_init(out, &calibration, layout) != LUM_OK) {
        return lum_error_set(error,
                             "a value of the calibration is out of range: "
                             "lum_calibration_fault %d, eye %u",
                             (int)fault, eye);
    }
    return 0;
}

/* What its layout tells. */
static void set_clock(lum_member_way *way, const lum_demux_options *demux,
                      const lum_layout *layout)
{
    way->pose = lum_pose_identity();
    way->has_clock = layout->profile.group[LUM_FIELD_TIMESTAMP].bytes != 0;
    lum_pause_init(&way->pause, demux->config.gap_us, &layout->profile);
}

/* --- The sensors of a rig --- */

static int set_member(lum_member_way *way, const lum_framer_options *o,
                      const lum_demux_options *demux, size_t i,
                      lum_error *error)
{
    const lum_rig_member *m = &o->members[i];
    const lum_layout *layout = m->layout != NULL ? m->layout : &demux->layout;
    const bool is_own = m->projector != NULL || m->calibration != NULL;
    lum_error why;
    set_clock(way, demux, layout);
    if (make_projector(&way->projector, is_own ? m->projector : o->projector,
                       is_own ? m->calibration : o->calibration, layout,
                       &why) != 0) {
        return lum_error_set(error, "member %zu: %s", i, why.text);
    }
    if (m->pose == NULL) {
        return 0;
    }
    way->is_placed = true;
    way->pose = *m->pose;
    if (!lum_pose_normalize(&way->pose)) {
        return lum_error_set(error,
                             "member %zu: its pose has a number that is not "
                             "finite, or a quaternion of length 0",
                             i);
    }
    lum_projector_place(&way->projector, &way->pose);
    return 0;
}

static int check_members(const lum_framer_options *o, lum_error *error)
{
    if (o->member_count > LUM_RIG_MEMBERS_MAX) {
        return lum_error_set(error, "%zu members; at most %u are accepted",
                             o->member_count, LUM_RIG_MEMBERS_MAX);
    }
    if (o->member_count != 0 && o->members == NULL) {
        return lum_error_set(error,
                             "members is NULL, but %zu members are announced; "
                             "give members, or 0 as their number",
                             o->member_count);
    }
    if (o->member_count != 0 && (o->only_first || o->has_sensor)) {
        return lum_error_set(error, "members do not go with only_first or "
                                    "has_sensor; give one of them");
    }
    return 0;
}

/* The ways of lines to frames. */
static int set_ways(lum_framer *f, const lum_framer_options *o,
                    const lum_demux_options *demux, lum_error *error)
{
    const size_t count = o->member_count != 0 ? o->member_count : 1u;
    f->member_count = o->member_count;
    f->ways = calloc(count, sizeof *f->ways);
    if (f->ways == NULL) {
        return lum_error_set(error, "out of memory");
    }
    if (o->member_count == 0) {
        set_clock(f->ways, demux, &demux->layout);
        return make_projector(&f->ways->projector, o->projector, o->calibration,
                              &demux->layout, error);
    }
    for (size_t i = 0; i < count; i++) {
        if (set_member(&f->ways[i], o, demux, i, error) != 0) {
            return -1;
        }
    }
    return 0;
}

static void take_members(const lum_framer_options *o,
                         lum_demux_member out[LUM_RIG_MEMBERS_MAX])
{
    for (size_t i = 0; i < o->member_count; i++) {
        out[i] = (lum_demux_member){.address = o->members[i].address,
                                    .interface = o->members[i].interface,
                                    .layout = o->members[i].layout,
                                    .is_left_out = o->members[i].is_left_out};
    }
}

/* --- All of them --- */

static bool is_possible(const lum_assembler_config *c)
{
    return c->open_lines >= 1u && c->open_lines <= LUM_OPEN_LINES_MAX &&
           c->reorder_lines >= 1u && c->reorder_lines <= LUM_REORDER_MAX &&
           c->words_per_line >= 1u && c->words_per_line <= LUM_LINE_WORDS_MAX &&
           c->gap_us < LUM_GAP_US_END;
}

/* All that needs memory. */
static int allocate(lum_framer *f, const lum_demux_options *demux,
                    const lum_framer_options *o, lum_error *error)
{
    const size_t words = demux->config.words_per_line;
    const size_t points_max =
        o->points_max != 0 ? o->points_max : LUM_FRAME_POINTS_MAX;
    if (lum_demux_new(demux, &f->demux, error) != 0) {
        return -1;
    }
    f->pool = lum_frame_pool_new(points_max, SPARE_MAX, o->keeps_raw);
    f->watch = o->keeps_raw ? lum_raw_watch_new(f->demux) : NULL;
    return f->pool != NULL && (!o->keeps_raw || f->watch != NULL) &&
                   lum_column_work_allocate(&f->line.work, words) &&
                   (o->threads < 2u ||
                    lum_line_threads_new(o->threads - 1u, words, &f->threads))
               ? 0
               : lum_error_set(error, "out of memory");
}

static int set_up(lum_framer *f, const lum_framer_options *o, lum_error *error)
{
    lum_demux_member members[LUM_RIG_MEMBERS_MAX] = {{.address = 0}};
    lum_demux_options demux = {.struct_size = sizeof demux,
                               .has_sensor = o->has_sensor,
                               .sensor = o->sensor,
                               .port = o->port,
                               .sensor_interface = o->sensor_interface,
                               .records_are_single = o->records_are_single,
                               .members = members,
                               .member_count = o->member_count};
    if (check_members(o, error) != 0) {
        return -1;
    }
    take_members(o, members);
    lum_layout_default(&demux.layout);
    lum_assembler_config_default(&demux.config);
    demux.layout = o->layout != NULL ? *o->layout : demux.layout;
    demux.config = o->config != NULL ? *o->config : demux.config;
    if (!is_possible(&demux.config)) {
        return lum_error_set(error, "a constant of reassembly is out of range; "
                                    "lum_assembler_config_default() sets them");
    }
    if (o->threads > LUM_FRAMER_THREADS_MAX) {
        return lum_error_set(error, "%lu threads; at most %u are possible",
                             (unsigned long)o->threads, LUM_FRAMER_THREADS_MAX);
    }
    f->choice = (lum_framer_choice){
        .wants = o->wants != 0 ? o->wants : (unsigned)LUM_WANT_FRAMES,
        .eyes = o->eyes != 0 ? o->eyes : (unsigned)LUM_EYES_BOTH,
        .has_range = o->has_range,
        .frame_first = o->frame_first,
        .frame_last = o->frame_last,
        .drop_incomplete = o->drop_incomplete,
        .only_first = o->only_first && !o->has_sensor};
    if (set_first_views(f, o, error) != 0 ||
        set_ways(f, o, &demux, error) != 0) {
        return -1;
    }
    return allocate(f, &demux, o, error);
}

/* --- Making and freeing --- */

int lum_framer_new(const lum_framer_options *options, lum_framer **out,
                   lum_error *error)
{
    lum_framer_options known;
    *out = NULL;
    if (lum_sized_take(&known, sizeof known, options, "the framer's options",
                       "lum_framer_options", error) != 0) {
        return -1;
    }
    lum_framer *f = calloc(1, sizeof *f);
    if (f == NULL) {
        return lum_error_set(error, "out of memory");
    }
    if (set_up(f, &known, error) != 0) {
        lum_framer_free(f);
        return -1;
    }
    *out = f;
    return 0;
}

void lum_framer_free(lum_framer *framer)
{
    if (framer == NULL) {
        return;
    }
    lum_line_threads_settle(framer->threads);
    lum_line_threads_free(framer->threads);
    lum_draft_drop(&framer->out);
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        lum_sensor_stream_free(framer->sensors[i]);
    }
    lum_frame_pool_free(framer->pool);
    lum_demux_free(framer->demux);
    lum_raw_watch_free(framer->watch);
    lum_column_work_release(&framer->line.work);
    free(framer->ways);
    free(framer);
}
