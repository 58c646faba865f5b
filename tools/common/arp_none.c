/* No ARP, on systems without raw sockets for it. */
#include "arp.h"

enum arp_opened arp_open(const struct host_interface *interface,
                         struct arp **out, lum_error *error)
{
    (void)out;
    (void)lum_error_set(error, "%s: no raw ARP on this system",
                        interface->name);
    return ARP_NO_WAY;
}

int arp_ask(struct arp *arp, uint32_t address, lum_error *error)
{
    (void)arp;
    (void)address;
    return lum_error_set(error, "no raw ARP on this system");
}

bool arp_receive(struct arp *arp, int64_t deadline_ns, struct arp_speaker *out)
{
    (void)arp;
    (void)deadline_ns;
    (void)out;
    return false;
}

int arp_descriptor(const struct arp *arp)
{
    (void)arp;
    return -1;
}

void arp_close(struct arp *arp)
{
    (void)arp;
}
