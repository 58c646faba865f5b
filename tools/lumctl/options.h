/* The options of lumctl, at any place of a line. */
#ifndef LUMCTL_OPTIONS_H
#define LUMCTL_OPTIONS_H

#include "ctl.h"

/* Options that only some commands have. */
enum own_option {
    OWN_WATCH = 1,
    OWN_HEARTBEAT = 2,
    OWN_RATE = 4,
    OWN_DURATION = 8,
    OWN_SHAPE = 16,
    OWN_LINES = 32,
    OWN_SESSION = 64, /* what a session is opened with: none inside a shell */
    OWN_FORCE = 128,
    OWN_SUBNET = 256,
    OWN_CALIBRATION = 1024,
    OWN_PROFILE = 2048, /* as OWN_SESSION, and no dry run in a shell has it */
    OWN_FOR = 4096,
    OWN_LASER = 8192,
    OWN_EVERY = 16384,
    OWN_UNTIL = 32768,
    OWN_CSV = 65536,
    OWN_PROMETHEUS = 131072,
    OWN_OUTPUT = 262144,
    OWN_CONTINUE = 524288
};

/* What a line held beside what went to the options. */
struct options_found {
    int count;    /* words that are left, from argv[1] on */
    unsigned own; /* the own_options given */
};

/* Takes the options out of a line; argv[0] is the program. A word such as -1 or
 * -.5 is a value. Complains, and names what helps, such as "lumctl --help". */
enum exit_status options_parse(struct ctl_options *options, const char *help,
                               int argc, char **argv,
                               struct options_found *out);

/* An option's name for a person ("--watch"), of one of the own_options. */
const char *options_name(unsigned own);

/* The part of --help about options: those of every command without these two
 * (NULL: with all), and these. */
void options_help(bool general, unsigned own, const char *const lacks[2]);

/* Host and port, as --host has them. */
bool options_parse_host(const char *text, lum_endpoint *out, lum_error *why);

/* Whether a host may be given in this form. A name is refused, with the reason,
 * if nothing may wait for a resolver: heartbeats would stop during that time.
 */
bool options_allow_host(const struct ctl_options *options, const char *text,
                        lum_error *why);

#endif
