#define _GNU_SOURCE
#include "disk.h"
#include "net.h"
#include "net_internal.h"
#include "udp.h"

#include <arpa/inet.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A text that grows. */
typedef struct text {
    char *bytes;
    size_t len, room;
} text;

__attribute__((format(printf, 2, 3))) static void add(text *out,
                                                      const char *format, ...)
{
    va_list arguments;
    char line[256];
    va_start(arguments, format);
    const int n = vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    const size_t len = (size_t)n < sizeof line ? (size_t)n : sizeof line - 1u;
    if (out->len + len + 1u > out->room) {
        out->room = 2u * (out->len + len + 1u);
        out->bytes = realloc(out->bytes, out->room);
        if (out->bytes == NULL) {
            abort();
        }
    }
    memcpy(out->bytes + out->len, line, len);
    out->len += len;
    out->bytes[out->len] = '\0';
}

/* --- sockets --- */

static void add_socket(text *out, const struct world_udp *udp)
{
    add(out,
        "%5u: %08X:%04X %08X:%04X %02X %08X:%08X %02X:%08X %08X %5u %8d %llu "
        "%d %016x %u\n",
        udp->port % WORLD_PORT_LISTS, htonl(udp->address), udp->port,
        htonl(udp->peer), udp->peer_port, udp->is_connected ? 1u : 7u,
        udp->log->queued, udp->held, 0u, 0u, 0u, WORLD_UID, 0,
        (unsigned long long)udp->file->number, 2, 0u, udp->drops);
}

static char *udp_text(world_host *host)
{
    text out = {NULL, 0, 0};
    add(&out, "   sl  local_address rem_address   st tx_queue rx_queue tr "
              "tm->when retrnsmt   uid  timeout inode ref pointer drops\n");
    for (unsigned i = 0; i < WORLD_PORT_LISTS; i++) {
        for (const struct world_udp *u = world_udp_at_port(host, (uint16_t)i);
             u != NULL; u = u->next_of_port) {
            add_socket(&out, u);
        }
    }
    return out.bytes;
}

/* No host of the world has sockets of these. */
static char *udp6_text(world_host *host)
{
    text out = {NULL, 0, 0};
    (void)host;
    add(&out, "  sl  local_address                         remote_address     "
              "                   st tx_queue rx_queue tr tm->when retrnsmt   "
              "uid  timeout inode ref pointer drops\n");
    return out.bytes;
}

static char *tcp_text(world_host *host)
{
    text out = {NULL, 0, 0};
    (void)host;
    add(&out, "  sl  local_address rem_address   st tx_queue rx_queue tr "
              "tm->when retrnsmt   uid  timeout inode\n");
    return out.bytes;
}

/* --- neighbours --- */

typedef struct arp_context {
    text *out;
    const world_interface *at;
} arp_context;

static void add_neighbour(void *context, uint32_t address, const uint8_t *mac)
{
    static const uint8_t unknown[6];
    const arp_context *arp = context;
    const uint8_t *m = mac != NULL ? mac : unknown;
    char name[16];
    (void)snprintf(name, sizeof name, "%u.%u.%u.%u", address >> 24,
                   address >> 16 & 255u, address >> 8 & 255u, address & 255u);
    add(arp->out,
        "%-16s 0x1         0x%x         %02x:%02x:%02x:%02x:%02x:%02x     * "
        "       %s\n",
        name, mac != NULL ? 2u : 0u, m[0], m[1], m[2], m[3], m[4], m[5],
        arp->at->name);
}

static char *arp_text(world_host *host)
{
    text out = {NULL, 0, 0};
    arp_context context = {&out, NULL};
    add(&out, "IP address       HW type     Flags       HW address            "
              "Mask     Device\n");
    for (const world_interface *i = world_interface_first(host); i != NULL;
         i = i->next) {
        context.at = i;
        world_neighbours_list(i, add_neighbour, &context);
    }
    return out.bytes;
}

/* --- limits --- */

static char *zero_text(world_host *host)
{
    text out = {NULL, 0, 0};
    (void)host;
    add(&out, "0\n");
    return out.bytes;
}

static char *receive_max_text(world_host *host)
{
    text out = {NULL, 0, 0};
    add(&out, "%u\n", (unsigned)world_net_rights_of(host)->receive_max);
    return out.bytes;
}

static char *send_max_text(world_host *host)
{
    text out = {NULL, 0, 0};
    add(&out, "%u\n", (unsigned)world_net_rights_of(host)->send_max);
    return out.bytes;
}

/* --- all of them --- */

static const struct {
    const char *path;
    char *(*text)(world_host *host);
} files[] = {
    {"/proc/net/udp", udp_text},
    {"/proc/net/udp6", udp6_text},
    {"/proc/net/tcp", tcp_text},
    {"/proc/net/arp", arp_text},
    {"/proc/sys/net/core/rmem_max", receive_max_text},
    {"/proc/sys/net/core/wmem_max", send_max_text},
    {"/proc/sys/net/ipv4/conf/all/rp_filter", zero_text},
};

char *world_net_text(world_host *host, const char *path)
{
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        if (strcmp(files[i].path, path) == 0) {
            return files[i].text(host);
        }
    }
    return NULL;
}

void world_net_publish(world_host *host)
{
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++) {
        world_disk_put_text(world_disk_of(host), files[i].path, files[i].text);
    }
}

void world_net_publish_interface(const world_interface *interface)
{
    char path[80];
    (void)snprintf(path, sizeof path, "/proc/sys/net/ipv4/conf/%s/rp_filter",
                   interface->name);
    world_disk_put_text(world_disk_of(interface->host), path, zero_text);
}
