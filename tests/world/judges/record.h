/* What was seen of a run from outside, for judges: the logs of the devices,
 * each datagram and its fate, the tools with what their user asked for and what
 * they printed, and what befell network, disks and clocks. All times are true
 * ones of the world, in ns. A record owns copies of all that it holds. */
#ifndef WORLD_RECORD_H
#define WORLD_RECORD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define RECORD_NEVER INT64_MAX
#define RECORD_NONE  (-1)

#define RECORD_PORT 5517u /* docs/protocol.md, section 1 */

#define RECORD_US INT64_C(1000)
#define RECORD_MS INT64_C(1000000)
#define RECORD_S  INT64_C(1000000000)

typedef struct record_endpoint {
    uint32_t address;
    uint16_t port;
} record_endpoint;

bool record_is_same(record_endpoint a, record_endpoint b);

/* --- Devices --- */

typedef enum record_event {
    RECORD_START,
    RECORD_HEARTBEAT,
    RECORD_TIMESTAMP,
    RECORD_TLV,
    RECORD_SET_IP,
    RECORD_REPLY,
    RECORD_UNSENT,
    RECORD_STATUS,
    RECORD_LASER,
    RECORD_STREAM,
    RECORD_MOVE,
    RECORD_FAULT,
    RECORD_STOP,
    RECORD_OTHER
} record_event;

/* A line of a device's log (lumsim(1), LOG). */
typedef struct record_line {
    int64_t t_ns;
    record_event event;
    record_endpoint peer; /* from, to or address */
    uint32_t sequence;
    unsigned status; /* of RECORD_STATUS */
    bool is_yes;     /* the laser is up; a move is done; a fault ends; a reply
                        was lost */
    char *text;      /* a note, a fault's name, a reply's kind; never NULL */
} record_line;

typedef struct record_device {
    unsigned host;
    int64_t began_ns, ended_ns; /* of its power */
    record_line *lines;
    size_t count, room;
    size_t read; /* bytes of the log that became lines */
} record_device;

/* --- Tools --- */

typedef struct record_span {
    int64_t from_ns, to_ns;
    bool is_before_send; /* it stopped right before a call that sends: whatever
                            it looks at before that, it has looked at */
} record_span;

typedef struct record_signal {
    int64_t t_ns;
    int number;
} record_signal;

/* What the clocks of a host show at a moment. */
typedef struct record_clock {
    int64_t mono_ns, utc_ns;
    int64_t drift_ppb;
} record_clock;

/* A tool has printed: how much it is in all. */
typedef struct record_print {
    int64_t t_ns;
    size_t out, err;
    record_clock clock; /* of its host */
} record_print;

/* A line that its user typed. */
typedef struct record_typed {
    int64_t t_ns;
    char *text;
} record_typed;

#define RECORD_ARGUMENTS 48
#define RECORD_SPANS     32

typedef struct record_tool {
    long id; /* of its process */
    unsigned host;
    unsigned count;
    char *arguments[RECORD_ARGUMENTS]; /* the first is the program */
    record_typed *typed;
    size_t typed_count;
    record_print *prints; /* not of a sensor */
    size_t print_count, print_room;
    uint8_t *kept; /* what a recording read of its sensor: each a length of 4
                      bytes, and its bytes */
    size_t kept_count, kept_size, kept_room;
    bool is_too_much;           /* some were not kept */
    int64_t began_ns, ended_ns; /* RECORD_NEVER: it runs */
    int status;                 /* as of waitpid() */
    char *out, *err;            /* what it printed; may be NULL */
    unsigned signal_count;
    record_signal signals[RECORD_SPANS]; /* but for SIGSTOP and SIGCONT */
    unsigned stop_count;
    record_span stops[RECORD_SPANS]; /* by SIGSTOP */
    bool was_cut;     /* ended by kill -9 or with its host's power */
    bool has_stalled; /* what it writes to stood still, or was slow */
    bool is_wrong;    /* its user asked for what has to be refused */
    bool met_others;  /* it read what no device with a log had sent */
    uint32_t usual;   /* the sensor of its environment (LUM_HOST); 0: none */
} record_tool;

/* --- Datagrams --- */

typedef enum record_packet {
    RECORD_IS_HEARTBEAT,
    RECORD_IS_TLV,
    RECORD_IS_TIMESTAMP,
    RECORD_IS_SET_IP,
    RECORD_IS_DATA,
    RECORD_IS_FOREIGN
} record_packet;

typedef enum record_fate {
    RECORD_UNDER_WAY,
    RECORD_READ,    /* by a socket's program */
    RECORD_DROPPED, /* the receive buffer was full */
    RECORD_UNREAD,  /* the socket was closed before */
    RECORD_LOST     /* anywhere else */
} record_fate;

typedef struct record_datagram {
    uint64_t number;
    int64_t sent_ns;
    int64_t fate_ns;
    int sender, reader; /* indexes of tools, or RECORD_NONE; the reader is that
                           of the socket for READ, DROPPED and UNREAD */
    record_endpoint from, to;
    uint32_t len;
    uint64_t hash; /* record_hash() of its bytes as they arrived */
    uint32_t sequence;
    uint32_t clock_us; /* of a time stamp */
    record_packet packet;
    char command[24]; /* of a TLV packet with a command, its beginning */
    record_fate fate;
    unsigned fates;  /* how often it was told one; 1 at the end */
    bool is_damaged; /* its bytes are not those that were sent */
    bool is_copy;    /* the network repeated it */
} record_datagram;

/* A moment close to the reading of a sensor's clock: a request for it was read,
 * or the answer was sent. */
