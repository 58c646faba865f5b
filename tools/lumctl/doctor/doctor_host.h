/* What the checks of a Linux host's side share. */
#ifndef LUMCTL_DOCTOR_HOST_H
#define LUMCTL_DOCTOR_HOST_H

#include "../../common/interfaces.h"
#include "doctor.h"

#include <stdbool.h>
#include <stddef.h>

/* An interface that is up and has the sensor in its subnet, and, where it was
 * looked at, whether somebody answers for the sensor's address there. */
struct candidate {
    const struct host_interface *interface;
    const struct interface_address *address;
    bool is_looked_at;
    bool is_sensor;     /* a sensor answers a request that goes out there */
    bool has_neighbour; /* somebody answers ARP there */
};

#define CANDIDATES_MAX 16u

bool host_is_asked_for(const struct doctor *d, const struct host_interface *i);

/* Those that --interface allows; returns how many. */
size_t host_candidates(const struct doctor *d,
                       struct candidate out[CANDIDATES_MAX]);

/* Looks whether somebody answers there, once. */
void host_look(struct doctor *d, struct candidate *c);

/* An address for this host beside the sensor's, that no other device has as far
 * as it may be asked on an interface (NULL: none); 0: each one is taken. One
 * that another device has would take that one off the network. */
uint32_t host_address_beside(struct doctor *d, const struct host_interface *w);

/* What there is to say and to do where it is 0. */
void host_say_full(const struct doctor *d, const struct host_interface *w,
                   struct doctor_finding *out);

/* The command by which the sensor is reached on that interface alone. */
void host_mend_interface(const struct doctor *d, const char *interface,
                         struct doctor_finding *out);

/* What is wrong stays a note where a sensor answers all the same: there is
 * nothing to mend. Returns whether it does. */
bool host_spare(struct doctor *d, struct doctor_finding *out);

#endif
