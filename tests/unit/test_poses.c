#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/frame/poses.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define S INT64_C(1000000000)

static const char tum[] =
    "# timestamp tx ty tz qx qy qz qw\n"
    "1764349529.000000001 1 2 3 0 0 0 1\r\n"
    "\n"
    "1764349529.5\t-1.5e0 +2 .25 0 0 0.70710678 0.70710678\n"
    "  1764349530.0000000000001 2 2 3. 0 0 0 -1";

static const char kitti[] = "1.000000e+00 0.0e+00 0 5 0 1 0 6 0 0 1 7\n"
                            "0 -1 0 5.5 1 0 0 6 0 0 1 7\n"
                            "-1 0 0 6 0 -1 0 6 0 0 1 7\n"
                            "1 0 0 6.5 0 -1 0 6 0 0 -1 7\n"
                            "-1 0 0 7 0 1 0 6 0 0 -1 7\n";

static const char kitti_times[] =
    "0.000000e+00\n1.0e-1\n# so far\n0.2\n0.3\n0.4\n";

static const char csv[] = "\xef\xbb\xbfqw,qz,qy,qx,speed,X,y,z,time_us\n"
                          "1,0,0,0,9,1,2,3,1000\n"
                          "1,0,0,0,9,1,2,4,101000\n";

/* In a place of its own on the heap, whose end the sanitizer guards. */
static int parse(const char *text, size_t len, const char *times,
                 const lum_poses_options *options, lum_poses **out,
                 lum_error *error)
{
    char *exact = malloc(len > 0 ? len : 1u);
    assert_non_null(exact);
    memcpy(exact, text, len);
    const lum_poses_text poses = {"p.txt", exact, len};
    const lum_poses_text of_times = {"t.txt", times,
                                     times != NULL ? strlen(times) : 0};
    const int result = lum_poses_parse(&poses, times != NULL ? &of_times : NULL,
                                       options, out, error);
    free(exact);
    return result;
}

static lum_poses *parsed(const char *text, const char *times)
{
    lum_poses *poses = NULL;
    lum_error error = {""};
    if (parse(text, strlen(text), times, NULL, &poses, &error) != 0) {
        fail_msg("%s", error.text);
    }
    return poses;
}

static void assert_pose(const lum_poses *poses, size_t i, int64_t time_ns,
                        const lum_pose *expected)
{
    int64_t time = 0;
    lum_pose pose;
    lum_poses_get(poses, i, &time, &pose);
    assert_int_equal(time, time_ns);
    for (int k = 0; k < 3; k++) {
        assert_true(fabs(pose.at[k] - expected->at[k]) < 1e-15);
    }
    assert_true(lum_pose_angle(&pose, expected) < 1e-7);
}

static lum_poses_info info_of(const lum_poses *poses)
{
    lum_poses_info info = {.struct_size = sizeof info};
    assert_int_equal(lum_poses_get_info(poses, &info), LUM_OK);
    return info;
}

static void tum_is_read_to_the_nanosecond(void **state)
{
    (void)state;
    lum_poses *poses = parsed(tum, NULL);
    const lum_poses_info info = info_of(poses);
    const double half = sqrt(0.5);
    assert_int_equal(info.count, 3);
    assert_int_equal(info.clock, LUM_POSES_UTC);
    assert_int_equal(info.first_ns, 1764349529 * S + 1);
    assert_int_equal(info.last_ns, 1764349530 * S);
    assert_int_equal(info.gaps, 0);
    assert_true(info.min[0] == -1.5 && info.max[0] == 2.0);
    assert_true(info.min[2] == 0.25 && info.max[2] == 3.0);
    assert_pose(poses, 0, 1764349529 * S + 1,
                &(lum_pose){{1, 2, 3}, {0, 0, 0, 1}});
    assert_pose(poses, 1, 1764349529 * S + S / 2,
                &(lum_pose){{-1.5, 2, 0.25}, {0, 0, half, half}});
    assert_pose(poses, 2, 1764349530 * S,
                &(lum_pose){{2, 2, 3}, {0, 0, 0, -1}});
    lum_poses_free(poses);
}

