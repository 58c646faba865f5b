#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "zone.h"

#include "lum/group.h"

#define MM(x) ((x)*LUM_FIXED_PER_MM)

static const zone box = {.min = {MM(1), MM(-2), MM(-3)},
                         .max = {MM(4), MM(5), MM(6)}};

/* 100 mm far, from 45 degrees on the left to 26.6 on the right. */
static const zone sector = {.min = {MM(-1000), MM(-1000), MM(-1000)},
                            .max = {MM(1000), MM(1000), MM(1000)},
                            .range = MM(100),
                            .left = ZONE_SLOPE_ONE,
                            .right = -ZONE_SLOPE_ONE / 2};

static lum_fixed_point point(int32_t x, int32_t y, int32_t z)
{
    return (lum_fixed_point){
        .x = x, .y = y, .z = z, .word = lum_word_make(1, true, 0)};
}

static bool holds(const zone *z, int32_t x, int32_t y, int32_t up)
{
    const lum_fixed_point p = point(x, y, up);
    return zone_holds(z, &p);
}

static void a_box_includes_its_faces(void **state)
{
    (void)state;
    for (unsigned axis = 0; axis < 3; axis++) {
        int32_t at[3] = {MM(2), MM(1), MM(1)};
        at[axis] = box.min[axis];
        assert_true(holds(&box, at[0], at[1], at[2]));
        at[axis]--;
        assert_false(holds(&box, at[0], at[1], at[2]));
        at[axis] = box.max[axis];
        assert_true(holds(&box, at[0], at[1], at[2]));
        at[axis]++;
        assert_false(holds(&box, at[0], at[1], at[2]));
    }
}

/* Exactly at an edge's slope, however far. */
static void a_sector_includes_its_edges(void **state)
{
    zone wide = sector;
    (void)state;
    for (int32_t x = 2; x < MM(70); x += 2 * 997) {
        assert_true(holds(&sector, x, x, 0));
        assert_false(holds(&sector, x, x + 1, 0));
        assert_true(holds(&sector, x, -x / 2, 0));
        assert_false(holds(&sector, x, -x / 2 - 1, 0));
    }
    for (unsigned axis = 0; axis < 3; axis++) {
        wide.min[axis] = -MM(20000);
        wide.max[axis] = MM(20000);
    }
    wide.range = MM(20000);
    assert_true(holds(&wide, 2 * ZONE_SLOPE_ONE, 2 * ZONE_SLOPE_ONE, 0));
    assert_false(holds(&wide, 2 * ZONE_SLOPE_ONE, 2 * ZONE_SLOPE_ONE + 1, 0));
}

static void a_sector_ends_at_its_range(void **state)
{
    (void)state;
    assert_true(holds(&sector, MM(100), 0, 0));
    assert_false(holds(&sector, MM(100) + 1, 0, 0));
    assert_true(holds(&sector, MM(80), MM(60), MM(500))); /* seen from above */
    assert_false(holds(&sector, MM(80) + 1, MM(60), 0));
    assert_true(holds(&sector, MM(96), -MM(28), 0));
    assert_false(holds(&sector, MM(96), -MM(28) - 1, 0));
}

static void a_sector_lies_ahead(void **state)
{
    (void)state;
    assert_true(holds(&sector, 1, 0, 0));
    assert_false(holds(&sector, 0, 0, 0));
    assert_false(holds(&sector, -1, 0, 0));
    assert_false(holds(&sector, -MM(50), -MM(50), 0));
}

static void a_sector_lies_in_its_box(void **state)
{
    zone z = sector;
    (void)state;
    z.max[0] = MM(10);
    assert_true(holds(&z, MM(10), 0, 0));
    assert_false(holds(&z, MM(10) + 1, 0, 0));
}

/* Whatever the slopes are, when there is no range. */
static void a_box_alone_has_no_slopes(void **state)
{
    zone z = box;
    (void)state;
    assert_true(holds(&z, MM(2), MM(5), 0));
    z.left = 1;
    assert_true(holds(&z, MM(2), MM(5), 0));
    z.right = 1;
    assert_true(holds(&z, MM(2), -MM(2), 0));
}

/* And a sector may have an edge straight ahead. */
static void a_slope_of_0_is_an_edge(void **state)
{
    zone z = sector;
    (void)state;
    z.left = 0;
    assert_true(holds(&z, MM(50), 0, 0));
    assert_false(holds(&z, MM(50), 1, 0));
    z = sector;
    z.right = 0;
    assert_true(holds(&z, MM(50), 0, 0));
    assert_false(holds(&z, MM(50), -1, 0));
}

