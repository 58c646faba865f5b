/* Any stream of lines, and any calls between: flushes, jumps, other views,
 * frames that are kept. Every input is a list of calls, five bytes each. What
 * include/lum/frame says of frames and counters is checked. */
#include "lum/frame/framer.h"
#include "lum/group.h"
#include "lum/wire.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define CALL_BYTES  5u
#define CALLS_MAX   400u
#define SAMPLES_MAX 64u
#define WORDS_MAX   200u
#define POINTS_MAX  500u
#define KEPT_MAX    4u
#define ROWS        5u

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

struct run {
    lum_framer *framer;
    lum_layout layout;
    uint32_t clock;
    int64_t time_ns;
    uint8_t packet[LUM_GROUP_HEAD_MAX + SAMPLES_MAX * LUM_SAMPLE_BYTES];
    lum_frame *kept[KEPT_MAX];
    size_t kept_count;
    uint64_t lines; /* as told one by one */
    uint64_t line_points;
    uint64_t framed_lines;
    uint64_t framed_points;
    uint64_t cut;
    uint64_t missing;
    uint64_t dropped; /* by a jump, at most */
    int changes;      /* of views */
};

static void require(int fact)
{
    if (!fact) {
        abort();
    }
}

static void require_lines(const lum_frame *frame)
{
    lum_frame_line line = {.struct_size = sizeof line};
    size_t points = 0;
    for (size_t i = 0; i < lum_frame_line_count(frame); i++) {
        require(lum_frame_get_line(frame, i, &line));
        require(line.first_point == points && line.eye < LUM_EYES);
        points += line.point_count;
    }
    require(!lum_frame_get_line(frame, lum_frame_line_count(frame), &line));
    require(points == lum_frame_count(frame));
}

static void require_columns(const lum_frame *frame)
{
    for (unsigned c = 0; c < LUM_COLUMN_COUNT; c++) {
        const float *floats = lum_frame_floats(frame, (lum_column)c);
        require((lum_frame_column(frame, (lum_column)c) != NULL) ==
                ((lum_frame_columns(frame) >> c & 1u) != 0));
        for (size_t i = 0; floats != NULL && i < lum_frame_count(frame); i++) {
            require(isfinite(floats[i]));
        }
    }
}

static void require_grid(const lum_frame *frame, unsigned eye, unsigned returns)
{
    static uint32_t index[ROWS * LUM_LINE_PIXELS * 3u];
    static float line[ROWS * LUM_LINE_PIXELS * 3u];
    const uint32_t *lines = lum_frame_uint32s(frame, LUM_COLUMN_LINE);
    const uint16_t *pixels = lum_frame_uint16s(frame, LUM_COLUMN_PIXEL);
    if (!lum_frame_grid_index(frame, eye, ROWS, returns, index)) {
        require(pixels == NULL);
        return;
    }
    const int has_lines =
        lum_frame_grid_floats(frame, LUM_COLUMN_LINE, eye, ROWS, returns, line);
    require(has_lines == (lines != NULL));
    for (size_t i = 0; i < ROWS * LUM_LINE_PIXELS * (size_t)returns; i++) {
        const uint32_t at = index[i];
        require(at == LUM_FRAME_MISSING || at < lum_frame_count(frame));
        require(at == LUM_FRAME_MISSING ||
                pixels[at] == i / returns % LUM_LINE_PIXELS);
        require(!has_lines || (isnan(line[i]) != 0) == (at == UINT32_MAX));
    }
}

static void take_frame(struct run *run, const lum_frame *frame)
{
    lum_frame_info info = {.struct_size = sizeof info};
    require(lum_frame_get_info(frame, &info) == LUM_OK);
    require(info.points == lum_frame_count(frame));
    require(info.points <= POINTS_MAX);
    require(info.lines[0] + (size_t)info.lines[1] ==
            lum_frame_line_count(frame));
    require(info.times.begin_clock_us <= info.times.end_clock_us);
    require(!info.is_complete ||
            (info.points_cut == 0 && info.lost_words == 0 && !info.has_pause));
    require(info.has_pause || info.lines_in_pauses == 0);
    require_lines(frame);
    require_columns(frame);
    require_grid(frame, (unsigned)info.number % 2u, 1u + info.lines[0] % 3u);
    run->framed_lines += lum_frame_line_count(frame);
    run->framed_points += info.points;
    run->cut += info.points_cut;
    run->missing += info.lines_missing[0] + (uint64_t)info.lines_missing[1];
    if (run->kept_count < KEPT_MAX) {
        run->kept[run->kept_count++] = lum_frame_keep(frame);
    }
}

static void take_event(struct run *run, lum_framer_event event)
{
    const lum_sample *samples = NULL;
    switch (event) {
    case LUM_FRAMER_LINE:
        run->lines++;
        run->line_points += lum_framer_line_samples(run->framer, 0, &samples);
        break;
    case LUM_FRAMER_FRAME:
        take_frame(run, lum_framer_frame(run->framer, 0));
        break;
    case LUM_FRAMER_FRAME_END:
    case LUM_FRAMER_NONE:
        break;
    case LUM_FRAMER_FAILED:
    default:
        abort();
    }
}

