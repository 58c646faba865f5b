#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../tools/lumctl/doctor/doctor_facts.h"
#include "../../tools/lumctl/doctor/doctor_legacy.h"
#include "../../tools/lumctl/doctor/doctor_trace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SENSOR 0x0a2a0025u

static FILE *open_text(const char *text)
{
    FILE *f = tmpfile();
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0);
    rewind(f);
    return f;
}

/* The kernel's own spelling of an address, which depends on the host. */
static const char *kernel_hex(uint32_t address, char out[9])
{
    const uint8_t b[4] = {(uint8_t)(address >> 24), (uint8_t)(address >> 16),
                          (uint8_t)(address >> 8), (uint8_t)address};
    uint32_t word = 0;
    memcpy(&word, b, sizeof word);
    snprintf(out, 9, "%08X", (unsigned)word);
    return out;
}

static const char arp_text[] =
    "IP address       HW type     Flags       HW address            Mask     "
    "Device\n"
    "10.42.0.37       0x1         0x2         9a:62:cd:08:a4:01     *        "
    "eth0\n"
    "10.42.0.37       0x1         0x0         00:00:00:00:00:00     *        "
    "eth1\n"
    "10.42.0.38       0x1         0x0         00:00:00:00:00:00     *        "
    "eth0\n"
    "broken\n"
    "10.42.0.40       0x1         0x6         9a:62:cd:08:a4:02     *        "
    "eth0\n";

static enum arp_state arp(uint32_t address, const char *device, char mac[18])
{
    FILE *f = open_text(arp_text);
    const enum arp_state state = facts_arp(f, address, device, mac);
    fclose(f);
    return state;
}

static void arp_tells_complete_incomplete_and_unknown(void **state)
{
    char mac[MAC_BYTES] = "before";
    (void)state;
    assert_int_equal(arp(SENSOR + 1u, "eth0", mac), ARP_INCOMPLETE);
    assert_int_equal(arp(SENSOR, "eth1", mac), ARP_INCOMPLETE);
    assert_int_equal(arp(SENSOR, "eth2", mac), ARP_UNKNOWN);
    assert_int_equal(arp(SENSOR + 2u, "eth0", mac), ARP_UNKNOWN);
    assert_string_equal(mac, "before");
    assert_int_equal(arp(SENSOR, "eth0", mac), ARP_COMPLETE);
    assert_string_equal(mac, "9a:62:cd:08:a4:01");
    assert_int_equal(arp(SENSOR + 3u, "eth0", mac), ARP_COMPLETE);
}

static size_t users(const char *text, struct udp_user *out, size_t room)
{
    FILE *f = open_text(text);
    const size_t n = facts_udp(f, 5517, out, room);
    fclose(f);
    return n;
}

static void udp_sockets_of_the_port_are_found_with_user_and_inode(void **state)
{
    struct udp_user u[4];
    char text[1024];
    char hex[9];
    (void)state;
    snprintf(text, sizeof text,
             "   sl  local_address rem_address   st tx_queue rx_queue tr "
             "tm->when retrnsmt   uid  timeout inode ref pointer drops\n"
             "  100: %s:158D 00000000:0000 07 00000000:00000000 00:00000000 "
             "00000000  1000        0 4711 2 0000000000000000 0\n"
             "  101: 00000000:158D 00000000:0000 07 00000000:00000000 "
             "00:00000000 00000000     0        0 99999999999 2 0 0\n"
             "  102: 00000000:158E 00000000:0000 07 00000000:00000000 "
             "00:00000000 00000000     0        0 1 2 0 0\n"
             "  103: xyz\n",
             kernel_hex(SENSOR, hex));
    assert_int_equal(users(text, u, 4), 2);
    assert_int_equal(u[0].address, SENSOR);
    assert_int_equal(u[0].uid, 1000);
    assert_int_equal(u[0].inode, 4711);
    assert_int_equal(u[1].address, 0);
    assert_true(u[1].inode == UINT64_C(99999999999));
    assert_int_equal(u[0].port, 5517);
    assert_int_equal(users(text, u, 1), 1);
    FILE *f = open_text(text);
    assert_int_equal(facts_udp(f, 0, u, 4), 3);
    fclose(f);
    assert_int_equal(u[2].port, 5518);
}

