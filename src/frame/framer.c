#include "lum/frame/framer.h"

#include "base/sized.h"
#include "capture/demux_state.h"
#include "clock_line.h"
#include "column_work.h"
#include "crew.h"
#include "frame_internal.h"
#include "framer_state.h"
#include "pace.h"
#include "pause.h"
#include "under_way.h"

#include "lum/smooth.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* An eye may begin a frame before the other has ended the one before. */
#define DRAFTS_MAX 4u

/* Frames whose memory is kept: in each view one that is handed out and one that
 * has already begun. */
#define SPARE_MAX (2u * LUM_VIEWS_MAX)

/* A view that was checked. */
struct view {
    lum_view asked;
    lum_selection selection;
    uint32_t window; /* of its smoothing; 0: none */
    uint32_t order;
    lum_smooth smooth;
    lum_columns columns;
};

struct views {
    struct view view[LUM_VIEWS_MAX];
    size_t count;
};

/* An unfinished frame, in the views that were requested when it began; if there
 * were none, it has one without points. */
struct draft {
    bool is_used;
    int64_t number;
    struct views views;
    size_t frame_count;
    lum_frame *frames[LUM_VIEWS_MAX];
};

/* What is known of one sensor. */
struct sensor {
    struct draft drafts[DRAFTS_MAX];
    bool has_joined; /* a line came */
    int64_t joined;  /* in this frame */
    bool has_done;   /* a frame was handed out */
    int64_t done;    /* the highest of these */
    bool has_range;  /* a frame was complete */
    int64_t first;
    int64_t last;
    uint32_t lines_max[LUM_EYES]; /* of the frame before */
    uint64_t lines_late;          /* since the frame before */
    size_t usual[LUM_VIEWS_MAX]; /* points that frames of a view have of late */
    bool has_given;              /* lines_given count for this frame */
    int64_t given;
    uint32_t lines_given[LUM_EYES];
    lum_pace pace;
    lum_clock_fit *clock; /* NULL: the layout has none */
    lum_under_way_state under_way;
    lum_pause pause;
    lum_framer_counters counters;
};

/* Work that the next call continues before it takes more records. */
enum in_hand {
    IN_HAND_NOTHING,
    IN_HAND_NEW,  /* a line that is not counted */
    IN_HAND_LINE, /* counted, and in no frame yet */
    IN_HAND_END   /* of a frame */
};

struct lum_framer {
    lum_demux *demux;
    lum_projector projector;
    struct views views;
    unsigned wants;
    unsigned eyes;
    bool has_clock;
    bool has_range;
    int64_t frame_first;
    int64_t frame_last;
    bool drop_incomplete;
    bool has_from; /* frames before one are passed over */
    int64_t from;
    bool only_first;
    bool is_flushing;
    lum_pause pause; /* of a sensor without lines */
    lum_frame_pool *pool;
    lum_crew *crew; /* NULL: the caller makes all points */
    struct sensor *sensors[LUM_DEMUX_SENSORS_MAX];

    enum in_hand in_hand;
    const lum_line *line; /* the latest */
    bool is_wanted;
    uint64_t rising; /* its words that give a point */
    uint64_t falling;
    uint64_t points; /* that the first view selects of it */
    lum_point_losses losses;
    lum_line seen;              /* it, as a view smooths it */
    const struct view *seen_by; /* NULL: by none yet */
    lum_angle angles[LUM_LINE_PIXELS];
    lum_column_work work;
    const struct view *sampled_by; /* NULL: there are no samples of it */
    size_t sample_count;

    int64_t number;   /* of the frame that the last event is about */
    struct draft out; /* what was handed out */
};

/* --- Small things --- */

/* Frames are numbered from 0 again after 2^32 - 1. */
static bool is_before(int64_t a, int64_t b)
{
    return (int32_t)((uint32_t)a - (uint32_t)b) < 0;
}

static void drop_draft(struct draft *draft)
{
    for (size_t i = 0; i < draft->frame_count; i++) {
        lum_frame_release(draft->frames[i]);
        draft->frames[i] = NULL;
    }
    draft->frame_count = 0;
    draft->is_used = false;
}

/* --- Options and views --- */

static int read_view(const lum_view *given, struct view *out, lum_error *error)
{
    lum_view v;
    if (lum_sized_take(&v, sizeof v, given, "a view", "lum_view", error) != 0) {
        return -1;
    }
    out->asked = v;
    out->selection = v.selection;
    out->columns = v.columns;
    out->window = v.smooth_window > 1u ? v.smooth_window : 0;
    out->order = v.smooth_order;
    if ((v.columns & ~LUM_COLUMNS_ALL) != 0) {
        return lum_error_set(error, "a view asks for columns that there are "
                                    "not; LUM_COLUMNS_ALL are all");
    }
    if (v.selection.edges < LUM_EDGES_RISING ||
        v.selection.edges > LUM_EDGES_BOTH ||
        v.selection.returns < LUM_RETURNS_ALL ||
        v.selection.returns > LUM_RETURNS_NUMBER) {
        return lum_error_set(error, "a view selects what there is not; "
                                    "lum_view_default() fills one");
    }
    if (out->window != 0 && lum_smooth_init(&out->smooth, v.smooth_window,
                                            v.smooth_order) != LUM_OK) {
        return lum_error_set(error,
                             "a view cannot smooth with window %lu and order "
                             "%lu; the window is odd and at most %u, the order "
                             "below it and at most %u",
                             (unsigned long)v.smooth_window,
                             (unsigned long)v.smooth_order,
                             LUM_SMOOTH_WINDOW_MAX, LUM_SMOOTH_ORDER_MAX);
    }
    return 0;
}

