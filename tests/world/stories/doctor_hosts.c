/* lumctl doctor as root: hosts that are broken in one way, what it proposes,
 * and that this fixes them. */
#include "look.h"

#include <string.h>

static user_bench root_bench(void)
{
    const user_bench b = tuned_bench();
    world_net_rights_of(b.host)->is_root = true;
    return b;
}

/* Such a bench with a sensor. */
static user_bench bench(void)
{
    const user_bench b = root_bench();
    (void)user_sensor_start(b.sensor, "--rate 4");
    return b;
}

static world_interface *other(const user_bench *b, const char *address)
{
    return user_interface(b->host, "other0", world_segment_new("other"),
                          address);
}

static user_tool *look(const user_bench *b, const char *options)
{
    return user_run(b->host, "lumctl %s doctor --json", options);
}

/* A look at which a check is wrong, and says so. */
static user_tool *broken(const user_bench *b, const char *options, int status,
                         const char *check, const char *told)
{
    user_tool *doctor = look(b, options);
    user_expect_status(doctor, status);
    expect_check(doctor, check, "wrong");
    expect_text(doctor, check, told);
    return doctor;
}

static void bare(const user_bench *b)
{
    world_interface_remove(b->eth0, user_ip("10.42.0.1"));
}

static const char by_eth0[] =
    "lumctl --host 10.42.0.37 --interface eth0 doctor    # --interface eth0 "
    "with every tool";

/* --- Addresses --- */

STORY(doctor_an_address_of_another_subnet,
      "an address of another subnet is told, and one of the sensor's fixes it")
{
    const user_bench b = bench();
    bare(&b);
    world_interface_add(b.eth0, user_ip("192.168.7.1"), 24);
    world_route_add(b.eth0, 0, 0, user_ip("192.168.7.2"));
    user_tool *doctor = broken(&b, "", FAILED, "interface", "192.168.7.1/24");
    expect_fix(doctor, "interface", "sudo ip addr add 10.42.0.1/24 dev eth0");
    world_interface_add(b.eth0, user_ip("10.42.0.1"), 24);
    expect_fine(examine(&b));
}

STORY(doctor_a_netmask,
      "a netmask that leaves the sensor out is told with what "
      "it takes in")
{
    const user_bench b = bench();
    bare(&b);
    world_interface_add(b.eth0, user_ip("10.42.0.1"), 28);
    user_tool *doctor = broken(&b, "", FAILED, "interface",
                               "eth0 has 10.42.0.1/28, a subnet from 10.42.0.0 "
                               "to 10.42.0.15, and 10.42.0.37 is outside");
    expect_fix(doctor, "interface", "sudo ip addr add 10.42.0.1/24 dev eth0");
    bare(&b);
    world_interface_add(b.eth0, user_ip("10.42.0.1"), 24);
    expect_fine(examine(&b));
}

STORY(doctor_what_interfaces_have_instead,
      "what interfaces have instead of an address in the subnet is shown")
{
    const user_bench b = root_bench();
    (void)other(&b, "192.168.7.1/24");
    bare(&b);
    user_tool *doctor =
        broken(&b, "", FAILED, "interface", "other0 has 192.168.7.1/24");
    expect_text(doctor, "interface", "eth0 has none");
}

STORY(doctor_an_address_of_another_device,
      "an address that another device has is not proposed")
{
    const user_bench b = bench();
    (void)user_interface(user_host_new("rival"), "eth0", b.wire,
                         "10.42.0.1/24");
    bare(&b);
    user_tool *doctor = broken(&b, "", FAILED, "interface", "subnet");
    expect_fix(doctor, "interface", "sudo ip addr add 10.42.0.2/24 dev eth0");
    world_interface_add(b.eth0, user_ip("10.42.0.2"), 24);
    expect_fine(examine(&b));
}

