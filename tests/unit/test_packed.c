#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "support.h"
#include "unpacked.h"

#include "lum/frame/clock_fit.h"
#include "lum/frame/packed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST 20000u

/* Columns, and a part of them. */
struct points {
    float x[MOST];
    float y[MOST];
    float z[MOST];
    float width[MOST];
    uint32_t line[MOST];
    uint16_t pixel[MOST];
    uint16_t number[MOST];
    uint16_t returns[MOST];
    uint8_t eye[MOST];
    uint8_t edge[MOST];
    uint8_t strongest[MOST];
    lum_packed_part part;
};

static const lum_packed_head head = {.struct_size = sizeof head,
                                     .frame = 3,
                                     .clock_us = 1500,
                                     .utc_ns = INT64_C(2500000000),
                                     .utc_error_ns = INT64_C(250000000),
                                     .complete_ns = INT64_C(500000000),
                                     .lost_words = 9,
                                     .shown = 17,
                                     .sensor = 0x0a2a0025u,
                                     .lines = 128,
                                     .time = LUM_PACKED_TIME_FITTED,
                                     .edges = LUM_EDGES_BOTH,
                                     .smooth = 31};

static struct points *points_new(void)
{
    struct points *p = calloc(1, sizeof *p);
    assert_non_null(p);
    p->part = (lum_packed_part){.struct_size = sizeof p->part,
                                .x = p->x,
                                .y = p->y,
                                .z = p->z,
                                .pulse_width = p->width,
                                .line = p->line,
                                .pixel = p->pixel,
                                .return_number = p->number,
                                .number_of_returns = p->returns,
                                .eye = p->eye,
                                .edge = p->edge,
                                .strongest = p->strongest};
    return p;
}

/* The next point, by default alone in its pixel. */
static size_t add(struct points *p, uint32_t line, unsigned pixel, float x,
                  float y, float z)
{
    const size_t i = p->part.count++;
    assert_true(i < MOST);
    p->x[i] = x;
    p->y[i] = y;
    p->z[i] = z;
    p->width[i] = 5.0f;
    p->line[i] = line;
    p->pixel[i] = (uint16_t)pixel;
    p->number[i] = 1;
    p->returns[i] = 1;
    p->edge[i] = 1;
    p->strongest[i] = 1;
    return i;
}

static float between(uint64_t *seed, float low, float high)
{
    return low + (high - low) * (float)(next_random(seed) >> 8) / 16777216.0f;
}

/* Lines of both eyes, with pixels that have none or several points. */
static void add_lines(struct points *p, uint32_t lines, uint64_t seed)
{
    for (uint32_t line = 0; line < lines; line++) {
        for (unsigned pixel = 0; pixel < 100; pixel++) {
            const unsigned count = next_random(&seed) % 4u;
            for (unsigned k = 0; k < count; k++) {
                const size_t i =
                    add(p, line / 2u, pixel, between(&seed, 0.0f, 200.0f),
                        between(&seed, -100.0f, 100.0f),
                        between(&seed, -3.0f, 20.0f));
                p->eye[i] = (uint8_t)(line % 2u);
                p->number[i] = (uint16_t)(k + 1u);
                p->returns[i] = (uint16_t)count;
                p->strongest[i] = k == 0;
                p->edge[i] = (uint8_t)(next_random(&seed) % 2u);
                p->width[i] = between(&seed, 0.0f, 100.0f);
            }
        }
    }
}

static lum_packed pack(const struct points *p)
{
    lum_packed out = {.bytes = NULL};
    assert_int_equal(lum_packed_make(&head, &p->part, 1, &out), LUM_OK);
    return out;
}

static struct unpacked unpack_all(const lum_packed *packed)
{
    struct unpacked out;
    assert_true(unpack(packed->bytes, packed->len, &out));
    return out;
}

static unsigned kind_of(const struct points *p, size_t i)
{
    const unsigned number = p->number[i] < 127u ? p->number[i] : 127u;
    const unsigned returns = p->returns[i] < 63u ? p->returns[i] : 63u;
    return number | (unsigned)p->strongest[i] << 7 | (unsigned)p->eye[i] << 8 |
           (unsigned)p->edge[i] << 9 | returns << 10;
}

