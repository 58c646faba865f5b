/* Who answers ARP for one address: asked again and again, since each question
 * and each answer could be lost. */
#ifndef LUM_TOOLS_ARP_ANSWERS_H
#define LUM_TOOLS_ARP_ANSWERS_H

#include "interfaces.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define ARP_ANSWERS_MAX 4u

struct arp_answers {
    bool is_heard; /* from the wire, just now: every device that answers is
                      among them. Otherwise from the kernel's table, where a
                      device may have gone */
    size_t count;  /* different ones */
    char macs[ARP_ANSWERS_MAX][INTERFACE_MAC_TEXT_BYTES];
};

struct arp_patience {
    int64_t wait_ns;              /* for the first answer */
    int64_t again_ns;             /* between questions */
    int64_t more_ns;              /* after the first answer */
    bool (*goes_on)(void *owner); /* called at least at each question and each
                                     answer; false ends the wait */
    void *owner;
};

/* Adds one, unless it is among them. */
void arp_answers_add(struct arp_answers *all, const char *mac);

/* Hears them on an interface. False: this program may not, or the interface has
 * no ARP; out has none then. */
bool arp_answers_hear(const struct host_interface *on, uint32_t address,
                      const struct arp_patience *patience,
                      struct arp_answers *out);

#endif
