/* Who has the sensor's port on this Linux host. */
#define _POSIX_C_SOURCE 200809L

#include "doctor.h"

#include "../common/number.h"
#include "doctor_facts.h"
#include "net/program.h"

#include <inttypes.h>
#include <stdio.h>

#define USERS_MAX 16u
#define WHO_BYTES 96u

static size_t read_users(const char *path, uint16_t port, struct udp_user *out,
                         size_t room)
{
    FILE *f = fopen(path, "re");
    if (f == NULL) {
        return 0;
    }
    const size_t n = facts_udp(f, port, out, room);
    (void)fclose(f);
    return n;
}

static size_t find_users(uint16_t port, struct udp_user out[USERS_MAX])
{
    const size_t n = read_users("/proc/net/udp", port, out, USERS_MAX);
    return n + read_users("/proc/net/udp6", port, out + n, USERS_MAX - n);
}

/* "lumsim (process 12)", and its number; 0: only root could tell. */
static long name_user(const struct udp_user *user, uint16_t port,
                      char out[WHO_BYTES])
{
    const lum_endpoint local = {user->address, port};
    const long process = lum_program_of_port(local);
    if (process > 0) {
        (void)snprintf(out, WHO_BYTES, "%s", lum_program_show(process).text);
    } else {
        (void)snprintf(out, WHO_BYTES,
                       "a program of user %" PRIu32 ", which root could name,",
                       user->uid);
    }
    return process;
}

static const char *name_address(const struct udp_user *user, char out[16])
{
    return user->address == 0 ? "any address"
                              : number_format_address(user->address, out);
}

static const struct udp_user *find_sensor(const struct doctor *d,
                                          const struct udp_user *users,
                                          size_t n)
{
    for (size_t i = 0; i < n; i++) {
        if (users[i].address == 0 || users[i].address == d->sensor.address) {
            return &users[i];
        }
    }
    return NULL;
}

/* The sensor is to be a program of this host. */
static void look_at_own(struct doctor *d, const struct udp_user *users,
                        size_t n, struct doctor_finding *out)
{
    const unsigned port = d->sensor.port;
    char who[WHO_BYTES];
    char address[16];
    const struct udp_user *user = find_sensor(d, users, n);
    if (user != NULL) {
        (void)name_user(user, d->sensor.port, who);
        doctor_fine(out, "%s has port %u of %s", who, port,
                    name_address(user, address));
        return;
    }
    d->is_silent = true;
    doctor_lack(d, DOCTOR_NEEDS_NEIGHBOUR, "nothing listens there");
    if (n > 0) {
        (void)name_user(&users[0], d->sensor.port, who);
        doctor_wrong(out, "nothing listens at %s:%u, but %s does at %s",
                     d->address, port, who, name_address(&users[0], address));
        doctor_mend(out, "lumctl --host %s doctor",
                    name_address(&users[0], address));
    } else {
        doctor_wrong(out,
                     "%s is on this host, and nothing listens on its port %u",
                     d->address, port);
        doctor_mend(out, "lumsim --address %s &%s%s", d->address,
                    d->own[0] != '\0' ? "    # or, if the address is to be a "
                                        "sensor's: sudo ip addr del "
                                      : "",
                    d->own);
    }
}

void doctor_check_port(struct doctor *d, struct doctor_finding *out)
{
    struct udp_user users[USERS_MAX];
    char who[WHO_BYTES];
    char address[16];
    const unsigned port = d->sensor.port;
    const size_t n = find_users(d->sensor.port, users);
    if (d->is_local) {
        look_at_own(d, users, n, out);
    } else if (n == 0) {
        doctor_fine(out, "port %u of this host is free", port);
    } else {
        const long process = name_user(&users[0], d->sensor.port, who);
        doctor_note(out,
                    "%s has port %u of %s on this host: a simulator? lumctl "
                    "and lumdump do not need that port, other programs may",
                    who, port, name_address(&users[0], address));
        if (process > 0) {
            doctor_mend(out, "kill %ld    # if it is not needed", process);
        }
    }
}
