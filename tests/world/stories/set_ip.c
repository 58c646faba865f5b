/* A sensor that is moved: what set-ip asks, proves, refuses and looks for, and
 * what a session does meanwhile. */
#include "help.h"
#include "made_up.h"

#include <fcntl.h>
#include <string.h>

#define OLD "10.42.0.37"
#define NEW "10.42.0.99"

/* Addresses of set IP packets that a sensor took, the last; NULL: none came. */
static const char *last_order(const user_sensor *s)
{
    const user_event *e = user_last(s, "set_ip");
    return e == NULL ? NULL : user_value(e->line, "address");
}

STORY(set_ip_proves_the_new_address, "set-ip proves the new address")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *there = user_run(b.host, "lumctl set-ip " NEW);
    user_expect_status(there, DONE);
    user_expect_has(user_out(there), NEW);
    user_expect_has(user_err(there), OLD); /* where it boots */
    user_expect_equal(user_events(s, "set_ip"), 1);
    user_expect_same(last_order(s), NEW);
    user_expect_status(user_run(b.host, "lumctl --host " NEW " status"), DONE);
    user_tool *back =
        user_run(b.host, "lumctl --host " NEW " set-ip " OLD " --json");
    user_expect_status(back, DONE);
    expect_value(back, "answers_at", "new");
    user_expect_status(user_run(b.host, "lumctl set-ip " OLD), DONE);
}

static const char little[] = "version: 1\nset_ip_order: little\n";

STORY(set_ip_the_other_way_round,
      "set-ip finds a sensor that took the bytes the other way round")
{
    const user_bench b = user_bench_new();
    world_route_add(b.eth0, user_ip("99.0.42.0"), 24, 0);
    world_route_add(world_interface_find(b.sensor, "eth0"),
                    user_ip("10.42.0.0"), 24, 0);
    user_write_file(b.sensor, "p.yaml", little);
    (void)user_sensor_start(b.sensor, "--rate 0.5 --profile p.yaml");
    user_tool *moved = user_run(b.host, "lumctl set-ip " NEW);
    user_expect_status(moved, FAILED);
    user_expect_has(user_err(moved), "99.0.42.10");
    user_expect_has(user_err(moved), "set_ip_order: little");
}

STORY(set_ip_that_is_ignored, "set-ip finds a sensor that has not moved")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, OLD, NULL);
    user_tool *moved = user_run(b.host, "lumctl set-ip " NEW);
    user_expect_status(moved, FAILED);
    user_expect_has(user_err(moved), "still answers at " OLD);
    user_expect_at_least(made_up_heard(m, MADE_UP_SET_IP), 2);
    for (size_t i = 0; i < m->count; i++) {
        if (m->packets[i].kind == MADE_UP_SET_IP) {
            user_expect_equal(m->packets[i].size, 16);
            user_expect(memcmp(m->packets[i].bytes + 12, "\12\52\0\143", 4) ==
                        0);
        }
    }
}

/* Requests for a time stamp that a wire loses, of those to an address. */
typedef struct lossy {
    uint32_t to;
    size_t left;
} lossy;

static bool loses_requests(void *context, const world_datagram *datagram)
{
    lossy *l = context;
    if (datagram->to == l->to && datagram->len == 20 && l->left > 0) {
        l->left--;
        return true;
    }
    return false;
}

STORY(set_ip_looks_as_long_as_it_is_told,
      "set-ip looks for a sensor on a bad wire as long as it is told")
{
    static lossy wire;
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 0.5");
    b.eth0->out.loses = loses_requests;
    b.eth0->out.context = &wire;
    wire.left = 0;
    user_tool *there = user_start(b.host, "lumctl set-ip " NEW);
    user_until(user_events(s, "move") > 0);
    wire = (lossy){user_ip(NEW), 16};
    user_expect_status(there, DONE);
    user_expect_equal(wire.left, 0);
    user_expect_equal(user_events(s, "set_ip"), 1);
    user_tool *back = user_start(b.host, "lumctl --host " NEW " set-ip " OLD
                                         " --timeout 500 --retries 59");
    user_until(user_events(s, "move") > 1);
    wire = (lossy){user_ip(OLD), 25};
    user_expect_status(back, DONE);
    user_expect_equal(wire.left, 0);
    user_expect_equal(user_events(s, "set_ip"), 2);
}

STORY(set_ip_of_another_sensor,
      "set-ip does not give two sensors one address, though the other's first "
      "answers are lost")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 0.5");
    world_host *other = user_sensor_host("other", b.wire, NEW "/24");
    (void)user_sensor_start(other, "--rate 0.5");
    user_tool *moved = user_run(b.host, "lumctl set-ip " NEW);
    user_expect_status(moved, FAILED);
    user_expect_has(user_err(moved), "another sensor has " NEW);
    user_expect_equal(user_events(s, "set_ip"), 0);
    b.eth0->out.lose_next = (uint64_t)user_any(1, 2);
    user_tool *again = user_run(b.host, "lumctl set-ip " NEW);
    user_expect_status(again, FAILED);
    user_expect_has(user_err(again), NEW);
    user_expect_equal(user_events(s, "set_ip"), 0);
}

