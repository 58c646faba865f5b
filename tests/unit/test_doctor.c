#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../tools/lumctl/doctor_facts.h"
#include "../../tools/lumctl/doctor_rules.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SENSOR 0x0a2a0025u
#define CLIENT 0x0a2a0001u

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

/* What rules do to the sensor's answer, or to what goes to it. */
struct judged {
    enum rule_fate fate;
    char base[RULE_NAME_BYTES];
    char chain[RULE_NAME_BYTES];
    char rule[RULE_TEXT_BYTES];
};

static struct judged judge(const char *text, bool is_nft, bool is_out)
{
    struct rule_packet packet = {false, SENSOR, CLIENT, 5517, 0, "eth0"};
    struct judged out = {RULE_PASSES, "", "", ""};
    struct rule_finding found;
    FILE *f = open_text(text);
    if (is_out) {
        packet = (struct rule_packet){true, CLIENT, SENSOR, 0, 5517, "eth0"};
    }
    struct ruleset *set = rules_new(&packet, is_nft);
    assert_non_null(set);
    (is_nft ? rules_read_nft : rules_read_iptables)(set, f);
    fclose(f);
    rules_judge(set, &found);
    out.fate = found.fate;
    if (found.base != NULL) {
        snprintf(out.base, sizeof out.base, "%s", found.base->name);
    }
    if (found.rule != NULL) {
        snprintf(out.chain, sizeof out.chain, "%s",
                 set->chains[found.rule->chain].name);
        snprintf(out.rule, sizeof out.rule, "%s", found.rule->text);
    }
    free(set);
    return out;
}

/* A chain of input with a policy and rules, as nft prints it. */
static enum rule_fate nft(const char *policy, const char *rules)
{
    char text[2048];
    snprintf(text, sizeof text,
             "table inet filter {\n"
             "\tset bad {\n\t\ttype ipv4_addr\n"
             "\t\telements = { 1.2.3.4,\n\t\t\t     1.2.3.5 }\n\t}\n\n"
             "\tchain input {\n"
             "\t\ttype filter hook input priority filter; policy %s;\n"
             "%s\n\t}\n}\n",
             policy, rules);
    return judge(text, true, false).fate;
}

static void no_rules_let_all_pass(void **state)
{
    (void)state;
    assert_int_equal(judge("", true, false).fate, RULE_PASSES);
    assert_int_equal(judge("", false, true).fate, RULE_PASSES);
    assert_int_equal(nft("accept", ""), RULE_PASSES);
}

static void a_policy_that_drops_drops_what_no_rule_accepts(void **state)
{
    (void)state;
    assert_int_equal(nft("drop", ""), RULE_IS_DROPPED);
    assert_int_equal(nft("drop", "tcp dport 22 accept"), RULE_IS_DROPPED);
    assert_int_equal(nft("drop", "iif \"lo\" accept"), RULE_IS_DROPPED);
    assert_int_equal(nft("drop", "ip6 saddr fe80::/10 accept"),
                     RULE_IS_DROPPED);
    assert_int_equal(nft("drop", "ct state invalid,new accept"),
                     RULE_IS_DROPPED);
}

static void each_match_that_holds_accepts(void **state)
{
    static const char *const rules[] = {
        "accept",
        "ct state established,related accept",
        "ct state { established, related } counter packets 5 bytes 7 accept",
        "ct state vmap { invalid : drop, established : accept }",
        "ct state != invalid accept",
        "ct state ! invalid,new accept",
        "ip saddr 10.42.0.37 accept",
        "ip saddr 10.42.0.0/24 udp sport 5517 accept",
        "ip saddr { 1.2.3.4, 10.42.0.30-10.42.0.40 } accept",
        "ip saddr != 10.43.0.0/16 accept",
        "ip daddr 10.42.0.1 accept",
        "udp sport { 53, 5000-6000 } accept",
        "udp dport 1024-65535 accept",
        "meta l4proto { tcp, udp } th sport 5517 accept",
        "ip protocol udp accept",
        "iifname \"eth*\" accept comment \"drop nothing\"",
        "iifname vmap { \"lo\" : drop, \"eth0\" : accept }",
        "meta nfproto ipv4 log prefix \"drop: \" level info accept",
    };
    (void)state;
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++) {
        if (nft("drop", rules[i]) != RULE_PASSES) {
            fail_msg("%s", rules[i]);
        }
    }
}

static void each_rule_that_holds_drops(void **state)
{
    static const char *const rules[] = {
        "drop",
        "reject with icmp port-unreachable",
        "udp sport 5517 counter packets 0 bytes 0 drop",
        "meta l4proto udp drop",
        "iifname != \"lo\" drop",
        "ct state vmap { established : drop, new : accept }",
        "ip saddr 10.0.0.0/8 ip daddr 10.42.0.1 reject",
    };
    (void)state;
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++) {
        if (nft("accept", rules[i]) != RULE_IS_DROPPED) {
            fail_msg("%s", rules[i]);
        }
    }
}

