#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/group.h"
#include "lum/packet.h"
#include "sim/packets.h"
#include "sim/reel.h"
#include "sim/render.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define LINES  16u
#define FRAMES 2u

static const lum_reel_settings usual = {1.0f, {1.0f, 1.0f}};

static const lum_reel_stop never = {NULL, NULL};

struct fixture {
    lum_render_options options;
    lum_render render;
    lum_sim_line line;
    lum_packet_batch batches[LUM_EYES];
    lum_reel *reel;
    lum_reel_packet packets[LUM_REEL_LINE_PACKETS];
    lum_reel_packet others[LUM_REEL_LINE_PACKETS];
};

static void make_reel(struct fixture *f)
{
    lum_reel_free(f->reel);
    f->reel = NULL;
    assert_int_equal(lum_reel_new(&f->options, FRAMES, never, &f->reel),
                     LUM_OK);
}

static int set_up(void **state)
{
    struct fixture *f = calloc(1, sizeof *f);
    if (f == NULL) {
        return -1;
    }
    lum_render_options_default(&f->options);
    f->options.seed = 42;
    f->options.lines = LINES;
    *state = f;
    return lum_render_init(&f->render, &f->options) == LUM_OK &&
                   lum_reel_new(&f->options, FRAMES, never, &f->reel) == LUM_OK
               ? 0
               : -1;
}

static int tear_down(void **state)
{
    struct fixture *f = *state;
    lum_reel_free(f->reel);
    lum_render_free(&f->render);
    free(f);
    return 0;
}

static lum_group decode(const struct fixture *f, const lum_reel_packet *packet)
{
    const lum_layout *layout = &f->options.layout;
    lum_group g = {0};
    assert_int_equal(lum_packet_decode(layout, packet->bytes, packet->len, &g),
                     LUM_PACKET_DATA);
    assert_int_equal(packet->len,
                     layout->profile.samples_at + 4 * g.num_samples);
    assert_true(packet->len <= LUM_PACKET_BYTES_MAX);
    return g;
}

/* What lum_render_line() and lum_packets_build() make of the same line. */
static size_t build(struct fixture *f, const lum_render_options *options,
                    unsigned frame, uint32_t line, lum_sim_packet **order)
{
    lum_render *render = malloc(sizeof *render);
    assert_non_null(render);
    assert_int_equal(lum_render_init(render, options), LUM_OK);
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        assert_int_equal(
            lum_render_line(render, (int64_t)frame + 1, line, eye, &f->line),
            LUM_OK);
        assert_int_equal(
            lum_packets_build(&options->layout, &f->line, &f->batches[eye]),
            LUM_OK);
    }
    lum_render_free(render);
    free(render);
    return lum_packets_spread(f->batches, 1e6, order);
}

static void at_full_power_a_line_is_what_the_renderer_gives(void **state)
{
    struct fixture *f = *state;
    lum_sim_packet *order[LUM_REEL_LINE_PACKETS];
    for (unsigned frame = 0; frame < FRAMES; frame++) {
        for (uint32_t line = 0; line < LINES; line++) {
            const size_t n = build(f, &f->options, frame, line, order);
            const uint32_t clock =
                (uint32_t)lum_render_clock_us(&f->render, frame + 1, line);
            assert_int_equal(
                lum_reel_line(f->reel, frame, line, &usual, clock, f->packets),
                n);
            for (size_t i = 0; i < n; i++) {
                assert_int_equal(f->packets[i].len, order[i]->len);
                assert_memory_equal(f->packets[i].bytes, order[i]->bytes,
                                    order[i]->len);
            }
        }
    }
}

static size_t count_words(struct fixture *f, uint32_t line, float gain,
                          float blue, float green, size_t words[LUM_EYES])
{
    const lum_reel_settings settings = {gain, {blue, green}};
    const size_t n = lum_reel_line(f->reel, 0, line, &settings, 1, f->packets);
    words[0] = words[1] = 0;
    for (size_t i = 0; i < n; i++) {
        const lum_group g = decode(f, &f->packets[i]);
        words[g.eye] += g.tag == LUM_TAG_RANGES ? g.num_samples : 0;
    }
    return n;
}

static void without_gain_there_are_angles_alone(void **state)
{
    struct fixture *f = *state;
    size_t words[LUM_EYES];
    for (uint32_t line = 0; line < LINES; line++) {
        (void)count_words(f, line, 1.0f, 1.0f, 1.0f, words);
        assert_true(words[0] + words[1] > 0);
        assert_int_equal(count_words(f, line, 0.0f, 1.0f, 1.0f, words), 6);
        assert_int_equal(count_words(f, line, 0.0f, 0.0f, 0.0f, words), 6);
        assert_int_equal(words[0] + words[1], 0);
    }
}