static void assert_same(const struct unpacked *u, const struct points *p)
{
    assert_int_equal(u->count, p->part.count);
    for (size_t i = 0; i < u->count; i++) {
        const float at[3] = {p->x[i], p->y[i], p->z[i]};
        for (size_t axis = 0; axis < 3; axis++) {
            assert_true(fabs(u->xyz[i][axis] - (double)at[axis]) <=
                        u->step[i] / 2.0);
        }
        assert_true(fabs(u->width[i] * 0.01 - (double)p->width[i]) < 0.0051);
        assert_int_equal(u->line[i], p->line[i]);
        assert_int_equal(u->pixel[i], p->pixel[i]);
        assert_int_equal(u->turn[i] | (unsigned)u->bits[i] << 8, kind_of(p, i));
    }
}

static void assert_round_trip(const struct points *p)
{
    lum_packed packed = pack(p);
    struct unpacked u = unpack_all(&packed);
    assert_same(&u, p);
    unpacked_free(&u);
    lum_packed_free(&packed);
}

static void a_frame_is_the_bytes_of_its_layout(void **state)
{
    static const uint8_t want[] = {
        'L', 'U', 'M', 'F', 5, 0, 104, 0, /* */
        0, 0, 0, 0, 0, 0, 0x08, 0x40,     /* 3.0 */
        0, 0, 0, 0, 0, 0x70, 0x97, 0x40,  /* 1500.0 */
        0, 0, 0, 0, 0, 0, 0x04, 0x40,     /* 2.5 */
        3, 0, 0, 0, 3, 31, 2, 0,          /* */
        128, 0, 0, 0, 9, 0, 0, 0,         /* */
        0x25, 0, 0x2a, 0x0a, 17, 0, 0, 0, /* */
        0, 0, 0, 0, 0, 0, 0xe0, 0x3f,     /* 0.5 */
        0, 0, 0, 0, 0, 0, 0xd0, 0x3f,     /* 0.25 */
        0, 0, 0, 0, 0, 0, 0, 0x3b,        /* 2^-9 */
        168, 0, 0, 0, 0, 0, 0, 0,         /* its bytes, piece 0 */
        1, 0, 0, 0, 3, 0, 0, 0,           /* of 1; points */
        1, 0, 0, 0, 0, 0, 0, 0,           /* runs, kinds */
        /* the run */
        0, 0, 0, 0, 0x04, 0x03, 0x02, 0x01, /* line */
        0x00, 0x10, 0, 0,                   /* x from 1 m */
        0x00, 0xe0, 0xff, 0xff,             /* y from -2 m */
        0, 0, 0, 0,                         /* z */
        3, 0, 7, 0,                         /* points, pixel */
        0x81, 0x0a, 0x02, 0x0a, 0x81, 0x06, /* kinds */
        12, 1,                              /* 2^-12 m, green */
        /* x, y, z, width */
        0, 0, 0, 0x08, 0, 0x30, 0, 0, 0, 0x10, 0, 0x50, 0, 0, 0, 0, 1, 0, 0xd3,
        0x04, 0, 0, 0xff, 0xff,
        /* high bits: y of the last 5 m + 16 m; kinds */
        0x00, 0x40, 0x84, 0,
        /* pixels 7, 7, 9; end */
        0x13, 0, 0, 0};
    struct points *p = points_new();
    (void)state;
    (void)add(p, 0x01020304u, 7, 1.0f, -2.0f, 0.0f);
    (void)add(p, 0x01020304u, 7, 1.5f, -1.0f, 0.0f);
    (void)add(p, 0x01020304u, 9, 4.0f, 19.0f, 0.000244140625f);
    p->returns[0] = p->returns[1] = 2;
    p->number[1] = 2;
    p->strongest[1] = 0;
    p->edge[2] = 1;
    p->returns[2] = 1;
    p->eye[0] = p->eye[1] = p->eye[2] = 1;
    p->width[0] = 12.35f;
    p->width[1] = 0.0f;
    p->width[2] = 700.0f;
    lum_packed packed = pack(p);
    assert_int_equal(packed.len, sizeof want);
    assert_memory_equal(packed.bytes, want, sizeof want);
    lum_packed_free(&packed);
    free(p);
}

static void points_come_back_within_half_a_step(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        struct points *p = points_new();
        add_lines(p, 1u + (uint32_t)seed * 5u, seed);
        assert_round_trip(p);
        free(p);
    }
}