static void kitti_has_its_times_in_another_file(void **state)
{
    (void)state;
    static const double turns[][4] = {
        {0, 0, 0, 1},
        {0, 0, 0.70710678118654752, 0.70710678118654752},
        {0, 0, 1, 0},
        {1, 0, 0, 0},
        {0, 1, 0, 0}};
    lum_poses *poses = parsed(kitti, kitti_times);
    assert_int_equal(info_of(poses).count, 5);
    assert_int_equal(info_of(poses).clock, LUM_POSES_SENSOR);
    for (size_t i = 0; i < 5; i++) {
        lum_pose expected = {{5.0 + 0.5 * (double)i, 6, 7}, {0}};
        memcpy(expected.turn, turns[i], sizeof expected.turn);
        assert_pose(poses, i, (int64_t)i * S / 10, &expected);
    }
    lum_poses_free(poses);
}

static void csv_is_read_by_its_names(void **state)
{
    (void)state;
    lum_poses *poses = parsed(csv, NULL);
    assert_pose(poses, 0, 1000000, &(lum_pose){{1, 2, 3}, {0, 0, 0, 1}});
    assert_pose(poses, 1, 101000000, &(lum_pose){{1, 2, 4}, {0, 0, 0, 1}});
    lum_poses_free(poses);
    /* Names in a comment count as well. */
    poses =
        parsed("# t, x, y, z, qw, qx, qy, qz\n1, 2, 3, 4, 1, 0, 0, 0\n", NULL);
    assert_pose(poses, 0, S, &(lum_pose){{2, 3, 4}, {0, 0, 0, 1}});
    lum_poses_free(poses);
}

struct refusal {
    const char *text;
    const char *times;
    const char *message;
};

#define GOOD "1 0 0 0 0 0 0 1\n"