/* A caller of another version has views of another size. */
static int read_views(const lum_view *given, size_t count, struct views *out,
                      lum_error *error)
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
        if (read_view((const lum_view *)(const void *)at, &out->view[i],
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
    struct views checked;
    if (read_views(views, view_count, &checked, error) != 0) {
        return -1;
    }
    framer->views = checked;
    framer->seen_by = NULL;
    framer->sampled_by = NULL;
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

/* --- Making and freeing --- */

static int set_projector(lum_framer *f, const lum_framer_options *o,
                         const lum_layout *layout, lum_error *error)
{
    lum_calibration calibration;
    lum_calibration_fault fault = LUM_CALIBRATION_FINE;
    unsigned eye = 0;
    if (o->projector != NULL) {
        f->projector = *o->projector;
        return 0;
    }
    lum_calibration_default(&calibration);
    if (o->calibration != NULL) {
        calibration = *o->calibration;
    }
    if (lum_calibration_check(&calibration, &fault, &eye) != LUM_OK ||
        lum_projector_init(&f->projector, &calibration, layout) != LUM_OK) {
        return lum_error_set(error,
                             "a value of the calibration is out of range: "
                             "lum_calibration_fault %d, eye %u",
                             (int)fault, eye);
    }
    return 0;
}

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
    f->pool = lum_frame_pool_new(points_max, SPARE_MAX);
    return f->pool != NULL && lum_column_work_allocate(&f->work, words) &&
                   (o->threads < 2u ||
                    lum_crew_new(o->threads - 1u, words, &f->crew))
               ? 0
               : lum_error_set(error, "out of memory");
}

static int set_up(lum_framer *f, const lum_framer_options *o, lum_error *error)
{
    lum_demux_options demux = {.struct_size = sizeof demux,
                               .has_sensor = o->has_sensor,
                               .sensor = o->sensor,
                               .port = o->port,
                               .sensor_interface = o->sensor_interface,
                               .records_are_single = o->records_are_single};
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
    f->wants = o->wants != 0 ? o->wants : (unsigned)LUM_WANT_FRAMES;
    f->eyes = o->eyes != 0 ? o->eyes : (unsigned)LUM_EYES_BOTH;
    f->has_clock = demux.layout.profile.group[LUM_FIELD_TIMESTAMP].bytes != 0;
    lum_pause_init(&f->pause, demux.config.gap_us, &demux.layout.profile);
    f->has_range = o->has_range;
    f->frame_first = o->frame_first;
    f->frame_last = o->frame_last;
    f->drop_incomplete = o->drop_incomplete;
    f->only_first = o->only_first && !o->has_sensor;
    if (set_first_views(f, o, error) != 0 ||
        set_projector(f, o, &demux.layout, error) != 0) {
        return -1;
    }
    return allocate(f, &demux, o, error);
}

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

static void drop_drafts(struct sensor *s)
{
    for (size_t i = 0; i < DRAFTS_MAX; i++) {
        drop_draft(&s->drafts[i]);
    }
}

static void free_sensor(struct sensor *s)
{
    if (s != NULL) {
        drop_drafts(s);
        lum_clock_fit_free(s->clock);
        free(s);
    }
}

void lum_framer_free(lum_framer *framer)
{
    if (framer == NULL) {
        return;
    }
    lum_crew_settle(framer->crew);
    lum_crew_free(framer->crew);
    drop_draft(&framer->out);
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        free_sensor(framer->sensors[i]);
    }
    lum_frame_pool_free(framer->pool);
    lum_demux_free(framer->demux);
    lum_column_work_release(&framer->work);
    free(framer);
}

/* NULL without memory. */
static struct sensor *new_sensor(const lum_framer *f)
{
    struct sensor *s = calloc(1, sizeof *s);
    if (s != NULL) {
        s->pause = f->pause;
    }
    if (s != NULL && f->has_clock) {
        s->clock = lum_clock_fit_new();
        if (s->clock == NULL) {
            free(s);
            return NULL;
        }
    }
    return s;
}

/* The sensor of the latest event; NULL without memory. */
static struct sensor *current(lum_framer *f)
{
    struct sensor **s = &f->sensors[lum_demux_current_index(f->demux)];
    if (*s == NULL) {
        *s = new_sensor(f);
        if (*s != NULL && f->is_flushing) {
            lum_under_way_leave(&(*s)->under_way);
        }
    }
    return *s;
}