STORY(set_ip_where_a_sensor_is_already,
      "a sensor that had the address before is no move: nothing is sent")
{
    const user_bench b = user_bench_new();
    world_host *other = user_sensor_host("other", b.wire, NEW "/24");
    const user_sensor *s = user_sensor_start(other, "--rate 0.5");
    user_tool *moved = user_run(b.host, "lumctl set-ip " NEW);
    user_expect_status(moved, FAILED);
    user_expect_has(user_err(moved), NEW " answers already; nothing was sent");
    user_expect_same(user_out(moved), "");
    user_expect_equal(user_events(s, "set_ip"), 0);
}

STORY(set_ip_where_nobody_is, "set-ip says when nobody answers anywhere")
{
    static const char *const told[] = {
        OLD, NEW, "The packet may still have arrived", "doctor"};
    const user_bench b = user_bench_new();
    user_tool *moved = user_run(b.host, "lumctl set-ip " NEW);
    user_expect_status(moved, NO_ANSWER);
    for (size_t i = 0; i < sizeof told / sizeof *told; i++) {
        user_expect_has(user_err(moved), told[i]);
    }
    user_tool *json = user_run(b.host, "lumctl set-ip " NEW " --json");
    user_expect_status(json, NO_ANSWER);
    expect_value(json, "answers_at", "nowhere");
}

STORY(set_ip_reversed_out_of_reach,
      "that the reversed address cannot be reached is no news")
{
    const user_bench b = user_bench_new();
    user_tool *here =
        user_run(b.host, "lumctl --host 127.0.0.9 set-ip 127.0.0.6");
    user_expect_status(here, NO_ANSWER);
    user_expect_has(
        user_err(here),
        "nobody answers at 127.0.0.6, nor at 127.0.0.9 or 6.0.0.127. ");
    user_expect_lacks(user_err(here), "cannot send");
    user_tool *away =
        user_run(b.host, "lumctl --host 127.0.0.9 set-ip 192.168.9.6 --force");
    user_expect_like(user_err(away),
                     "^lumctl: cannot send [^\n]* to 192\\.168\\.9\\.6[^\n]*\n"
                     "[^\n]*nobody answers at 192\\.168\\.9\\.6");
}

static void expect_refused(const user_bench *b, const user_sensor *s,
                           const char *words, const char *told,
                           const char *told_too)
{
    user_tool *tool = user_run(b->host, "lumctl set-ip %s", words);
    user_expect_status(tool, BAD);
    user_expect_has(user_err(tool), told);
    user_expect_has(user_err(tool), told_too);
    user_expect_equal(user_events(s, "set_ip"), 0);
}

STORY(set_ip_that_would_strand, "set-ip strands no sensor, unless it is forced")
{
    static const struct {
        const char *address, *told;
    } cases[] = {
        {"10.42.0.1", "10.42.0.1 is this host's own address, on eth0"},
        {"10.50.0.1", "own address, on other0"},
        {"127.0.0.1", "loopback"},
        {"127.33.0.5", "loopback"},
        {"10.42.0.255", "the broadcast address of eth0's subnet 10.42.0.0/24"},
        {"10.42.0.0", "the network address of eth0's subnet 10.42.0.0/24"},
        {"10.50.0.255", "the broadcast address of other0's"},
        {"10.50.0.7", "is reached by other0, and the sensor is at eth0"},
        {"192.168.9.6", "out of reach: no route of eth0 leads there"},
    };
    static const char *const never[] = {"0.0.0.0", "224.0.0.1",
                                        "255.255.255.255"};
    static const char force[] = "nothing was sent. --force";
    const user_bench b = user_bench_new();
    (void)user_interface(b.host, "other0", world_segment_new("other"),
                         "10.50.0.1/24");
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 0.5");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect_refused(&b, s, cases[i].address, cases[i].told, force);
    }
    world_route_add(b.eth0, 0, 0, user_ip("10.42.0.254"));
    expect_refused(&b, s, "192.168.9.6", "is reached by a gateway (eth0)",
                   force);
    expect_refused(&b, s, "192.168.9.6 --interface eth0",
                   "is reached by a gateway (eth0)", force);
    for (size_t i = 0; i < sizeof never / sizeof *never; i++) {
        expect_refused(&b, s, user_format("%s --force", never[i]),
                       "not an address that a sensor can have", "");
    }
    user_tool *shell = run_fed(b.host, "lumctl shell", "set-ip 10.42.0.255\n");
    user_expect_status(shell, BAD);
    user_expect_has(user_err(shell), "broadcast");
    user_expect_equal(user_events(s, "set_ip"), 0);

    /* With a route of the sensor's interface, or when it is forced, it is sent.
     */
    world_route_add(b.eth0, user_ip("10.43.0.0"), 24, 0);
    (void)user_run(b.host, "lumctl set-ip 10.43.0.5 --timeout 50");
    user_expect_same(last_order(s), "10.43.0.5");
    const size_t before = user_events(s, "set_ip");
    (void)user_run(b.host, "lumctl --host 10.43.0.5 set-ip 10.42.0.255 --force "
                           "--timeout 50");
    user_expect_at_least(user_events(s, "set_ip"), before + 1);
    user_expect_same(last_order(s), "10.42.0.255");
}

