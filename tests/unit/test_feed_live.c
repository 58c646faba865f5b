#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "view.h"

#include "lum/base/time.h"
#include "lum/laser.h"
#include "lum/wire.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#define ADDRESS      "127.88.4.1"
#define ADDRESS_HOST 0x7f580401u

static char directory[] = "/tmp/lum-feed-live-XXXXXX";
static char log_path[64];
static pid_t running; /* the sensor that is; 0: none */

/* A simulated sensor, by its process; it writes log_path. */
static pid_t start_sensor(const char *option, const char *value)
{
    const pid_t child = fork();
    if (child == 0) {
        (void)execl(LUM_LUMSIM, "lumsim", "--quiet", "--address", ADDRESS,
                    "--frames", "2", "--duration", "900", "--log", log_path,
                    option, value, (char *)NULL);
        _exit(127);
    }
    assert_true(child > 0);
    running = child;
    return child;
}

static void stop_sensor(pid_t sensor)
{
    int status = 0;
    running = 0;
    assert_int_equal(kill(sensor, SIGTERM), 0);
    assert_int_equal(waitpid(sensor, &status, 0), sensor);
    assert_int_equal(unlink(log_path), 0);
}

static void open_live(struct viewer *v, bool laser)
{
    viewer_init(v, "udp://" ADDRESS);
    v->options.is_live = true;
    v->options.live.address = (lum_endpoint){ADDRESS_HOST, LUM_PORT};
    v->options.live.laser = laser;
    viewer_open(v);
}

static void close_well(struct viewer *v)
{
    lum_error error = {""};
    if (viewer_close(v, &error) != 0) {
        fail_msg("%s", error.text);
    }
}

/* The last line of the log that has a text in it; "" for none. */
static bool has_points(const struct feed_status *s, int64_t points)
{
    return s->decoded.points > (uint64_t)points;
}

static bool is_up(const struct feed_status *s, int64_t ignored)
{
    (void)ignored;
    return s->has_laser && !lum_laser_is_down(s->laser);
}

static void frames_come_in_all_views_with_the_time_of_their_completion(
    void **state)
{
    static const struct feed_view views[] = {{LUM_EDGES_RISING, 0},
                                             {LUM_EDGES_BOTH, 31}};
    struct viewer v;
    (void)state;
    const pid_t sensor = start_sensor("--seed", "1");
    open_live(&v, true);
    (void)viewer_wait(&v, is_up, 0);
    feed_want(v.feed, views, 2);
    const struct feed_status s = viewer_wait(&v, has_points, 500000);
    (void)viewer_wait(&v, has_shown, (int64_t)s.frames + 2);
    struct frame *rising = viewer_wait_frame(&v, LUM_EDGES_RISING, 0);
    struct frame *both = viewer_wait_frame(&v, LUM_EDGES_BOTH, 31);
    assert_true(frame_points(rising) > 0);
    assert_true(frame_points(both) > 0);
    assert_int_equal(frame_u32(rising, 48), ADDRESS_HOST);
    const double now = (double)lum_time_monotonic_ns() * 1e-9;
    assert_true(frame_double(rising, 56) <= now);
    assert_true(frame_double(rising, 56) > now - VIEW_PATIENCE_S);
    assert_true(frame_double(rising, 24) > 1e9);
    frame_release(rising);
    frame_release(both);
    close_well(&v);
    stop_sensor(sensor);
}

static void orders_to_a_capture_are_nothing_to_a_sensor(void **state)
{
    struct viewer v;
    (void)state;
    const pid_t sensor = start_sensor("--seed", "1");
    open_live(&v, false);
    const struct feed_status s = viewer_wait(&v, has_shown, 2);
    feed_play(v.feed, false);
    feed_step(v.feed, -1);
    feed_seek(v.feed, 1);
    feed_loop(v.feed, true);
    feed_speed(v.feed, 0.01);
    (void)viewer_wait(&v, has_shown, (int64_t)s.frames + 3);
    close_well(&v);
    stop_sensor(sensor);
}

static int set_up(void **state)
{
    (void)state;
    assert_non_null(mkdtemp(directory));
    (void)snprintf(log_path, sizeof log_path, "%s/log", directory);
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    if (running > 0) {
        stop_sensor(running); /* of a test that failed */
    }
    return rmdir(directory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(
            frames_come_in_all_views_with_the_time_of_their_completion),
        cmocka_unit_test(orders_to_a_capture_are_nothing_to_a_sensor),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
