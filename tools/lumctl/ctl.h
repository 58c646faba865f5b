/* What all commands of lumctl share: the options, the session, requests, and
 * how a command ends. */
#ifndef LUMCTL_CTL_H
#define LUMCTL_CTL_H

#include "../common/json.h"
#include "../common/set_keys.h"
#include "memory.h"

#include "lum/base/error.h"
#include "lum/calibration.h"
#include "lum/live/laser_session.h"
#include "lum/net/sensor.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum exit_status {
    EXIT_DONE = 0,
    EXIT_FAILED = 1,    /* I/O, network, the sensor did not do it */
    EXIT_BAD = 2,       /* arguments or configuration */
    EXIT_NO_ANSWER = 3, /* the sensor is silent */
    EXIT_HAZARD = 4     /* the sensor reports a hazard */
};

/* What ends a command that goes on. */
enum ctl_until {
    UNTIL_NOTHING,
    UNTIL_HAZARD,
    UNTIL_UP,
    UNTIL_DOWN
};

/* How a request is sent, and how long an answer may take. */
struct request_options {
    uint32_t timeout_ms; /* of one try */
    uint32_t retries;
    bool has_retries; /* by --retries */
    bool has_sequence;
    uint32_t sequence; /* of the first */
};

/* How a command goes on, and where its lines go: status, time, heartbeat,
 * wait. */
struct repeat_options {
    bool watch;
    double every_s;    /* 0: not given, as the next three */
    double duration_s; /* 0: without end */
    unsigned until;    /* of enum ctl_until */
    const char *csv;
    const char *prometheus;
};

/* What a session does that owns the sensor: heartbeat, shell, sweep. */
struct owner_options {
    bool heartbeat;
    double rate_hz; /* 0: not given */
    bool laser;
};

struct sweep_options {
    const char *output; /* NULL: not given */
    bool goes_on;
};

struct yscan_options {
    const char *shape; /* NULL: not given */
    uint32_t lines;    /* 0: not given */
};

/* Options, as they stand for one command. */
struct ctl_options {
    lum_endpoint host;
    bool has_host;           /* by --host */
    const char *interface;   /* NULL: as the routes say */
    const char *profile;     /* NULL: the default */
    const char *calibration; /* NULL: the default */
    struct set_keys set;     /* on top of both */
    struct request_options requests;
    bool dry_run; /* print the packet, send nothing */
    bool json;
    bool quiet;
    /* Of single commands; the table in commands.c says which may have which. */
    struct repeat_options repeat;
    struct owner_options owner;
    struct sweep_options sweep;
    struct yscan_options yscan;
    bool force;         /* set-ip */
    const char *subnet; /* find; NULL: not given */
    bool wants_help;
    bool wants_version;
    bool no_names; /* hosts only by their addresses: no waiting */
};

struct ctl {
    struct ctl_options options;
    lum_layout layout;
    lum_cancel *cancel;       /* raised by signals; never NULL */
    lum_sensor *sensor;       /* NULL until ctl_open() */
    lum_laser_session *laser; /* of that session */
    bool owns;        /* the session sends heartbeats and gets the data */
    bool in_shell;    /* a prompt follows; the session stays open */
    size_t shell_set; /* settings by key that the shell was given */
    bool is_lasting;  /* a signal is the command's usual end */
    bool has_status;  /* a status has been seen */
    uint16_t status;  /* the last one */
    bool was_up;      /* the laser, in the session before; not seen since */
    uint16_t refused; /* with what the laser session just refused laser on */
    lum_news trouble; /* the first news by which data is no longer what was
                         asked for; kind 0: none */
    const lum_calibration *calibration; /* read before; NULL: it is not */
    bool has_packets; /* of a dry run, in JSON: the array is open */
    struct json packets;
    struct memory changes;     /* of settings, by this command */
    struct memory_table table; /* what a table was made from, if it is sent */
};

/* A command: words[0] is its name. Complains on standard error. */
typedef enum exit_status (*ctl_command)(struct ctl *ctl, int count,
                                        char **words);

