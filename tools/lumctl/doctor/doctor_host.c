/* What the checks of a Linux host share: advice that several give, an address
 * that is free, what the kernel tells of packets from the sensor. */
#include "doctor_host.h"

#include "../../common/number.h"
#include "../beside.h"
#include "doctor_knock.h"
#include "doctor_neighbour.h"

#include <string.h>

bool host_is_asked_for(const struct doctor *d, const struct host_interface *i)
{
    const char *only = d->ctl->options.interface;
    return only == NULL || strcmp(only, i->name) == 0;
}

bool host_spare(struct doctor *d, struct doctor_finding *out)
{
    session_keep_alive(d->ctl);
    if (!knock_reaches(d->sensor, d->ctl->options.interface)) {
        return false;
    }
    out->result = DOCTOR_NOTE;
    out->fix[0] = '\0';
    doctor_add(out, "; a sensor answers at %s all the same", d->address);
    return true;
}

void host_fix_interface(const struct doctor *d, const char *interface,
                        struct doctor_finding *out)
{
    char at[SESSION_CTL_BYTES];
    doctor_fix(out, "%s doctor    # --interface %s with every tool",
               lum_news_ctl(d->sensor, interface, at, sizeof at), interface);
}

/* --- An address for this host --- */

struct wish {
    struct doctor *d;
    const struct host_interface *on; /* NULL: none that can be asked */
};

static bool is_taken(void *context, uint32_t address)
{
    struct wish *w = context;
    struct arp_answers who = {0};
    if (interfaces_owner(w->d->host.all, w->d->host.count, address, NULL) !=
        NULL) {
        return true;
    }
    return w->on != NULL && neighbours_hear(w->d, w->on, address, &who) &&
           who.count > 0;
}

uint32_t host_address_beside(struct doctor *d, const struct host_interface *w)
{
    struct wish wish = {d, w != NULL && w->is_up && w->has_link ? w : NULL};
    return beside_find(d->sensor.address, is_taken, &wish);
}

void host_say_full(const struct doctor *d, const struct host_interface *w,
                   struct doctor_finding *out)
{
    const uint32_t subnet = d->sensor.address & BESIDE_MASK;
    doctor_add(out, "; every address from %s to %s is taken",
               number_address(subnet | 1u).text,
               number_address(subnet | BESIDE_LAST).text);
    doctor_fix(out,
               "sudo lumctl find --interface %s --subnet %s/24    # who has "
               "which; then give %s one that nobody has",
               w != NULL ? w->name : "INTERFACE", number_address(subnet).text,
               w != NULL ? w->name : "INTERFACE");
}

/* --- For checks on the wire --- */

void doctor_fix_watch(const struct doctor *d, struct doctor_finding *out,
                      const char *filter, const char *why)
{
    doctor_fix(out, "sudo tcpdump -ni %s '%s'    # %s",
               d->route.interface[0] != '\0' ? d->route.interface : "any",
               filter, why);
}

/* The kernel doubles the requested size, for its own overhead. */
size_t doctor_buffer_payload(size_t granted)
{
    return granted / 2u;
}

void doctor_fix_buffer(struct doctor_finding *out)
{
    doctor_fix(out, "sudo sysctl -w net.core.rmem_max=%u",
               LUM_SOCKET_RECEIVE_BUFFER);
}