/* 9 bytes of a point, its pixel, and little else. */
static void a_point_needs_less_than_10_bytes(void **state)
{
    struct points *p = points_new();
    (void)state;
    for (uint32_t i = 0; i < MOST; i++) {
        const float turn = (float)(i % 1000u) * 0.002f - 1.0f;
        (void)add(p, i / 1000u, i % 1000u, 150.0f * cosf(turn),
                  150.0f * sinf(turn), 1.0f);
    }
    lum_packed packed = pack(p);
    assert_true((double)packed.len / MOST < 9.5);
    lum_packed_free(&packed);
    free(p);
}

/* Lines near the sensor have finer steps. */
static void steps_are_as_fine_as_the_run_allows(void **state)
{
    static const struct {
        float reach;
        double step;
    } cases[] = {{0.0f, 1.0 / 4096},   {63.99f, 1.0 / 4096},
                 {64.01f, 1.0 / 2048}, {127.9f, 1.0 / 2048},
                 {128.1f, 1.0 / 1024}, {255.9f, 1.0 / 1024},
                 {256.1f, 1.0 / 512},  {511.9f, 1.0 / 512}};
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        struct points *p = points_new();
        (void)add(p, 1, 1, 0.0f, -1.0f, 0.0f);
        (void)add(p, 1, 2, 0.0f, -1.0f + cases[i].reach, 0.0f);
        lum_packed packed = pack(p);
        struct unpacked u = unpack_all(&packed);
        assert_true(u.step[0] >= cases[i].step && u.step[0] <= cases[i].step);
        assert_same(&u, p);
        unpacked_free(&u);
        lum_packed_free(&packed);
        free(p);
    }
}

static void a_line_that_is_wider_than_18_bits_is_cut(void **state)
{
    struct points *p = points_new();
    (void)state;
    for (unsigned i = 0; i < 1000; i++) {
        (void)add(p, 1, i, (float)i * 100.0f, i % 2u == 0 ? 0.0f : -4000.0f,
                  1e5f);
    }
    assert_round_trip(p);
    free(p);
}

/* What no sensor gives is not worse than wrong. */
static void numbers_that_are_none_end_nowhere(void **state)
{
    static const float odd[] = {(float)NAN, (float)INFINITY, (float)-INFINITY,
                                3e38f,      -3e38f,          0.0f};
    struct points *p = points_new();
    (void)state;
    for (unsigned i = 0; i < 216; i++) {
        const size_t k =
            add(p, 1, i, odd[i % 6u], odd[i / 6u % 6u], odd[i / 36u % 6u]);
        p->width[k] = odd[i % 6u];
    }
    lum_packed packed = pack(p);
    struct unpacked u = unpack_all(&packed);
    for (size_t i = 0; i < u.count; i++) {
        assert_int_equal(u.pixel[i], i);
        assert_true(isfinite(u.xyz[i][0]) && isfinite(u.xyz[i][2]));
    }
    unpacked_free(&u);
    lum_packed_free(&packed);
    free(p);
}

static void what_does_not_fit_its_field_is_the_most_it_can_be(void **state)
{
    struct points *p = points_new();
    lum_packed_head much = head;
    lum_packed packed = {.bytes = NULL};
    (void)state;
    const size_t i = add(p, UINT32_MAX, UINT16_MAX, 1.0f, 2.0f, 3.0f);
    p->number[i] = 128;
    p->returns[i] = 64;
    p->width[i] = 655.36f;
    much.lost_words = UINT64_C(1) << 33;
    much.utc_error_ns = LUM_CLOCK_ERROR_UNKNOWN;
    assert_int_equal(lum_packed_make(&much, &p->part, 1, &packed), LUM_OK);
    struct unpacked u = unpack_all(&packed);
    assert_int_equal(u.line[0], UINT32_MAX);
    assert_int_equal(u.pixel[0], UINT16_MAX);
    assert_int_equal(u.turn[0], 0xff);
    assert_int_equal(u.bits[0] >> 2, 63);
    assert_int_equal(u.width[0], 65535);
    assert_int_equal(unpacked_u32(packed.bytes, 44), UINT32_MAX);
    assert_true(isnan(unpacked_double(packed.bytes, 64)));
    unpacked_free(&u);
    lum_packed_free(&packed);
    free(p);
}

