/* Which program has the sensor's port on this Linux host. */
#define _POSIX_C_SOURCE 200809L

#include "doctor.h"

#include "../../common/number.h"
#include "doctor_facts.h"
#include "net/program.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define USERS_MAX 16u
#define ALL_MAX   64u

#define LOOKS 4

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

static size_t read_all_users(uint16_t port, struct udp_user *out, size_t room)
{
    const size_t n = read_users("/proc/net/udp", port, out, room);
    return n + read_users("/proc/net/udp6", port, out + n, room - n);
}

/* A socket that no program has any more has the inode 0. */
static bool has_user(const struct udp_user *list, size_t n,
                     const struct udp_user *user)
{
    for (size_t i = 0; i < n; i++) {
        if (list[i].inode == user->inode && list[i].port == user->port &&
            list[i].address == user->address) {
            return true;
        }
    }
    return false;
}

/* The kernel gives its tables by parts, and leaves out lines between two parts
 * when sockets are closed meanwhile. What any of some looks finds is taken. */
static size_t find_users(uint16_t port, struct udp_user *out, size_t room)
{
    struct udp_user found[ALL_MAX];
    size_t n = 0;
    for (int look = 0; look < LOOKS; look++) {
        const size_t now = read_all_users(port, found, ALL_MAX);
        for (size_t i = 0; i < now && n < room; i++) {
            if (!has_user(out, n, &found[i])) {
                out[n++] = found[i];
            }
        }
    }
    return n;
}

static lum_endpoint endpoint_of(const struct udp_user *user)
{
    return (lum_endpoint){user->address, user->port};
}

struct who {
    char text[96];
};

/* "lumsim (process 12)" */
static struct who name_user(const struct udp_user *user)
{
    struct who who;
    const long process = lum_program_of_port(endpoint_of(user));
    if (process > 0) {
        (void)snprintf(who.text, sizeof who.text, "%s",
                       lum_program_show(process).text);
    } else {
        (void)snprintf(who.text, sizeof who.text,
                       "a program of user %" PRIu32 ", which root could name,",
                       user->uid);
    }
    return who;
}

static struct number_address name_address(const struct udp_user *user)
{
    const struct number_address any = {"any address"};
    return user->address == 0 ? any : number_address(user->address);
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

/* A simulator of this host, at whatever address and port. */
static bool find_simulator(struct udp_user *out)
{
    struct udp_user all[ALL_MAX];
    const size_t n = find_users(0, all, ALL_MAX);
    for (size_t i = 0; i < n; i++) {
        if (strncmp(name_user(&all[i]).text, "lumsim (", strlen("lumsim (")) ==
            0) {
            *out = all[i];
            return true;
        }
    }
    return false;
}

bool doctor_fix_simulator(struct doctor_finding *out, const char *otherwise)
{
    struct udp_user user;
    if (!find_simulator(&user)) {
        return false;
    }
    doctor_fix(out, "lumctl --host %s doctor    # lumsim is there%s%s",
               doctor_place(endpoint_of(&user)).text,
               otherwise[0] != '\0' ? "; for another sensor: " : "", otherwise);
    return true;
}

/* Another program listens, but not where the sensor should be. */
static void say_elsewhere(const struct doctor *d, const struct udp_user *user,
                          struct doctor_finding *out)
{
    doctor_wrong(out, "nothing listens at %s:%u, but %s does at %s:%u",
                 d->address, (unsigned)d->sensor.port, name_user(user).text,
                 name_address(user).text, (unsigned)user->port);
    doctor_fix(out, "lumctl --host %s doctor",
               doctor_place(endpoint_of(user)).text);
}

/* Packets to an address of this host never leave it. */
static void say_own_address(const struct doctor *d, struct doctor_finding *out)
{
    doctor_wrong(out,
                 "%s is this host's own address (%s), and no simulator has "
                 "its port %u: what is sent to the sensor does not leave",
                 d->address, strstr(d->host.own, "dev "),
                 (unsigned)d->sensor.port);
    doctor_fix(out, "sudo ip addr del %s", d->host.own);
}

/* The sensor should be a program of this host. */
static void look_at_own(struct doctor *d, const struct udp_user *users,
                        size_t n, struct doctor_finding *out)
{
    struct udp_user simulator;
    const struct udp_user *user = find_sensor(d, users, n);
    if (user != NULL) {
        doctor_fine(out, "%s has port %u of %s", name_user(user).text,
                    (unsigned)d->sensor.port, name_address(user).text);
        return;
    }
    d->is_silent = true;
    doctor_lack(d, DOCTOR_NEEDS_NEIGHBOUR, "nothing listens there");
    if (d->host.own[0] != '\0') {
        say_own_address(d, out);
    } else if (find_simulator(&simulator)) {
        say_elsewhere(d, &simulator, out);
    } else if (n > 0) {
        say_elsewhere(d, &users[0], out);
    } else {
        doctor_wrong(out,
                     "%s is on this host, and nothing listens on its port %u",
                     d->address, (unsigned)d->sensor.port);
        doctor_fix(out, "lumsim --address %s &", doctor_place(d->sensor).text);
    }
}

static void note_user(const struct udp_user *user, struct doctor_finding *out)
{
    doctor_note(out,
                "%s has port %u of %s on this host: a simulator? lumctl "
                "and lumdump do not need that port, other programs may",
                name_user(user).text, (unsigned)user->port,
                name_address(user).text);
}

static void note_simulator(const struct udp_user *user,
                           struct doctor_finding *out)
{
    doctor_note(out,
                "%s listens at %s:%u of this host: harmless, unless it is the "
                "sensor that you mean",
                name_user(user).text, name_address(user).text,
                (unsigned)user->port);
    doctor_fix(out, "lumctl --host %s doctor",
               doctor_place(endpoint_of(user)).text);
}

void doctor_check_port(struct doctor *d, struct doctor_finding *out)
{
    struct udp_user users[USERS_MAX];
    struct udp_user simulator;
    const size_t n = find_users(d->sensor.port, users, USERS_MAX);
    if (d->is_local) {
        look_at_own(d, users, n, out);
    } else if (find_simulator(&simulator)) {
        note_simulator(&simulator, out);
    } else if (n > 0) {
        note_user(&users[0], out);
    } else {
        doctor_fine(out, "port %u of this host is free",
                    (unsigned)d->sensor.port);
    }
}