static const struct refusal refusals[] = {
    {"", NULL, "p.txt: has no poses; at least one is needed"},
    {"# nothing\n\n", NULL, "p.txt: has no poses; at least one is needed"},
    {"t,x,y,z,qx,qy,qz,qw\n", NULL,
     "p.txt: has no poses; at least one is needed"},
    {"1 2 3\n", NULL,
     "p.txt: line 1 has 3 values; use 8 (TUM: t x y z qx qy qz qw), 12 (KITTI: "
     "3 rows of 4), or a CSV with a line of names (t,x,y,z,qx,qy,qz,qw)"},
    {"t,x,y,z\n1,2,3,4\n", NULL,
     "p.txt: line 1: has names, but lacks qx; use numbers (TUM: t x y z qx qy "
     "qz qw; KITTI: 12 of a matrix), or a CSV with a line of names: "
     "t,x,y,z,qx,qy,qz,qw"},
    {"t,x,y,z,qx,qy,qz,qw,tx\n", NULL,
     "p.txt: line 1: names a column twice; use numbers (TUM: t x y z qx qy qz "
     "qw; KITTI: 12 of a matrix), or a CSV with a line of names: "
     "t,x,y,z,qx,qy,qz,qw"},
    {GOOD "1.1 0 0 0 0 0 1\n" GOOD, NULL,
     "p.txt: line 2 has 7 values, the lines before 8: use the same number in "
     "each"},
    {GOOD "1.1 0 0", NULL,
     "p.txt: line 2 has 3 values, the lines before 8: was the file cut short?"},
    {GOOD "1.1 0 0 zero 0 0 0 1\n", NULL,
     "p.txt: line 2: 'zero' is not a number such as 12.5 or 1.25e1"},
    {"1,5 0 0 0 0 0 0 1\n", NULL,
     "p.txt: line 1 has 9 values; use 8 (TUM: t x y z qx qy qz qw), 12 (KITTI: "
     "3 rows of 4), or a CSV with a line of names (t,x,y,z,qx,qy,qz,qw)"},
    {GOOD "1.1 nan 0 0 0 0 0 1\n", NULL,
     "p.txt: line 2: 'nan' is not a number such as 12.5 or 1.25e1"},
    {GOOD "1.1 1e999 0 0 0 0 0 1\n", NULL,
     "p.txt: line 2: '1e999' is not a number such as 12.5 or 1.25e1"},
    {"# c\n" GOOD GOOD, NULL,
     "p.txt: line 3 has the time of line 2, 1.000000000 s: remove one of the "
     "two"},
    {GOOD "0.9 0 0 0 0 0 0 1\n", NULL,
     "p.txt: line 2 is out of order: its time is 0.900000000 s, that of line 1 "
     "is 1.000000000 s; sort the poses by time"},
    {GOOD "\n1.1 100.5 0 0 0 0 0 1\n", NULL,
     "p.txt: line 3 is 100.5 m away from the pose 0.100 s before: more than "
     "100 m; use metres: are x, y and z millimetres? If not, leave wrong poses "
     "out"},
    {GOOD "1.04 60 0 0 0 0 0 1\n1.09 90 0 0 0 0 0 1\n1.1 101 0 0 0 0 0 1\n",
     NULL,
     "p.txt: line 4 is 101.0 m away from the pose 0.100 s before: more than "
     "100 m; use metres: are x, y and z millimetres? If not, leave wrong poses "
     "out"},
    {"1 0 0 0 0 0 0 2\n", NULL,
     "p.txt: line 1: the quaternion's length is 2; use 1, as qx qy qz qw with "
     "w last, not angles"},
    {"1 0 0 0 0 0 0 0\n", NULL,
     "p.txt: line 1: the quaternion's length is 0; use 1, as qx qy qz qw with "
     "w last, not angles"},
    {"1764349529123 0 0 0 0 0 0 1\n", NULL,
     "p.txt: line 1: the time 1764349529123 is too large to be seconds; use "
     "seconds, or a CSV column t_ms, t_us or t_ns"},
    {"5000000000 0 0 0 0 0 0 1\n5000000000\n", NULL,
     "p.txt: line 1: the time 5000000000 is too large to be seconds; use "
     "seconds, or a CSV column t_ms, t_us or t_ns"},
    {"t_ns x y z qx qy qz qw\n99999999999999999999 0 0 0 0 0 0 1\n", NULL,
     "p.txt: line 2: the time is too large for nanoseconds in 64 bits; use the "
     "unit in the column's name"},
    {"t_ns x y z qx qy qz qw\n9223372036854775807 0 0 0 0 0 0 1\n", NULL,
     "p.txt: line 2: its time is 9.22337e+09 s, which is 140 years or more "
     "from 0; times are seconds"},
    {"100 0 0 0 0 0 0 1\n200 0 0 0 0 0 0 1\n", NULL,
     "p.txt: all poses are 100 s apart or more, and points are placed only "
     "between poses up to 1 s apart: if the times are milliseconds, convert "
     "them to seconds; otherwise add poses"},
    {"100000 0 0 0 0 0 0 1\n200000 0 0 0 0 0 0 1\n", NULL,
     "p.txt: all poses are 100000 s apart or more, and points are placed only "
     "between poses up to 1 s apart: if the times are microseconds, convert "
     "them to seconds; otherwise add poses"},
    {"1 0 0 5 0 1 0 6 0 0 1 7\n", NULL,
     "p.txt: line 1: a matrix of KITTI has no time: name the file of times "
     "too, one a line"},
    {"1 0 0 5 0 1 0 6 0 0 1 7\n", "",
     "t.txt has fewer times than p.txt has poses: line 1 has none; use one for "
     "each"},
    {"1 0 0 5 0 1 0 6 0 0 1 7\n", "0 1\n", "t.txt: line 1: use one time alone"},
    {"1 0 0 5 0 1 0 6 0 0 1 7\n", "0\n1\n",
     "t.txt: line 2: there are more times than poses; use one for each"},
    {"1 0 0 5 0 1 0 6 0 0 -1 7\n", "0\n",
     "p.txt: line 1: the first three columns are not a rotation; use "
     "right-handed rows of length 1, square to each other"},
    {"1 0.1 0 5 0 1 0 6 0 0 1 7\n", "0\n",
     "p.txt: line 1: the first three columns are not a rotation; use "
     "right-handed rows of length 1, square to each other"},
    {GOOD, "0\n",
     "p.txt has times of its own: leave out the file of times, t.txt"},
};

static void what_is_wrong_is_said(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
        const struct refusal *r = &refusals[i];
        lum_poses *poses = NULL;
        lum_error error = {""};
        errno = 0;
        assert_int_equal(
            parse(r->text, strlen(r->text), r->times, NULL, &poses, &error),
            -1);
        assert_null(poses);
        assert_string_equal(error.text, r->message);
        assert_int_equal(errno, EINVAL);
    }
}

static void every_truncation_ends_in_order(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        const char *times;
    } texts[] = {{tum, NULL}, {kitti, kitti_times}, {csv, NULL}};
    for (size_t t = 0; t < sizeof texts / sizeof *texts; t++) {
        for (size_t n = 0; n <= strlen(texts[t].text); n++) {
            lum_poses *poses = NULL;
            lum_error error = {""};
            const int result =
                parse(texts[t].text, n, texts[t].times, NULL, &poses, &error);
            assert_true((result == 0) == (poses != NULL));
            assert_true((result == 0) == (error.text[0] == '\0'));
            lum_poses_free(poses);
        }
    }
}

