#include "batch.h"

#include "base/grow.h"
#include "points/columns.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#define LINES_MAX 16u

/* Rows of a batch that is full: they fit the second cache of a core. */
#define ROWS_BYTES  (UINT64_C(3) << 18)
#define WORDS_FIRST 8192u /* until it is known how many words make these */
#define WORDS_MAX   65536u

/* A line without room of its own for what is long. */
struct batch_line {
    lum_line line;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    size_t at;        /* of its words, or of its samples */
    bool has_samples; /* these are known, */
    size_t count;     /* so many */
    int64_t timestamp_us;
    const void *const *extra; /* as of its samples */
    const lum_projector *projector;
};

struct batch {
    struct batch_line lines[LINES_MAX];
    size_t count;
    uint32_t *words; /* of all lines */
    size_t word_count;
    size_t word_room;
    lum_sample *samples; /* likewise */
    size_t sample_count;
    size_t sample_room;
    size_t full; /* words, or samples, with which it is full */
    lum_writer *part;
    bool has_failed;
    int failure_code;
    lum_error failure;
};

struct batch_tools {
    lum_sample_workspace work;
    lum_angle angles[LUM_LINE_PIXELS];
    lum_return returns[LUM_LINE_WORDS_MAX];
    lum_sample samples[LUM_LINE_WORDS_MAX];
};

/* --- The batch --- */

struct batch *batch_new(lum_writer *part)
{
    struct batch *batch = calloc(1, sizeof *batch);
    if (batch == NULL) {
        lum_writer_abort(part);
        return NULL;
    }
    batch->part = part;
    batch->full = WORDS_FIRST;
    return batch;
}

void batch_free(struct batch *batch)
{
    if (batch == NULL) {
        return;
    }
    lum_writer_abort(batch->part);
    free(batch->words);
    free(batch->samples);
    free(batch);
}

bool batch_is_empty(const struct batch *batch)
{
    return batch->count == 0;
}

bool batch_is_full(const struct batch *batch)
{
    return batch->count == LINES_MAX ||
           batch->word_count + batch->sample_count >= batch->full;
}

int64_t batch_frame(const struct batch *batch)
{
    return batch->lines[0].line.frame;
}

void batch_clear(struct batch *batch)
{
    batch->count = 0;
    batch->word_count = 0;
    batch->sample_count = 0;
    batch->has_failed = false;
    lum_writer_clear_part(batch->part);
}

/* --- Lines --- */

int batch_add_line(struct batch *batch, const lum_line *line,
                   const lum_projector *projector,
                   const lum_line_samples *about)
{
    struct batch_line *to = &batch->lines[batch->count];
    const size_t n = line->word_count;
    uint32_t *words = lum_grown(batch->words, batch->word_count, n,
                                sizeof *words, &batch->word_room);
    if (words == NULL) {
        return -1;
    }
    batch->words = words;
    memcpy(words + batch->word_count, line->words, n * sizeof *words);
    memcpy(to->angles, line->angles, sizeof to->angles);
    memcpy(to->marks, line->angle_marks, sizeof to->marks);
    to->line = *line;
    to->at = batch->word_count;
    to->has_samples = false;
    to->timestamp_us = about->timestamp_us;
    to->extra = about->extra;
    to->projector = projector;
    batch->word_count += n;
    batch->count++;
    return 0;
}

int batch_add_samples(struct batch *batch, const lum_line_samples *line)
{
    struct batch_line *to = &batch->lines[batch->count];
    lum_sample *samples =
        lum_grown(batch->samples, batch->sample_count, line->count,
                  sizeof *samples, &batch->sample_room);
    if (samples == NULL) {
        return -1;
    }
    batch->samples = samples;
    memcpy(samples + batch->sample_count, line->samples,
           line->count * sizeof *samples);
    to->line = (lum_line){
        .frame = line->frame, .number = line->line, .eye = line->eye};
    to->at = batch->sample_count;
    to->has_samples = true;
    to->count = line->count;
    to->timestamp_us = line->timestamp_us;
    to->extra = line->extra;
    batch->sample_count += line->count;
    batch->count++;
    return 0;
}

/* --- Rows --- */

struct batch_tools *batch_tools_new(void)
{
    struct batch_tools *tools = malloc(sizeof *tools);
    if (tools != NULL) {
        tools->work.returns = tools->returns;
    }
    return tools;
}

void batch_tools_free(struct batch_tools *tools)
{
    free(tools);
}

/* The points of a line. Returns how many there are. */
static size_t project(const struct batch *batch, const struct batch_line *from,
                      const struct batch_view *view, struct batch_tools *tools)
{
    lum_line line = from->line;
    line.angles = from->angles;
    line.angle_marks = from->marks;
    line.words = batch->words + from->at;
    if (view->smooths) {
        lum_smooth_line(&view->smooth, &line, tools->angles);
        line.angles = tools->angles;
    }
    return lum_samples_make(from->projector, &line, &view->selection,
                            view->leaves, &tools->work, tools->samples);
}

static int make_line(struct batch *batch, const struct batch_line *from,
                     const struct batch_view *view, struct batch_tools *tools)
{
    lum_line_samples line = {.struct_size = sizeof line,
                             .frame = from->line.frame,
                             .timestamp_us = from->timestamp_us,
                             .line = from->line.number,
                             .eye = from->line.eye,
                             .extra = from->extra};
    if (from->has_samples) {
        line.samples = batch->samples + from->at;
        line.count = from->count;
    } else {
        line.samples = tools->samples;
        line.count = project(batch, from, view, tools);
    }
    return lum_writer_add(batch->part, &line, &batch->failure);
}

/* As many words as the rows are to have bytes, if the next are alike. */
static void find_full(struct batch *batch)
{
    const uint64_t words = batch->word_count + batch->sample_count;
    const uint64_t bytes = lum_writer_bytes(batch->part);
    const uint64_t full = bytes > 0 ? words * ROWS_BYTES / bytes : WORDS_MAX;
    batch->full = (size_t)(full < WORDS_MAX ? full : WORDS_MAX);
}

void batch_make(struct batch *batch, const struct batch_view *view,
                struct batch_tools *tools)
{
    for (size_t i = 0; i < batch->count && !batch->has_failed; i++) {
        if (make_line(batch, &batch->lines[i], view, tools) != 0) {
            batch->has_failed = true;
            batch->failure_code = errno;
        }
    }
    find_full(batch);
}

lum_writer *batch_rows(struct batch *batch, lum_error *error)
{
    if (!batch->has_failed) {
        return batch->part;
    }
    *error = batch->failure;
    errno = batch->failure_code;
    return NULL;
}