/* A packet of a line: b is eye and tag, line, clock, samples, pixel. */
static void push(struct run *run, const uint8_t *b)
{
    const lum_group g = {
        .eye = b[0] & 1u,
        .tag = (b[0] & 2u) != 0 ? LUM_TAG_ANGLES : LUM_TAG_RANGES,
        .line = b[1] < 250u ? b[1] % 8u : (uint32_t)b[1] * 257u,
        .clock_raw = run->clock += b[2] < 250u ? b[2] : b[2] * 65536u,
        .num_samples = 1u + b[3] % SAMPLES_MAX,
        .first_sample_index = b[4] * 3u};
    lum_framer_event event = LUM_FRAMER_NONE;
    size_t head = 0;
    require(lum_group_encode(&run->layout, &g, run->packet, sizeof run->packet,
                             &head) == LUM_OK);
    for (uint32_t i = 0; i < g.num_samples; i++) {
        const uint32_t word =
            lum_word_make((int32_t)(i * 97u) + b[3] - 60, i % 3u != 1u,
                          (g.first_sample_index + i / 2u) % LUM_LINE_PIXELS);
        lum_word_encode(g.tag == LUM_TAG_ANGLES ? i * 65537u * b[3] : word,
                        run->packet + head + (size_t)LUM_SAMPLE_BYTES * i);
    }
    const lum_record record = {.time_ns = run->time_ns++,
                               .payload = run->packet,
                               .len = head +
                                      (size_t)LUM_SAMPLE_BYTES * g.num_samples,
                               .source = 1u + (b[0] >> 2 & 1u),
                               .source_port = LUM_PORT,
                               .kind = LUM_RECORD_DATAGRAM};
    while ((event = lum_framer_push(run->framer, &record, NULL)) !=
           LUM_FRAMER_NONE) {
        take_event(run, event);
    }
}

static void flush(struct run *run)
{
    lum_framer_event event = LUM_FRAMER_NONE;
    while ((event = lum_framer_flush(run->framer)) != LUM_FRAMER_NONE) {
        take_event(run, event);
    }
}

static lum_view view_of(const uint8_t *b)
{
    lum_view view;
    lum_view_default(&view);
    view.columns = (b[1] | (uint32_t)b[2] << 8) & LUM_COLUMNS_ALL;
    view.selection.edges = (lum_edges)(1u + b[3] % 3u);
    view.selection.returns = (lum_return_choice)(b[3] / 3u % 5u);
    view.selection.return_number = 1;
    view.smooth_window = b[4] % 3u == 0 ? 2u * (b[4] % 8u) + 1u : 0;
    return view;
}

static void change_views(struct run *run, const uint8_t *b)
{
    const lum_view views[2] = {view_of(b), view_of(b)};
    require(lum_framer_set_views(run->framer, views, b[0] / 16u % 3u, NULL) ==
            0);
    run->changes = 1;
}

static void release(struct run *run)
{
    while (run->kept_count > 0) {
        require_lines(run->kept[--run->kept_count]);
        lum_frame_release(run->kept[run->kept_count]);
    }
}

static void call(struct run *run, const uint8_t *b)
{
    switch (b[0] & 0xf8u) {
    case 0xf8:
        flush(run);
        break;
    case 0xf0:
        change_views(run, b);
        break;
    case 0xe8:
        lum_framer_skip_to(run->framer, b[1] % 16u);
        run->dropped = 1;
        break;
    case 0xe0:
        release(run);
        break;
    default:
        push(run, b);
        break;
    }
}

/* Lines and points are in a frame or counted. */
static void require_counted(const struct run *run)
{
    uint64_t late = 0;
    uint64_t late_points = 0;
    uint64_t points = 0;
    uint64_t cut = 0;
    uint64_t missing = 0;
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        lum_framer_counters c = {.struct_size = sizeof c};
        require(lum_framer_count(run->framer, i, &c) == LUM_OK);
        late += c.lines_late;
        late_points += c.points_late;
        points += c.points;
        cut += c.points_cut;
        missing += c.lines_missing;
        require(c.missing_under_way <= c.lines_missing);
        require(c.pauses <= c.lines[0] + c.lines[1]);
        require(c.pauses != 0 || (c.paused_us == 0 && c.lines_in_pauses == 0));
    }
    require(missing == run->missing);
    if (!run->dropped) {
        require(run->framed_lines + late == run->lines);
    }
    if (!run->dropped && !run->changes) {
        require(points == run->line_points && cut == run->cut);
        require(run->framed_points + late_points + cut == run->line_points);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct run run;
    lum_assembler_config config;
    lum_view view;
    if (size < CALL_BYTES) {
        return 0;
    }
    run = (struct run){.clock = 1000, .time_ns = 1};
    view = view_of(data);
    lum_layout_default(&run.layout);
    lum_assembler_config_default(&config);
    config.words_per_line = WORDS_MAX;
    config.open_lines = (uint8_t)(1u + data[0] % 4u);
    const lum_framer_options options = {
        .struct_size = sizeof options,
        .config = &config,
        .views = &view,
        .view_count = 1,
        .wants = LUM_WANT_FRAMES | LUM_WANT_LINES | LUM_WANT_FRAME_ENDS,
        .drop_incomplete = (data[0] & 64u) != 0,
        .points_max = POINTS_MAX};
    require(lum_framer_new(&options, &run.framer, NULL) == 0);
    /* frames without columns have no points */
    run.changes = view.columns == 0;
    for (size_t i = 1; i < size / CALL_BYTES && i < CALLS_MAX; i++) {
        call(&run, data + i * CALL_BYTES);
    }
    flush(&run);
    require_counted(&run);
    lum_framer_free(run.framer);
    release(&run);
    return 0;
}