/* --- The line in hand, and its points --- */

/* Make `seen` the line as a view sees it. */
static void look_through(lum_framer *f, const struct view *view)
{
    const struct view *before = f->seen_by;
    const bool is_same = before != NULL && before->window == view->window &&
                         (view->window == 0 || before->order == view->order);
    f->seen_by = view;
    if (is_same) {
        return;
    }
    lum_column_work_begin(&f->work);
    f->seen = *f->line;
    if (view->window != 0) {
        lum_smooth_line(&view->smooth, f->line, f->angles);
        f->seen.angles = f->angles;
    }
}

static const lum_sample *compute_samples(lum_framer *f, const struct view *view)
{
    if (f->sampled_by != view) {
        look_through(f, view);
        f->sample_count =
            lum_samples_compute(&f->projector, &f->seen, &view->selection,
                                &f->work.samples, f->work.sample, NULL);
        f->sampled_by = view;
    }
    return f->work.sample;
}

/* Points of the line that a selection without limits asks for. */
static uint64_t count_edges(const lum_framer *f, unsigned edges)
{
    return ((edges & LUM_EDGES_RISING) != 0 ? f->rising : 0) +
           ((edges & LUM_EDGES_FALLING) != 0 ? f->falling : 0);
}

static bool counts_edges(const lum_selection *s)
{
    return !s->has_range && !s->has_box && s->returns == LUM_RETURNS_ALL;
}

/* What the first view selects of the line. */
static uint64_t count_points(lum_framer *f)
{
    const struct view *first = &f->views.view[0];
    if (f->views.count == 0) {
        return f->rising;
    }
    if (counts_edges(&first->selection)) {
        return count_edges(f, (unsigned)first->selection.edges);
    }
    (void)compute_samples(f, first);
    return f->sample_count;
}

static bool is_wanted_frame(const lum_framer *f, int64_t number)
{
    return !f->has_range ||
           (number >= f->frame_first && number <= f->frame_last);
}

static bool is_wanted_line(const lum_framer *f, const lum_line *line)
{
    const bool is_whole =
        line->angle_count == LUM_LINE_PIXELS && line->lost_words == 0;
    return (f->eyes >> line->eye & 1u) != 0 &&
           is_wanted_frame(f, line->frame) && (is_whole || !f->drop_incomplete);
}

static bool is_passed_over(const lum_framer *f, int64_t number)
{
    return f->has_from && number < f->from;
}

static void note_joined(struct sensor *s, const lum_line *line)
{
    if (!s->has_joined) {
        s->has_joined = true;
        s->joined = line->frame;
    }
}

/* A line was handed out: count it. */
static void note_line(lum_framer *f, struct sensor *s)
{
    const lum_assembler *assembler = lum_demux_current(f->demux);
    const lum_line *line = lum_assembler_line(assembler);
    lum_framer_counters *c = &s->counters;
    f->line = line;
    f->seen_by = NULL;
    f->sampled_by = NULL;
    f->number = line->frame;
    c->lines[line->eye]++;
    note_joined(s, line);
    lum_pace_take(&s->pace, line->frame, line->arrival);
    lum_pause_take(&s->pause, line, lum_assembler_line_is_decided(assembler));
    if (s->clock != NULL) {
        (void)lum_clock_fit_add(s->clock, line->clock_us, line->arrival);
    }
    if (is_passed_over(f, line->frame)) {
        lum_under_way_take(&s->under_way, line, 0);
        return;
    }
    f->losses = (lum_point_losses){0, 0};
    lum_points_count(&f->projector, line, &f->rising, &f->falling, &f->losses);
    c->rising += f->rising;
    c->falling += f->falling;
    c->losses.no_angle += f->losses.no_angle;
    c->losses.no_range += f->losses.no_range;
    lum_under_way_take(&s->under_way, line, f->losses.no_angle);
    f->is_wanted = is_wanted_line(f, line);
    if (f->is_wanted) {
        f->points = count_points(f);
        c->points += f->points;
    }
    f->in_hand = f->is_wanted || (f->wants & LUM_WANT_ALL_LINES) != 0
                     ? IN_HAND_LINE
                     : IN_HAND_NOTHING;
}

/* --- Drafts: frames under way --- */

/* Else they have no points, and only what they lack is counted. */
static bool makes_frames(const lum_framer *f)
{
    return (f->wants & LUM_WANT_FRAMES) != 0;
}

/* Called with draft->views set. usual: points that each view is likely to have;
 * 0: not known. */
static bool begin_frames(lum_framer *f, struct draft *draft,
                         const size_t *usual)
{
    const struct views *views = &draft->views;
    draft->frame_count = views->count > 0 ? views->count : 1u;
    draft->is_used = true;
    for (size_t i = 0; i < draft->frame_count; i++) {
        draft->frames[i] = lum_frame_begin(
            f->pool, views->count > 0 ? views->view[i].columns : 0, usual[i]);
        if (draft->frames[i] == NULL) {
            draft->frame_count = i;
            drop_draft(draft);
            return false;
        }
    }
    return true;
}

