/* lumctl find as root, which asks by ARP and hears what comes to an interface.
 */
#include "help.h"

#include "kernel/net.h"

#include <string.h>

/* The host's programs run as root; its own address is gone if it has none. */
static user_bench root_bench(const char *own)
{
    const user_bench b = user_bench_new();
    world_net_rights_of(b.host)->is_root = true;
    if (own == NULL) {
        world_interface_remove(b.eth0, user_ip("10.42.0.1"));
    }
    return b;
}

static void expect_found(const user_tool *find, size_t i, const char *sensor,
                         const char *how, const char *reach)
{
    expect_value(find, user_format("sensors.%zu.sensor", i), sensor);
    expect_value(find, user_format("sensors.%zu.how", i), how);
    expect_value(find, user_format("sensors.%zu.reach", i), reach);
}

static user_tool *find_json(const user_bench *b, int status, const char *words)
{
    user_tool *find = user_run(b->host, "lumctl find --json %s", words);
    user_expect_status(find, status);
    return find;
}

STORY(find_beyond_the_subnets,
      "find shows a sensor beyond this host's subnets, and how to reach it")
{
    const user_bench b = root_bench(NULL);
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *find = find_json(&b, NO_ANSWER, "");
    user_expect_equal(user_length(user_out(find), "sensors"), 1);
    expect_found(find, 0, "10.42.0.37", "arp",
                 "ip addr add 10.42.0.1/24 dev eth0");
    user_tool *plain = user_run(b.host, "lumctl find");
    user_expect_status(plain, NO_ANSWER);
    user_expect_has(user_out(plain),
                    "as root: ip addr add 10.42.0.1/24 dev eth0");
    world_interface_add(b.eth0, user_ip("10.42.0.1"), 24);
    expect_found(find_json(&b, DONE, ""), 0, "10.42.0.37", "answers", "null");
    user_expect_status(user_run(b.host, "lumctl status"), DONE);
}

STORY(find_proposes_a_free_address,
      "find proposes an address that another device does not have")
{
    const user_bench b = root_bench(NULL);
    world_host *other = user_host_new("other");
    (void)user_interface(other, "eth0", b.wire, "10.42.0.1/24");
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *find = find_json(&b, NO_ANSWER, "");
    user_expect_equal(user_length(user_out(find), "sensors"), 2);
    expect_found(find, 1, "10.42.0.37", "arp",
                 "ip addr add 10.42.0.2/24 dev eth0");
}

STORY(find_breaks_no_other_interface,
      "the way that find shows leaves another interface of the subnet alone")
{
    const user_bench b = root_bench("10.42.0.1");
    world_segment *other = world_segment_new("other");
    world_interface *eth1 = world_interface_new(b.host, other, "eth1");
    world_host *far = user_sensor_host("far", other, "10.42.0.37/24");
    world_host *near = user_sensor_host("near", b.wire, "10.42.0.99/24");
    (void)user_sensor_start(near, "--rate 2");
    (void)user_sensor_start(far, "--rate 2");
    user_tool *find = find_json(&b, DONE, "");
    user_expect_equal(user_length(user_out(find), "sensors"), 2);
    expect_found(find, 0, "10.42.0.37", "arp",
                 "ip route add 10.42.0.37/32 dev eth1");
    expect_found(find, 1, "10.42.0.99", "answers", "null");
    world_route_add(eth1, user_ip("10.42.0.37"), 32, 0);
    user_expect_status(user_run(b.host, "lumctl --host 10.42.0.37 time"), DONE);
    user_expect_status(user_run(b.host, "lumctl --host 10.42.0.99 time"), DONE);
}

STORY(find_asks_where_no_address_fits,
      "an interface without a fitting address is asked for all of the sensors' "
      "subnet")
{
    const user_bench b = root_bench(NULL);
    world_segment *other = world_segment_new("other");
    (void)world_interface_new(b.host, other, "eth1");
    (void)user_sensor_start(b.sensor, "--rate 2");
    (void)user_sensor_start(user_sensor_host("far", other, "10.42.0.37/24"),
                            "--rate 2");
    user_tool *find = find_json(&b, NO_ANSWER, "--retries 0");
    user_expect_equal(user_length(user_out(find), "sensors"), 2);
    for (size_t i = 0; i < 2; i++) {
        expect_value(find, user_format("sensors.%zu.sensor", i), "10.42.0.37");
        expect_value(find, user_format("searched.%zu.by", i), "arp");
        expect_value(find, user_format("searched.%zu.interface", i),
                     user_format("eth%zu", i));
    }
    expect_value(find, "asked", "254");
}

