/* Network interfaces of Windows, by their names. */
#include "net/winsock.h"

#include "base/text.h"
#include "net/adapter.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Enough for some dozens of interfaces; the call says if it is not. */
#define FIRST_BYTES 16384u

IP_ADAPTER_ADDRESSES *lum_adapter_all(unsigned long *code)
{
    const ULONG flags = GAA_FLAG_SKIP_ANYCAST | GAA_FLAG_SKIP_MULTICAST |
                        GAA_FLAG_SKIP_DNS_SERVER;
    ULONG bytes = FIRST_BYTES;
    for (int tries = 0; tries < 3; tries++) {
        IP_ADAPTER_ADDRESSES *all = malloc(bytes);
        *code = all == NULL
                    ? ERROR_NOT_ENOUGH_MEMORY
                    : GetAdaptersAddresses(AF_INET, flags, NULL, all, &bytes);
        if (*code == NO_ERROR) {
            return all;
        }
        free(all);
        if (*code != ERROR_BUFFER_OVERFLOW) {
            break;
        }
    }
    return NULL;
}

void lum_adapter_name(const IP_ADAPTER_ADDRESSES *entry,
                      char out[LUM_ADAPTER_NAME_BYTES])
{
    if (WideCharToMultiByte(CP_ACP, 0, entry->FriendlyName, -1, out,
                            LUM_ADAPTER_NAME_BYTES, NULL, NULL) == 0) {
        (void)snprintf(out, LUM_ADAPTER_NAME_BYTES, "%lu", entry->IfIndex);
    }
}

static uint32_t address_of(const IP_ADAPTER_ADDRESSES *entry, uint32_t wanted)
{
    uint32_t found = 0;
    for (const IP_ADAPTER_UNICAST_ADDRESS *i = entry->FirstUnicastAddress;
         i != NULL; i = i->Next) {
        struct sockaddr_in address;
        if (i->Address.lpSockaddr->sa_family != AF_INET) {
            continue;
        }
        memcpy(&address, i->Address.lpSockaddr, sizeof address);
        const uint32_t theirs = ntohl(address.sin_addr.s_addr);
        if (found == 0 || theirs == wanted) {
            found = theirs;
        }
    }
    return found;
}

static lum_adapter describe(const IP_ADAPTER_ADDRESSES *entry, uint32_t wanted)
{
    lum_adapter out = {.index = entry->IfIndex,
                       .address = address_of(entry, wanted)};
    lum_adapter_name(entry, out.name);
    return out;
}

/* By name, or by index if name is NULL. */
static bool find(const char *name, unsigned long index, uint32_t wanted,
                 lum_adapter *out)
{
    unsigned long code = 0;
    IP_ADAPTER_ADDRESSES *all = lum_adapter_all(&code);
    bool found = false;
    for (const IP_ADAPTER_ADDRESSES *i = all; i != NULL && !found;
         i = i->Next) {
        const lum_adapter here = describe(i, wanted);
        found =
            name != NULL ? strcmp(here.name, name) == 0 : here.index == index;
        if (found) {
            *out = here;
        }
    }
    free(all);
    return found;
}

bool lum_adapter_find(const char *name, uint32_t wanted, lum_adapter *out)
{
    return find(name, 0, wanted, out);
}

bool lum_adapter_at(unsigned long index, lum_adapter *out)
{
    return find(NULL, index, 0, out);
}

void lum_adapter_list(char *out, size_t room)
{
    unsigned long code = 0;
    IP_ADAPTER_ADDRESSES *all = lum_adapter_all(&code);
    *out = '\0';
    for (const IP_ADAPTER_ADDRESSES *i = all; i != NULL; i = i->Next) {
        lum_text_list(out, room, ", ", describe(i, 0).name);
    }
    free(all);
}