static void less_power_and_higher_thresholds_show_less(void **state)
{
    static const float gains[] = {1.0f, 0.5f, 0.1f, 0.01f};
    static const float thresholds[] = {0.25f, 0.5f, 1.0f, 2.0f, 50.0f};
    struct fixture *f = *state;
    size_t words[LUM_EYES];
    size_t before = SIZE_MAX;
    for (unsigned i = 0; i < 4; i++) {
        (void)count_words(f, 2, gains[i], 1.0f, 1.0f, words);
        assert_true(words[0] + words[1] < before);
        before = words[0] + words[1];
    }
    before = SIZE_MAX;
    for (unsigned i = 0; i < 5; i++) {
        (void)count_words(f, 2, 1.0f, thresholds[i], thresholds[i], words);
        assert_true(words[0] + words[1] < before);
        before = words[0] + words[1];
    }
}

static void a_threshold_below_the_faintest_shows_the_faintest(void **state)
{
    struct fixture *f = *state;
    size_t none[LUM_EYES];
    size_t quarter[LUM_EYES];
    (void)count_words(f, 2, 1.0f, 0.0f, 0.0f, none);
    (void)count_words(f, 2, 1.0f, LUM_RENDER_FAINTEST, LUM_RENDER_FAINTEST,
                      quarter);
    assert_memory_equal(none, quarter, sizeof none);
}

static void a_threshold_is_one_eyes_own(void **state)
{
    struct fixture *f = *state;
    size_t all[LUM_EYES];
    size_t words[LUM_EYES];
    (void)count_words(f, 8, 1.0f, 1.0f, 1.0f, all);
    (void)count_words(f, 8, 1.0f, 100.0f, 1.0f, words);
    assert_true(words[LUM_EYE_BLUE] < all[LUM_EYE_BLUE]);
    assert_int_equal(words[LUM_EYE_GREEN], all[LUM_EYE_GREEN]);
    (void)count_words(f, 8, 1.0f, 1.0f, 100.0f, words);
    assert_int_equal(words[LUM_EYE_BLUE], all[LUM_EYE_BLUE]);
    assert_true(words[LUM_EYE_GREEN] < all[LUM_EYE_GREEN]);
}

/* Speckle differs, as fewer returns draw fewer random numbers. */
static void thinned_lines_have_as_many_words_as_rendered_ones(void **state)
{
    struct fixture *f = *state;
    lum_render_options options = f->options;
    lum_sim_packet *order[LUM_REEL_LINE_PACKETS];
    size_t thinned = 0;
    size_t rendered = 0;
    options.gain = 0.02f;
    options.threshold = 2.0f;
    for (uint32_t line = 0; line < LINES; line++) {
        size_t words[LUM_EYES];
        const size_t n = build(f, &options, 0, line, order);
        for (size_t i = 0; i < n; i++) {
            const lum_reel_packet built = {order[i]->bytes, order[i]->len};
            const lum_group g = decode(f, &built);
            rendered += g.tag == LUM_TAG_RANGES ? g.num_samples : 0;
        }
        (void)count_words(f, line, 0.02f, 2.0f, 2.0f, words);
        thinned += words[0] + words[1];
    }
    assert_true(thinned > 1000);
    assert_true(thinned > rendered - rendered / 50 &&
                thinned < rendered + rendered / 50);
}

/* Full packets, no pixel in two of them, first indices that add up. */
static void check_cuts(struct fixture *f, size_t n, unsigned room)
{
    uint32_t words[LUM_EYES] = {0, 0};
    uint32_t pixel[LUM_EYES] = {UINT32_MAX, UINT32_MAX};
    uint32_t samples[LUM_EYES] = {room, room};
    for (size_t i = 0; i < n; i++) {
        const lum_group g = decode(f, &f->packets[i]);
        if (g.tag != LUM_TAG_RANGES) {
            continue;
        }
        assert_true(samples[g.eye] > room - 2 * f->options.returns_max);
        assert_int_equal(g.first_sample_index, words[g.eye]);
        assert_int_not_equal(lum_word_pixel(lum_group_word(&g, 0)),
                             pixel[g.eye]);
        words[g.eye] += g.num_samples;
        samples[g.eye] = g.num_samples;
        pixel[g.eye] = lum_word_pixel(lum_group_word(&g, g.num_samples - 1));
    }
}

