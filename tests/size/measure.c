/* What a datagram costs, in instructions, on a board that counts them. Prints
 * one line for each figure, of all that were like it. */
#include "count.h"
#include "lum/assembler.h"
#include "lum/calibration.h"
#include "lum/packet.h"
#include "lum/points_fixed.h"
#include "lum/profile.h"
#include "lum/receiver.h"
#include "lum/returns.h"
#include "port/port.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define OPEN_LINES    2u
#define REORDER_LINES 8u
#define LINE_WORDS    4000u
#define LINES         40u
#define MOST          340u /* samples of a packet: what Ethernet holds */
#define PACKETS_MAX   8u
#define BLOCK         64u
#define CLOCK_STEP    200u /* microseconds between lines */

/* What is counted apart. */
enum cost {
    COST_LINE,
    COST_ANGLES,
    COST_SINGLES,
    COST_PULSES,
    COST_REORDERED,
    COST_PACKET,
    COST_RECEIVED,
    COST_RECEIVED_ANGLES,
    COST_RETURNS,
    COST_POINTS_SINGLES,
    COST_POINTS_PULSES,
    COST_POINTS_ASIDE,
    COSTS
};

static const char *const names[COSTS] = {
    "line",      "angles",         "singles",       "pulses",
    "reordered", "packet",         "received",      "received_angles",
    "returns",   "points_singles", "points_pulses", "points_aside"};

static struct count sums[COSTS];
static struct datagram packets[PACKETS_MAX];
static lum_layout layout;
static lum_assembler assembler;
static lum_line_slot slots[LUM_ASSEMBLER_SLOTS(OPEN_LINES)];
static uint32_t words[LUM_ASSEMBLER_WORDS(OPEN_LINES, LINE_WORDS)];
static lum_reach reach[LUM_ASSEMBLER_REACH(REORDER_LINES)];
static const lum_assembler_storage storage =
    LUM_ASSEMBLER_STORAGE(slots, words, reach);
static lum_receiver receiver;
static uint32_t received[MOST];
static lum_fixed_projector projector;
static lum_fixed_point points[BLOCK];
static lum_return returns[LINE_WORDS];
static enum cost projecting;
static uint32_t pushed_words;
static uint32_t points_made;
static uint32_t line_number;
static bool looks_aside;
static bool is_wrong;

static void use_line(const lum_line *line)
{
    lum_point_losses losses = {0, 0};
    uint32_t begin = port_ticks();
    for (uint32_t i = 0; i < line->word_count; i += BLOCK) {
        points_made += (uint32_t)lum_points_fixed_compute(
            &projector, line, i, BLOCK, points, &losses);
    }
    count_add(&sums[projecting], port_ticks() - begin, line->word_count);
    begin = port_ticks();
    lum_returns_compute(line->words, line->word_count, returns);
    count_add(&sums[COST_RETURNS], port_ticks() - begin, line->word_count);
}

/* Takes a datagram as a gateway does. A line that it completes is used between
 * the two pushes and counts as its own. */
static void receive(const struct datagram *d, enum cost cost, uint32_t units)
{
    lum_group group;
    uint32_t begin = port_ticks();
    lum_result r = LUM_E_TYPE;
    if (lum_packet_decode(&layout, d->bytes, d->len, &group) ==
        LUM_PACKET_DATA) {
        r = lum_assembler_push(&assembler, &group, 0);
    }
    count_add(&sums[cost], port_ticks() - begin, units);
    while (r > 0) {
        if (r == LUM_LINE_READY) {
            use_line(lum_assembler_line(&assembler));
        }
        begin = port_ticks();
        r = lum_assembler_push(&assembler, &group, 0);
        count_add(&sums[cost], port_ticks() - begin, 0);
    }
    is_wrong = is_wrong || r != LUM_OK;
}

static void begin_packet(struct datagram *d, uint8_t tag, uint32_t first,
                         uint32_t samples)
{
    const lum_group group = {.line = line_number,
                             .num_samples = samples,
                             .first_sample_index = first,
                             .clock_raw = line_number * CLOCK_STEP,
                             .eye = LUM_EYE_BLUE,
                             .tag = tag};
    is_wrong = is_wrong || !datagram_begin(d, &layout, &group);
}

static void make_angles(struct datagram *d, uint32_t first, uint32_t samples)
{
    begin_packet(d, LUM_TAG_ANGLES, first, samples);
    for (uint32_t i = 0; i < samples; i++) {
        const int32_t pixel = (int32_t)(first + i);
        const lum_angle angle = {
            (int16_t)(looks_aside ? -12000 - 8 * pixel : 32000 - 64 * pixel),
            (int16_t)(-20000 + 37 * pixel)};
        lum_angle_encode(&layout, angle, datagram_sample(d, samples, i));
    }
}

/* Words from an index of the line on; each pixel has that many. */
static void make_words(struct datagram *d, uint32_t first, uint32_t samples,
                       uint32_t words_of_pixel)
{
    begin_packet(d, LUM_TAG_RANGES, first, samples);
    for (uint32_t i = 0; i < samples; i++) {
        const uint32_t n = first + i;
        const int32_t tof = (int32_t)(2000 + 7 * n);
        const uint32_t word =
            lum_word_make(tof, n % words_of_pixel == 0, n / words_of_pixel);
        lum_word_encode(word, datagram_sample(d, samples, i));
    }
    pushed_words += samples;
}