/* usual: as begin_frames(). */
static bool begin_draft(lum_framer *f, struct draft *draft, int64_t number,
                        const size_t *usual)
{
    draft->number = number;
    draft->views = f->views;
    if (!makes_frames(f)) {
        draft->views.count = 0;
    }
    return begin_frames(f, draft, usual);
}

static struct draft *find_draft(struct sensor *s, int64_t number)
{
    for (size_t i = 0; i < DRAFTS_MAX; i++) {
        if (s->drafts[i].is_used && s->drafts[i].number == number) {
            return &s->drafts[i];
        }
    }
    return NULL;
}

static struct draft *find_unused(struct sensor *s)
{
    for (size_t i = 0; i < DRAFTS_MAX; i++) {
        if (!s->drafts[i].is_used) {
            return &s->drafts[i];
        }
    }
    return NULL;
}

static struct draft *find_lowest(struct sensor *s)
{
    struct draft *lowest = NULL;
    for (size_t i = 0; i < DRAFTS_MAX; i++) {
        struct draft *d = &s->drafts[i];
        if (d->is_used &&
            (lowest == NULL || is_before(d->number, lowest->number))) {
            lowest = d;
        }
    }
    return lowest;
}

/* After a jump to this frame, the one before has not all of its lines. */
static void take_given(struct sensor *s, int64_t number)
{
    if (s->has_given && !is_before(number, s->given)) {
        memcpy(s->lines_max, s->lines_given, sizeof s->lines_max);
        s->has_given = false;
    }
}

static void count_missing(lum_framer_counters *c, const lum_frame_info *info)
{
    const uint64_t lines = (uint64_t)info->lines_missing[LUM_EYE_BLUE] +
                           info->lines_missing[LUM_EYE_GREEN];
    c->lines_missing += lines;
    c->missing_under_way += info->is_first || info->is_last ? lines : 0;
}

static void seal(lum_framer *f, struct sensor *s, struct draft *draft)
{
    const size_t sensor = lum_demux_current_index(f->demux);
    const lum_frame *first = draft->frames[0];
    const lum_frame_info *info = &first->info;
    lum_frame_end end = {.has_clock = f->has_clock,
                         .clock = s->clock,
                         .lines_late = s->lines_late};
    lum_crew_settle(f->crew);
    if (f->is_flushing) {
        lum_pause_end(&s->pause);
    }
    end.has_pause =
        lum_pause_frame_ends(&s->pause, (uint32_t)draft->number, f->eyes,
                             f->is_flushing, &end.lines_in_pauses);
    take_given(s, draft->number);
    memcpy(end.lines_max, s->lines_max, sizeof end.lines_max);
    for (size_t i = 0; i < draft->frame_count; i++) {
        lum_frame_info *to = &draft->frames[i]->info;
        to->number = draft->number;
        to->sensor = lum_demux_address(f->demux, sensor);
        (void)snprintf(to->sensor_interface, sizeof to->sensor_interface, "%s",
                       lum_demux_further(f->demux, sensor));
        to->is_first = s->has_joined && !is_before(s->joined, draft->number);
        to->is_last = f->is_flushing;
        lum_frame_seal(draft->frames[i], &end);
    }
    s->counters.points_cut += makes_frames(f) ? info->points_cut : 0;
    s->counters.lines_cut += makes_frames(f) ? info->lines_cut : 0;
    count_missing(&s->counters, info);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        s->lines_max[eye] = lum_frame_whole_rows(first, eye);
    }
}

/* A frame with few points among others says little about the next one. */
static void note_sizes(struct sensor *s, const struct draft *draft)
{
    for (size_t i = 0; i < draft->frame_count; i++) {
        const size_t count = lum_frame_count(draft->frames[i]);
        const size_t half = s->usual[i] / 2u;
        s->usual[i] = count > half ? count : half;
    }
}

/* Hand out a frame, if frames are made; its draft is free then. */
static lum_framer_event hand_out(lum_framer *f, struct sensor *s,
                                 struct draft *draft)
{
    seal(f, s, draft);
    note_sizes(s, draft);
    s->lines_late = 0;
    s->has_done = true;
    s->done = draft->number;
    if (!makes_frames(f)) {
        drop_draft(draft);
        return LUM_FRAMER_NONE;
    }
    f->number = draft->number;
    f->out = *draft;
    draft->is_used = false;
    draft->frame_count = 0;
    return LUM_FRAMER_FRAME;
}

/* --- A line into its frame --- */

static bool is_late(const struct sensor *s, int64_t number)
{
    return s->has_done && !is_before(s->done, number);
}

