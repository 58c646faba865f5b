#include "convert.h"

#include "rig_report.h"

#include "frame/framer_state.h"

#include "lum/base/time.h"
#include "lum/wire.h"

#include <errno.h>

/* --- Lines and frames --- */

enum pass_result pass_failure(void)
{
    return errno == EPIPE ? PASS_READER_LEFT : PASS_FAILED;
}

/* The line's packets came just now, so its clock is near what is known. */
static int64_t timestamp_us(const struct pass *pass, int64_t clock_us,
                            int64_t arrival_ns)
{
    const lum_clock_fit *clock =
        lum_framer_clock(pass->framer, lum_framer_sensor(pass->framer));
    lum_clock_time time;
    if (pass->options->points.time == TIME_SENSOR) {
        return clock_us;
    }
    return pass->options->points.time == TIME_UTC && clock != NULL &&
                   lum_clock_fit_utc(clock, clock_us, &time) == LUM_OK
               ? time.utc_ns / 1000
               : arrival_ns / 1000;
}

/* Which of the rig's sensors the event is of; without a rig the first. */
static size_t member_of(const struct pass *pass)
{
    const int member = pass->options->rig != NULL
                           ? rig_member_of(pass->options->rig, pass->framer,
                                           lum_framer_sensor(pass->framer))
                           : 0;
    return member > 0 ? (size_t)member : 0;
}

static struct frame_lines *frame_lines_of(const struct pass *pass)
{
    return pass->frame_lines[member_of(pass)];
}

/* Outputs of a rig are told whose the event is. */
static struct action action_of(const struct pass *pass)
{
    const struct rig *rig = pass->options->rig;
    const size_t i = member_of(pass);
    struct action action = {.sensor = 0};
    if (rig != NULL) {
        action.sensor = (unsigned)i + 1u;
        action.extra = &rig->sensors[i].column;
    }
    return action;
}

static int64_t clock_of_line(const void *pass, const lum_frame_line *line)
{
    return timestamp_us(pass, line->clock_us, line->arrival_ns);
}

static int write_line(struct pass *pass, lum_error *error)
{
    const lum_line *line = lum_framer_line(pass->framer);
    const struct rig *rig = pass->options->rig;
    struct action action = action_of(pass);
    if (!outputs_any(pass->outputs, output_wants_lines)) {
        return 0;
    }
    lum_line_samples points = {
        .struct_size = sizeof points,
        .frame = line->frame,
        .timestamp_us = timestamp_us(pass, line->clock_us, line->arrival),
        .line = line->number,
        .eye = line->eye,
        .extra = action.extra};
    if (pass->rows != NULL) {
        return row_threads_add(pass->rows, pass->framer,
                               rig != NULL
                                   ? &rig->sensors[member_of(pass)].projector
                                   : pass->projector,
                               &points, error);
    }
    points.count = lum_framer_line_samples(
        pass->framer, 0,
        outputs_any(pass->outputs, output_wants_points) ? &points.samples
                                                        : NULL);
    action.kind = ADD_LINE;
    action.line = &points;
    return outputs_act(pass->outputs, &action, error);
}

static int take_line(struct pass *pass, lum_error *error)
{
    const bool is_wanted = lum_framer_line_is_wanted(pass->framer);
    if (pass->cut != NULL) {
        cut_take_line(pass->cut, lum_framer_line(pass->framer), is_wanted);
    }
    return is_wanted ? write_line(pass, error) : 0;
}

/* Of --frames whole:N the first so many, else all. One without points is that
 * of a laser that is not on yet. */
static bool choose_frame(struct pass *pass)
{
    struct summary *s = &pass->summary;
    const struct taken_frame *taken = frame_lines_taken(frame_lines_of(pass));
    if (s->whole.asked == 0) {
        return true;
    }
    if (pass->frames_to_come.are_done || taken->points == 0 ||
        !taken->is_whole) {
        return false;
    }
    s->whole.sensor = lum_framer_sensor(pass->framer);
    s->whole.frames++;
    s->whole.points += taken->points;
    pass->frames_to_come.are_done = s->whole.frames == s->whole.asked;
    return true;
}