typedef struct record_stamp {
    uint64_t number; /* of the datagram */
    int64_t t_ns;
    record_clock asker;  /* of the host that asks */
    record_clock sensor; /* of the sensor's */
} record_stamp;

/* --- The whole --- */

typedef struct record_fault {
    char name[24]; /* as in coverage: "loss", "disk-full" */
    int64_t from_ns, to_ns;
} record_fault;

struct record {
    int64_t now_ns; /* until when it was looked */
    record_device *devices;
    size_t device_count;
    record_tool *tools;
    size_t tool_count;
    record_datagram *datagrams;
    size_t datagram_count, datagram_room;
    record_fault *faults;
    size_t fault_count;
    record_stamp *stamps; /* in the order of their moments */
    size_t stamp_count, stamp_room;
    const char *full; /* a table that had no room any more; NULL: none */
};

void record_free(struct record *record);

/* The index of the new one. */
size_t record_add_device(struct record *record, unsigned host, int64_t t_ns);
size_t record_add_tool(struct record *record, const char *const *arguments,
                       unsigned host, int64_t t_ns);
/* Valid until the next one is added. */
record_datagram *record_add_datagram(struct record *record);
size_t record_add_fault(struct record *record, const char *name,
                        int64_t from_ns, int64_t to_ns);

void record_signal_to(struct record *record, record_tool *tool, int64_t t_ns,
                      int number);
/* The stop that began at a moment is right before a call that sends. */
void record_stop_before_send(record_tool *tool, int64_t t_ns);

/* Each line of the text by itself. */
void record_type(record_tool *tool, int64_t t_ns, const char *text);
void record_add_print(record_tool *tool, record_print print);
/* What a recording read, as long as it is no more than 24 MB. */
void record_keep(record_tool *tool, const void *bytes, size_t len);
void record_add_stamp(struct record *record, record_stamp stamp);

/* Takes what is new of a device's log: whole lines alone. true_ns: tells the
 * true time of a moment of the device's host, by its monotonic clock. */
void record_read_log(struct record *record, size_t device, const char *bytes,
                     size_t size,
                     int64_t (*true_ns)(void *context, int64_t mono_ns),
                     void *context);

uint64_t record_hash(const void *bytes, size_t len);

/* Kind, sequence and command of a datagram's bytes. */
void record_look_at(record_datagram *out, const void *bytes, size_t len);

/* --- Questions --- */

/* Whether a word stands alone in a text, between spaces. */
bool record_has_word(const char *text, const char *word);
/* Whether a device's note says that it carried a command out: it stands alone
 * between "; ", where a refusal has more words. */
bool record_was_done(const record_line *line, const char *command);

/* The value of an option, as "--timeout 50" or "--timeout=50"; NULL: not
 * given. "" of one without a value. */
const char *record_option(const record_tool *tool, const char *name);
double record_number(const record_tool *tool, const char *name, double usual);
bool record_is_program(const record_tool *tool, const char *name);
/* Word n of a lumctl command, the command itself is 0; "" beyond the last. */
const char *record_word(const record_tool *tool, unsigned n);
/* "10.42.0.37", also where something follows it; 0: it is none. behind: what
 * follows, may be NULL. */
uint32_t record_address(const char *text, const char **behind);
/* The address that it talks to, 0: none. */
uint32_t record_host_of(const record_tool *tool);
/* The sensor's port. */
unsigned record_port_of(const record_tool *tool);
/* Whether it sends heartbeats when all is well. */
bool record_owns(const record_tool *tool);
/* Whether it asks again and again: --watch, --every. */
bool record_watches(const record_tool *tool);
/* By an owner on another host: the sensor sends its data to whom it heard last,
 * and nobody is told (docs/protocol.md, section 6). */
bool record_is_shared(const struct record *record, const record_tool *tool);

bool record_is_running(const record_tool *tool, int64_t t_ns);
/* How long it was stopped between two moments. */
int64_t record_stopped_ns(const record_tool *tool, int64_t from_ns,
                          int64_t to_ns);
/* The first signal that asks it to end; RECORD_NEVER: none came. */
int64_t record_asked_to_end(const record_tool *tool);
bool record_was_signalled(const record_tool *tool, int number);
int record_exit_status(const record_tool *tool); /* -1: by a signal, or runs */

/* The tool that sent from an endpoint, at or before a moment; NULL: none. */
const record_tool *record_sender(const struct record *record,
                                 record_endpoint from, int64_t t_ns);
/* No fault touches the time. name: of one fault alone; NULL: of any. */
bool record_is_calm(const struct record *record, const char *name,
                    int64_t from_ns, int64_t to_ns);
/* No datagram whose bytes are not those that were sent was read in the time. */
bool record_is_undamaged(const struct record *record, int64_t from_ns,
                         int64_t to_ns);

/* The device with an address at a moment; NULL: none. */
const record_device *record_device_at(const struct record *record,
                                      uint32_t address, int64_t t_ns);
/* Whether there is one all the time that answers at once, with no mishap of its
 * own until the end of it. */
bool record_answers(const struct record *record, uint32_t address,
                    int64_t from_ns, int64_t to_ns);
/* The state just behind a moment. */
bool record_laser_is_up(const record_device *device, int64_t t_ns);
unsigned record_status_at(const record_device *device, int64_t t_ns);
/* Whether it was, at any moment of a span, both ends included. */
bool record_laser_was(const record_device *device, bool is_up, int64_t from_ns,
                      int64_t to_ns);

/* A whole number behind "key": in JSON text, from a place on; false: none. */
bool record_json_number(const char *text, const char *key, uint64_t *out);
bool record_json_bool(const char *text, const char *key, bool *out);

#endif