static void a_frame_without_points_is_one_piece(void **state)
{
    struct points *p = points_new();
    (void)state;
    lum_packed packed = pack(p);
    assert_int_equal(packed.len, LUM_PACKED_HEAD_BYTES);
    assert_int_equal(lum_packed_piece(&packed, 0), packed.len);
    assert_int_equal(lum_packed_piece(&packed, packed.len), 0);
    struct unpacked u = unpack_all(&packed);
    assert_int_equal(u.pieces, 1);
    unpacked_free(&u);
    lum_packed_free(&packed);
    assert_int_equal(lum_packed_piece(&packed, 0), 0);
    free(p);
}

/* The farthest that a line of an eye is from one that has come, when so many
 * pieces have. */
static uint32_t widest_gap(const struct unpacked *u, const lum_packed *packed,
                           size_t pieces, unsigned eye)
{
    bool has[512] = {false};
    size_t at = 0;
    for (size_t k = 0; k < pieces; k++) {
        const uint8_t *b = packed->bytes + at;
        for (uint32_t run = 0; run < unpacked_u32(b, 96); run++) {
            const uint8_t *r = b + LUM_PACKED_HEAD_BYTES + 32u * run;
            if (r[31] == eye) {
                has[u->line[unpacked_u32(r, 0)]] = true;
            }
        }
        at += lum_packed_piece(packed, at);
    }
    uint32_t gap = 0;
    uint32_t widest = 0;
    for (uint32_t line = 0; line <= u->line[u->count - 1u]; line++) {
        gap = has[line] ? 0 : gap + 1u;
        widest = gap > widest ? gap : widest;
    }
    return widest;
}

static void the_first_pieces_are_spread_over_the_frame(void **state)
{
    struct points *p = points_new();
    (void)state;
    add_lines(p, 128, 5); /* 64 of each eye */
    lum_packed packed = pack(p);
    struct unpacked u = unpack_all(&packed);
    assert_true(u.pieces > 3);
    const uint32_t in_first = unpacked_u32(packed.bytes, 96);
    for (unsigned eye = 0; eye < 2; eye++) {
        assert_in_range(widest_gap(&u, &packed, 1, eye), 1,
                        4u * 128u / in_first);
        assert_int_equal(widest_gap(&u, &packed, u.pieces, eye), 0);
    }
    unpacked_free(&u);
    lum_packed_free(&packed);
    free(p);
}

static void a_line_can_be_longer_than_a_run(void **state)
{
    struct points *p = points_new();
    (void)state;
    for (unsigned i = 0; i < MOST; i++) {
        const size_t k = add(p, 1, i / 20u, (float)i * 0.001f, 0.0f, 0.0f);
        p->number[k] = (uint16_t)(i % 20u + 1u);
        p->returns[k] = 20;
    }
    assert_round_trip(p);
    free(p);
}

static void lines_whose_pixels_fall_are_runs_of_their_own(void **state)
{
    struct points *p = points_new();
    (void)state;
    for (unsigned i = 0; i < 3000; i++) {
        (void)add(p, 1, 65535u - i * 20u, 1.0f, 2.0f, 3.0f);
    }
    (void)add(p, 1, 65535, 1.0f, 2.0f, 3.0f);
    assert_round_trip(p);
    free(p);
}

static void parts_are_told_by_the_head(void **state)
{
    struct points *one = points_new();
    struct points *other = points_new();
    lum_packed_head rig = head;
    lum_packed packed = {.bytes = NULL};
    (void)state;
    add_lines(one, 30, 1);
    add_lines(other, 20, 2);
    const lum_packed_part two[] = {one->part, other->part};
    assert_int_equal(lum_packed_make(&head, two, 2, &packed), LUM_OK);
    assert_int_equal(packed.bytes[39], 0);
    assert_int_equal(unpacked_u32(packed.bytes, 32),
                     one->part.count + other->part.count);
    assert_int_equal(unpacked_u32(packed.bytes, 72), other->part.count);
    rig.is_rig = true;
    lum_packed_part sensors[] = {one->part, other->part};
    sensors[0].frame = 7;
    sensors[0].sensor = 2;
    sensors[1].frame = -1;
    assert_int_equal(lum_packed_make(&rig, sensors, 2, &packed), LUM_OK);
    struct unpacked u = unpack_all(&packed);
    const uint8_t *b = packed.bytes + LUM_PACKED_HEAD_BYTES;
    assert_int_equal(packed.bytes[39], 2);
    assert_int_equal(unpacked_u32(packed.bytes, 72), 0);
    assert_true(unpacked_double(b, 0) == 7.0);
    assert_int_equal(unpacked_u32(b, 8), one->part.count);
    assert_int_equal(unpacked_u32(b, 12), 2);
    assert_true(unpacked_double(b, 16) == -1.0);
    assert_int_equal(unpacked_u32(b, 24), other->part.count);
    assert_int_equal(u.line[one->part.count], other->line[0]);
    unpacked_free(&u);
    lum_packed_free(&packed);
    free(one);
    free(other);
}