static int move_frame(struct pass *pass, const lum_frame *frame,
                      struct moved *out, lum_error *error)
{
    if (pass->motion == NULL) {
        return 0;
    }
    if (motion_move(pass->motion, frame, out, error) != 0) {
        return -1;
    }
    frame_lines_move(frame_lines_of(pass), out);
    return 0;
}

static int take_frame(struct pass *pass, lum_error *error)
{
    const lum_frame *frame = lum_framer_frame(pass->framer, 0);
    struct frame_lines *lines = frame_lines_of(pass);
    struct action action = action_of(pass);
    struct moved moved;
    const bool is_written =
        pass->voxels != NULL || outputs_any(pass->outputs, output_wants_frames);
    if (!is_written && pass->summary.whole.asked == 0) {
        return 0;
    }
    if (frame_lines_take(lines, frame, pass->frames_to_come.want_rows) != 0) {
        errno = ENOMEM;
        return lum_error_set(error, "out of memory");
    }
    if (!choose_frame(pass) || !is_written) {
        return 0;
    }
    if (move_frame(pass, frame, &moved, error) != 0) {
        return -1;
    }
    action.kind = ADD_FRAME;
    action.frame = lines;
    return pass->voxels != NULL
               ? voxels_take(pass->voxels, frame,
                             pass->motion != NULL ? &moved : NULL,
                             action.sensor, pass->outputs, error)
               : outputs_act(pass->outputs, &action, error);
}

static int end_frame(struct pass *pass, lum_error *error)
{
    const int64_t number = lum_framer_frame_number(pass->framer);
    const int64_t last = pass->options->choice.frame_last;
    pass->frames_to_come.are_done |= last != INT64_MAX && number >= last;
    if (pass->outputs == NULL) {
        return 0;
    }
    struct action action = action_of(pass);
    action.kind = END_FRAME;
    action.number = number;
    return pass->rows != NULL ? row_threads_end_frame(pass->rows, number, error)
                              : outputs_act(pass->outputs, &action, error);
}

static enum pass_result handle_event(struct pass *pass, lum_framer_event event,
                                     lum_error *error)
{
    int result = 0;
    switch (event) {
    case LUM_FRAMER_LINE:
        result = take_line(pass, error);
        break;
    case LUM_FRAMER_FRAME_END:
        result = end_frame(pass, error);
        break;
    case LUM_FRAMER_FRAME:
        result = take_frame(pass, error);
        break;
    case LUM_FRAMER_FAILED:
        (void)lum_error_set(error, "out of memory");
        return PASS_FAILED;
    case LUM_FRAMER_NONE:
    default:
        break;
    }
    return result == 0 ? PASS_DONE : pass_failure();
}

/* --- Records --- */

/* Files have no column for the sensor. */
static bool has_too_many_sensors(const struct pass *pass)
{
    return pass->outputs != NULL && !pass->options->sensor.is_chosen &&
           pass->options->rig == NULL &&
           lum_demux_sensor_count(lum_framer_demux(pass->framer)) > 1;
}

static void note_time(struct summary_span *s, int64_t time_ns)
{
    if (!s->is_known) {
        s->is_known = true;
        s->first_ns = time_ns;
        s->last_ns = time_ns;
    }
    if (time_ns > s->last_ns) {
        s->last_ns = time_ns;
    }
}

static int set_time(struct pass *pass, const lum_record *record,
                    lum_error *error)
{
    return outputs_act(
        pass->outputs,
        &(struct action){.kind = SET_TIME, .number = record->time_ns}, error);
}

/* Which of the rig's sensors a record is of; -1: none. */
static int record_member(const struct pass *pass, const lum_record *record)
{
    const lum_capture *capture = pass->source.capture;
    if (pass->options->is_live) {
        return 0;
    }
    return rig_member(pass->options->rig, lum_framer_demux(pass->framer),
                      record,
                      capture != NULL ? lum_capture_interface(capture) : NULL);
}