static void begin_assembler(void)
{
    lum_assembler_config config;
    lum_assembler_config_default(&config);
    config.open_lines = OPEN_LINES;
    config.words_per_line = LINE_WORDS;
    if (lum_assembler_init(&assembler, &config, &layout, &storage) != LUM_OK) {
        is_wrong = true;
    }
    line_number = 0;
    pushed_words = 0;
    points_made = 0;
}

static void finish(void)
{
    lum_result r = LUM_OK;
    while ((r = lum_assembler_flush(&assembler)) > 0) {
        if (r == LUM_LINE_READY) {
            use_line(lum_assembler_line(&assembler));
        }
    }
    const lum_assembly_counters *c = lum_assembler_counters(&assembler);
    is_wrong = is_wrong || c->lines != LINES || c->lines_missing_angles != 0 ||
               c->words != pushed_words || c->lost_words != 0 ||
               points_made != pushed_words;
}

/* The first packet opens a line, and closes the one that has to make room. */
static void send_angles(void)
{
    static const uint32_t firsts[] = {0, 334, 668};
    static const uint32_t counts[] = {334, 334, 332};
    for (unsigned i = 0; i < 3; i++) {
        make_angles(&packets[0], firsts[i], counts[i]);
        receive(&packets[0], i == 0 ? COST_LINE : COST_ANGLES,
                i == 0 ? 1 : counts[i]);
    }
}

/* Lines whose packets come in order. */
static void run_in_order(enum cost cost, enum cost points_cost,
                         uint32_t words_of_pixel)
{
    const uint32_t count = 1000u * words_of_pixel / MOST;
    begin_assembler();
    projecting = points_cost;
    for (; line_number < LINES; line_number++) {
        send_angles();
        for (uint32_t i = 0; i < count; i++) {
            make_words(&packets[0], i * MOST, MOST, words_of_pixel);
            receive(&packets[0], cost, MOST);
        }
        make_words(&packets[0], count * MOST, 1, words_of_pixel);
        receive(&packets[0], COST_PACKET, 1);
    }
    finish();
}

/* Lines whose packets of ranges come backwards; the first of them is in
 * order. */
static void run_backwards(void)
{
    const uint32_t count = 5;
    begin_assembler();
    projecting = COST_POINTS_PULSES;
    for (; line_number < LINES; line_number++) {
        send_angles();
        for (uint32_t i = count; i-- > 0;) {
            make_words(&packets[0], i * MOST, MOST, 2);
            receive(&packets[0], i + 1u == count ? COST_PULSES : COST_REORDERED,
                    MOST);
        }
    }
    finish();
}

static void pass_on(enum cost cost, uint32_t units)
{
    const struct datagram *d = &packets[0];
    lum_group group;
    const uint32_t begin = port_ticks();
    lum_result r = LUM_E_TYPE;
    if (lum_packet_decode(&layout, d->bytes, d->len, &group) ==
        LUM_PACKET_DATA) {
        r = lum_receiver_push(&receiver, &group);
    }
    count_add(&sums[cost], port_ticks() - begin, units);
    is_wrong = is_wrong || r != LUM_OK;
    if (group.tag == LUM_TAG_RANGES) {
        is_wrong = is_wrong || lum_receiver_line(&receiver)->word_count !=
                                   group.num_samples;
    }
}

/* The same lines by a receiver. */
static void run_receiver(void)
{
    static const uint32_t firsts[] = {0, 334, 668};
    static const uint32_t counts[] = {334, 334, 332};
    if (lum_receiver_init(&receiver, &layout, LUM_RECEIVER_GAP_US, received,
                          MOST) != LUM_OK) {
        is_wrong = true;
    }
    for (line_number = 0; line_number < LINES; line_number++) {
        for (unsigned i = 0; i < 3; i++) {
            make_angles(&packets[0], firsts[i], counts[i]);
            pass_on(COST_RECEIVED_ANGLES, counts[i]);
        }
        for (uint32_t i = 0; i < 2; i++) {
            make_words(&packets[0], i * MOST, MOST, 1);
            pass_on(COST_RECEIVED, MOST);
        }
    }
}

int main(int argc, char **argv)
{
    lum_calibration calibration;
    (void)argc;
    (void)argv;
    lum_layout_default(&layout);
    lum_calibration_default(&calibration);
    calibration.eye[LUM_EYE_BLUE].mount_um[0] = 123456;
    calibration.eye[LUM_EYE_BLUE].mount_roll_udeg = 1500000;
    calibration.eye[LUM_EYE_BLUE].mount_pitch_udeg = -2500000;
    if (lum_fixed_projector_init(&projector, &calibration, &layout) != LUM_OK) {
        return 1;
    }
    count_print_scale();
    run_in_order(COST_SINGLES, COST_POINTS_SINGLES, 1);
    run_in_order(COST_PULSES, COST_POINTS_PULSES, 2);
    run_backwards();
    run_receiver();
    /* -66 to -110 degrees of a whole turn, and -81 to -56 */
    looks_aside = true;
    calibration.eye[LUM_EYE_BLUE].azimuth_width_udeg = 360000000;
    calibration.eye[LUM_EYE_BLUE].elevation_min_udeg = -90000000;
    calibration.eye[LUM_EYE_BLUE].elevation_max_udeg = -46000000;
    if (lum_fixed_projector_init(&projector, &calibration, &layout) != LUM_OK) {
        return 1;
    }
    run_in_order(COST_SINGLES, COST_POINTS_ASIDE, 1);
    for (unsigned i = 0; i < COSTS; i++) {
        count_print(names[i], &sums[i]);
    }
    return is_wrong ? 1 : 0;
}