STORY(find_counts_an_address_once,
      "a subnet that is asked in several ways is counted once")
{
    const user_bench b = root_bench("10.42.0.1");
    world_segment *other = world_segment_new("other");
    (void)world_interface_new(b.host, other, "eth1");
    user_tool *find =
        find_json(&b, NO_ANSWER, "--subnet 172.16.9.0/24 --retries 0");
    user_expect_equal(user_length(user_out(find), "searched"), 3);
    expect_value(find, "searched.0.by", "udp");
    expect_value(find, "searched.1.by", "arp");
    expect_value(find, "searched.2.interface", "eth1");
    expect_value(find, "asked", "254");
    expect_value(find, "not_sent", "254");
    user_tool *plain =
        user_run(b.host, "lumctl find --subnet 172.16.9.0/24 --retries 0");
    user_expect_status(plain, NO_ANSWER);
    user_expect_has(user_err(plain), "254 of 762 requests were not sent");
    user_expect_has(user_err(plain), "no sensor answers at any of 254");
}

STORY(find_asks_a_named_subnet_by_arp,
      "a subnet that is named is asked by ARP where no address fits")
{
    const user_bench b = root_bench("10.42.0.1");
    (void)user_sensor_start(user_sensor_host("seven", b.wire, "10.7.7.7/24"),
                            "--rate 2");
    user_tool *find =
        find_json(&b, NO_ANSWER, "--interface eth0 --subnet 10.7.7.0/28");
    expect_found(find, 0, "10.7.7.7", "arp",
                 "ip addr add 10.7.7.1/24 dev eth0");
    expect_value(find, "searched.0.by", "arp");
    world_interface_add(b.eth0, user_ip("10.7.7.1"), 24);
    find = find_json(&b, DONE, "--subnet 10.7.7.0/28");
    expect_found(find, 0, "10.7.7.7", "answers", "null");
}

STORY(find_proposes_none_where_none_is_free,
      "where no address is known to be free, none is proposed")
{
    const user_bench b = root_bench("10.42.0.1");
    world_host *far = user_host_new("far");
    world_interface *its = user_interface(far, "eth0", b.wire, "10.9.9.99/24");
    for (unsigned n = 1; n <= 16; n++) {
        world_interface_add(its, user_ip("10.9.9.0") + n, 24);
    }
    static const char where[] = "--interface eth0 --subnet 10.9.9.96/28";
    user_tool *find = find_json(&b, NO_ANSWER, where);
    user_expect_equal(user_length(user_out(find), "sensors"), 1);
    expect_found(find, 0, "10.9.9.99", "arp", "null");
    user_tool *plain = user_run(b.host, "lumctl find %s", where);
    user_expect_status(plain, NO_ANSWER);
    user_expect_has(user_out(plain),
                    "not reached from this host: give eth0 an address in "
                    "10.9.9.0/24 that no device has");
}

STORY(find_says_what_it_left_out, "what was not searched is said")
{
    const user_bench b = root_bench("10.42.0.1");
    world_segment *other = world_segment_new("other");
    world_interface *eth1 =
        user_interface(b.host, "eth1", other, "10.43.0.1/16");
    user_tool *find = find_json(&b, NO_ANSWER, "--interface eth1 --retries 0");
    user_expect_equal(user_length(user_out(find), "left_out"), 1);
    expect_value(find, "left_out.0",
                 "of 10.43.0.0/16 on eth1 only 10.43.0.0/22 was searched, "
                 "around this host's own address; --subnet searches another "
                 "part");
    world_interface_set_carrier(eth1, false);
    user_tool *plain = user_run(b.host, "lumctl find --interface eth1");
    user_expect_status(plain, FAILED);
    user_expect_has(user_err(plain), "eth1: no link, and not searched");
    world_interface_set_up(eth1, false);
    plain = user_run(b.host, "lumctl find --interface eth1");
    user_expect_status(plain, FAILED);
    user_expect_has(user_err(plain), "ip link set eth1 up");
    user_expect_has(user_err(plain), "nothing could be asked");
}

STORY(find_without_rights, "without rights all but ARP works, and that is said")
{
    const user_bench b = user_bench_new();
    world_segment *other = world_segment_new("other");
    (void)world_interface_new(b.host, other, "eth1");
    (void)user_sensor_start(b.sensor, "--rate 2");
    user_tool *find = find_json(&b, DONE, "");
    expect_found(find, 0, "10.42.0.37", "answers", "null");
    expect_value(find, "sensors.0.mac", "null");
    expect_value(find, "left_out.0",
                 "eth1: no address in a sensor's subnet, and not asked by ARP, "
                 "which needs root: run 'sudo lumctl find'");
}
