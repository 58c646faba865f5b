#include "net/winsock.h"

#include "net/adapter.h"
#include "net/route.h"

#include <iphlpapi.h>
#include <stdio.h>

bool lum_route_interface(uint32_t address, char *out, size_t room)
{
    DWORD index = 0;
    lum_adapter adapter;
    if (GetBestInterface(htonl(address), &index) != NO_ERROR ||
        !lum_adapter_at(index, &adapter)) {
        return false;
    }
    (void)snprintf(out, room, "%s", adapter.name);
    return true;
}
