#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "strongest.h"

#include <string.h>

#define WORDS_MAX 400u

struct scene {
    lum_projector projector;
    lum_line line;
    lum_angle angles[LUM_LINE_PIXELS];
    uint32_t marks[LUM_PIXEL_MARK_WORDS];
    uint32_t words[WORDS_MAX];
    lum_return returns[2][WORDS_MAX];
    lum_sample all[WORDS_MAX];
    lum_sample chosen[WORDS_MAX];
    uint8_t marked[WORDS_MAX];
};

static uint32_t next_random(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* Several words in most pixels, equal pulses among them, words too near to be
 * points, and pixels without angles. */
static void fill(struct scene *s, uint32_t *seed)
{
    lum_calibration calibration;
    lum_layout layout;
    lum_calibration_default(&calibration);
    calibration.eye[0].tof_offset_fs = -130000; /* ten steps */
    lum_layout_default(&layout);
    assert_int_equal(lum_projector_init(&s->projector, &calibration, &layout),
                     LUM_OK);
    for (size_t i = 0; i < LUM_PIXEL_MARK_WORDS; i++) {
        s->marks[i] = next_random(seed) | next_random(seed) << 16;
    }
    s->line =
        (lum_line){.angles = s->angles,
                   .angle_marks = s->marks,
                   .words = s->words,
                   .angle_count = (uint16_t)(next_random(seed) % 2u * 1000u)};
    for (uint32_t pixel = 0; s->line.word_count < WORDS_MAX; pixel++) {
        for (uint32_t n = next_random(seed) % 7u;
             n > 0 && s->line.word_count < WORDS_MAX; n--) {
            s->words[s->line.word_count++] =
                lum_word_make((int32_t)(next_random(seed) % 40u),
                              next_random(seed) % 3u != 0, pixel);
        }
    }
}

static size_t choose(struct scene *s, lum_edges edges,
                     lum_return_choice returns, lum_sample *out)
{
    lum_selection selection;
    lum_sample_workspace workspace = {.returns = s->returns[0]};
    lum_point_losses losses = {0, 0};
    lum_selection_default(&selection);
    selection.edges = edges;
    selection.returns = returns;
    return lum_samples_compute(&s->projector, &s->line, &selection, &workspace,
                               out, &losses);
}

static void assert_marks(struct scene *s, lum_edges edges)
{
    const size_t all = choose(s, edges, LUM_RETURNS_ALL, s->all);
    const size_t chosen = choose(s, edges, LUM_RETURNS_STRONGEST, s->chosen);
    size_t n = 0;
    memset(s->marked, 0xff, sizeof s->marked);
    strongest_mark(&s->line, s->returns[1], s->all, all, s->marked);
    for (size_t i = 0; i < all; i++) {
        assert_true(s->marked[i] <= 1);
        if (s->marked[i] == 1) {
            assert_true(n < chosen);
            assert_memory_equal(&s->all[i], &s->chosen[n], sizeof *s->all);
            n++;
        }
    }
    assert_int_equal(n, chosen);
}

static void marked_are_those_that_a_selection_chooses(void **state)
{
    static struct scene scene;
    uint32_t seed = 1;
    (void)state;
    for (int round = 0; round < 200; round++) {
        fill(&scene, &seed);
        assert_marks(&scene, LUM_EDGES_RISING);
        assert_marks(&scene, LUM_EDGES_FALLING);
        assert_marks(&scene, LUM_EDGES_BOTH);
    }
}

static void a_line_without_words_marks_nothing(void **state)
{
    static struct scene scene;
    (void)state;
    scene.line = (lum_line){.words = scene.words};
    scene.marked[0] = 9;
    strongest_mark(&scene.line, scene.returns[0], scene.all, 0, scene.marked);
    assert_int_equal(scene.marked[0], 9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(marked_are_those_that_a_selection_chooses),
        cmocka_unit_test(a_line_without_words_marks_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