static void near_ones_are_made_unit(void **state)
{
    (void)state;
    lum_poses *poses = parsed("1 0 0 0 0 0 0 1.009\n", NULL);
    lum_pose pose;
    lum_poses_get(poses, 0, NULL, &pose);
    assert_true(pose.turn[3] == 1.0);
    lum_poses_free(poses);
}

/* 1.6 ms apart, as lumsim writes them. */
static int make_dense(double metres_per_second, lum_error *error)
{
    static int64_t times[1000];
    static lum_pose list[1000];
    lum_poses *poses = NULL;
    for (size_t i = 0; i < 1000; i++) {
        times[i] = (int64_t)i * 1600000;
        list[i] = lum_pose_identity();
        list[i].at[1] = metres_per_second * (double)times[i] * 1e-9;
    }
    const int result = lum_poses_new(times, list, 1000, NULL, &poses, error);
    if (result == 0) {
        lum_poses_free(poses);
    }
    return result;
}

static void a_speed_that_nothing_has_is_a_jump(void **state)
{
    (void)state;
    lum_error error = {""};
    assert_int_equal(make_dense(900.0, &error), 0);
    assert_int_equal(make_dense(10e3, &error), -1); /* 10 m/s in mm */
    assert_non_null(strstr(error.text, "are x, y and z millimetres?"));
    assert_int_equal(make_dense(1050.0, &error), -1);
    assert_string_equal(error.text,
                        "pose 60 is 100.8 m away from the pose 0.096 s before: "
                        "more than 100 m; use metres: are x, y and z "
                        "millimetres? If not, leave wrong poses out");
}

static void options_change_the_limits(void **state)
{
    (void)state;
    static const char text[] =
        "10 0 0 0 0 0 0 1\n12 150 0 0 0 0 0 1\n20 151 0 0 0 0 0 1\n";
    const lum_poses_options options = {.struct_size = sizeof options,
                                       .clock = LUM_POSES_UTC,
                                       .gap_ns = 3 * S,
                                       .jump_m = 200.0};
    lum_poses *poses = NULL;
    lum_error error = {""};
    assert_int_equal(parse(text, strlen(text), NULL, &options, &poses, &error),
                     0);
    const lum_poses_info info = info_of(poses);
    assert_int_equal(info.clock, LUM_POSES_UTC);
    assert_int_equal(info.gaps, 1);
    assert_int_equal(info.gap_from_ns, 12 * S);
    assert_int_equal(info.gap_to_ns, 20 * S);
    lum_poses_free(poses);
    const lum_poses_options none = {.struct_size = 0};
    assert_int_equal(parse(text, strlen(text), NULL, &none, &poses, &error),
                     -1);
}

static void options_that_mean_nothing_are_refused(void **state)
{
    (void)state;
    static const struct {
        lum_poses_options options;
        const char *told;
    } cases[] = {
        {{.gap_ns = -1},
         "poses: the option gap_ns is -1; use more than 0, or 0 for the usual "
         "one"},
        {{.jump_m = -2.0},
         "poses: the option jump_m is -2; use more than 0, or 0 for the usual "
         "one"},
        {{.jump_m = NAN}, "use more than 0"},
        {{.clock = (lum_poses_clock)3},
         "poses: the option clock is 3; use a value of lum_poses_clock"},
    };
    const int64_t times[] = {0};
    const lum_pose list[] = {{.turn = {0, 0, 0, 1}}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        lum_poses_options options = cases[i].options;
        lum_poses *poses = NULL;
        lum_error error = {""};
        options.struct_size = sizeof options;
        errno = 0;
        assert_int_equal(
            lum_poses_new(times, list, 1, &options, &poses, &error), -1);
        assert_int_equal(errno, EINVAL);
        assert_non_null(strstr(error.text, cases[i].told));
    }
}

static void check_origin(double x, double y, bool is_far, double x_origin)
{
    const int64_t times[] = {0, 1};
    const lum_pose list[] = {{.at = {x, 0, -400}, .turn = {0, 0, 0, 1}},
                             {.at = {x, y, -400}, .turn = {0, 0, 0, 1}}};
    lum_poses *poses = NULL;
    lum_error error = {""};
    double origin[3] = {1.0, 1.0, 1.0};
    assert_int_equal(lum_poses_new(times, list, 2, NULL, &poses, &error), 0);
    assert_int_equal(lum_poses_origin(poses, origin), is_far);
    assert_true(origin[0] == x_origin && origin[1] == 0.0 && origin[2] == 0.0);
    assert_false(signbit(origin[0]) && origin[0] == 0.0);
    assert_false(signbit(origin[2]));
    lum_poses_free(poses);
}