static void udp6_counts_where_it_can_take_ipv4(void **state)
{
    struct udp_user u[4];
    char text[1024];
    char hex[2][9];
    (void)state;
    snprintf(text, sizeof text,
             "  sl  local_address\n"
             " 1: 00000000000000000000000000000000:158D "
             "00000000000000000000000000000000:0000 07 0:0 0:0 0 7 0 11 2 0 0\n"
             " 2: 0000000000000000%s%s:158D "
             "00000000000000000000000000000000:0000 07 0:0 0:0 0 8 0 12 2 0 0\n"
             " 3: 000080FE00000000%s01000000:158D "
             "00000000000000000000000000000000:0000 07 0:0 0:0 0 9 0 13 2 0 "
             "0\n",
             kernel_hex(0xffffu, hex[0]), kernel_hex(SENSOR, hex[1]), hex[0]);
    assert_int_equal(users(text, u, 4), 2);
    assert_int_equal(u[0].address, 0);
    assert_int_equal(u[0].uid, 7);
    assert_int_equal(u[1].address, SENSOR);
}

/* As nft prints it: a packet that leaves, and the answer, dropped in a chain
 * behind a jump. */
static const char *const traced[] = {
    "trace id 0a1b ip lumctl_7 leaves packet: oif \"eth0\" ip saddr 10.42.0.1",
    "trace id 0a1b ip lumctl_7 leaves rule ip daddr 10.42.0.37 meta nftrace "
    "set 1 (verdict continue)",
    "trace id 0a1b ip lumctl_7 leaves policy accept ",
    "trace id 0a1b inet filter output packet: oif \"eth0\"",
    "trace id 0a1b inet filter output policy accept ",
    "trace id 0c2d netdev lumctl_7 comes packet: iif \"eth0\"",
    "trace id 0c2d netdev lumctl_7 comes policy accept ",
    "trace id 0c2d ip guard in packet: iif \"eth0\" ip saddr 10.42.0.37",
    "trace id 0c2d ip guard in rule ip saddr 10.42.0.0/16 jump no_udp (verdict "
    "jump no_udp)",
    "trace id 0c2d ip guard no_udp rule udp sport { 53, 5000-6000 } counter "
    "packets 0 bytes 0 drop (verdict drop)",
};

#define TRACED (sizeof traced / sizeof traced[0])

static struct trace_reader read_lines(const char *const *lines, size_t n)
{
    struct trace_reader r = {.table = "lumctl_7"};
    for (size_t i = 0; i < n; i++) {
        trace_read(&r, lines[i]);
    }
    return r;
}

static void a_trace_names_the_rule_that_drops(void **state)
{
    const struct trace_reader r = read_lines(traced, TRACED);
    const struct trace_way *way = trace_dropped(&r);
    (void)state;
    assert_non_null(way);
    assert_false(way->is_out || way->has_ufw);
    assert_string_equal(way->family, "ip");
    assert_string_equal(way->table, "guard");
    assert_string_equal(way->base, "in");
    assert_string_equal(way->chain, "no_udp");
    assert_string_equal(way->rule, "udp sport { 53, 5000-6000 } counter "
                                   "packets 0 bytes 0 drop");
}

static void a_trace_of_what_passes_names_none(void **state)
{
    const struct trace_reader left = read_lines(traced, 5);
    const struct trace_reader both = read_lines(traced, TRACED - 1u);
    (void)state;
    assert_null(trace_dropped(&left));
    assert_true(trace_saw(&left, true));
    assert_false(trace_saw(&left, false));
    assert_null(trace_dropped(&both));
    assert_true(trace_saw(&both, false));
}

static void a_trace_tells_policies_ways_and_ufw(void **state)
{
    static const char *const lines[] = {
        "trace id 1 ip lumctl_7 leaves policy accept ",
        "trace id 1 ip filter OUTPUT packet: oif \"eth0\"",
        "trace id 1 ip filter OUTPUT rule jump ufw-out (verdict jump ufw-out)",
        "trace id 1 ip filter ufw-out unknown rule handle 2 (verdict continue)",
        "trace id 1 ip filter OUTPUT policy drop ",
        "trace id 2 ip lumctl_7 comes policy accept ",
        "trace id 2 inet f in policy drop ",
    };
    struct trace_reader r = read_lines(lines, 5);
    const struct trace_way *way = trace_dropped(&r);
    (void)state;
    assert_non_null(way);
    assert_true(way->is_out && way->has_ufw);
    assert_string_equal(way->chain, "OUTPUT");
    assert_string_equal(way->base, "OUTPUT");
    assert_string_equal(way->rule, "");
    /* an answer that is dropped says more */
    trace_read(&r, lines[5]);
    trace_read(&r, lines[6]);
    way = trace_dropped(&r);
    assert_non_null(way);
    assert_false(way->is_out);
    assert_string_equal(way->table, "f");
}

