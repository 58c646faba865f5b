/* lumctl find, where it asks by UDP; wire.c has those of root, who asks by ARP.
 */
#include "help.h"
#include "made_up.h"

#include <string.h>

#define HERE "--subnet 10.42.0.0/28"

/* A sensor's computer in that subnet. */
static world_host *at_three(const user_bench *b)
{
    return user_sensor_host("three", b->wire, "10.42.0.3/24");
}

STORY(find_a_sensor,
      "find finds a sensor in a subnet, and asks for the time alone")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(at_three(&b), "--rate 2");
    user_tool *find = user_run(b.host, "lumctl find " HERE " --json");
    user_expect_status(find, DONE);
    user_expect_equal(user_length(user_out(find), "sensors"), 1);
    expect_value(find, "sensors.0.sensor", "10.42.0.3");
    expect_value(find, "sensors.0.interface", "eth0");
    expect_value(find, "sensors.0.how", "answers");
    expect_value(find, "searched.0.subnet", "10.42.0.0/28");
    expect_value(find, "searched.0.by", "udp");
    expect_value(find, "complete", "true");
    expect_value(find, "not_sent", "0");
    user_expect(user_number(user_out(find), "sensors.0.clock_us") > 0);
    user_expect(user_number(user_out(find), "sensors.0.round_trip_ms") > 0);
    user_expect_equal(user_events(s, "heartbeat"), 0);
    user_expect_equal(user_events(s, "tlv"), 0);
    user_expect_equal(user_events(s, "set_ip"), 0);
}

STORY(find_three_sensors, "find finds three sensors at odd addresses")
{
    static const char *const addresses[] = {"10.42.0.77", "10.42.0.143",
                                            "10.42.0.251"};
    const user_bench b = user_bench_new();
    const user_sensor *sensors[3];
    for (size_t i = 0; i < 3; i++) {
        sensors[i] = user_sensor_start(
            user_sensor_host(user_format("s%zu", i), b.wire,
                             user_format("%s/24", addresses[i])),
            "--rate 2");
    }
    user_tool *json = user_run(b.host, "lumctl find --json");
    user_expect_status(json, DONE);
    user_expect_equal(user_length(user_out(json), "sensors"), 3);
    user_tool *plain = user_run(b.host, "lumctl find");
    user_expect_status(plain, DONE);
    for (size_t i = 0; i < 3; i++) {
        expect_value(json, user_format("sensors.%zu.sensor", i), addresses[i]);
        user_expect_like(
            user_out(plain),
            user_format("\n%s +eth0 .* answers in ", addresses[i]));
    }
    user_expect_equal(user_length(user_out(json), "searched"), 1);
    expect_value(json, "searched.0.interface", "eth0");
    expect_value(json, "searched.0.subnet", "10.42.0.0/24");
    expect_value(json, "searched.0.by", "udp");
    expect_value(json, "asked", "254");
    for (size_t i = 0; i < 3; i++) {
        user_expect_equal(user_events(sensors[i], "heartbeat"), 0);
        user_expect_equal(user_events(sensors[i], "tlv"), 0);
    }
}

STORY(find_leaves_an_owner_alone,
      "a sensor that is another's is found and stays his")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *owner = hold(&b);
    const char *from = user_value(user_last(s, "heartbeat")->line, "from");
    user_expect_status(user_run(b.host, "lumctl find"), DONE);
    user_expect(!user_ended(owner));
    for (size_t i = 0; i < user_events(s, "heartbeat"); i++) {
        user_expect_same(
            user_value(user_event_at(s, "heartbeat", i)->line, "from"), from);
    }
}

STORY(find_asks_twice,
      "only requests for a time stamp are sent twice, and none to "
      "who has answered")
{
    const user_bench b = user_bench_new();
    const made_up *silent = made_up_new(b.sensor, "10.42.0.5", made_up_silent);
    const made_up *speaks = made_up_new(at_three(&b), "10.42.0.3", NULL);
    user_expect_status(user_run(b.host, "lumctl find " HERE), DONE);
    user_expect_equal(silent->count, 2);
    user_expect_equal(made_up_heard(silent, MADE_UP_TIME), 2);
    user_expect_equal(speaks->count, 1);
    user_expect_equal(made_up_heard(speaks, MADE_UP_TIME), 1);
    user_expect_status(user_run(b.host, "lumctl find " HERE " --retries 2"),
                       DONE);
    user_expect_equal(silent->count, 2 + 3);
}

STORY(find_an_answer_from_another_port,
      "an answer from another port is shown with it")
{
    const user_bench b = user_bench_new();
    world_host *three = at_three(&b);
    made_up *m = made_up_new(three, "10.42.0.3", NULL);
    m->answers_by = user_peer_new(three, "10.42.0.3", 6000, NULL, NULL);
    user_tool *find = user_run(b.host, "lumctl find " HERE);
    user_expect_status(find, DONE);
    user_expect_has(user_out(find), "10.42.0.3:6000");
}

static void answer_as_a_stranger(made_up *self, const made_up_packet *packet)
{
    uint8_t bytes[64];
    memcpy(bytes, packet->bytes, packet->size);
    bytes[8] = 99;
    made_up_send_bytes(self, packet, bytes, packet->size);
}