STORY(set_ip_to_and_fro, "set-ip goes back to an address that the sensor had")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(b.sensor, "--rate 0.5");
    for (size_t i = 0; i < 2; i++) {
        user_expect_status(user_run(b.host, "lumctl set-ip " NEW), DONE);
        user_expect_status(
            user_run(b.host, "lumctl --host " NEW " set-ip " OLD), DONE);
    }
}

STORY(force_goes_with_set_ip_alone, "--force goes with set-ip alone")
{
    const user_bench b = user_bench_new();
    user_leave("status-2", "the option is wrong on purpose");
    user_tool *power = user_run(b.host, "lumctl power 50 --force");
    user_expect_status(power, BAD);
    user_expect_has(user_err(power),
                    "--force does not go with power; it goes with set-ip");
}

/* --- A session meanwhile --- */

/* Between the first heartbeat and now, heartbeats have kept the laser on. */
static void expect_steady(const user_sensor *s)
{
    const size_t count = user_events(s, "heartbeat");
    user_expect_at_least(count, 6);
    for (size_t i = 1; i < count; i++) {
        user_expect_at_most(user_event_at(s, "heartbeat", i)->t_ns -
                                user_event_at(s, "heartbeat", i - 1)->t_ns,
                            3 * WORLD_S - 1);
    }
}

STORY(heartbeats_while_set_ip_looks,
      "heartbeats go on while set-ip looks in vain")
{
    const user_bench b = user_bench_new();
    world_interface *its = world_interface_find(b.sensor, "eth0");
    world_interface_add(its, user_ip(OLD), 24);
    world_interface_roam(its, 0); /* no other address is its */
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    world_file *end = NULL;
    world_writer *input = world_writer_new(&end);
    user_tool *shell = user_start_with(b.host, (user_with){.input = end},
                                       "lumctl shell --heartbeat");
    user_type(shell, input, "laser on\nset-ip " NEW "\nlaser off\n");
    user_until(user_has(user_err(shell), "answers"));
    expect_steady(s);
    world_writer_close(input);
    (void)user_wait(shell);
    user_expect(!user_laser_is_on(s));
}

STORY(a_sensor_that_another_moves,
      "a sensor that another moves is named with its new address")
{
    static const char *const owners[] = {"lumctl heartbeat",
                                         "lumctl shell --heartbeat"};
    const user_bench b = user_bench_new();
    for (size_t i = 0; i < 2; i++) {
        const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
        world_file *end = NULL;
        world_writer *input = world_writer_new(&end);
        user_tool *owner =
            user_start_with(b.host, (user_with){.input = end}, "%s", owners[i]);
        user_until(user_events(s, "stream") > 0);
        user_expect_status(user_run(b.host, "lumctl set-ip " NEW), DONE);
        static const char told[] =
            "the data comes from " NEW " now, not from " OLD;
        user_until(user_has(user_out(owner), told) ||
                   user_has(user_err(owner), told));
        user_pause_ms(500);
        user_expect_equal(user_count(user_out(owner), told) +
                              user_count(user_err(owner), told),
                          1);
        (void)user_end(owner, i == 0 ? SIGINT : SIGTERM);
        world_writer_close(input);
        (void)user_end(s->tool, SIGTERM);
    }
}

/* Until a byte more would have to wait. */
static void fill(world_file *end)
{
    static const char zeros[4096];
    end->flags |= O_NONBLOCK;
    while (end->kind->write(end, zeros, sizeof zeros) > 0) {
    }
    end->flags &= ~O_NONBLOCK;
}

STORY(heartbeats_that_nobody_reads_of,
      "heartbeats go on though nobody reads what is told")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    world_file *end = NULL;
    world_reader *reader = world_reader_new("nobody", &end);
    world_reader_pace(reader, 0);
    fill(end);
    user_tool *beat = user_start_with(
        b.host, (user_with){.output = end, .error = world_file_use(end)},
        "lumctl heartbeat");
    user_until(user_events(s, "heartbeat") > 2);
    user_expect_status(user_run(b.host, "lumctl laser on"), DONE);
    user_signal(s->tool, SIGSTOP); /* no data for 2 s, which is worth a word */
    user_pause_ms(3000);
    user_signal(s->tool, SIGCONT);
    user_until_beats(s, 26);
    user_expect(!user_ended(beat));
}