STORY(doctor_no_free_address,
      "where every address that is looked at is taken, none is proposed")
{
    const user_bench b = root_bench();
    bare(&b);
    world_interface *its =
        user_interface(user_host_new("crowd"), "eth0", b.wire, "10.42.0.1/32");
    for (uint32_t n = 2; n <= 16; n++) {
        world_interface_add(its, user_ip("10.42.0.0") + n, 32);
    }
    user_tool *doctor = look(&b, "--host 10.42.0.16");
    expect_text(doctor, "interface",
                "every address from 10.42.0.1 to 10.42.0.16 is taken");
    expect_fix(doctor, "interface",
               "sudo lumctl find --interface eth0 --subnet 10.42.0.0/24    # "
               "who has which; then give eth0 one that nobody has");
    world_interface_remove(its, user_ip("10.42.0.9"));
    expect_fix(look(&b, "--host 10.42.0.16"), "interface",
               "sudo ip addr add 10.42.0.9/24 dev eth0");
}

STORY(doctor_down_and_without_address,
      "an interface that is down and has no address is fixed step by step")
{
    const user_bench b = bench();
    bare(&b);
    world_interface_set_up(b.eth0, false);
    user_tool *doctor = broken(&b, "", FAILED, "interface", "");
    user_expect(*look_of(doctor, "interface", "fix") != '\0');
    world_interface_set_up(b.eth0, true);
    world_interface_add(b.eth0, user_ip("10.42.0.1"), 24);
    expect_fine(examine(&b));
}

STORY(doctor_no_cable, "a cable that is not in is told")
{
    const user_bench b = root_bench();
    user_cable(b.eth0, false);
    (void)broken(&b, "", FAILED, "interface", "no link");
}

STORY(doctor_a_simulator_on_this_host,
      "a simulator on this host is the fix, and is not to be killed")
{
    const user_bench b = root_bench();
    bare(&b);
    (void)user_start(b.host,
                     "lumsim --address 127.0.0.1 --port 5600 --frames 1 "
                     "--rate 4");
    user_pause_ms(100);
    user_tool *doctor = broken(&b, "", FAILED, "interface", "subnet");
    expect_fix(doctor, "interface",
               "lumctl --host 127.0.0.1 --port 5600 doctor    # lumsim is "
               "there; for another sensor: sudo ip addr add 10.42.0.1/24 dev "
               "eth0");
    expect_check(doctor, "port", "note");
    expect_fix(doctor, "port", "lumctl --host 127.0.0.1 --port 5600 doctor");
    user_expect_status(look(&b, "--host 127.0.0.1 --port 5600"), DONE);
}

STORY(doctor_mends_bear_the_port, "fixes bear the port of what they name")
{
    const user_bench b = root_bench();
    (void)user_start(b.host, "lumsim --address 127.0.0.1 --frames 1 --rate 4");
    user_pause_ms(100);
    user_tool *doctor = broken(&b, "--host 127.0.0.3 --port 5518", FAILED,
                               "port", "lumsim (process");
    expect_fix(doctor, "port", "lumctl --host 127.0.0.1 doctor");
    expect_text(doctor, "port", "at 127.0.0.1:5517");
}

/* --- Routes that work --- */

/* A computer with two addresses, one of them the sensor's, which it keeps. */
static world_interface *keep_two(const user_bench *b, const char *address)
{
    world_interface *its = world_interface_find(b->sensor, "eth0");
    world_interface_add(its, user_ip(SENSOR), 24);
    world_interface_add(its, user_ip(address), 24);
    return its;
}

STORY(doctor_a_gateway_that_works, "a gateway that works is left alone")
{
    const user_bench b = bench();
    (void)keep_two(&b, "10.42.0.9");
    world_route_add(b.eth0, user_ip("10.42.0.32"), 29, user_ip("10.42.0.9"));
    user_tool *doctor = look(&b, "");
    user_expect_status(doctor, DONE);
    expect_check(doctor, "route", "note");
    expect_fix(doctor, "route", "");
}

STORY(doctor_behind_the_default_route,
      "a sensor behind the default route is left alone")
{
    const user_bench b = bench();
    (void)keep_two(&b, "192.168.7.2");
    bare(&b);
    world_interface_add(b.eth0, user_ip("192.168.7.1"), 24);
    world_route_add(b.eth0, 0, 0, user_ip("192.168.7.2"));
    user_tool *doctor = look(&b, "");
    user_expect_status(doctor, DONE);
    expect_check(doctor, "interface", "note");
    expect_fix(doctor, "interface", "");
    expect_check(doctor, "answer", "fine");
}