static int add_datagram(struct pass *pass, const lum_record *record,
                        lum_error *error)
{
    const struct rig *rig = pass->options->rig;
    const int found = rig != NULL ? record_member(pass, record) : 0;
    const size_t i = found > 0 ? (size_t)found : 0;
    const struct action action = {
        .kind = ADD_DATAGRAM,
        .sensor = rig != NULL ? (unsigned)i + 1u : 0,
        .number = options_is_rotation(&pass->options->files.rotation) &&
                  frame_watch_begins(&pass->frames[i],
                                     rig != NULL ? &rig->sensors[i].layout
                                                 : pass->layout,
                                     record->payload, record->len),
        .record = record};
    return outputs_act(pass->outputs, &action, error);
}

/* Decide on the packets that are held, as far as possible now. */
static int write_cut(struct pass *pass, lum_error *error)
{
    lum_record record;
    int result = 0;
    while (result == 0 && cut_next(pass->cut, &record)) {
        result = add_datagram(pass, &record, error);
    }
    return result;
}

/* In captures that are written the sensor's side always has the port of all
 * sensors, because readers find it by that port. */
static lum_record with_port(lum_record record, uint16_t port)
{
    uint16_t *side = record.source_port == port ? &record.source_port
                                                : &record.destination_port;
    *side = port != 0 ? (uint16_t)LUM_PORT : *side;
    return record;
}

static int write_datagram(struct pass *pass, const lum_record *from,
                          lum_error *error)
{
    const lum_record record = with_port(*from, pass->options->sensor.port);
    if (pass->cut == NULL) {
        return add_datagram(pass, &record, error);
    }
    return cut_add(pass->cut, &record, error) == 0 ? write_cut(pass, error)
                                                   : -1;
}

static void note_status(struct pass *pass, const lum_record *record)
{
    uint32_t sequence = 0;
    lum_tlv_reader reader;
    lum_tlv tlv;
    if (lum_tlv_open(record->payload, record->len, &sequence, &reader) !=
        LUM_OK) {
        return;
    }
    while (lum_tlv_next(&reader, &tlv) == LUM_OK) {
        if (tlv.type == pass->layout->profile.tlv[LUM_TLV_STATUS] &&
            lum_tlv_u16(&tlv, &pass->laser.status) == LUM_OK) {
            pass->laser.is_known = true;
            pass->laser.at_ns = lum_time_monotonic_ns();
        }
    }
}

/* A record of port 5517 that was counted as `kind`. */
static enum pass_result note_ours(struct pass *pass, const lum_record *record,
                                  lum_packet_kind kind, lum_error *error)
{
    const bool is_foreign = kind == LUM_PACKET_FOREIGN;
    if (!is_foreign) {
        note_time(&pass->summary.span, record->time_ns);
    }
    if (!is_foreign && kind != LUM_PACKET_DATA) {
        diagnosis_note(&pass->diagnosis, record->payload, record->len, kind);
    }
    if (kind == LUM_PACKET_TLV) {
        note_status(pass, record);
    }
    if (pass->outputs != NULL && !is_foreign &&
        write_datagram(pass, record, error) != 0) {
        return pass_failure();
    }
    return PASS_DONE;
}

static bool is_of_asked_sensor(const struct pass *pass,
                               const lum_record *record)
{
    const struct options *o = pass->options;
    if (o->rig != NULL) {
        return record_member(pass, record) >= 0;
    }
    return !o->sensor.is_chosen ||
           ((record->source == o->sensor.address ||
             record->destination == o->sensor.address) &&
            lum_demux_is_wanted(lum_framer_demux(pass->framer)));
}