static void packets_stay_full_and_cut_no_pixel(void **state)
{
    static const lum_reel_settings all[] = {{1.0f, {0.0f, 0.0f}},
                                            {1.0f, {1.0f, 2.0f}},
                                            {0.3f, {1.0f, 0.5f}},
                                            {0.02f, {1.0f, 1.0f}}};
    struct fixture *f = *state;
    for (uint32_t line = 0; line < LINES; line++) {
        for (unsigned i = 0; i < 4; i++) {
            const size_t n =
                lum_reel_line(f->reel, 1, line, &all[i], 0, f->packets);
            check_cuts(f, n, 362);
        }
    }
}

/* The least room for words, the most words for a pixel: no write leaves the
 * reel's memory. */
static void the_widest_head_and_most_returns_find_room(void **state)
{
    const lum_reel_settings settings = {1.0f, {0.0f, 0.0f}};
    struct fixture *f = *state;
    f->options.layout.profile.samples_at = 64;
    f->options.returns_max = LUM_RENDER_RETURNS_MAX;
    make_reel(f);
    for (uint32_t line = 0; line < LINES; line++) {
        const size_t n =
            lum_reel_line(f->reel, 0, line, &settings, 0, f->packets);
        check_cuts(f, n, 352);
    }
}

static void a_line_comes_back_after_other_settings(void **state)
{
    const lum_reel_settings weak = {0.01f, {1.0f, 1.0f}};
    struct fixture *f = *state;
    uint8_t *copy =
        malloc((size_t)LUM_REEL_LINE_PACKETS * LUM_PACKET_BYTES_MAX);
    assert_non_null(copy);
    const size_t n = lum_reel_line(f->reel, 1, 3, &usual, 7, f->packets);
    for (size_t i = 0; i < n; i++) {
        memcpy(copy + i * LUM_PACKET_BYTES_MAX, f->packets[i].bytes,
               f->packets[i].len);
    }
    assert_true(lum_reel_line(f->reel, 1, 3, &weak, 7, f->others) < n);
    assert_int_equal(lum_reel_line(f->reel, 1, 3, &usual, 7, f->others), n);
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(f->others[i].len, f->packets[i].len);
        assert_memory_equal(copy + i * LUM_PACKET_BYTES_MAX, f->others[i].bytes,
                            f->others[i].len);
    }
    free(copy);
}

static void every_packet_bears_the_clock_at_its_width(void **state)
{
    static const uint8_t widths[] = {4, 2, 1, 0};
    static const uint32_t seen[] = {0x89abcdefu, 0xcdefu, 0xefu, 0};
    struct fixture *f = *state;
    for (unsigned i = 0; i < 4; i++) {
        lum_profile *p = &f->options.layout.profile;
        uint8_t sample[LUM_SAMPLE_BYTES];
        p->group[LUM_FIELD_TIMESTAMP].bytes = widths[i];
        p->samples_at = (uint8_t)(20 + widths[i]);
        make_reel(f);
        (void)lum_reel_line(f->reel, 0, 0, &usual, 0, f->packets);
        memcpy(sample, f->packets[0].bytes + p->samples_at, sizeof sample);
        const size_t n =
            lum_reel_line(f->reel, 0, 0, &usual, 0x89abcdefu, f->packets);
        assert_memory_equal(sample, f->packets[0].bytes + p->samples_at,
                            sizeof sample);
        for (size_t k = 0; k < n; k++) {
            assert_int_equal(decode(f, &f->packets[k]).clock_raw, seen[i]);
        }
    }
}

static void eyes_take_turns(void **state)
{
    struct fixture *f = *state;
    const size_t n = lum_reel_line(f->reel, 0, 5, &usual, 0, f->packets);
    assert_true(n > 6);
    for (size_t i = 0; i < n; i++) {
        const lum_group g = decode(f, &f->packets[i]);
        assert_int_equal(g.line, 5);
        assert_int_equal(g.tag, i < 6 ? LUM_TAG_ANGLES : LUM_TAG_RANGES);
        assert_true(i >= 6 || g.eye == i % 2);
    }
}

static void a_reel_tells_its_size(void **state)
{
    struct fixture *f = *state;
    assert_int_equal(lum_reel_frames(f->reel), FRAMES);
    assert_int_equal(lum_reel_lines(f->reel), LINES);
}

static bool at_once(void *context)
{
    (void)context;
    return true;
}

