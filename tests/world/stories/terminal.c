/* What is painted on a terminal, and who may. */
#include "bench.h"

#include <string.h>

STORY(a_status_line, "a status line is shown on a terminal, within its width")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    world_terminal *terminal = world_terminal_new("terminal");
    user_tool *dump = user_start_with(b.host, (user_with){.terminal = terminal},
                                      RECORD " -o c.csv");
    user_until(user_has(user_shown(terminal), "laser up  buf"));
    world_terminal_type(terminal, "\003");
    user_expect_status(dump, 0);
    user_expect_like(user_shown(terminal),
                     "[0-9]+.[0-9][0-9] Mpt/s  lost: wire [0-9]+w [0-9]+l, "
                     "kernel [0-9]+, ring [0-9]+, bad [0-9]+  laser up  buf "
                     "[0-9]+%");
    for (const char *at = strstr(user_shown(terminal), "\r\033[K"); at != NULL;
         at = strstr(at + 4, "\r\033[K")) {
        user_expect_at_most(strcspn(at + 4, "\r\n^"), 79);
    }
}

static const char *const painters[] = {
    "lumdump udp://10.42.0.37 -o live.pcap --duration 3",
    "lumctl heartbeat --duration 3", "lumctl find --subnet 10.42.0.32/29",
    "lumsim --frames 2 --lines 64 -o sim.pcap", "lumdump sim.pcap -o c.csv"};

STORY(who_paints, "each tool paints in the foreground, and not behind it")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 2");
    for (size_t i = 0; i < 10; i++) {
        world_terminal *terminal = world_terminal_new("terminal");
        const user_with with = {.terminal = terminal, .is_background = i >= 5};
        user_tool *tool = user_start_with(b.host, with, "%s", painters[i % 5]);
        user_expect_status(tool, 0);
        if (i < 5) {
            user_expect_has(user_shown(terminal), "\r\033[K");
        } else {
            user_expect_lacks(user_shown(terminal), "\033[K");
        }
    }
}

STORY(one_that_comes_to_the_foreground,
      "a recording that comes to the foreground paints there")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 4");
    world_terminal *terminal = world_terminal_new("terminal");
    const user_with with = {.terminal = terminal, .is_background = true};
    user_tool *dump = user_start_with(b.host, with, LIVE " -o live.pcap");
    until_data(&b, "live.pcap", 500000);
    user_expect_lacks(user_shown(terminal), "Mpt/s");
    user_foreground(terminal, dump);
    user_until(user_like(user_shown(terminal), "packets/s|Mpt/s"));
    world_terminal_type(terminal, "\003");
    user_expect_status(dump, 0);
    user_expect_has(user_shown(terminal), "losses");
}

STORY(a_window_that_is_closed,
      "a window that is closed ends a recording, and its laser")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_terminal *terminal = world_terminal_new("terminal");
    user_tool *dump = user_start_with(b.host, (user_with){.terminal = terminal},
                                      RECORD " -o a.pcap");
    user_until(user_laser_is_on(s));
    user_pause_between_ms(0, 2000);
    world_terminal_hang_up(terminal);
    (void)user_wait(dump);
    user_expect(!user_laser_is_on(s));
    user_expect_at_least(user_heard(s, "d"), 1);
}
