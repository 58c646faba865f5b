#include "doctor_facts.h"

#include "../../common/number.h"

#include <stdlib.h>
#include <string.h>

#define LINE_BYTES  512u
#define FIELDS_MAX  16u
#define ARP_IS_DONE 0x02u /* ATF_COM of the flags */

/* Splits at blanks, in place. */
static size_t split(char *line, char *out[FIELDS_MAX])
{
    size_t n = 0;
    char *p = line;
    while (n < FIELDS_MAX) {
        p += strspn(p, " \t\r\n");
        if (*p == '\0') {
            break;
        }
        out[n] = p;
        n++;
        p += strcspn(p, " \t\r\n");
        if (*p != '\0') {
            *p = '\0';
            p++;
        }
    }
    return n;
}

static bool parse_hex(const char *text, size_t digits, uint32_t *out)
{
    char copy[9] = "";
    char *end = NULL;
    if (digits > 8u || strspn(text, "0123456789abcdefABCDEF") < digits) {
        return false;
    }
    memcpy(copy, text, digits);
    *out = (uint32_t)strtoul(copy, &end, 16);
    return end == copy + digits;
}

/* IP address, HW type, flags, HW address, mask, device. */
enum arp_state facts_arp(FILE *in, uint32_t address, const char *device,
                         char mac[MAC_BYTES])
{
    char line[LINE_BYTES];
    char *f[FIELDS_MAX];
    while (fgets(line, sizeof line, in) != NULL) {
        uint32_t a = 0;
        if (split(line, f) < 6u || !number_parse_address(f[0], &a) ||
            a != address || strcmp(f[5], device) != 0) {
            continue;
        }
        if ((strtoul(f[2], NULL, 16) & ARP_IS_DONE) == 0) {
            return ARP_INCOMPLETE;
        }
        (void)snprintf(mac, MAC_BYTES, "%s", f[3]);
        return ARP_COMPLETE;
    }
    return ARP_UNKNOWN;
}

/* The bytes are in network order, and the kernel prints them as a number of
 * this host. */
static uint32_t from_network(uint32_t word)
{
    uint8_t b[4];
    memcpy(b, &word, sizeof b);
    return ((uint32_t)b[0] << 24) | ((uint32_t)b[1] << 16) |
           ((uint32_t)b[2] << 8) | b[3];
}

/* ADDRESS:PORT; also false for an IPv6 address that is neither any nor a mapped
 * IPv4. */
static bool parse_local(const char *text, uint32_t *address, uint32_t *port)
{
    const char *colon = strchr(text, ':');
    const size_t digits = colon == NULL ? 0 : (size_t)(colon - text);
    uint32_t words[4] = {0};
    if ((digits != 8u && digits != 32u) || !parse_hex(colon + 1, 4, port)) {
        return false;
    }
    for (size_t i = 0; i < digits / 8u; i++) {
        if (!parse_hex(text + 8u * i, 8, &words[i])) {
            return false;
        }
    }
    const bool is_mapped = from_network(words[2]) == 0xffffu;
    *address = from_network(digits == 8u ? words[0] : words[3]);
    return digits == 8u || (words[0] == 0 && words[1] == 0 &&
                            (is_mapped || (words[2] == 0 && words[3] == 0)));
}

/* sl, local, remote, st, queues, timer, retransmits, uid, timeout, inode. */
size_t facts_udp(FILE *in, uint16_t port, struct udp_user *out, size_t room)
{
    char line[LINE_BYTES];
    char *f[FIELDS_MAX];
    size_t n = 0;
    while (n < room && fgets(line, sizeof line, in) != NULL) {
        struct udp_user u = {0, 0, 0, 0};
        uint32_t p = 0;
        if (split(line, f) < 10u || !parse_local(f[1], &u.address, &p) ||
            (port != 0 && p != port)) {
            continue;
        }
        u.port = (uint16_t)p;
        u.uid = (uint32_t)strtoul(f[7], NULL, 10);
        u.inode = strtoull(f[9], NULL, 10);
        out[n] = u;
        n++;
    }
    return n;
}
