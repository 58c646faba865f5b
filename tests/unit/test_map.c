/* The map: counts and nearest points against a plain search, whatever part of
 * it is on the disk, in whatever order points come. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/map/map.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define POINTS 60000u
#define VOXEL  0.25

/* Points of a road, some of them at equal places, and what they become. */
struct road {
    float x[POINTS];
    float y[POINTS];
    float z[POINTS];
    float width[POINTS];
    float time[POINTS];
    size_t order[POINTS]; /* of the points, by voxel */
};

/* --- Points --- */

static uint64_t state = 1;

static uint32_t next_random(void)
{
    state = state * UINT64_C(6364136223846793005) + 1442695040888963407u;
    return (uint32_t)(state >> 33);
}

static float between(float from, float to)
{
    return from + (to - from) * (float)(next_random() % 100000u) / 100000.0f;
}

/* Places are multiples of 1/64 m, so that points lie equally near. */
static float place(float from, float to)
{
    return roundf(between(from, to) * 64.0f) / 64.0f;
}

static void make(struct road *road, uint64_t seed)
{
    state = seed;
    for (size_t i = 0; i < POINTS; i++) {
        road->x[i] = place(-300.0f, 300.0f);
        road->y[i] = next_random() % 2u == 0 ? place(-2.0f, 2.0f) : 7.5f;
        road->z[i] = place(-1.0f, 1.0f);
        road->width[i] = (float)(next_random() % 5u);
        road->time[i] = (float)(next_random() % 3u);
    }
}

/* --- What it becomes --- */

static const struct road *sorted; /* for comparing */

static int64_t voxel_at(float v)
{
    return (int64_t)floor((double)v / VOXEL);
}

static double from_centre(const struct road *r, size_t i)
{
    const float at[3] = {r->x[i], r->y[i], r->z[i]};
    double sum = 0;
    for (unsigned k = 0; k < 3u; k++) {
        const double centre = ((double)voxel_at(at[k]) + 0.5) * VOXEL;
        sum += ((double)at[k] - centre) * ((double)at[k] - centre);
    }
    return sum;
}

static int by(double one, double other)
{
    return one < other ? -1 : one > other;
}

static int compare_voxels(size_t a, size_t b)
{
    const struct road *r = sorted;
    const int64_t one[3] = {voxel_at(r->x[a]), voxel_at(r->y[a]),
                            voxel_at(r->z[a])};
    const int64_t other[3] = {voxel_at(r->x[b]), voxel_at(r->y[b]),
                              voxel_at(r->z[b])};
    for (unsigned k = 0; k < 3u; k++) {
        if (one[k] != other[k]) {
            return one[k] < other[k] ? -1 : 1;
        }
    }
    return 0;
}

/* By voxel, then by the rule of lum_map_next(). */
static int compare(const void *one, const void *other)
{
    const struct road *r = sorted;
    const size_t a = *(const size_t *)one;
    const size_t b = *(const size_t *)other;
    const double differences[][2] = {
        {from_centre(r, a), from_centre(r, b)},
        {r->time[a], r->time[b]},
        {r->x[a], r->x[b]},
        {r->y[a], r->y[b]},
        {r->z[a], r->z[b]},
        {r->width[a], r->width[b]},
    };
    int result = compare_voxels(a, b);
    for (size_t k = 0; result == 0 && k < 6u; k++) {
        result = by(differences[k][0], differences[k][1]);
    }
    return result;
}

/* Tiles are of 64 m: voxels of one tile come before those of the next. */
static int compare_tiles(const void *one, const void *other)
{
    const lum_map_voxel *a = one;
    const lum_map_voxel *b = other;
    const double edges[][2] = {{a->x, b->x}, {a->y, b->y}, {a->z, b->z}};
    for (size_t k = 0; k < 3u; k++) {
        const double tile = VOXEL * (k < 2u ? 256.0 : 65536.0);
        const int result =
            by(floor(edges[k][0] / tile), floor(edges[k][1] / tile));
        if (result != 0) {
            return result;
        }
    }
    for (size_t k = 0; k < 3u; k++) {
        const int result =
            by(floor(edges[k][0] / VOXEL), floor(edges[k][1] / VOXEL));
        if (result != 0) {
            return result;
        }
    }
    return 0;
}

static size_t search(struct road *road, lum_map_voxel *out)
{
    size_t n = 0;
    sorted = road;
    for (size_t i = 0; i < POINTS; i++) {
        road->order[i] = i;
    }
    qsort(road->order, POINTS, sizeof road->order[0], compare);
    for (size_t i = 0; i < POINTS; i++) {
        const size_t p = road->order[i];
        if (i > 0 && compare_voxels(road->order[i - 1u], p) == 0) {
            out[n - 1u].count++;
            continue;
        }
        out[n++] = (lum_map_voxel){.x = (double)road->x[p],
                                   .y = (double)road->y[p],
                                   .z = (double)road->z[p],
                                   .time_ns = 5000 + (int64_t)road->time[p] *
                                                         1000000000,
                                   .pulse_width = road->width[p],
                                   .count = 1};
    }
    qsort(out, n, sizeof *out, compare_tiles);
    return n;
}

