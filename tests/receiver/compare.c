/* compare CAPTURE: the points of a capture by a receiver and by an assembler
 * are the same, and so is what they count. compare CAPTURE DISTURBED: what a
 * receiver makes of the second are points that an assembler makes of the first,
 * each as often at most. Both with the built-in layout and calibration, of the
 * first sensor. */
#include "lum/assembler.h"
#include "lum/calibration.h"
#include "lum/capture/capture.h"
#include "lum/packet.h"
#include "lum/points_fixed.h"
#include "lum/receiver.h"
#include "lum/wire.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define OPEN_LINES     4u
#define REORDER_LINES  8u
#define WORDS_PER_LINE 16384u
#define ROOM           16384u
#define BLOCK          1024u

struct point {
    lum_fixed_point at;
    uint32_t line;
    uint32_t eye;
};

struct points {
    struct point *all;
    size_t count;
    size_t size;
    lum_point_losses losses;
};

static lum_layout layout;
static lum_fixed_projector projector;
static lum_assembler assembler;
static lum_line_slot slots[LUM_ASSEMBLER_SLOTS(OPEN_LINES)];
static uint32_t words[LUM_ASSEMBLER_WORDS(OPEN_LINES, WORDS_PER_LINE)];
static lum_reach reach[LUM_ASSEMBLER_REACH(REORDER_LINES)];
static lum_receiver receiver;
static uint32_t room[ROOM];
static struct points assembled;
static struct points received;

static void keep(struct points *to, const lum_line *line)
{
    lum_fixed_point block[BLOCK];
    for (uint32_t i = 0; i < line->word_count; i += BLOCK) {
        const size_t n = lum_points_fixed_compute(&projector, line, i, BLOCK,
                                                  block, &to->losses);
        if (to->size - to->count < n) {
            to->size = 2 * to->size + BLOCK;
            to->all = realloc(to->all, to->size * sizeof to->all[0]);
            if (to->all == NULL) {
                abort();
            }
        }
        for (size_t k = 0; k < n; k++) {
            to->all[to->count++] =
                (struct point){block[k], line->number, line->eye};
        }
    }
}

static void assemble(const lum_group *group)
{
    lum_result r = LUM_OK;
    while ((r = lum_assembler_push(&assembler, group, 0)) > 0) {
        if (r == LUM_LINE_READY) {
            keep(&assembled, lum_assembler_line(&assembler));
        }
    }
}

static void receive(const lum_group *group)
{
    if (lum_receiver_push(&receiver, group) == LUM_OK) {
        keep(&received, lum_receiver_line(&receiver));
    }
}

static void finish(void)
{
    lum_result r = LUM_OK;
    while ((r = lum_assembler_flush(&assembler)) > 0) {
        if (r == LUM_LINE_READY) {
            keep(&assembled, lum_assembler_line(&assembler));
        }
    }
    lum_receiver_forget(&receiver);
}

static bool begin(void)
{
    static const lum_assembler_storage storage =
        LUM_ASSEMBLER_STORAGE(slots, words, reach);
    lum_assembler_config config;
    lum_calibration calibration;
    lum_layout_default(&layout);
    lum_calibration_default(&calibration);
    lum_assembler_config_default(&config);
    return lum_fixed_projector_init(&projector, &calibration, &layout) ==
               LUM_OK &&
           lum_assembler_init(&assembler, &config, &layout, &storage) ==
               LUM_OK &&
           lum_receiver_init(&receiver, &layout, LUM_RECEIVER_GAP_US, room,
                             ROOM) == LUM_OK;
}

static bool read_capture(const char *path, void (*take)(const lum_group *))
{
    lum_error error = {{0}};
    lum_capture *capture = NULL;
    lum_record record;
    uint32_t sensor = 0;
    int more = 0;
    if (lum_capture_open(path, &capture, &error) != 0) {
        (void)fprintf(stderr, "compare: %s\n", error.text);
        return false;
    }
    while ((more = lum_capture_next(capture, &record, &error)) > 0) {
        lum_group group;
        if (!lum_record_is_datagram(&record) ||
            record.source_port != LUM_PORT ||
            lum_packet_decode(&layout, record.payload, record.len, &group) !=
                LUM_PACKET_DATA) {
            continue;
        }
        sensor = sensor == 0 ? record.source : sensor;
        if (record.source == sensor) {
            take(&group);
        }
    }
    lum_capture_close(capture);
    if (more < 0) {
        (void)fprintf(stderr, "compare: %s\n", error.text);
    }
    return more == 0;
}

static int compare(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(struct point));
}

static void sort(struct points *p)
{
    if (p->count > 0) {
        qsort(p->all, p->count, sizeof p->all[0], compare);
    }
}

/* How many of the receiver's are no one's of the assembler. */
static size_t count_foreign(void)
{
    size_t foreign = 0;
    size_t k = 0;
    for (size_t i = 0; i < received.count; i++) {
        while (k < assembled.count &&
               compare(&assembled.all[k], &received.all[i]) < 0) {
            k++;
        }
        if (k < assembled.count &&
            compare(&assembled.all[k], &received.all[i]) == 0) {
            k++;
        } else {
            foreign++;
        }
    }
    return foreign;
}

static bool are_same(void)
{
    const lum_receiver_counters *r = lum_receiver_counted(&receiver);
    const lum_assembly_counters *a = lum_assembler_counters(&assembler);
    return received.count == assembled.count && r->words == a->words &&
           r->lost_words == a->lost_words && r->lines == a->lines &&
           r->lines_missing_angles == a->lines_missing_angles &&
           r->lines_skipped == a->lines_skipped && r->late == a->late &&
           r->stray == a->stray && r->duplicate == a->duplicate &&
           r->conflict == a->conflict && r->bad_words == a->bad_words &&
           received.losses.no_angle == assembled.losses.no_angle &&
           received.losses.no_range == assembled.losses.no_range;
}

int main(int argc, char **argv)
{
    if (argc != 2 && argc != 3) {
        (void)fputs("usage: compare CAPTURE [DISTURBED]\n", stderr);
        return 2;
    }
    if (!begin() || !read_capture(argv[1], assemble) ||
        !read_capture(argv[argc - 1], receive)) {
        return EXIT_FAILURE;
    }
    finish();
    sort(&assembled);
    sort(&received);
    const size_t foreign = count_foreign();
    const bool is_right =
        foreign == 0 && received.count > 0 && (argc == 3 || are_same());
    (void)printf("points: %lu by the assembler, %lu by the receiver, %lu of "
                 "them foreign\n",
                 (unsigned long)assembled.count, (unsigned long)received.count,
                 (unsigned long)foreign);
    free(assembled.all);
    free(received.all);
    return is_right ? EXIT_SUCCESS : EXIT_FAILURE;
}