/* So that neither end of a long way is coarser than the other. */
static void an_origin_is_in_the_middle(void **state)
{
    (void)state;
    const int64_t times[] = {0, 2 * S};
    const lum_pose list[] = {{.at = {0, 600, -900}, .turn = {0, 0, 0, 1}},
                             {.at = {10e3, 800, 0}, .turn = {0, 0, 0, 1}}};
    lum_poses *poses = NULL;
    lum_error error = {""};
    double origin[3];
    const lum_poses_options options = {
        .struct_size = sizeof options, .gap_ns = 3 * S, .jump_m = 20e3};
    assert_int_equal(lum_poses_new(times, list, 2, &options, &poses, &error),
                     0);
    assert_true(lum_poses_origin(poses, origin));
    assert_true(origin[0] == 5000.0 && origin[1] == 1000.0);
    assert_true(origin[2] == 0.0 && !signbit(origin[2]));
    lum_poses_free(poses);
}

static void a_far_world_has_an_origin(void **state)
{
    (void)state;
    check_origin(5000.0, 0.0, false, 0.0);
    check_origin(-5000.0, 0.0, false, 0.0);
    check_origin(5000.5, 0.0, true, 5000.0);
    check_origin(6500.0, 0.0, true, 7000.0);
    check_origin(-6500.0, 90.0, true, -7000.0);
}

static void arrays_are_checked_as_files_are(void **state)
{
    (void)state;
    const int64_t times[] = {0, S / 2, S / 2};
    lum_pose list[3] = {lum_pose_identity(), lum_pose_identity(),
                        lum_pose_identity()};
    lum_poses *poses = NULL;
    lum_error error = {""};
    assert_int_equal(lum_poses_new(times, list, 3, NULL, &poses, &error), -1);
    assert_string_equal(error.text, "pose 2 has the time of pose 1, "
                                    "0.500000000 s: remove one of the two");
    list[1].turn[0] = (double)NAN;
    assert_int_equal(lum_poses_new(times, list, 2, NULL, &poses, &error), -1);
    assert_string_equal(
        error.text,
        "pose 1: a number is infinite or not a number; leave such poses out");
    assert_int_equal(lum_poses_new(times, list, 0, NULL, &poses, &error), -1);
    assert_string_equal(error.text,
                        "poses: has no poses; at least one is needed");
}

static void a_time_has_the_pose_of_the_screw(void **state)
{
    (void)state;
    lum_poses *poses = parsed("10 0 0 0 0 0 0 1\n"
                              "10.5 1 1 0 0 0 0.70710678118654752 "
                              "0.70710678118654752\n"
                              "15 1 2 0 0 0 0 1\n"
                              "15.5 1 2 0 0 0 0 1\n",
                              NULL);
    static const struct {
        int64_t time_ns;
        lum_poses_place place;
        double x;
    } times[] = {{10 * S, LUM_POSES_INSIDE, 0.0},
                 {10 * S - 1000, LUM_POSES_INSIDE, 0.0},
                 {10 * S - 1001, LUM_POSES_BEFORE, 0.0},
                 {INT64_MIN / 2, LUM_POSES_BEFORE, 0.0},
                 {10 * S + S / 4, LUM_POSES_INSIDE, 0.70710678118654752},
                 {10 * S + S / 2, LUM_POSES_INSIDE, 1.0},
                 {10 * S + S / 2 + 1000, LUM_POSES_INSIDE, 1.0},
                 {10 * S + S / 2 + 1001, LUM_POSES_IN_GAP, 1.0},
                 {14 * S, LUM_POSES_IN_GAP, 1.0},
                 {15 * S - 1001, LUM_POSES_IN_GAP, 1.0},
                 {15 * S - 1000, LUM_POSES_INSIDE, 1.0},
                 {15 * S + S / 2 + 1000, LUM_POSES_INSIDE, 1.0},
                 {15 * S + S / 2 + 1001, LUM_POSES_AFTER, 1.0},
                 {INT64_MAX / 2, LUM_POSES_AFTER, 1.0}};
    size_t near = 0;
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        lum_pose pose;
        assert_int_equal(lum_poses_at(poses, times[i].time_ns, NULL, &pose),
                         times[i].place);
        assert_true(fabs(pose.at[0] - times[i].x) < 1e-12);
        assert_int_equal(lum_poses_at(poses, times[i].time_ns, &near, &pose),
                         times[i].place);
        assert_true(fabs(pose.at[0] - times[i].x) < 1e-12);
    }
    lum_poses_free(poses);
}