static void nothing_was_seen_at_first(void **state)
{
    const zone_sight sight = zone_empty();
    (void)state;
    assert_int_equal(sight.hits, 0);
    assert_true(sight.nearest_square == UINT64_MAX);
    assert_int_equal(zone_nearest_mm(&sight), 0);
}

static void each_rising_edge_in_the_zone_is_a_hit(void **state)
{
    const lum_fixed_point outside = point(MM(5), 0, 0);
    lum_fixed_point falling = point(MM(1), 0, 0);
    zone_sight sight = zone_empty();
    (void)state;
    falling.word = lum_word_make(1, false, 0);
    const lum_fixed_point points[] = {outside,
                                      point(MM(3), MM(4), 0),
                                      falling,
                                      point(MM(4), 0, MM(3)),
                                      point(MM(4), MM(4), MM(6)),
                                      outside};
    zone_look(&box, &sight, points, 6);
    assert_int_equal(sight.hits, 3);
    assert_int_equal(zone_nearest_mm(&sight), 5);
    zone_look(&box, &sight, points + 5, 1);
    assert_int_equal(sight.hits, 3);
    const lum_fixed_point near = point(MM(1), MM(2), -MM(2));
    zone_look(&box, &sight, &near, 1);
    assert_int_equal(sight.hits, 4);
    assert_int_equal(zone_nearest_mm(&sight), 3);
    zone_look(&box, &sight, points, 0);
    assert_int_equal(sight.hits, 4);
}

static void the_root_rounds_down(void **state)
{
    const uint64_t mm_square = (uint64_t)LUM_FIXED_PER_MM * LUM_FIXED_PER_MM;
    static const uint32_t roots[] = {1,    2,     3,     15,    16,
                                     1000, 65535, 65536, 700000};
    (void)state;
    for (size_t i = 0; i < sizeof roots / sizeof roots[0]; i++) {
        const uint64_t r = roots[i];
        zone_sight sight = {.hits = 1, .nearest_square = r * r * mm_square};
        assert_int_equal(zone_nearest_mm(&sight), r);
        sight.nearest_square--;
        assert_int_equal(zone_nearest_mm(&sight), r - 1);
    }
    const zone_sight here = {.hits = 1, .nearest_square = 0};
    assert_int_equal(zone_nearest_mm(&here), 0);
    const zone_sight farthest = {.hits = 1, .nearest_square = UINT64_MAX};
    assert_int_equal(zone_nearest_mm(&farthest),
                     UINT64_C(0x100000000) / LUM_FIXED_PER_MM - 1);
}

static void the_nearest_is_exact_as_far_as_points_reach(void **state)
{
    static const zone all = {.min = {INT32_MIN, INT32_MIN, INT32_MIN},
                             .max = {INT32_MAX, INT32_MAX, INT32_MAX}};
    static const struct {
        int32_t x, y, z;
        uint32_t mm;
    } rows[] = {
        {MM(3000), MM(-4000), 0, 5000},
        {MM(2000), MM(-3000), MM(6000), 7000},
        {MM(1), 0, 0, 1},
        {MM(1) - 1, 0, 0, 0},
        {1400000000, 1400000000, -1400000000, 151554445},
        {INT32_MIN, INT32_MIN, INT32_MIN, 232471924},
    };
    (void)state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const lum_fixed_point points[] = {
            {INT32_MIN, INT32_MIN, INT32_MIN, LUM_WORD_RISING},
            {rows[i].x, rows[i].y, rows[i].z, LUM_WORD_RISING},
            {0, 0, 0, 0}, /* a falling edge */
        };
        zone_sight sight = zone_empty();
        zone_look(&all, &sight, points, 3);
        assert_int_equal(sight.hits, 2);
        assert_int_equal(zone_nearest_mm(&sight), rows[i].mm);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_box_includes_its_faces),
        cmocka_unit_test(a_sector_includes_its_edges),
        cmocka_unit_test(a_sector_ends_at_its_range),
        cmocka_unit_test(a_sector_lies_ahead),
        cmocka_unit_test(a_sector_lies_in_its_box),
        cmocka_unit_test(a_box_alone_has_no_slopes),
        cmocka_unit_test(a_slope_of_0_is_an_edge),
        cmocka_unit_test(nothing_was_seen_at_first),
        cmocka_unit_test(each_rising_edge_in_the_zone_is_a_hit),
        cmocka_unit_test(the_root_rounds_down),
        cmocka_unit_test(the_nearest_is_exact_as_far_as_points_reach),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
