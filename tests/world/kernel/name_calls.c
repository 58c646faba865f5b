#define _GNU_SOURCE
#include "net_internal.h"
#include "socket_calls.h"
#include "task.h"
#include "time.h"
#include "trace.h"

#include <arpa/inet.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CALL_NS WORLD_US
#define FILE_NS (100 * WORLD_US) /* to read /etc/hosts */

typedef struct name_entry {
    struct name_entry *next;
    char name[64];
    uint32_t address;
} name_entry;

static struct {
    name_entry *names;
    int64_t delay_ns;
    bool fails;
} server;

void world_net_name(const char *name, uint32_t address)
{
    name_entry *entry = calloc(1, sizeof *entry);
    if (entry == NULL) {
        abort();
    }
    (void)snprintf(entry->name, sizeof entry->name, "%s", name);
    entry->address = address;
    entry->next = server.names;
    server.names = entry;
}

void world_net_name_server(int64_t delay_ns, bool fails)
{
    server.delay_ns = delay_ns;
    server.fails = fails;
}

void world_names_reset(void)
{
    while (server.names != NULL) {
        name_entry *next = server.names->next;
        free(server.names);
        server.names = next;
    }
    memset(&server, 0, sizeof server);
}

/* --- looking up --- */

static uint32_t first_address(const world_host *host)
{
    for (const world_interface *i = world_interface_first(host); i != NULL;
         i = i->next) {
        if (!world_interface_is_loopback(i) && i->address_count > 0) {
            return i->addresses[0].address;
        }
    }
    return 0;
}

/* 0, or a code of getaddrinfo(). */
static int answer_of(uint32_t address, uint32_t *out)
{
    *out = address;
    return address != 0 ? 0 : EAI_NODATA;
}

static int ask_server(const char *name, uint32_t *out)
{
    if (server.delay_ns > 0) {
        world_queue nothing = {NULL, NULL};
        world_met("net:slow-names");
        world_wait_deaf(&nothing, world_now() + server.delay_ns);
    }
    if (server.fails) {
        world_met("net:no-names");
        return EAI_AGAIN;
    }
    for (const name_entry *e = server.names; e != NULL; e = e->next) {
        if (strcmp(e->name, name) == 0) {
            return answer_of(e->address, out);
        }
    }
    for (const world_host *h = world_host_first(); h != NULL; h = h->next) {
        if (strcmp(h->name, name) == 0) {
            return answer_of(first_address(h), out);
        }
    }
    return EAI_NONAME;
}

/* inet_aton() reads "10.1" and "0x0a000001" too, as getaddrinfo() does. */
static int look_up(const char *node, int flags, uint32_t *out)
{
    struct in_addr numeric;
    if (node == NULL) {
        *out = (flags & AI_PASSIVE) != 0 ? 0 : WORLD_LOOPBACK;
        return 0;
    }
    if (inet_aton(node, &numeric) != 0) {
        *out = ntohl(numeric.s_addr);
        return 0;
    }
    if ((flags & AI_NUMERICHOST) != 0) {
        return EAI_NONAME;
    }
    world_spend(FILE_NS);
    if (strcmp(node, "localhost") == 0) {
        *out = WORLD_LOOPBACK;
        return 0;
    }
    return ask_server(node, out);
}

static int read_service(const char *service, uint16_t *out)
{
    char *end = NULL;
    *out = 0;
    if (service == NULL) {
        return 0;
    }
    const unsigned long port = strtoul(service, &end, 10);
    if (*service == '\0' || *end != '\0' || port > UINT16_MAX) {
        return EAI_SERVICE;
    }
    *out = (uint16_t)port;
    return 0;
}

typedef struct found {
    struct addrinfo info;
    struct sockaddr_in address;
} found;

int world_call_getaddrinfo(const char *node, const char *service,
                           const struct addrinfo *hints, struct addrinfo **out)
{
    world_call(CALL_NS);
    static const struct addrinfo none = {.ai_family = AF_UNSPEC};
    const struct addrinfo *asked = hints != NULL ? hints : &none;
    uint32_t address = 0;
    uint16_t port = 0;
    if (asked->ai_family != AF_UNSPEC && asked->ai_family != AF_INET) {
        return EAI_FAMILY;
    }
    int code = read_service(service, &port);
    if (code == 0) {
        code = look_up(node, asked->ai_flags, &address);
    }
    if (code != 0) {
        return code;
    }
    found *block = world_calloc(1, sizeof *block);
    if (block == NULL) {
        return EAI_MEMORY;
    }
    block->address.sin_family = AF_INET;
    block->address.sin_port = htons(port);
    block->address.sin_addr.s_addr = htonl(address);
    block->info.ai_family = AF_INET;
    block->info.ai_socktype =
        asked->ai_socktype != 0 ? asked->ai_socktype : SOCK_DGRAM;
    block->info.ai_addrlen = sizeof block->address;
    block->info.ai_addr = (struct sockaddr *)&block->address;
    *out = &block->info;
    return 0;
}

void world_call_freeaddrinfo(struct addrinfo *list)
{
    world_free(list);
}