enum pass_result pass_take(struct pass *pass, const lum_record *record,
                           lum_error *error)
{
    lum_packet_kind kind = LUM_PACKET_KINDS;
    lum_framer_event event = LUM_FRAMER_NONE;
    if (pass->outputs != NULL && set_time(pass, record, error) != 0) {
        return pass_failure();
    }
    while ((event = lum_framer_push(pass->framer, record, &kind)) !=
           LUM_FRAMER_NONE) {
        const enum pass_result result = handle_event(pass, event, error);
        if (result != PASS_DONE) {
            return result;
        }
    }
    if (has_too_many_sensors(pass)) {
        return PASS_SENSORS;
    }
    if (kind != LUM_PACKET_KINDS && is_of_asked_sensor(pass, record)) {
        return note_ours(pass, record, kind, error);
    }
    if (pass->options->rig != NULL && pass->source.capture != NULL) {
        rig_others_note(&pass->summary.others, pass->options,
                        lum_framer_demux(pass->framer), record,
                        lum_capture_interface(pass->source.capture));
    }
    return PASS_DONE;
}

/* A recording holds all packets of the sensor, so its summary is that of the
 * run. */
enum pass_result pass_record(struct pass *pass, const lum_record *record,
                             lum_error *error)
{
    if (record->kind != LUM_RECORD_DATAGRAM) {
        return PASS_DONE;
    }
    return set_time(pass, record, error) == 0 &&
                   add_datagram(pass, record, error) == 0
               ? PASS_DONE
               : pass_failure();
}

enum pass_result pass_flush(struct pass *pass, lum_error *error)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    while ((event = lum_framer_flush(pass->framer)) != LUM_FRAMER_NONE) {
        const enum pass_result result = handle_event(pass, event, error);
        if (result != PASS_DONE) {
            return result;
        }
    }
    if (pass->rows != NULL && row_threads_finish(pass->rows, error) != 0) {
        return pass_failure();
    }
    if (has_too_many_sensors(pass)) {
        return PASS_SENSORS;
    }
    if (pass->motion != NULL && motion_check(pass->motion, error) != 0) {
        return PASS_REFUSED;
    }
    if (pass->cut == NULL || pass->outputs == NULL) {
        return PASS_DONE;
    }
    cut_end(pass->cut);
    return write_cut(pass, error) == 0 ? PASS_DONE : pass_failure();
}

/* --- Getting ready --- */

/* What the framer is to tell of. Of a capture its packets matter. */
static unsigned find_wants(const struct pass *pass)
{
    const struct options *o = pass->options;
    unsigned wants = LUM_WANT_FRAME_ENDS;
    if (o->choice.whole != 0) {
        wants |= (unsigned)LUM_WANT_FRAMES;
    }
    for (size_t i = 0; i < o->output_count && !pass->counts_alone; i++) {
        if (options_takes_frames(o, i) || o->cloud.voxel > 0) {
            wants |= (unsigned)LUM_WANT_FRAMES;
        } else if (!options_is_recording(o, i)) {
            wants |= (unsigned)LUM_WANT_LINES;
        }
    }
    return wants | (cut_is_asked(o) ? (unsigned)LUM_WANT_ALL_LINES : 0u);
}

/* Messages need fewer columns. */
static bool needs_all_columns(const struct options *o, size_t i)
{
    return options_takes_frames(o, i) && !options_has_messages(o, i);
}

static int prepare_frames(struct pass *pass)
{
    const struct options *o = pass->options;
    const size_t count = o->rig != NULL ? o->rig->count : 1u;
    for (size_t i = 0; i < count; i++) {
        pass->frame_lines[i] =
            frame_lines_new(o->choice.eyes, clock_of_line, pass);
        if (pass->frame_lines[i] == NULL) {
            return -1;
        }
    }
    return 0;
}

/* What is needed besides the framer. */
static int prepare_parts(struct pass *pass, unsigned wants)
{
    const struct options *o = pass->options;
    if ((wants & (unsigned)LUM_WANT_ALL_LINES) != 0) {
        pass->cut = cut_new(o, pass->layout);
        if (pass->cut == NULL) {
            return -1;
        }
    }
    if ((wants & (unsigned)LUM_WANT_FRAMES) != 0) {
        pass->frames_to_come.want_rows = options_any(o, options_is_organized);
        return prepare_frames(pass);
    }
    return 0;
}