/* Runs a command line, argv[0] the program: options and words in any order,
 * also as typed in a shell. Its options apply only to this command. */
enum exit_status ctl_run(struct ctl *ctl, int argc, char **argv);

/* Opens the session where there is none. Complains. A command that needs to own
 * the sensor (heartbeats, data) says so. */
enum exit_status ctl_open(struct ctl *ctl, bool owns);

/* The answer to a request. */
struct ctl_answer {
    bool has_status;
    uint16_t status;
    char debug[2048];  /* debug texts, a line each; NUL-terminated */
    char others[2048]; /* TLVs of other types, TYPE:HEX, a line each */
    unsigned tries;
    int64_t round_trip_ns; /* 0: not known, since it was sent more than once */
};

/* Sends TLVs (len 0: a status poll) and waits for the answer; prints status
 * changes and debug texts that come unasked. With --dry-run prints the packet
 * and returns EXIT_DONE with *was_sent false. EXIT_NO_ANSWER when none came
 * (complains, and says what to do), EXIT_FAILED on a network failure or a
 * signal. */
enum exit_status ctl_request(struct ctl *ctl, const void *tlvs, size_t len,
                             struct ctl_answer *out, bool *was_sent);

/* As ctl_request() for a checked text of commands, of which tlvs is the
 * encoding. */
enum exit_status ctl_request_text(struct ctl *ctl, const char *text,
                                  const void *tlvs, size_t len,
                                  struct ctl_answer *out, bool *was_sent);

/* A command TLV with a text such as "50p u", checked before; then as
 * ctl_request(), and EXIT_FAILED when the answer's debug texts refuse
 * something, or the answer does not show the laser as u or d in the text wants
 * it (EXIT_HAZARD where a hazard keeps it down). Prints the outcome for people
 * or as JSON, which has the text itself; messages use the words that the user
 * typed, for example "power 60" for 60p. */
enum exit_status ctl_command_words(struct ctl *ctl, const char *text,
                                   const char *typed);

/* Prints a packet as one line of hex, or adds it to the JSON object of a dry
 * run, which ctl_end_packets() closes. */
enum exit_status ctl_print_packet(struct ctl *ctl, const void *bytes,
                                  size_t len);
void ctl_end_packets(struct ctl *ctl);

/* complain.c. Complaints: "lumctl: ..." and a newline on standard error.
 * Returns status. */
LUM_PRINTF(2, 3)
enum exit_status ctl_complain(enum exit_status status, const char *format, ...);

/* From now on complaints and notes that have to wait for a reader are left
 * out. */
void ctl_complain_hurry(bool is);

/* Notes on standard error, unless --quiet. */
LUM_PRINTF(2, 3)
void ctl_note(const struct ctl *ctl, const char *format, ...);

/* One for each command; similar commands share a file. */
enum exit_status command_heartbeat(struct ctl *ctl, int count, char **words);
enum exit_status command_status(struct ctl *ctl, int count, char **words);
enum exit_status command_time(struct ctl *ctl, int count, char **words);
enum exit_status command_set_ip(struct ctl *ctl, int count, char **words);
enum exit_status command_laser(struct ctl *ctl, int count, char **words);
enum exit_status command_parameter(struct ctl *ctl, int count, char **words);
enum exit_status command_yscan(struct ctl *ctl, int count, char **words);
enum exit_status command_send(struct ctl *ctl, int count, char **words);
enum exit_status command_tlv(struct ctl *ctl, int count, char **words);
enum exit_status command_apply(struct ctl *ctl, int count, char **words);
enum exit_status command_find(struct ctl *ctl, int count, char **words);
enum exit_status command_show(struct ctl *ctl, int count, char **words);
enum exit_status command_save(struct ctl *ctl, int count, char **words);
enum exit_status command_shell(struct ctl *ctl, int count, char **words);
enum exit_status command_doctor(struct ctl *ctl, int count, char **words);
enum exit_status command_wait(struct ctl *ctl, int count, char **words);
enum exit_status command_sweep(struct ctl *ctl, int count, char **words);

/* The commands' names: the i-th, NULL after the last. */
const char *ctl_command_name(size_t i);

#endif