static void what_cannot_be_rendered_is_refused(void **state)
{
    struct fixture *f = *state;
    lum_reel *none = NULL;
    const lum_reel_stop stop = {at_once, NULL};
    assert_int_equal(lum_reel_new(&f->options, 0, never, &none), LUM_E_VALUE);
    assert_int_equal(lum_reel_new(&f->options, 1, stop, &none), LUM_END);
    f->options.layout.profile.angle_lsb_pdeg = 1;
    assert_int_equal(lum_reel_new(&f->options, 1, never, &none), LUM_E_VALUE);
    f->options.layout.profile.angle_lsb_pdeg = 0;
    f->options.layout.profile.group[LUM_FIELD_FIRST_SAMPLE_INDEX].bytes = 1;
    assert_int_equal(lum_reel_new(&f->options, 1, never, &none), LUM_E_VALUE);
    assert_null(none);
    lum_reel_free(NULL);
}

static void lines_lie_where_they_are_aimed(void **state)
{
    static const int32_t wanted[LINES] = {
        40000000,  3000000,   2000000,   1990000,  0,         -1,
        -1000000,  -4000000,  -7000000,  -7000000, -10000000, -13000000,
        -16000000, -16900000, -17000000, -90000000};
    struct fixture *f = *state;
    int32_t *aim = malloc(sizeof wanted);
    assert_non_null(aim);
    memcpy(aim, wanted, sizeof wanted);
    f->options.elevations_udeg[LUM_EYE_GREEN] = aim;
    make_reel(f);
    /* A reel keeps nothing of what it was rendered by. */
    free(aim);
    f->options.elevations_udeg[LUM_EYE_GREEN] = NULL;
    for (uint32_t line = 0; line < LINES; line++) {
        const double even = 3.0 - 20.0 * (line + 0.5) / LINES;
        const double up = fmax(-17.0, fmin(3.0, wanted[line] * 1e-6));
        (void)lum_reel_line(f->reel, 0, line, &usual, 0, f->packets);
        for (size_t i = 0; i < 6; i++) {
            const lum_group g = decode(f, &f->packets[i]);
            const lum_angle a = lum_group_angle(&f->options.layout, &g, 160);
            const double el = a.elevation / 32768.0 * 10.0 - 7.0;
            assert_true(fabs(el - (g.eye == LUM_EYE_GREEN ? up : even)) < 0.15);
        }
    }
}

static void nothing_lies_outside_the_span(void **state)
{
    struct fixture *f = *state;
    int32_t aim[LINES] = {0};
    f->options.elevations_udeg[LUM_EYE_BLUE] = aim;
    aim[3] = 40000000;
    make_reel(f);
    lum_reel *high = f->reel;
    f->reel = NULL;
    aim[3] = 3000000;
    make_reel(f);
    const size_t n = lum_reel_line(f->reel, 0, 3, &usual, 7, f->packets);
    assert_int_equal(lum_reel_line(high, 0, 3, &usual, 7, f->others), n);
    for (size_t i = 0; i < n; i++) {
        assert_int_equal(f->others[i].len, f->packets[i].len);
        assert_memory_equal(f->others[i].bytes, f->packets[i].bytes,
                            f->packets[i].len);
    }
    lum_reel_free(high);
}

int main(void)
{
#define WITH_REEL(test) cmocka_unit_test_setup_teardown(test, set_up, tear_down)
    const struct CMUnitTest tests[] = {
        WITH_REEL(at_full_power_a_line_is_what_the_renderer_gives),
        WITH_REEL(without_gain_there_are_angles_alone),
        WITH_REEL(less_power_and_higher_thresholds_show_less),
        WITH_REEL(a_threshold_below_the_faintest_shows_the_faintest),
        WITH_REEL(a_threshold_is_one_eyes_own),
        WITH_REEL(thinned_lines_have_as_many_words_as_rendered_ones),
        WITH_REEL(packets_stay_full_and_cut_no_pixel),
        WITH_REEL(the_widest_head_and_most_returns_find_room),
        WITH_REEL(a_line_comes_back_after_other_settings),
        WITH_REEL(every_packet_bears_the_clock_at_its_width),
        WITH_REEL(eyes_take_turns),
        WITH_REEL(a_reel_tells_its_size),
        WITH_REEL(what_cannot_be_rendered_is_refused),
        WITH_REEL(lines_lie_where_they_are_aimed),
        WITH_REEL(nothing_lies_outside_the_span),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