/* Lines have threads of their own. A third thread would not help: the first has
 * most of the work. */
static unsigned framer_threads(const struct options *o, unsigned wants)
{
    if (o->is_live || (wants & (unsigned)LUM_WANT_FRAMES) == 0) {
        return 1u;
    }
    const unsigned threads = options_threads(o);
    return o->points.threads != 0 || threads < 2u ? threads : 2u;
}

static lum_view make_view(const struct options *o, unsigned wants)
{
    lum_view view;
    lum_view_default(&view);
    view.selection = o->choice.points;
    view.smooth_window = o->points.smooth_window;
    view.smooth_order = o->points.smooth_order;
    if ((wants & (unsigned)LUM_WANT_FRAMES) != 0) {
        view.columns =
            o->cloud.preset != NULL || options_any(o, needs_all_columns)
                ? FRAME_LINES_COLUMNS
                : FRAME_LINES_OF_MESSAGES;
    }
    return view;
}

enum pass_result pass_prepare(struct pass *pass, lum_error *error)
{
    const struct options *o = pass->options;
    const unsigned wants = find_wants(pass);
    const lum_view view = make_view(o, wants);
    /* the layout is for sensors that the rig does not name */
    const bool has_members = o->rig != NULL && !o->is_live;
    const lum_framer_options options = {
        .struct_size = sizeof options,
        .layout = has_members ? NULL : pass->layout,
        .projector = pass->projector,
        .views = &view,
        .view_count = 1,
        .wants = wants,
        .eyes = o->choice.eyes,
        .has_sensor = o->sensor.is_chosen,
        .sensor = o->sensor.address,
        .port = o->sensor.port,
        .records_are_single = true,
        .sensor_interface = o->sensor.interface,
        .has_range = true,
        .frame_first = o->choice.frame_first,
        .frame_last = o->choice.frame_last,
        .drop_incomplete = o->choice.drop_incomplete,
        .members = has_members ? o->rig->members : NULL,
        .member_count = has_members ? o->rig->files.rig.count : 0,
        .threads = framer_threads(o, wants)};
    if (lum_framer_new(&options, &pass->framer, error) != 0) {
        return PASS_FAILED;
    }
    lum_framer_leave(pass->framer, options_leaves(o));
    if (prepare_parts(pass, wants) != 0) {
        (void)lum_error_set(error, "out of memory");
        return PASS_FAILED;
    }
    motion_restart(pass->motion);
    pass->summary.moved =
        pass->motion != NULL ? motion_counts(pass->motion) : NULL;
    pass->summary.origin = o->about.origin;
    pass->summary.source = o->source;
    pass->summary.framer = pass->framer;
    pass->summary.rig = o->rig;
    pass->summary.has_frames = options_has_frames(o);
    pass->summary.whole.asked = o->choice.whole;
    return PASS_DONE;
}

/* --- The end --- */

/* What comes after its frame was handed out is in no frame. */
void pass_note_left_out(struct pass *pass)
{
    struct summary_outputs *s = &pass->summary.outputs;
    struct left_out of_frames = {.late = 0};
    if (pass->frame_lines[0] != NULL && pass->summary.whole.asked == 0) {
        const lum_framer_counters c = summary_count(&pass->summary);
        of_frames.late = c.points_late;
        of_frames.cut = c.points_cut;
    }
    s->left_out_count =
        outputs_left_out(pass->outputs, &of_frames, s->left_out);
    s->drawn_count = outputs_drawn(pass->outputs, s->drawn);
}

void pass_free(struct pass *pass)
{
    row_threads_free(pass->rows);
    voxels_free(pass->voxels);
    cut_free(pass->cut);
    for (size_t i = 0; i < LUM_RIG_SENSORS_MAX; i++) {
        frame_lines_free(pass->frame_lines[i]);
    }
    lum_framer_free(pass->framer);
    lum_capture_close(pass->source.capture);
}