static void each_rule_of_others_is_passed_by(void **state)
{
    static const char *const rules[] = {
        "tcp dport 5517 drop",
        "icmp type echo-request drop",
        "ip saddr 10.42.0.38 drop",
        "udp sport != 5517 drop",
        "udp sport { 53, 5518-6000 } drop",
        "oifname \"eth0\" drop",
        "iifname \"eth1\" drop",
        "ct state invalid drop",
        "meta nfproto ipv6 drop",
        "meta pkttype { broadcast, multicast } drop",
    };
    (void)state;
    for (size_t i = 0; i < sizeof rules / sizeof rules[0]; i++) {
        if (nft("accept", rules[i]) != RULE_PASSES) {
            fail_msg("%s", rules[i]);
        }
    }
}

static void what_is_not_understood_is_only_a_doubt(void **state)
{
    (void)state;
    assert_int_equal(nft("accept", "limit rate over 5/second burst 5 packets "
                                   "drop"),
                     RULE_MAY_BE_DROPPED);
    assert_int_equal(nft("accept", "ip saddr @bad drop"), RULE_MAY_BE_DROPPED);
    assert_int_equal(nft("accept", "udp dport 5000-6000 drop"),
                     RULE_MAY_BE_DROPPED);
    assert_int_equal(nft("drop", "fib daddr type local accept"),
                     RULE_MAY_BE_DROPPED);
    assert_int_equal(nft("accept", "limit rate 5/second accept\n\t\tudp sport "
                                   "5517 drop"),
                     RULE_MAY_BE_DROPPED);
    assert_int_equal(nft("drop", "queue num 1"), RULE_MAY_BE_DROPPED);
    assert_int_equal(nft("drop", "mark vmap { 0x1 : accept }"),
                     RULE_MAY_BE_DROPPED);
    assert_int_equal(nft("drop", "limit rate 5/second jump nowhere"),
                     RULE_MAY_BE_DROPPED);
}

static void the_first_verdict_holds(void **state)
{
    (void)state;
    assert_int_equal(nft("drop", "udp sport 5517 accept\n\t\tudp sport 5517 "
                                 "drop"),
                     RULE_PASSES);
    assert_int_equal(nft("accept", "udp sport 5517 drop\n\t\tudp sport 5517 "
                                   "accept"),
                     RULE_IS_DROPPED);
}

static const char jumps[] =
    "table ip guard {\n"
    "\tchain in {\n"
    "\t\ttype filter hook prerouting priority raw; policy accept;\n"
    "\t\ttcp dport 22 jump strict\n"
    "\t\tip saddr 10.42.0.0/16 jump mild\n"
    "\t\tip saddr 10.42.0.0/16 jump strict\n"
    "\t}\n\n"
    "\tchain mild {\n\t\tip saddr 10.42.0.37 return\n\t\tdrop\n\t}\n\n"
    "\tchain strict {\n\t\tudp sport 5517 drop\n\t}\n"
    "}\n"
    "table ip6 other {\n\tchain in {\n"
    "\t\ttype filter hook input priority 0; policy drop;\n\t}\n}\n"
    "table ip nat {\n\tchain out {\n"
    "\t\ttype nat hook output priority 0; policy drop;\n\t}\n}\n";

static void jumps_are_followed_and_returns_come_back(void **state)
{
    const struct judged j = judge(jumps, true, false);
    (void)state;
    assert_int_equal(j.fate, RULE_IS_DROPPED);
    assert_string_equal(j.base, "in");
    assert_string_equal(j.chain, "strict");
    assert_string_equal(j.rule, "udp sport 5517 drop");
    assert_int_equal(judge(jumps, true, true).fate, RULE_PASSES);
}

static void a_chain_that_jumps_to_itself_ends(void **state)
{
    (void)state;
    assert_int_equal(judge("table ip t {\n\tchain a {\n\t\ttype filter hook "
                           "input priority 0; policy drop;\n\t\tjump a\n\t\t"
                           "jump a\n\t}\n}\n",
                           true, false)
                         .fate,
                     RULE_MAY_BE_DROPPED);
}

static void what_leaves_is_judged_by_other_hooks(void **state)
{
    static const char text[] =
        "table inet f {\n\tchain o {\n"
        "\t\ttype filter hook output priority 0; policy accept;\n"
        "\t\tct state established accept\n"
        "\t\tip daddr 10.42.0.37 udp dport 5517 reject\n\t}\n}\n";
    (void)state;
    assert_int_equal(judge(text, true, false).fate, RULE_PASSES);
    assert_int_equal(judge(text, true, true).fate, RULE_IS_DROPPED);
}

static void ingress_of_another_device_is_not_met(void **state)
{
    static const char format[] =
        "table netdev f {\n\tchain i {\n\t\ttype filter hook ingress device "
        "\"%s\" priority 0; policy drop;\n\t}\n}\n";
    char text[256];
    (void)state;
    snprintf(text, sizeof text, format, "eth0");
    assert_int_equal(judge(text, true, false).fate, RULE_IS_DROPPED);
    snprintf(text, sizeof text, format, "eth1");
    assert_int_equal(judge(text, true, false).fate, RULE_PASSES);
}

