#define _POSIX_C_SOURCE 200809L

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "../../tools/lumctl/doctor/doctor_facts.h"

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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(arp_tells_complete_incomplete_and_unknown),
        cmocka_unit_test(udp_sockets_of_the_port_are_found_with_user_and_inode),
        cmocka_unit_test(udp6_counts_where_it_can_take_ipv4),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
