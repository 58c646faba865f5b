/* Sensors whose address is not known: which addresses to ask, asking them, and
 * the results. Only requests for a time stamp and ARP requests are sent. */
#ifndef LUMCTL_FIND_H
#define LUMCTL_FIND_H

#include "../common/arp.h"
#include "../common/interfaces.h"
#include "ctl.h"

#define FIND_BITS_MIN       22u /* of the widest subnet that is asked */
#define FIND_RANGES_MAX     64u
#define FIND_SOCKETS_MAX    32u /* as many as one wait can have */
#define FIND_FOUND_MAX      1024u
#define FIND_BESIDES_MAX    16u
#define FIND_LEFT_OUT_MAX   32u
#define FIND_LEFT_OUT_BYTES 448u

/* A subnet as it was given or as an interface has it. */
struct find_subnet {
    uint32_t network;
    unsigned bits;
};

/* Addresses that are asked in one way. */
struct find_range {
    const struct host_interface *interface; /* NULL: as the routes say */
    struct find_subnet subnet;
    uint32_t first;
    uint32_t last;
    bool by_arp;     /* the interface has no address in that subnet */
    bool is_askable; /* has a socket, or the right to ARP */
};

bool find_is_in(const struct find_range *range, uint32_t address);

/* What was not searched, and why; a sentence each. */
struct find_left_out {
    char texts[FIND_LEFT_OUT_MAX + 1u][FIND_LEFT_OUT_BYTES];
    size_t count;
    size_t more; /* that had no room */
};

struct find_plan {
    struct host_interface *interfaces; /* free() them */
    size_t interface_count;
    struct find_range ranges[FIND_RANGES_MAX];
    size_t range_count;
    struct find_left_out left_out;
};

/* Room for one more sentence, of FIND_LEFT_OUT_BYTES. */
char *find_leave_out(struct find_left_out *out);

/* Adds a name to a list such as "eth0, eth1"; one that is full ends with dots.
 */
#define FIND_NAMES_BYTES 128u
void find_add_name(char names[FIND_NAMES_BYTES], const char *name);

/* "10.42.0.0/24", its host bits cleared. False: it is none. */
bool find_parse_subnet(const char *text, struct find_subnet *out);

/* "10.42.0.0/24" */
struct find_subnet_text {
    char text[20];
};
struct find_subnet_text find_show_subnet(const struct find_subnet *subnet);

/* Whether an address is asked already by a range before this one, as when two
 * interfaces are in one subnet. */
bool find_is_repeated(const struct find_plan *plan, size_t range,
                      uint32_t address);

/* Fills ranges and left_out from the interfaces.
 * name    the one to search; NULL: every one that is up, except the loopback.
 * subnet  the one to search; NULL: those of the interfaces; of one larger than
 *         FIND_BITS_MIN, the part around the own address. */
void find_make_plan(struct find_plan *plan, const char *name,
                    const struct find_subnet *subnet);

/* How somebody made himself known; the later the surer. */
enum find_how {
    FIND_ARP,     /* has an address; may be no sensor */
    FIND_OTHER,   /* sends our magic, but no packet that a sensor sends */
    FIND_SENDS,   /* sends a sensor's packets to somebody */
    FIND_ANSWERS, /* answers */
    FIND_HOWS
};

struct find_found {
    enum find_how how;
    lum_endpoint host;
    const struct host_interface *interface; /* NULL: not known */
    char mac[INTERFACE_MAC_TEXT_BYTES];     /* empty: not known */
    bool is_mac_of_sensor; /* packets of a sensor came from it */
    char other_mac[INTERFACE_MAC_TEXT_BYTES]; /* empty; else two devices have
                                                 one address */
    uint32_t clock_us;                        /* FIND_ANSWERS */
    int64_t round_trip_ns;
};

/* A /24 in which this host has no address, and wants one to reach somebody. */
struct find_subnet_beside {
    const struct host_interface *interface;
    uint32_t network;
    uint32_t taken; /* bit n: address n answers, up to BESIDE_LAST */
    bool is_asked;  /* all of them were asked by ARP */
};

struct find_result {
    struct find_found found[FIND_FOUND_MAX];
    size_t count;
    bool is_full; /* others were seen, and did not fit */
    struct find_subnet_beside besides[FIND_BESIDES_MAX];
    size_t beside_count;
    unsigned asked;     /* addresses, each counted once */
    unsigned wanted;    /* addresses that were to be asked */
    unsigned questions; /* of the first time that all are asked */
    unsigned unsent;    /* of those, that did not leave */
    lum_error error;    /* of the first of them */
    bool is_cut_short;  /* by a signal */
};

/* Asks and listens. EXIT_DONE; otherwise an error of the socket, which is
 * printed. */
enum exit_status find_ask(struct ctl *ctl, struct find_plan *plan,
                          struct find_result *out);

/* The entry of somebody; where he is not known a new one, as by FIND_ARP. NULL:
 * the table is full. One address on two interfaces is two findings. */
struct find_found *find_entry(struct find_result *result, lum_endpoint host,
                              const struct host_interface *interface);

/* Notes a MAC that has a finding's address. The MAC of a sensor's packets comes
 * first. */
void find_note_mac(struct find_found *found, const char *mac, bool is_sensor);

/* Whether this host has to take an address of its subnet to reach a finding. */
bool find_needs_address(const struct find_plan *plan,
                        const struct find_found *found);

/* Fills besides with the subnets in which this host needs an address; nobody is
 * asked yet. */
void find_plan_besides(const struct find_plan *plan,
                       struct find_result *result);

/* Sets the address's bit, if it is one that could be proposed in a /24. */
void find_note_taken(uint32_t *taken, uint32_t network, uint32_t address);

/* The command that lets the host reach a finding; empty if it already does, if
 * --interface distinguishes it from another one, or if no address is known to
 * be free. */
struct find_reach {
    char text[INTERFACE_NAME_BYTES + 64u];
};
struct find_reach find_reach(const struct find_plan *plan,
                             struct find_result *result,
                             const struct find_found *found);

/* Sorts, prints for people or as JSON. */
void find_print(const struct ctl *ctl, const struct find_plan *plan,
                struct find_result *result);

#endif