static void a_rule_whose_text_says_drop_need_not_drop(void **state)
{
    static const char *const lines[] = {
        "trace id 1 ip f in rule log prefix \"drop: \" accept (verdict accept)",
        "trace id 1 ip f in rule counter drop (verdict continue)",
        "trace id 1 ip f in rule log \"(verdict drop)\" (verdict accept)",
        "trace id 1 ip f in return ",
        "trace id 1 ip f in policy accept ",
    };
    const struct trace_reader r = read_lines(lines, 5);
    (void)state;
    assert_null(trace_dropped(&r));
}

/* With any input, reading ends and stays inside the buffer. */
static void damaged_lines_are_survived(void **state)
{
    struct trace_reader r = {.table = "lumctl_7"};
    uint32_t seed = 1;
    (void)state;
    for (unsigned round = 0; round < 20000; round++) {
        char line[256];
        size_t len = strlen(traced[round % TRACED]);
        memcpy(line, traced[round % TRACED], len + 1u);
        for (unsigned i = 0; i < 4; i++) {
            seed = seed * 1664525u + 1013904223u;
            line[(seed >> 8) % len] = "{}\"\n (:!@x"[(seed >> 4) % 10u];
        }
        line[seed % len] = round % 3u == 0 ? '\0' : 'a';
        trace_read(&r, line);
    }
    assert_true(r.count <= TRACE_IDS_MAX);
}

static void a_name_as_long_as_they_come_is_cut(void **state)
{
    char line[1024];
    struct trace_reader r = {.table = "lumctl_7"};
    (void)state;
    for (size_t len = 1; len < 600; len++) {
        snprintf(line, sizeof line, "trace id 1 ip %0*d in policy drop",
                 (int)len, 1);
        r.count = 0;
        trace_read(&r, line);
        assert_int_equal(strlen(r.ways[0].table),
                         len < TRACE_NAME_BYTES ? len : TRACE_NAME_BYTES - 1u);
    }
}

static const char saved[] =
    "# Generated by iptables-save\n*raw\n:PREROUTING ACCEPT [70:900]\n"
    "[%u:144] -A PREROUTING -s 10.42.0.37/32 -j DROP\nCOMMIT\n"
    "*filter\n:INPUT DROP [%u:340]\n:FORWARD DROP [0:0]\n:inner - [0:0]\n"
    "[9:1] -A INPUT -p tcp -j ACCEPT\n[%u:1] -A inner -j REJECT\n"
    "[broken\n:\n[5] -j DROP\nCOMMIT\n";

static struct legacy_rules legacy(unsigned raw, unsigned policy, unsigned inner)
{
    char text[1024];
    struct legacy_rules out;
    snprintf(text, sizeof text, saved, raw, policy, inner);
    FILE *f = open_text(text);
    legacy_read(f, &out);
    fclose(f);
    return out;
}

static void old_rules_are_known_by_what_they_count(void **state)
{
    const struct legacy_rules before = legacy(3, 12, 0);
    const struct legacy_rules by_rule = legacy(9, 12, 0);
    const struct legacy_rules by_policy = legacy(4, 17, 0);
    const struct legacy_rules busy = legacy(3, 900, 6);
    (void)state;
    assert_int_equal(before.count, 4);
    assert_null(legacy_grown(&before, &before, 1));
    const struct legacy_rule *rule = legacy_grown(&before, &by_rule, 5);
    assert_non_null(rule);
    assert_string_equal(rule->table, "raw");
    assert_string_equal(rule->chain, "PREROUTING");
    assert_string_equal(rule->text, "-A PREROUTING -s 10.42.0.37/32 -j DROP");
    assert_null(legacy_grown(&before, &by_rule, 7));
    rule = legacy_grown(&before, &by_policy, 5);
    assert_non_null(rule);
    assert_string_equal(rule->table, "filter");
    assert_string_equal(rule->chain, "INPUT");
    assert_string_equal(rule->text, "");
    /* what others lose there hides nothing */
    rule = legacy_grown(&before, &busy, 5);
    assert_non_null(rule);
    assert_string_equal(rule->chain, "inner");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arp_tells_complete_incomplete_and_unknown),
        cmocka_unit_test(udp_sockets_of_the_port_are_found_with_user_and_inode),
        cmocka_unit_test(udp6_counts_where_it_can_take_ipv4),
        cmocka_unit_test(old_rules_are_known_by_what_they_count),
        cmocka_unit_test(a_trace_names_the_rule_that_drops),
        cmocka_unit_test(a_trace_of_what_passes_names_none),
        cmocka_unit_test(a_trace_tells_policies_ways_and_ufw),
        cmocka_unit_test(a_rule_whose_text_says_drop_need_not_drop),
        cmocka_unit_test(damaged_lines_are_survived),
        cmocka_unit_test(a_name_as_long_as_they_come_is_cut),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
