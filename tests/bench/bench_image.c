/* bench_image CAPTURE: each whole frame of a capture as a picture of both eyes:
 * its index and its ranges, in milliseconds of processor time, the median and
 * the longest, by each choice. */
#include "datagrams.h"

#include "lum/frame/image.h"
#include "lum/frame/reader.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHOICES 5u

static const char *const names[CHOICES] = {"nearest", "farthest", "strongest",
                                           "first", "last"};

struct bench {
    lum_image_options options;
    uint32_t *index;
    float *range;
    size_t pixels;
    lum_image_counts counts;
};

static void prepare(struct bench *b, const lum_frame *frame)
{
    b->options.struct_size = sizeof b->options;
    (void)lum_frame_image_default(frame, LUM_IMAGE_BOTH, &b->options);
    b->pixels = (size_t)b->options.view.rows * b->options.view.columns;
    b->index = allocate(b->pixels * sizeof *b->index);
    b->range = allocate(b->pixels * sizeof *b->range);
}

/* Milliseconds. */
static double time_picture(struct bench *b, const lum_frame *frame)
{
    const double begin = processor_s();
    b->counts.struct_size = sizeof b->counts;
    if (lum_frame_image_index(frame, &b->options, b->index, NULL, &b->counts) !=
            LUM_OK ||
        lum_frame_image(frame, LUM_COLUMN_RANGE, b->index, b->pixels,
                        b->range) != LUM_OK) {
        stop("no picture");
    }
    return 1e3 * (processor_s() - begin);
}

static void measure(struct bench *b, const lum_frame *frame)
{
    if (b->pixels == 0) {
        prepare(b, frame);
    }
    (void)printf("frame of %zu points, %" PRIu32 " x %" PRIu32 " pixels:",
                 lum_frame_count(frame), b->options.view.rows,
                 b->options.view.columns);
    for (unsigned choice = 0; choice < CHOICES; choice++) {
        double ms[ROUNDS];
        b->options.choice = (lum_image_choice)choice;
        (void)time_picture(b, frame);
        for (unsigned round = 0; round < ROUNDS; round++) {
            ms[round] = time_picture(b, frame);
        }
        const double middle = median(ms);
        (void)printf(" %s %.2f ms (most %.2f)", names[choice], middle,
                     ms[ROUNDS - 1u]);
    }
    (void)printf("; %.1f %% of pixels filled, %" PRIu64 " hidden, %" PRIu64
                 " outside\n",
                 100.0 * (double)b->counts.filled / (double)b->pixels,
                 b->counts.hidden, b->counts.outside);
}

int main(int argc, char **argv)
{
    static struct bench bench;
    lum_view view;
    lum_reader *reader = NULL;
    const lum_frame *frame = NULL;
    lum_error error = {""};
    lum_view_default(&view);
    view.columns |= LUM_COLUMN_BIT(LUM_COLUMN_RANGE) |
                    LUM_COLUMN_BIT(LUM_COLUMN_PULSE_WIDTH);
    const lum_framer_options framer = {
        .struct_size = sizeof framer, .views = &view, .view_count = 1};
    const lum_reader_options options = {.struct_size = sizeof options,
                                        .path = argc == 2 ? argv[1] : "",
                                        .framer = &framer};
    int status = lum_reader_open(&options, &reader, &error);
    while (status >= 0 &&
           (status = lum_reader_next_frame(reader, &frame, &error)) > 0) {
        measure(&bench, frame);
    }
    if (status < 0) {
        stop(error.text);
    }
    lum_reader_close(reader);
    free(bench.index);
    free(bench.range);
    return 0;
}