/* As iptables-save prints it. */
static enum rule_fate tables(const char *policy, const char *rules)
{
    char text[2048];
    snprintf(text, sizeof text,
             "# Generated by iptables-save\n"
             "*nat\n:PREROUTING DROP [0:0]\n-A PREROUTING -j DROP\nCOMMIT\n"
             "*filter\n:INPUT %s [0:0]\n:FORWARD DROP [0:0]\n"
             ":OUTPUT ACCEPT [0:0]\n:inner - [0:0]\n%s\nCOMMIT\n",
             policy, rules);
    return judge(text, false, false).fate;
}

static void rules_of_iptables_are_read_too(void **state)
{
    (void)state;
    assert_int_equal(tables("ACCEPT", ""), RULE_PASSES);
    assert_int_equal(tables("DROP", ""), RULE_IS_DROPPED);
    assert_int_equal(tables("DROP", "-A INPUT -i lo -j ACCEPT"),
                     RULE_IS_DROPPED);
    assert_int_equal(tables("DROP", "-A INPUT -m conntrack --ctstate "
                                    "RELATED,ESTABLISHED -j ACCEPT"),
                     RULE_PASSES);
    assert_int_equal(tables("DROP", "-A INPUT -m conntrack ! --ctstate "
                                    "INVALID,NEW -j ACCEPT"),
                     RULE_PASSES);
    assert_int_equal(tables("ACCEPT",
                            "-A INPUT -s 10.42.0.0/24 -p udp -m udp --sport "
                            "5517 -m comment --comment \"a \\\"b\\\" -j "
                            "ACCEPT\" -j REJECT --reject-with "
                            "icmp-port-unreachable"),
                     RULE_IS_DROPPED);
    assert_int_equal(tables("ACCEPT", "-A INPUT ! -s 10.42.0.0/24 -j DROP"),
                     RULE_PASSES);
    assert_int_equal(tables("ACCEPT", "-A INPUT -s 10.42.0.0/255.255.255.0 -j "
                                      "DROP"),
                     RULE_IS_DROPPED);
    assert_int_equal(tables("ACCEPT", "-A INPUT -p udp -m multiport --sports "
                                      "1,5000:6000 -j inner\n"
                                      "-A inner -i eth+ -j DROP"),
                     RULE_IS_DROPPED);
    assert_int_equal(tables("ACCEPT", "-A INPUT -p tcp -j DROP"), RULE_PASSES);
    assert_int_equal(tables("ACCEPT", "-A INPUT -m limit --limit 3/min -j "
                                      "DROP"),
                     RULE_MAY_BE_DROPPED);
    assert_int_equal(tables("DROP", "-A INPUT -j NFQUEUE --queue-num 0"),
                     RULE_MAY_BE_DROPPED);
    assert_int_equal(tables("DROP", "-A INPUT -p udp -g inner\n"
                                    "-A INPUT -j ACCEPT\n"
                                    "-A inner -p tcp -j ACCEPT"),
                     RULE_IS_DROPPED);
}

/* Whatever is read, it ends and stays inside. */
static void damaged_text_is_survived(void **state)
{
    char text[sizeof jumps];
    uint32_t seed = 1;
    (void)state;
    for (unsigned round = 0; round < 2000; round++) {
        memcpy(text, jumps, sizeof text);
        for (unsigned i = 0; i < 6; i++) {
            seed = seed * 1664525u + 1013904223u;
            text[(seed >> 8) % (sizeof text - 1u)] =
                "{}\"\n ,;:!@x"[(seed >> 4) % 11u];
        }
        (void)judge(text, round % 4u != 0, round % 2u != 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arp_tells_complete_incomplete_and_unknown),
        cmocka_unit_test(udp_sockets_of_the_port_are_found_with_user_and_inode),
        cmocka_unit_test(udp6_counts_where_it_can_take_ipv4),
        cmocka_unit_test(no_rules_let_all_pass),
        cmocka_unit_test(a_policy_that_drops_drops_what_no_rule_accepts),
        cmocka_unit_test(each_match_that_holds_accepts),
        cmocka_unit_test(each_rule_that_holds_drops),
        cmocka_unit_test(each_rule_of_others_is_passed_by),
        cmocka_unit_test(what_is_not_understood_is_only_a_doubt),
        cmocka_unit_test(the_first_verdict_holds),
        cmocka_unit_test(jumps_are_followed_and_returns_come_back),
        cmocka_unit_test(a_chain_that_jumps_to_itself_ends),
        cmocka_unit_test(what_leaves_is_judged_by_other_hooks),
        cmocka_unit_test(ingress_of_another_device_is_not_met),
        cmocka_unit_test(rules_of_iptables_are_read_too),
        cmocka_unit_test(damaged_text_is_survived),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