/* While a frame moves, nobody writes into it. */
static bool reserve(const lum_framer *f, const struct draft *draft)
{
    const uint32_t points = f->line->word_count;
    for (size_t i = 0; i < draft->frame_count; i++) {
        lum_frame *frame = draft->frames[i];
        if (!lum_frame_reserve_row(frame)) {
            return false;
        }
        if (!lum_frame_claim_room(frame, points)) {
            lum_crew_settle(f->crew);
            if (!lum_frame_move(frame, points)) {
                return false;
            }
        }
    }
    return true;
}

static lum_frame_part part_of(lum_framer *f, const struct view *view,
                              const lum_line *line)
{
    return (lum_frame_part){.line = {.projector = &f->projector,
                                     .line = line,
                                     .rising = f->rising,
                                     .falling = f->falling},
                            .selection = &view->selection,
                            .work = &f->work,
                            .losses = f->losses};
}

/* Have others make the points, where their number is known. The view is that of
 * a draft, and so lives as long as its frame is under way. */
static bool give_to_crew(lum_framer *f, const struct view *view,
                         lum_frame *frame)
{
    const uint64_t n = count_edges(f, (unsigned)view->selection.edges);
    if (f->crew == NULL || view->columns == 0 || n == 0 ||
        !counts_edges(&view->selection) || n > lum_frame_points_left(frame)) {
        return false;
    }
    const lum_frame_part part = part_of(f, view, f->line);
    const lum_crew_task task = {.line = part.line,
                                .selection = &view->selection,
                                .smooth =
                                    view->window != 0 ? &view->smooth : NULL,
                                .places = lum_frame_next_places(frame)};
    if (!lum_crew_give(f->crew, &task)) {
        return false;
    }
    lum_frame_add_made(frame, &part, (size_t)n);
    return true;
}

/* False: there was no memory, and it is in none of the views. */
static bool add_line(lum_framer *f, const struct draft *draft)
{
    static const struct view lines_alone = {.columns = 0};
    if (!makes_frames(f)) {
        const lum_frame_part part = part_of(f, &lines_alone, f->line);
        if (!lum_frame_reserve_row(draft->frames[0])) {
            return false;
        }
        lum_frame_add(draft->frames[0], &part);
        return true;
    }
    if (!reserve(f, draft)) {
        return false;
    }
    f->sampled_by = NULL;
    for (size_t i = 0; i < draft->frame_count; i++) {
        const struct view *view =
            draft->views.count > 0 ? &draft->views.view[i] : &lines_alone;
        if (!give_to_crew(f, view, draft->frames[i])) {
            look_through(f, view);
            const lum_frame_part part = part_of(f, view, &f->seen);
            lum_frame_add(draft->frames[i], &part);
        }
    }
    f->seen_by = NULL; /* the draft's views may go */
    return true;
}

static void note_late(const lum_framer *f, struct sensor *s)
{
    if (makes_frames(f)) {
        s->lines_late++;
        s->counters.lines_late++;
        s->counters.points_late += f->points;
    }
}

/* Put the line in its frame. If too many frames are open, the lowest is handed
 * out first. */
static lum_framer_event place_line(lum_framer *f, struct sensor *s)
{
    const int64_t number = f->line->frame;
    struct draft *draft = find_draft(s, number);
    if (is_late(s, number)) {
        note_late(f, s);
        return LUM_FRAMER_NONE;
    }
    if (draft == NULL) {
        draft = find_unused(s);
        if (draft == NULL) {
            const lum_framer_event event = hand_out(f, s, find_lowest(s));
            if (event != LUM_FRAMER_NONE) {
                return event;
            }
            draft = find_unused(s);
        }
        if (!begin_draft(f, draft, number, s->usual)) {
            return LUM_FRAMER_FAILED;
        }
    }
    return add_line(f, draft) ? LUM_FRAMER_NONE : LUM_FRAMER_FAILED;
}

static lum_framer_event go_on_with_line(lum_framer *f, struct sensor *s)
{
    const unsigned told =
        f->is_wanted ? (unsigned)LUM_WANT_LINES | (unsigned)LUM_WANT_ALL_LINES
                     : (unsigned)LUM_WANT_ALL_LINES;
    if (f->is_wanted) {
        const lum_framer_event event = place_line(f, s);
        if (event != LUM_FRAMER_NONE) {
            return event;
        }
    }
    f->in_hand = IN_HAND_NOTHING;
    f->number = f->line->frame;
    return (f->wants & told) != 0 ? LUM_FRAMER_LINE : LUM_FRAMER_NONE;
}

/* --- Ends of frames --- */

/* The frame that is complete; empty if none of its lines came. */
static lum_framer_event hand_out_end(lum_framer *f, struct sensor *s,
                                     int64_t number)
{
    static const size_t none[LUM_VIEWS_MAX];
    struct draft *lowest = NULL;
    while ((lowest = find_lowest(s)) != NULL &&
           !is_before(number, lowest->number)) {
        const lum_framer_event event = hand_out(f, s, lowest);
        if (event != LUM_FRAMER_NONE) {
            return event;
        }
    }
    if (is_late(s, number) || !is_wanted_frame(f, number)) {
        return LUM_FRAMER_NONE;
    }
    struct draft *draft = find_unused(s);
    if (draft == NULL) {
        return LUM_FRAMER_NONE;
    }
    return begin_draft(f, draft, number, none) ? hand_out(f, s, draft)
                                               : LUM_FRAMER_FAILED;
}