/* --- Two interfaces in its subnet --- */

STORY(doctor_two_interfaces_and_the_right_one,
      "a second interface in the subnet is told, where the route leads by the "
      "right one")
{
    const user_bench b = bench();
    (void)other(&b, "10.42.0.2/24");
    user_tool *doctor = look(&b, "");
    expect_fine(doctor);
    user_expect_same(look_of(doctor, "interface", "text"),
                     "eth0 is up and has 10.42.0.1/24, and 10.42.0.37 answers "
                     "there; other0 with 10.42.0.2/24 is in that subnet too, "
                     "and nobody answers there");
}

/* The route of the address that came first holds. */
static user_bench by_the_wrong_one(const char *address)
{
    const user_bench b = bench();
    bare(&b);
    (void)other(&b, address);
    world_interface_add(b.eth0, user_ip("10.42.0.1"), 24);
    return b;
}

STORY(doctor_two_interfaces_and_the_wrong_one,
      "where the route leads by the wrong one of two, the right one is named")
{
    static const char *const addresses[] = {"10.42.0.2/24", "10.42.0.1/24"};
    const user_bench b = by_the_wrong_one(addresses[user_any(0, 1)]);
    user_tool *doctor =
        broken(&b, "", FAILED, "route",
               "goes out by other0, and not by eth0 in its subnet, where it "
               "answers");
    user_expect_like(look_of(doctor, "interface", "text"),
                     "^eth0 is up and has 10\\.42\\.0\\.1/24, and "
                     "10\\.42\\.0\\.37 answers there");
    expect_fix(doctor, "route", by_eth0);
    expect_fine(look(&b, "--interface eth0"));
}

STORY(doctor_the_wrong_one_without_rights,
      "which of two interfaces is the right one is told without rights too")
{
    const user_bench b = by_the_wrong_one("10.42.0.2/24");
    world_net_rights_of(b.host)->is_root = false;
    user_tool *doctor = broken(&b, "", FAILED, "route", "other0");
    expect_fix(doctor, "route", by_eth0);
}

STORY(doctor_the_wrong_interface,
      "that the wrong interface was asked for is told")
{
    const user_bench b = bench();
    (void)other(&b, "10.42.0.2/24");
    user_tool *doctor = broken(&b, "--interface other0", FAILED, "arp",
                               "but a device on eth0 does");
    expect_text(doctor, "interface", "other0");
    expect_fix(doctor, "arp", by_eth0);
    expect_fine(look(&b, "--interface eth0"));
}

STORY(doctor_an_interface_without_address,
      "that an interface without an address was asked for is told")
{
    const user_bench b = bench();
    world_interface *other0 =
        world_interface_new(b.host, world_segment_new("other"), "other0");
    user_tool *doctor =
        broken(&b, "--interface other0", FAILED, "interface",
               "interface other0 has no address in the sensor's subnet");
    expect_fix(doctor, "interface", by_eth0);
    world_net_rights_of(b.host)->is_root = false;
    expect_fix(look(&b, "--interface other0"), "interface", by_eth0);
    world_net_rights_of(b.host)->is_root = true;
    world_interface_add(other0, user_ip("10.42.0.2"), 24);
    world_interface_set_up(other0, false);
    doctor = broken(&b, "--interface other0", FAILED, "interface",
                    "down; 10.42.0.37 answers on eth0");
    expect_fix(doctor, "interface", by_eth0);
    bare(&b);
    world_interface_remove(other0, user_ip("10.42.0.2"));
    world_interface_set_up(other0, true);
    (void)broken(&b, "--interface other0", FAILED, "interface",
                 "10.42.0.37 answers on eth0");
}

