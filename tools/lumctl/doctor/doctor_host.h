/* What the checks of a Linux host's side share. */
#ifndef LUMCTL_DOCTOR_HOST_H
#define LUMCTL_DOCTOR_HOST_H

#include "../../common/interfaces.h"
#include "doctor.h"

#include <stdbool.h>
#include <stddef.h>

/* An interface that is up and has the sensor in its subnet, and, if this was
 * checked, whether a device answers for the sensor's address there. */
struct candidate {
    const struct host_interface *interface;
    const struct interface_address *address;
    bool is_sensor;     /* a sensor answers a request that goes out there */
    bool has_neighbour; /* a device answers ARP there */
};

#define CANDIDATES_MAX 16u

/* Whether --interface allows it. */
bool host_is_asked_for(const struct doctor *d, const struct host_interface *i);

/* Those that --interface allows; returns how many (doctor_candidate.c, as all
 * up to host_near()). */
size_t host_candidates(const struct doctor *d,
                       struct candidate out[CANDIDATES_MAX]);

/* The best of them: where a sensor answers, then any device, then by the
 * kernel's route. Asks only where there are several. */
struct candidate *host_choose(struct doctor *d, struct candidate *all,
                              size_t n);

/* Where a device answers for the sensor, if that can be heard; else a guess;
 * NULL: none is allowed. */
const struct host_interface *host_likeliest(struct doctor *d);

/* Where else than on the requested interface the sensor answers; NULL: nowhere,
 * or none was requested. */
const struct host_interface *host_elsewhere(struct doctor *d);

/* An address of an interface beside the sensor's; NULL: none. */
const struct interface_address *host_near(const struct doctor *d,
                                          const struct host_interface *w);

/* Whether a device answers for the sensor on the chosen interface
 * (doctor_interface.c). */
bool host_answers(struct doctor *d);

/* An address for this host in the sensor's subnet that no other device has, if
 * this can be asked on an interface (NULL: none); 0: all are in use. With the
 * address of another device, this host would cut that device off the
 * network. */
uint32_t host_address_beside(struct doctor *d, const struct host_interface *w);

/* The message and the advice if it is 0. */
void host_say_full(const struct doctor *d, const struct host_interface *w,
                   struct doctor_finding *out);

/* The command that reaches the sensor only by that interface. */
void host_fix_interface(const struct doctor *d, const char *interface,
                        struct doctor_finding *out);

/* If a sensor answers in spite of a fault, the fault is only a note: there is
 * nothing to fix. Returns whether a sensor answers. */
bool host_spare(struct doctor *d, struct doctor_finding *out);

#endif