static lum_framer_event go_on_with_end(lum_framer *f, struct sensor *s)
{
    const int64_t number = lum_assembler_frame(lum_demux_current(f->demux));
    s->first = s->has_range ? s->first : number;
    s->last = number;
    s->has_range = true;
    if (is_passed_over(f, number)) {
        f->in_hand = IN_HAND_NOTHING;
        return LUM_FRAMER_NONE;
    }
    const lum_framer_event event = hand_out_end(f, s, number);
    if (event != LUM_FRAMER_NONE) {
        return event;
    }
    f->in_hand = IN_HAND_NOTHING;
    f->number = number;
    s->counters.frames += is_wanted_frame(f, number) ? 1u : 0u;
    return (f->wants & LUM_WANT_FRAME_ENDS) != 0 ? LUM_FRAMER_FRAME_END
                                                 : LUM_FRAMER_NONE;
}

/* --- Events --- */

static lum_framer_event go_on_with_new(lum_framer *f, struct sensor *s)
{
    f->in_hand = IN_HAND_NOTHING;
    note_line(f, s);
    return f->in_hand == IN_HAND_LINE ? go_on_with_line(f, s) : LUM_FRAMER_NONE;
}

/* Go on with what is in hand. */
static lum_framer_event go_on(lum_framer *f)
{
    struct sensor *s = NULL;
    switch (f->in_hand) {
    case IN_HAND_NEW:
        s = current(f);
        return s != NULL ? go_on_with_new(f, s) : LUM_FRAMER_FAILED;
    case IN_HAND_LINE:
        s = current(f);
        return s != NULL ? go_on_with_line(f, s) : LUM_FRAMER_FAILED;
    case IN_HAND_END:
        s = current(f);
        return s != NULL ? go_on_with_end(f, s) : LUM_FRAMER_FAILED;
    case IN_HAND_NOTHING:
    default:
        return LUM_FRAMER_NONE;
    }
}

static lum_framer_event take(lum_framer *f, lum_result event)
{
    if (f->only_first && lum_demux_current_index(f->demux) > 0) {
        return LUM_FRAMER_NONE;
    }
    switch (event) {
    case LUM_LINE_READY:
        f->in_hand = IN_HAND_NEW;
        break;
    case LUM_FRAME_READY:
        f->in_hand = IN_HAND_END;
        break;
    case LUM_OK:
    case LUM_END:
    case LUM_E_SHORT:
    case LUM_E_SPACE:
    case LUM_E_VALUE:
    case LUM_E_FOREIGN:
    case LUM_E_TYPE:
    case LUM_E_MALFORMED:
    case LUM_E_UNKNOWN_TAG:
    case LUM_E_STRAY:
    case LUM_E_LATE:
    case LUM_E_DUPLICATE:
    case LUM_E_CONFLICT:
    case LUM_E_NO_ROOM:
    case LUM_E_ORDER:
    default: /* no event */
        break;
    }
    return go_on(f);
}

/* Records come again. */
static void end_flush(lum_framer *f)
{
    f->is_flushing = false;
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        if (f->sensors[i] != NULL) {
            lum_under_way_join(&f->sensors[i]->under_way);
            lum_pause_join(&f->sensors[i]->pause);
            f->sensors[i]->has_joined = false;
        }
    }
}

void lum_framer_set_interface(lum_framer *framer, const char *name)
{
    lum_demux_set_interface(framer->demux, name);
}

/* A data packet was taken; those that end no line have stamps, too. */
static void note_stamp(lum_framer *f, int64_t time_ns)
{
    size_t i = 0;
    const struct sensor *s =
        lum_demux_sender(f->demux, &i) ? f->sensors[i] : NULL;
    if (s != NULL && s->clock != NULL) {
        lum_clock_fit_note_stamp(s->clock, time_ns);
    }
}

lum_framer_event lum_framer_push(lum_framer *framer, const lum_record *record,
                                 lum_packet_kind *kind)
{
    lum_packet_kind own = LUM_PACKET_KINDS;
    lum_packet_kind *its = kind != NULL ? kind : &own;
    lum_result r = LUM_OK;
    drop_draft(&framer->out);
    lum_framer_event event = go_on(framer);
    if (framer->is_flushing && event == LUM_FRAMER_NONE) {
        end_flush(framer);
    }
    while (event == LUM_FRAMER_NONE &&
           (r = lum_demux_push(framer->demux, record, its)) > 0) {
        event = take(framer, r);
    }
    if (event == LUM_FRAMER_NONE && r == LUM_OK && *its == LUM_PACKET_DATA) {
        note_stamp(framer, record->time_ns);
    }
    return r >= 0 ? event : LUM_FRAMER_FAILED;
}