/* Whatever the last look-up was. */
static void a_near_look_up_finds_what_a_search_finds(void **state)
{
    (void)state;
    int64_t times[40];
    lum_pose list[40];
    lum_poses *poses = NULL;
    lum_error error = {""};
    for (size_t i = 0; i < 40; i++) {
        times[i] = (int64_t)(i * i);
        list[i] = lum_pose_identity();
    }
    assert_int_equal(lum_poses_new(times, list, 40, NULL, &poses, &error), 0);
    for (size_t from = 0; from <= 41; from++) {
        for (int64_t t = -2; t < 1530; t++) {
            size_t near = from;
            assert_int_equal(lum_poses_find(poses, t, &near),
                             lum_poses_find(poses, t, NULL));
            assert_int_equal(near, lum_poses_find(poses, t, NULL));
        }
    }
    lum_poses_free(poses);
}

static void poses_of_another_drive_are_told(void **state)
{
    (void)state;
    lum_error error = {""};
    lum_poses *poses =
        parsed("1000 0 0 0 0 0 0 1\n1000.5 0 0 0 0 0 0 1\n", NULL);
    assert_int_equal(lum_poses_check_span(poses, "p.txt", 1000 * S + S / 2,
                                          2000 * S, &error),
                     0);
    assert_int_equal(
        lum_poses_check_span(poses, "p.txt", 2000 * S, 2100 * S, &error), -1);
    assert_string_equal(error.text,
                        "p.txt: its poses are from 1000.000 to 1000.500 s of "
                        "the sensor's clock, the points from 2000.000 to "
                        "2100.000 s; are they from another drive?");
    assert_int_equal(lum_poses_check_span(poses, "p.txt", 0, 2 * S, &error),
                     -1);
    assert_string_equal(
        error.text,
        "p.txt: its poses are from 1000.000 to 1000.500 s of the sensor's "
        "clock, the points from 0.000 to 2.000 s; are its times milliseconds?");
    lum_poses_free(poses);
}

static void files_are_read(void **state)
{
    (void)state;
    lum_poses *poses = NULL;
    lum_error error = {""};
    static const char name[] = "test_poses.txt";
    FILE *file = fopen(name, "wb");
    assert_non_null(file);
    for (unsigned i = 0; i < 5000; i++) { /* beyond a block of reading */
        (void)fprintf(file, "%u.%02u %u 0 0 0 0 0 1\n", i / 100u, i % 100u, i);
    }
    assert_int_equal(fclose(file), 0);
    assert_int_equal(lum_poses_read(name, NULL, NULL, &poses, &error), 0);
    assert_int_equal(info_of(poses).count, 5000);
    lum_poses_free(poses);
    assert_int_equal(remove(name), 0);
    assert_int_equal(lum_poses_read(name, NULL, NULL, &poses, &error), -1);
    assert_string_equal(
        error.text,
        "test_poses.txt: cannot be read: No such file or directory");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tum_is_read_to_the_nanosecond),
        cmocka_unit_test(kitti_has_its_times_in_another_file),
        cmocka_unit_test(csv_is_read_by_its_names),
        cmocka_unit_test(what_is_wrong_is_said),
        cmocka_unit_test(every_truncation_ends_in_order),
        cmocka_unit_test(near_ones_are_made_unit),
        cmocka_unit_test(a_speed_that_nothing_has_is_a_jump),
        cmocka_unit_test(options_change_the_limits),
        cmocka_unit_test(options_that_mean_nothing_are_refused),
        cmocka_unit_test(an_origin_is_in_the_middle),
        cmocka_unit_test(a_far_world_has_an_origin),
        cmocka_unit_test(arrays_are_checked_as_files_are),
        cmocka_unit_test(a_time_has_the_pose_of_the_screw),
        cmocka_unit_test(a_near_look_up_finds_what_a_search_finds),
        cmocka_unit_test(poses_of_another_drive_are_told),
        cmocka_unit_test(files_are_read),
    };
    return cmocka_run_group_tests_name("poses", tests, NULL, NULL);
}