STORY(doctor_the_cable_with_the_sensor,
      "the cable with the sensor is known by its answer")
{
    const user_bench b = bench();
    (void)world_interface_new(b.host, world_segment_new("other"), "enp1s0");
    bare(&b);
    world_interface_add(b.eth0, user_ip("192.168.7.9"), 24);
    user_tool *doctor = broken(&b, "", FAILED, "interface", "subnet");
    expect_fix(doctor, "interface", "sudo ip addr add 10.42.0.1/24 dev eth0");
}

STORY(
    doctor_two_interfaces_and_no_sensor,
    "where no sensor is at either interface, nobody's silence is a wrong route")
{
    const user_bench b = root_bench();
    (void)other(&b, "10.42.0.2/24");
    user_tool *doctor = broken(&b, "", NO_ANSWER, "arp", "nobody on eth0");
    expect_check(doctor, "route", "fine");
}

STORY(doctor_a_second_interface_that_is_down,
      "a second interface that is down is no matter")
{
    const user_bench b = bench();
    world_interface_set_up(other(&b, "10.42.0.2/24"), false);
    expect_fine(look(&b, ""));
}

/* --- Devices --- */

STORY(doctor_two_devices, "two devices with the sensor's address are told, and "
                          "one that goes is not believed any more")
{
    const user_bench b = bench();
    world_interface *rival =
        user_interface(user_host_new("rival"), "eth0", b.wire, SENSOR "/24");
    user_tool *doctor = look(&b, "");
    expect_check(doctor, "arp", "wrong");
    user_expect_like(look_of(doctor, "arp", "text"),
                     "2 devices on eth0 answer for 10\\.42\\.0\\.37: "
                     "(..:){5}.. and (..:){5}..; ");
    world_interface_remove(rival, user_ip(SENSOR));
    expect_fine(look(&b, ""));
}

STORY(doctor_two_devices_and_no_sensor,
      "two devices with the sensor's address, and the one reached is none")
{
    const user_bench b = root_bench();
    (void)user_interface(user_host_new("one"), "eth0", b.wire, SENSOR "/24");
    (void)user_interface(user_host_new("two"), "eth0", b.wire, SENSOR "/24");
    user_tool *doctor =
        broken(&b, "", FAILED, "arp", "2 devices on eth0 answer");
    expect_value(doctor, "overall", "wrong");
    expect_check(doctor, "answer", "wrong");
}

STORY(doctor_the_hosts_own_address,
      "the sensor's address on the host itself is told, whether it is on the "
      "loopback, and whether a sensor has it too")
{
    const user_bench b = bench();
    world_interface *lo = world_interface_find(b.host, "lo");
    world_interface_add(lo, user_ip(SENSOR), 32);
    user_tool *doctor = broken(&b, "", FAILED, "port", "own address (dev lo)");
    expect_check(doctor, "arp", "wrong");
    expect_text(doctor, "arp", "a device on eth0 has it, too: 02:");
    expect_fix(doctor, "arp", "sudo ip addr del 10.42.0.37/32 dev lo");
    expect_fix(doctor, "port", "sudo ip addr del 10.42.0.37/32 dev lo");
    world_interface_remove(lo, user_ip(SENSOR));
    expect_fine(look(&b, ""));
}

STORY(doctor_the_hosts_own_address_and_no_sensor,
      "the sensor's address on the host itself, where no sensor has it")
{
    const user_bench b = root_bench();
    world_interface_add(b.eth0, user_ip(SENSOR), 24);
    (void)user_start(b.host, "lumsim --address 127.0.0.1 --frames 1 --rate 4");
    user_pause_ms(100);
    user_tool *doctor = broken(&b, "", FAILED, "port", "own address");
    expect_check(doctor, "arp", "fine");
    expect_fix(doctor, "port", "sudo ip addr del 10.42.0.37/24 dev eth0");
}

STORY(doctor_a_program_with_the_port,
      "a program of this host that has the port is a note")
{
    const user_bench b = bench();
    (void)user_peer_new(b.host, "127.0.0.1", 5517, NULL, NULL);
    user_tool *doctor = look(&b, "");
    user_expect_status(doctor, DONE);
    expect_check(doctor, "port", "note");
}