/* --- The map --- */

static lum_map *begin(uint64_t memory, const char *spool, bool has_thread)
{
    lum_map *map = NULL;
    lum_error error = {""};
    const lum_map_options options = {.struct_size = sizeof options,
                                     .voxel = VOXEL,
                                     .memory = memory,
                                     .spool = spool,
                                     .has_thread = has_thread};
    if (lum_map_new(&options, &map, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return map;
}

static lum_map_points part_of(const struct road *road, size_t from, size_t n)
{
    return (lum_map_points){.struct_size = sizeof(lum_map_points),
                            .count = n,
                            .x = road->x + from,
                            .y = road->y + from,
                            .z = road->z + from,
                            .pulse_width = road->width + from,
                            .time = road->time + from,
                            .time_ns = 5000};
}

/* Pieces of some points each; backwards: the last piece first. */
static void add(lum_map *map, const struct road *road, bool backwards)
{
    enum {
        PIECE = 750
    };
    lum_error error = {""};
    for (size_t i = 0; i < POINTS; i += PIECE) {
        const lum_map_points points =
            part_of(road, backwards ? POINTS - PIECE - i : i, PIECE);
        if (lum_map_add(map, &points, &error) != 0) {
            fail_msg("%s", error.text);
        }
    }
}

static size_t take(lum_map *map, lum_map_voxel *out, size_t room)
{
    lum_error error = {""};
    size_t n = 0;
    size_t more = 1;
    while (more > 0) {
        if (lum_map_next(map, out + n, room < POINTS - n ? room : POINTS - n,
                         &more, &error) != 0) {
            fail_msg("%s", error.text);
        }
        n += more;
        if (n == POINTS) {
            break;
        }
    }
    return n;
}

static void assert_same(const lum_map_voxel *got, size_t got_count,
                        const lum_map_voxel *wanted, size_t count)
{
    assert_int_equal(got_count, count);
    for (size_t i = 0; i < count; i++) {
        assert_true(fabs(got[i].x - wanted[i].x) < VOXEL / 65536.0 &&
                    fabs(got[i].y - wanted[i].y) < VOXEL / 65536.0 &&
                    fabs(got[i].z - wanted[i].z) < VOXEL / 65536.0);
        assert_int_equal(got[i].time_ns, wanted[i].time_ns);
        assert_true(got[i].pulse_width == wanted[i].pulse_width);
        assert_int_equal(got[i].count, wanted[i].count);
    }
}

static lum_map_counters count(lum_map *map)
{
    lum_map_counters counters = {.struct_size = sizeof counters};
    assert_int_equal(lum_map_count(map, &counters), 0);
    return counters;
}

static struct road road;
static lum_map_voxel wanted[POINTS];
static lum_map_voxel got[POINTS];

static void a_map_is_what_a_plain_search_finds(void **unused)
{
    (void)unused;
    for (uint64_t seed = 1; seed <= 2u; seed++) {
        make(&road, seed);
        const size_t n = search(&road, wanted);
        for (unsigned kind = 0; kind < 8u; kind++) {
            const bool is_small = (kind & 1u) != 0;
            lum_map *map = begin(is_small ? LUM_MAP_MEMORY_MIN : 0,
                                 "./test_map", (kind & 2u) != 0);
            add(map, &road, (kind & 4u) != 0);
            const lum_map_counters before = count(map);
            assert_true(before.voxels_most >= n);
            assert_true((before.spooled > 0) == is_small);
            assert_true(before.memory_most <=
                        (is_small ? 2u * LUM_MAP_MEMORY_MIN : LUM_MAP_MEMORY));
            const size_t got_count = take(map, got, is_small ? 7 : POINTS);
            assert_same(got, got_count, wanted, n);
            assert_int_equal(count(map).points, POINTS);
            assert_int_equal(count(map).voxels, n);
            lum_map_free(map);
        }
    }
}

/* Every tile goes to the disk again and again: a part has at most the voxels of
 * its tile, so some tile has had more than 65. */
static void many_parts_of_a_tile_become_one(void **unused)
{
    (void)unused;
    make(&road, 3);
    const size_t n = search(&road, wanted);
    for (size_t i = 0; i < n; i++) {
        wanted[i].count *= 80u;
    }
    lum_map *map = begin(LUM_MAP_MEMORY_MIN, "./test_map", false);
    for (unsigned round = 0; round < 80u; round++) {
        add(map, &road, false);
    }
    assert_true(count(map).spooled / 24u > 65u * n);
    assert_same(got, take(map, got, 1000), wanted, n);
    lum_map_free(map);
}

static void what_has_no_place_is_counted(void **unused)
{
    (void)unused;
    float at[6] = {1.0f, NAN, INFINITY, 1e30f, -1e30f, 2.0f};
    float zero[6] = {0};
    lum_error error = {""};
    size_t n = 0;
    lum_map *map = begin(0, NULL, false);
    lum_map_points points = {.struct_size = sizeof points,
                             .count = 6,
                             .x = at,
                             .y = zero,
                             .z = zero,
                             .origin = {4e6, -5e6, 1e6}};
    assert_int_equal(lum_map_add(map, &points, &error), 0);
    assert_int_equal(lum_map_next(map, got, POINTS, &n, &error), 0);
    assert_int_equal(n, 2);
    assert_true(fabs(got[1].x - 4000002.0) < 1e-5 &&
                fabs(got[1].y + 5e6) < 1e-5 && fabs(got[1].z - 1e6) < 1e-5);
    assert_int_equal(count(map).not_finite, 2);
    assert_int_equal(count(map).out_of_range, 2);
    assert_int_equal(lum_map_add(map, &points, &error), -1);
    assert_non_null(strstr(error.text, "make a new map"));
    lum_map_free(map);
}

static void a_time_that_is_none_is_that_of_all(void **unused)
{
    (void)unused;
    const float at[5] = {1.0f, 2.0f, 3.0f, 4.0f, 5.0f};
    const float zero[5] = {0};
    const float time[5] = {2.0f, NAN, 8.9e9f, -8.9e9f, -INFINITY};
    const int64_t now_ns = INT64_C(1764349529000000000);
    lum_error error = {""};
    size_t n = 0;
    lum_map *map = begin(0, NULL, false);
    const lum_map_points points = {.struct_size = sizeof points,
                                   .count = 5,
                                   .x = at,
                                   .y = zero,
                                   .z = zero,
                                   .time = time,
                                   .time_ns = now_ns};
    assert_int_equal(lum_map_add(map, &points, &error), 0);
    assert_int_equal(lum_map_next(map, got, POINTS, &n, &error), 0);
    assert_int_equal(n, 5);
    for (size_t i = 0; i < n; i++) {
        assert_true(got[i].time_ns == now_ns + (i == 0 ? 2000000000 : 0));
    }
    lum_map_free(map);
}

static void a_map_that_does_not_fit_says_what_would(void **unused)
{
    (void)unused;
    static const struct {
        const char *spool;
        const char *text;
        int code;
    } cases[] = {
        {NULL, "more memory, or larger voxels", ENOMEM},
        {"./no/such/folder/map.las",
         "./no/such/folder/map.las: after 0 MiB, the map's temporary file "
         "beside it cannot be written: No such file or directory; free some of "
         "the disk, put the map on another, or take larger voxels",
         ENOENT}};
    make(&road, 1);
    for (size_t i = 0; i < 4u; i++) {
        lum_error error = {""};
        lum_map *map =
            begin(LUM_MAP_MEMORY_MIN, cases[i / 2u].spool, i % 2u == 0);
        const lum_map_points points = part_of(&road, 0, POINTS);
        size_t n = 0;
        if (lum_map_add(map, &points, &error) == 0) {
            assert_int_equal(lum_map_next(map, got, POINTS, &n, &error), -1);
        }
        assert_int_equal(errno, cases[i / 2u].code);
        assert_non_null(strstr(error.text, cases[i / 2u].text));
        assert_int_equal(lum_map_next(map, got, POINTS, &n, &error), -1);
        lum_map_free(map);
    }
}

static void options_that_are_not_allowed_are_refused(void **unused)
{
    (void)unused;
    static const lum_map_options refused[] = {
        {.struct_size = sizeof(lum_map_options), .voxel = 0.001},
        {.struct_size = sizeof(lum_map_options), .voxel = NAN},
        {.struct_size = sizeof(lum_map_options), .voxel = 101.0},
        {.struct_size = sizeof(lum_map_options), .voxel = 1, .memory = 5},
        {.voxel = 1}};
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        lum_map *map = NULL;
        lum_error error = {""};
        errno = 0;
        assert_int_equal(lum_map_new(&refused[i], &map, &error), -1);
        assert_int_equal(errno, EINVAL);
        assert_true(error.text[0] != '\0');
        assert_null(map);
    }
}

static void nothing_gives_nothing(void **unused)
{
    (void)unused;
    lum_map *map = begin(0, NULL, true);
    assert_int_equal(take(map, got, 5), 0);
    assert_int_equal(count(map).tiles, 0);
    lum_map_free(map);
    lum_map_free(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_map_is_what_a_plain_search_finds),
        cmocka_unit_test(many_parts_of_a_tile_become_one),
        cmocka_unit_test(what_has_no_place_is_counted),
        cmocka_unit_test(a_time_that_is_none_is_that_of_all),
        cmocka_unit_test(a_map_that_does_not_fit_says_what_would),
        cmocka_unit_test(options_that_are_not_allowed_are_refused),
        cmocka_unit_test(nothing_gives_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