static void every_truncation_is_noticed(void **state)
{
    struct points *p = points_new();
    (void)state;
    add_lines(p, 6, 3);
    lum_packed packed = pack(p);
    for (size_t n = 0; n < packed.len; n++) {
        struct unpacked u;
        uint8_t *exact = exact_copy(packed.bytes, n);
        assert_false(unpack(exact, n, &u));
        unpacked_free(&u);
        free(exact);
    }
    lum_packed_free(&packed);
    free(p);
}

static void memory_is_used_again(void **state)
{
    struct points *p = points_new();
    (void)state;
    add_lines(p, 20, 1);
    lum_packed packed = pack(p);
    const uint8_t *before = packed.bytes;
    const size_t room = packed.room;
    p->part.count /= 2u;
    assert_int_equal(lum_packed_make(&head, &p->part, 1, &packed), LUM_OK);
    assert_ptr_equal(packed.bytes, before);
    assert_int_equal(packed.room, room);
    struct unpacked u = unpack_all(&packed);
    assert_same(&u, p);
    unpacked_free(&u);
    lum_packed_free(&packed);
    assert_null(packed.bytes);
    free(p);
}

static void what_cannot_be_is_refused(void **state)
{
    struct points *p = points_new();
    lum_packed_part parts[LUM_PACKED_PARTS_MAX + 1u];
    lum_packed out = {.bytes = NULL};
    lum_packed_head other = head;
    (void)state;
    (void)add(p, 1, 1, 1.0f, 2.0f, 3.0f);
    for (size_t i = 0; i <= LUM_PACKED_PARTS_MAX; i++) {
        parts[i] = p->part;
    }
    assert_int_equal(lum_packed_make(&head, parts, 0, &out), LUM_E_VALUE);
    assert_int_equal(lum_packed_make(&head, parts, 3, &out), LUM_E_VALUE);
    other.is_rig = true;
    assert_int_equal(lum_packed_make(&other, parts, LUM_PACKED_PARTS_MAX, &out),
                     LUM_OK);
    assert_int_equal(
        lum_packed_make(&other, parts, LUM_PACKED_PARTS_MAX + 1u, &out),
        LUM_E_VALUE);
    assert_int_equal(out.len, 0);
    parts[1].count = LUM_PACKED_POINTS_MAX;
    assert_int_equal(lum_packed_make(&head, parts, 2, &out), LUM_E_VALUE);
    parts[0].struct_size = 0;
    assert_int_equal(lum_packed_make(&head, parts, 1, &out), LUM_E_VALUE);
    other.struct_size = 0;
    assert_int_equal(lum_packed_make(&other, &p->part, 1, &out), LUM_E_VALUE);
    lum_packed_free(&out);
    free(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_is_the_bytes_of_its_layout),
        cmocka_unit_test(points_come_back_within_half_a_step),
        cmocka_unit_test(a_point_needs_less_than_10_bytes),
        cmocka_unit_test(steps_are_as_fine_as_the_run_allows),
        cmocka_unit_test(a_line_that_is_wider_than_18_bits_is_cut),
        cmocka_unit_test(numbers_that_are_none_end_nowhere),
        cmocka_unit_test(what_does_not_fit_its_field_is_the_most_it_can_be),
        cmocka_unit_test(a_frame_without_points_is_one_piece),
        cmocka_unit_test(the_first_pieces_are_spread_over_the_frame),
        cmocka_unit_test(a_line_can_be_longer_than_a_run),
        cmocka_unit_test(lines_whose_pixels_fall_are_runs_of_their_own),
        cmocka_unit_test(parts_are_told_by_the_head),
        cmocka_unit_test(every_truncation_is_noticed),
        cmocka_unit_test(memory_is_used_again),
        cmocka_unit_test(what_cannot_be_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