STORY(find_a_stranger,
      "who sends the magic and nothing of a sensor is told, and is none")
{
    const user_bench b = user_bench_new();
    (void)made_up_new(at_three(&b), "10.42.0.3", answer_as_a_stranger);
    user_tool *find = user_run(b.host, "lumctl find " HERE);
    user_expect_status(find, NO_ANSWER);
    user_expect_like(user_out(find),
                     "10\\.42\\.0\\.3 .*no packet that a sensor sends");
    user_expect_has(user_err(find), "may be one");
}

STORY(find_none,
      "find tells that there is none, and paints where a terminal is "
      "alone")
{
    const user_bench b = user_bench_new();
    user_tool *plain = user_run(b.host, "lumctl find --subnet 10.42.0.8/30");
    user_expect_status(plain, NO_ANSWER);
    user_expect_same(user_out(plain), "");
    user_expect_has(user_err(plain), "no sensor answers at any of 2 addresses");
    user_expect_lacks(user_err(plain), "\r");
    user_tool *json =
        user_run(b.host, "lumctl find --subnet 10.42.0.8/30 --json");
    user_expect_status(json, NO_ANSWER);
    expect_value(json, "sensors", "[]");
}

STORY(find_and_ctrl_c, "Ctrl-C prints what was found so far")
{
    const user_bench b = user_bench_new();
    (void)user_sensor_start(at_three(&b), "--rate 2");
    world_terminal *t = world_terminal_new("xterm");
    world_file *end = NULL;
    world_reader *out = world_reader_new("found", &end);
    user_tool *find =
        user_start_with(b.host, (user_with){.terminal = t, .output = end},
                        "lumctl find --timeout 20000 --subnet 10.42.0.0/24");
    user_until(user_has(user_shown(t), ", 1 sensor found"));
    user_expect_end(find, SIGINT, DONE);
    user_until(user_has(user_taken(out), "10.42.0.3 "));
    user_expect_has(user_shown(t), "interrupted: ");
}

STORY(find_and_an_early_ctrl_c,
      "Ctrl-C before anything was found ends find by it")
{
    const user_bench b = user_bench_new();
    const made_up *asked =
        made_up_new(at_three(&b), "10.42.0.3", made_up_silent);
    user_tool *find =
        user_start(b.host, "lumctl find --timeout 20000 --subnet 10.42.0.0/24");
    user_until(asked->count > 0);
    user_expect_end(find, SIGINT, -SIGINT);
    user_expect_has(user_err(find), "interrupted");
}

STORY(find_in_a_shell,
      "a shell that owns a sensor keeps it alive while it finds")
{
    const user_bench b = user_bench_new();
    const user_sensor *s = user_sensor_start(b.sensor, "--rate 2");
    user_tool *shell =
        run_fed(b.host, "lumctl shell --heartbeat",
                "laser on\nfind --subnet 127.62.16.0/23\nlaser off\n");
    user_expect_status(shell, NO_ANSWER);
    user_expect_equal(user_laser_rises(s), 1);
    user_expect(!user_laser_is_on(s));
    const user_event *up = user_event_at(s, "laser", 0);
    const user_event *down = user_last(s, "laser");
    for (const user_event *e = up; e != down; e = e->next) {
        user_expect(strcmp(e->kind, "status") != 0 ||
                    !user_has(e->line, "HEARTBEAT_TIMEOUT"));
    }
}

STORY(find_with_hardware_addresses,
      "as root, find tells the hardware address of each sensor")
{
    const user_bench b = user_bench_new();
    world_net_rights_of(b.host)->is_root = true;
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *find = user_run(b.host, "lumctl find --json");
    user_expect_status(find, DONE);
    expect_value(find, "sensors.0.how", "answers");
    const uint8_t *mac = world_interface_find(b.sensor, "eth0")->mac;
    expect_value(find, "sensors.0.mac",
                 user_format("%02x:%02x:%02x:%02x:%02x:%02x", mac[0], mac[1],
                             mac[2], mac[3], mac[4], mac[5]));
    expect_value(find, "sensors.0.reach", "null");
    expect_value(find, "sensors.0.several_macs", "false");
}

STORY(find_perhaps_a_sensor,
      "a device in the sensors' subnet that speaks ARP alone is perhaps a "
      "sensor")
{
    const user_bench b = user_bench_new();
    world_net_rights_of(b.host)->is_root = true;
    world_interface_remove(b.eth0, user_ip("10.42.0.1"));
    (void)user_interface(user_host_new("other"), "eth0", b.wire,
                         "10.42.0.143/24");
    user_tool *find = user_run(b.host, "lumctl find --interface eth0");
    user_expect_status(find, NO_ANSWER);
    user_expect_like(user_out(find),
                     "10\\.42\\.0\\.143 [^\n]*perhaps a sensor\n[^\n]*ip addr "
                     "add 10\\.42\\.0\\.1/24 dev eth0");
    user_expect_has(user_err(find),
                    "no sensor answers at any of 254 addresses");
}