/* All lines are there. */
static void end_pauses(lum_framer *f)
{
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        if (f->sensors[i] != NULL) {
            lum_pause_end(&f->sensors[i]->pause);
        }
    }
}

static void begin_flush(lum_framer *f)
{
    f->is_flushing = true;
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        if (f->sensors[i] != NULL) {
            lum_under_way_leave(&f->sensors[i]->under_way);
        }
    }
}

lum_framer_event lum_framer_flush(lum_framer *framer)
{
    lum_result r = LUM_OK;
    drop_draft(&framer->out);
    lum_framer_event event = go_on(framer);
    if (!framer->is_flushing) {
        begin_flush(framer);
    }
    while (event == LUM_FRAMER_NONE &&
           (r = lum_demux_flush(framer->demux)) > 0) {
        event = take(framer, r);
    }
    if (event == LUM_FRAMER_NONE) {
        end_pauses(framer);
    }
    return r >= 0 ? event : LUM_FRAMER_FAILED;
}

/* --- Skipping --- */

static void drop_before(struct sensor *s, int64_t frame)
{
    for (size_t i = 0; i < DRAFTS_MAX; i++) {
        if (s->drafts[i].is_used && s->drafts[i].number < frame) {
            drop_draft(&s->drafts[i]);
        }
    }
}

void lum_framer_skip_to(lum_framer *framer, int64_t frame)
{
    lum_crew_settle(framer->crew);
    framer->has_from = true;
    framer->from = frame;
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        struct sensor *s = framer->sensors[i];
        if (s != NULL) {
            drop_before(s, frame);
            memset(s->lines_max, 0, sizeof s->lines_max);
            s->lines_late = 0;
        }
    }
}

/* --- From a place in the middle --- */

void lum_framer_restart(lum_framer *framer)
{
    lum_crew_settle(framer->crew);
    drop_draft(&framer->out);
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        free_sensor(framer->sensors[i]);
        framer->sensors[i] = NULL;
    }
    lum_demux_restart(framer->demux);
    framer->in_hand = IN_HAND_NOTHING;
    framer->is_flushing = false;
    framer->has_from = false;
    framer->seen_by = NULL;
    framer->sampled_by = NULL;
}

lum_demux *lum_framer_sensors(lum_framer *framer)
{
    return framer->demux;
}

bool lum_framer_gives(const lum_framer *framer, size_t sensor)
{
    return (framer->wants & LUM_WANT_FRAMES) != 0 &&
           (!framer->only_first || sensor == 0);
}

bool lum_framer_is_skipping(const lum_framer *framer)
{
    return framer->has_from;
}

void lum_framer_pack_options(const lum_framer *framer, lum_pack *pack)
{
    lum_framer f = *framer;
    uint32_t eyes = f.eyes;
    lum_demux_pack_options(f.demux, pack);
    lum_pack_u32(pack, &eyes);
    lum_pack_bool(pack, &f.has_range);
    lum_pack_i64(pack, &f.frame_first);
    lum_pack_i64(pack, &f.frame_last);
    lum_pack_bool(pack, &f.drop_incomplete);
    lum_pack_bool(pack, &f.only_first);
}

/* Only sensors that it was taught of are known so early. */
bool lum_framer_pack_taught(lum_framer *framer, lum_pack *pack)
{
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX && !pack->has_failed; i++) {
        bool is_known = framer->sensors[i] != NULL;
        lum_pack_bool(pack, &is_known);
        if (is_known && framer->sensors[i] == NULL) {
            framer->sensors[i] = new_sensor(framer);
        }
        const struct sensor *s = is_known ? framer->sensors[i] : NULL;
        if (is_known && s == NULL) {
            pack->has_failed = true;
        } else if (is_known && s->clock != NULL) {
            (void)lum_clock_fit_pack(s->clock, pack);
        }
    }
    return !pack->has_failed;
}

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
static void pack_drafts(lum_framer *f, struct sensor *s, lum_pack *p)
{
    for (size_t i = 0; i < DRAFTS_MAX && !p->has_failed; i++) {
        struct draft *d = &s->drafts[i];
        bool is_used = d->is_used;
        int64_t number = d->number;
        lum_pack_bool(p, &is_used);
        if (is_used) {
            pack_number(p, &number);
        }
        if (is_used && lum_pack_is_reading(p) && !p->has_failed &&
            !begin_draft(f, d, number, s->usual)) {
            p->has_failed = true;
        }
    }
}

static void pack_own(struct sensor *s, lum_pack *p)
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
    struct sensor **s = &framer->sensors[sensor];
    if (*s == NULL && lum_pack_is_reading(pack)) {
        *s = new_sensor(framer);
    }
    if (*s == NULL) {
        pack->has_failed = true;
        return false;
    }
    if (lum_demux_pack_sensor(framer->demux, sensor, from, pack)) {
        pack_own(*s, pack);
        pack_drafts(framer, *s, pack);
    }
    if ((*s)->clock != NULL && !pack->has_failed) {
        (void)lum_clock_fit_pack((*s)->clock, pack);
    }
    return !pack->has_failed;
}