STORY(doctor_nobody_has_the_address, "that nobody has the address is told")
{
    const user_bench b = bench();
    user_tool *elsewhere =
        broken(&b, "--host 10.42.0.99", NO_ANSWER, "arp", "nobody on eth0");
    user_expect_has(look_of(elsewhere, "arp", "fix"), "boots at 10.42.0.37");
    expect_fine(look(&b, ""));
    world_interface_set_up(world_interface_find(b.sensor, "eth0"), false);
    user_tool *gone =
        broken(&b, "", NO_ANSWER, "arp", "nobody on eth0"); /* any more */
    user_expect_has(look_of(gone, "arp", "fix"), "lumctl find");
}

STORY(doctor_a_sensor_that_moved,
      "a sensor that got another address is searched for, not switched off")
{
    const user_bench b = bench();
    world_interface_add(world_interface_find(b.sensor, "eth0"),
                        user_ip("10.42.0.50"), 24);
    user_expect_status(user_run(b.host, "lumctl set-ip 10.42.0.50"), DONE);
    world_interface_remove(world_interface_find(b.sensor, "eth0"),
                           user_ip(SENSOR));
    user_tool *doctor = broken(&b, "", NO_ANSWER, "arp", "nobody on eth0");
    expect_fix(doctor, "arp",
               "sudo lumctl find --interface eth0    # at which address does "
               "it answer? It boots at 10.42.0.37");
    user_expect_has(user_out(user_run(b.host, "lumctl find --interface eth0")),
                    "10.42.0.50");
    expect_fine(look(&b, "--host 10.42.0.50"));
}

STORY(doctor_another_host_with_our_address,
      "another host with this host's own address is told, and not this host "
      "itself on a second interface")
{
    const user_bench b = bench();
    world_interface *second =
        user_interface(b.host, "eth1", b.wire, "10.43.0.1/24");
    expect_fine(look(&b, ""));
    (void)user_interface(user_host_new("rival"), "eth0", b.wire,
                         "10.42.0.1/24");
    user_tool *doctor =
        broken(&b, "", FAILED, "arp",
               " on eth0 has this host's address 10.42.0.1, too");
    expect_fix(doctor, "arp",
               "sudo ip addr add 10.42.0.2/24 dev eth0 && sudo ip addr del "
               "10.42.0.1/24 dev eth0    # or give the other one another "
               "address");
    world_net_rights_of(b.host)->is_root = false;
    expect_text(look(&b, ""), "arp", "or has this host's address, too");
    world_net_rights_of(b.host)->is_root = true;
    world_interface_set_up(world_interface_find(b.sensor, "eth0"), false);
    doctor = broken(&b, "", FAILED, "arp", "nobody on eth0");
    expect_text(doctor, "arp", "has this host's address 10.42.0.1, too");
    world_interface_set_up(world_interface_find(b.sensor, "eth0"), true);
    world_interface_set_up(second, false);
    bare(&b);
    world_interface_add(b.eth0, user_ip("10.42.0.2"), 24);
    expect_fine(look(&b, ""));
}

STORY(doctor_a_host_without_a_sensor, "a host where nothing listens is told")
{
    const user_bench b = root_bench();
    (void)keep_two(&b, "10.42.0.9");
    (void)broken(&b, "", NO_ANSWER, "answer", "nothing listens on its port");
}

/* --- What was held up --- */

STORY(doctor_held_up_as_root,
      "what still waits for a doctor that was held up is not blamed on a "
      "firewall")
{
    const user_bench b = root_bench();
    const user_sensor *s =
        user_sensor_start(b.sensor, "--rate 4 --answer-delay 90");
    user_tool *doctor = user_start(b.host, "lumctl doctor --json");
    user_until(user_events(s, "heartbeat") > 0);
    user_pause_between_ms(1500, 1900);
    user_signal(doctor, SIGSTOP);
    user_pause_between_ms(500, 700);
    user_signal(doctor, SIGCONT);
    (void)user_wait(doctor);
    user_expect_lacks(look_of(doctor, "loss", "text"), "firewall");
}