void lum_framer_get_lines(const lum_framer *framer, size_t sensor,
                          uint32_t out[LUM_EYES])
{
    const struct sensor *s = framer->sensors[sensor];
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        out[eye] = s != NULL ? s->lines_max[eye] : 0;
    }
}

void lum_framer_set_lines(lum_framer *framer, size_t sensor, int64_t frame,
                          const uint32_t lines[LUM_EYES])
{
    struct sensor *s = framer->sensors[sensor];
    if (s != NULL) {
        s->has_given = true;
        s->given = frame;
        memcpy(s->lines_given, lines, sizeof s->lines_given);
    }
}

/* --- What the last event is about --- */

const lum_line *lum_framer_line(const lum_framer *framer)
{
    return framer->line;
}

bool lum_framer_line_is_wanted(const lum_framer *framer)
{
    return framer->is_wanted;
}

size_t lum_framer_line_samples(lum_framer *framer, size_t view,
                               const lum_sample **out)
{
    *out = framer->work.sample;
    if (view >= framer->views.count) {
        return 0;
    }
    *out = compute_samples(framer, &framer->views.view[view]);
    return framer->sample_count;
}

const lum_frame *lum_framer_frame(const lum_framer *framer, size_t view)
{
    return view < framer->out.frame_count ? framer->out.frames[view] : NULL;
}

bool lum_framer_frame_view(const lum_framer *framer, size_t view, lum_view *out)
{
    if (view >= framer->out.views.count || framer->out.frame_count == 0) {
        return false;
    }
    const lum_view *asked = &framer->out.views.view[view].asked;
    return lum_sized_fill(out, asked, sizeof *asked);
}

int64_t lum_framer_frame_number(const lum_framer *framer)
{
    return framer->number;
}

size_t lum_framer_sensor(const lum_framer *framer)
{
    return lum_demux_current_index(framer->demux);
}

/* One of each break. */
static uint64_t count_stray(const lum_framer *f, size_t sensor)
{
    const uint64_t breaks = f->sensors[sensor]->pause.counts.breaks;
    lum_demux_counters c = {.struct_size = sizeof c};
    (void)lum_demux_count(f->demux, sensor, &c);
    return breaks < c.assembly.stray ? breaks : c.assembly.stray;
}

lum_result lum_framer_count(const lum_framer *framer, size_t sensor,
                            lum_framer_counters *out)
{
    lum_framer_counters counters = {.struct_size = sizeof counters};
    const struct sensor *s =
        sensor < LUM_DEMUX_SENSORS_MAX ? framer->sensors[sensor] : NULL;
    if (s != NULL) {
        counters = s->counters;
        counters.under_way = s->under_way.counts;
        counters.pauses = s->pause.counts.pauses;
        counters.paused_us = s->pause.counts.paused_us;
        counters.lines_in_pauses = s->pause.counts.lines;
        counters.stray_at_breaks = count_stray(framer, sensor);
        counters.frames_per_second = lum_pace_rate(&s->pace);
    }
    return lum_sized_fill(out, &counters, sizeof counters) ? LUM_OK
                                                           : LUM_E_VALUE;
}

uint64_t lum_framer_refused(const lum_demux_counters *packets,
                            const lum_framer_counters *lines)
{
    const lum_assembly_counters *a = &packets->assembly;
    const uint64_t *kinds = packets->packets;
    return a->late + a->conflict + a->no_room + a->stray -
           lines->stray_at_breaks + kinds[LUM_PACKET_MALFORMED] +
           kinds[LUM_PACKET_UNKNOWN_TAG] + kinds[LUM_PACKET_UNKNOWN_TYPE] +
           kinds[LUM_PACKET_FOREIGN];
}

bool lum_framer_range(const lum_framer *framer, size_t sensor, int64_t *first,
                      int64_t *last)
{
    const struct sensor *s =
        sensor < LUM_DEMUX_SENSORS_MAX ? framer->sensors[sensor] : NULL;
    if (s == NULL || !s->has_range) {
        return false;
    }
    *first = s->first;
    *last = s->last;
    return true;
}

const lum_clock_fit *lum_framer_clock(const lum_framer *framer, size_t sensor)
{
    const struct sensor *s =
        sensor < LUM_DEMUX_SENSORS_MAX ? framer->sensors[sensor] : NULL;
    return s != NULL ? s->clock : NULL;
}

int lum_framer_learn_clocks(lum_framer *framer, const lum_framer *from)
{
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        const lum_clock_fit *learned = lum_framer_clock(from, i);
        if (learned == NULL || !framer->has_clock) {
            continue;
        }
        if (framer->sensors[i] == NULL) {
            framer->sensors[i] = new_sensor(framer);
        }
        if (framer->sensors[i] == NULL) {
            return -1;
        }
        lum_clock_fit_learn(framer->sensors[i]->clock, learned);
    }
    return 0;
}

const lum_demux *lum_framer_demux(const lum_framer *framer)
{
    return framer->demux;
}
