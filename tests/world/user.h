/* What a story says: the user at a bench, who starts tools, looks at what they
 * print, sends signals, pulls cables, and expects.
 *
 * A story is a function that runs as the user of a world of its own:
 *
 *     STORY(off_at_half_loss, "laser off succeeds though half of all is lost")
 *     {
 *         user_bench b = user_bench_new();
 *         user_sensor *s = user_sensor_start(b.sensor, "--rate 0.5");
 *         user_fault(b.eth0, (user_faults){.lose = 0.5});
 *         user_tool *on = user_run(b.host, "lumctl send u --retries 30");
 *         user_expect_status(on, 0);
 *         user_tool *off = user_run(b.host, "lumctl laser off");
 *         user_expect_status(off, 0);
 *         user_expect(!user_laser_is_on(s));
 *     }
 *
 * It is told again under each seed, so it may not rely on an order that it did
 * not wait for. user_until(CONDITION) waits for what can be seen, whenever it
 * comes; what is not seen within the limit of the story fails it. An
 * expectation that does not hold ends the story at once. What is returned is
 * freed with the world. */
#ifndef WORLD_USER_H
#define WORLD_USER_H

#include "kernel/disk.h"
#include "kernel/host.h"
#include "kernel/net.h"
#include "kernel/pipe.h"
#include "kernel/process.h"
#include "kernel/terminal.h"
#include "kernel/time.h"

#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* --- Stories --- */

typedef struct user_story {
    const char *name, *fact, *file;
    int line;
    void (*tell)(void);
} user_story;

/* A story enters the table by itself. */
#define STORY(NAME, FACT)                                                      \
    static void NAME(void);                                                    \
    static const user_story story_of_##NAME = {#NAME, FACT, __FILE__,          \
                                               __LINE__, NAME};                \
    __attribute__((section("world_stories"),                                   \
                   used)) static const user_story *const entry_of_##NAME =     \
        &story_of_##NAME;                                                      \
    static void NAME(void)

/* Those of the table, in the order of the linker; NULL behind the last. */
const user_story *user_story_at(size_t i);
const user_story *user_story_find(const char *name);

/* What a telling came to. */
typedef struct user_result {
    char failure[1024]; /* "": none */
    int64_t lasted_ns;  /* simulated */
    uint64_t calls;     /* of processes to their system */
    uint64_t digest;
} user_result;

/* Tells a story in a new world, with the judges if they are built in; the world
 * is gone afterwards. */
user_result user_tell(const user_story *story, uint64_t seed);

/* Called in each new world before its story, and at its end before it is gone:
 * for judges. NULL: nothing. */
extern void (*user_begins)(void);
extern void (*user_ends)(void);

struct user_tool;
struct user_text;
/* What else judges are told of, NULL: nothing: that a tool has printed more,
 * what its user types, and which rule the story leaves. */
extern void (*user_prints)(const struct user_text *text);
extern void (*user_types)(const struct user_tool *tool, const char *text);
extern void (*user_leaves)(const char *rule, const char *why);

/* The story breaks a rule of the judges (docs/internals/testing.md), and may:
 * it says why. A story that leaves a rule and keeps it has failed. */
void user_leave(const char *rule, const char *why);

/* The log (world_traces) names what datagrams are, and leaves out those with
 * data that arrived, unless all are asked for. */
void user_trace_datagrams(bool all);

/* Simulated seconds (600 if not said) and calls of processes (20 million) after
 * which the story has failed. Said at its beginning. */
void user_limit(int64_t seconds, uint64_t calls);

/* --- Waiting and expecting --- */

/* Evaluates the condition anew whenever something happened, until it holds. */
#define user_until(...)                                                        \
    while (!(__VA_ARGS__))                                                     \
    user_wait_for_more(USER_HERE, #__VA_ARGS__)

/* Simulated time passes. For what must not happen meanwhile: what must happen
 * is waited for. */
void user_pause_ms(int64_t ms);
/* As long as the seed says, so that what follows meets each moment once. */
void user_pause_between_ms(int64_t least, int64_t most);
/* A number of the seed, both bounds included. */
int64_t user_any(int64_t least, int64_t most);

#define user_expect(...)                                                       \
    ((__VA_ARGS__) ? (void)0 : user_fail(USER_HERE, "%s", #__VA_ARGS__))
#define user_expect_equal(LEFT, RIGHT)                                         \
    user_check_equal(USER_HERE, #LEFT, (int64_t)(LEFT), (int64_t)(RIGHT))
#define user_expect_at_least(LEFT, RIGHT)                                      \
    user_check_order(USER_HERE, #LEFT, (int64_t)(LEFT), (int64_t)(RIGHT), true)
#define user_expect_at_most(LEFT, RIGHT)                                       \
    user_check_order(USER_HERE, #LEFT, (int64_t)(LEFT), (int64_t)(RIGHT), false)
/* Texts. */
#define user_expect_has(TEXT, PART) user_check_has(USER_HERE, TEXT, PART, true)
#define user_expect_lacks(TEXT, PART)                                          \
    user_check_has(USER_HERE, TEXT, PART, false)
#define user_expect_same(LEFT, RIGHT) user_check_same(USER_HERE, LEFT, RIGHT)
/* An extended regular expression finds something. */
#define user_expect_like(TEXT, PATTERN)                                        \
    user_check_like(USER_HERE, TEXT, PATTERN)

/* Where a story says something. */
typedef struct user_place {
    const char *file;
    int line;
} user_place;
#define USER_HERE ((user_place){__FILE__, __LINE__})

__attribute__((noreturn, format(printf, 2, 3))) void user_fail(
    user_place at, const char *format, ...);
void user_wait_for_more(user_place at, const char *what);
void user_check_equal(user_place at, const char *what, int64_t left,
                      int64_t right);
void user_check_order(user_place at, const char *what, int64_t left,
                      int64_t right, bool at_least);
void user_check_has(user_place at, const char *text, const char *part,
                    bool expected);
void user_check_same(user_place at, const char *left, const char *right);
void user_check_like(user_place at, const char *text, const char *pattern);

/* As printf, to a text. */
__attribute__((format(printf, 1, 2))) const char *user_format(
    const char *format, ...);
bool user_has(const char *text, const char *part);
bool user_like(const char *text, const char *pattern);
/* How often a part is in a text; lines are counted by "\n". */
size_t user_count(const char *text, const char *part);

/* --- The bench --- */

/* A computer "bench", 10.42.0.1/24, and that of a sensor, which has the address
 * that its sensor has (10.42.0.37 at first), and the wire between them; each
 * has eth0 there, and the loopback. Use net.h for all that is not here. */
typedef struct user_bench {
    world_host *host, *sensor;
    world_interface *eth0; /* of the bench; its faults are those of the wire */
    world_segment *wire;
} user_bench;
user_bench user_bench_new(void);

/* A computer with no interface but the loopback. */
world_host *user_host_new(const char *name);
/* An interface at a wire, up, with an address as "10.42.0.50/24"; /24 if it is
 * not said. */
world_interface *user_interface(world_host *host, const char *name,
                                world_segment *wire, const char *address);
/* A computer for a sensor: it has the address that its program binds. */
world_host *user_sensor_host(const char *name, world_segment *wire,
                             const char *address);
/* The address that a host got first: "10.42.0.37". */
const char *user_address_of(const world_host *host);
/* "10.42.0.1" as a number; fails the story if it is none. */
uint32_t user_ip(const char *address);

/* What a wire does to datagrams: probabilities of each, 0 to 1. */
typedef struct user_faults {
    double lose, repeat, corrupt;
    double reorder;    /* is held back, so that later ones overtake it */
    double reorder_ms; /* for up to so long; 0: 1 ms */
    double delay_ms, jitter_ms;
} user_faults;
/* Both directions at an interface, in place of earlier ones; {0}: a good wire.
 */
void user_fault(world_interface *interface, user_faults faults);
void user_fault_out(world_interface *interface, user_faults faults);
void user_fault_in(world_interface *interface, user_faults faults);
/* The cable is pulled, or put back. */
void user_cable(world_interface *interface, bool is_in);

/* --- Tools --- */

#define USER_SIGNALS 32

/* A started tool, and all that it printed. */
typedef struct user_tool {
    struct user_tool *next; /* in the order of their start */
    world_process *process;
    const char *command; /* as it was said */
    struct user_text *out, *err;
    unsigned signal_count;
    struct user_sent {
        int64_t t_ns;
        int number;
    } signals[USER_SIGNALS]; /* that the user sent; more are not noted */
} user_tool;
user_tool *user_tool_first(void);

/* Starts a tool: its name and arguments as for a shell, with '...' around what
 * has blanks. What it prints is kept; it has /dev/null as input. */
__attribute__((format(printf, 2, 3))) user_tool *user_start(world_host *host,
                                                            const char *format,
                                                            ...);

/* Types into the other end of its input. */
void user_type(const user_tool *tool, world_writer *keys, const char *text);
void user_type_at(const user_tool *tool, world_terminal *terminal,
                  const char *text);

/* Starts it, and waits for its end. */
__attribute__((format(printf, 2, 3))) user_tool *user_run(world_host *host,
                                                          const char *format,
                                                          ...);

/* How else it may be started. What is 0 or NULL is as user_start() does it. */
typedef struct user_with {
    world_file *input, *output,
        *error;                     /* ends of pipes, or files: a use each */
    world_terminal *terminal;       /* in place of what is not said otherwise */
    bool is_background;             /* not in the foreground of its terminal */
    bool ignores_int;               /* as `tool &` in a script */
    int ignores;                    /* a further signal; 0: none */
    const char *const *environment; /* "NAME=value", NULL behind the last */
    const char *directory;
} user_with;
__attribute__((format(printf, 3, 4))) user_tool *user_start_with(
    world_host *host, user_with with, const char *format, ...);

/* What it printed so far. */
const char *user_out(const user_tool *tool);
const char *user_err(const user_tool *tool);
size_t user_size_out(
    const user_tool *tool); /* where there may be zeros in it */
bool user_ended(const user_tool *tool);
/* Waits for its end; its exit status, or minus the signal that ended it. */
int user_wait(user_tool *tool);
/* A signal, and that wait. */
int user_end(user_tool *tool, int number);
void user_signal(user_tool *tool, int number);
/* Waits for the end too. */
#define user_expect_status(TOOL, STATUS)                                       \
    user_check_status(USER_HERE, TOOL, STATUS)
#define user_expect_end(TOOL, NUMBER, STATUS)                                  \
    (user_signal(TOOL, NUMBER), user_check_status(USER_HERE, TOOL, STATUS))
void user_check_status(user_place at, user_tool *tool, int status);

/* Something happens right before the n-th call from now of a name ("rename",
 * "sendmmsg", "open" for open64() too; NULL: of any) of a tool, once: a signal,
 * or whatever run() does, which must not wait. */
void user_signal_at(user_tool *tool, const char *call, unsigned n, int number);
void user_at_call(user_tool *tool, const char *call, unsigned n,
                  void (*run)(void *argument), void *argument);

/* --- A sensor --- */

/* lumsim, and its log. */
typedef struct user_sensor {
    user_tool *tool;
    world_host *host;
    const char *address;
    const struct user_event *first, *last;
    struct user_kind *kinds; /* sensor.c */
} user_sensor;

typedef struct user_event {
    const struct user_event *next, *next_of_kind;
    int64_t t_ns; /* true time of the world */
    char kind[24];
    const char *line; /* the whole object */
} user_event;

/* Starts lumsim at the address of its host, with `--frames 1`
 * unless the options say otherwise, and waits until it has rendered. */
__attribute__((format(printf, 2, 3))) user_sensor *user_sensor_start(
    world_host *host, const char *format, ...);

/* Does not wait. */
user_sensor *user_sensor_power_on(world_host *host, const char *options);

/* How many events of a kind its log has; the last of them, or NULL; the i-th
 * from 0, or NULL. */
size_t user_events(const user_sensor *sensor, const char *kind);
const user_event *user_last(const user_sensor *sensor, const char *kind);
const user_event *user_event_at(const user_sensor *sensor, const char *kind,
                                size_t i);
bool user_laser_is_on(const user_sensor *sensor);
/* How often the laser came on. */
size_t user_laser_rises(const user_sensor *sensor);
/* Commands of this text, each once however often it was sent. */
size_t user_heard(const user_sensor *sensor, const char *command);
/* How often one was carried out, alone or among others: "80p". */
size_t user_done(const user_sensor *sensor, const char *command);
/* Waits for so many more heartbeats: what the sensor said before is then known.
 */
#define user_until_beats(SENSOR, COUNT)                                        \
    user_wait_for_beats(USER_HERE, SENSOR, (size_t)(COUNT))
void user_wait_for_beats(user_place at, const user_sensor *sensor,
                         size_t count);

/* --- JSON --- */

/* A value of an object by its path, "outputs.0.end"; NULL: there is none. Texts
 * without their quotes, all else as it is written. */
const char *user_value(const char *json, const char *path);
/* Fail the story if there is none. */
double user_number(const char *json, const char *path);
/* Of an array. */
size_t user_length(const char *json, const char *path);

/* --- Files, disks, pipes, terminals --- */

/* These are short for what disk.h has, which a story uses for all else: stalls,
 * full and failing disks, power cuts. Paths are absolute or below "/home". */
const char *user_path(const char *path);
int64_t user_size(world_host *host, const char *path); /* -1: there is none */
/* Fails the story if there is none. */
const char *user_file(world_host *host, const char *path);
void user_write_file(world_host *host, const char *path, const char *text);
/* How many names in "/home" have this beginning and end. */
size_t user_files(world_host *host, const char *begin, const char *end);
/* Names in "/home", sorted, with a blank behind each. */
const char *user_names(world_host *host);
/* The largest file in "/home" whose name begins so: what is written has its
 * name at once, or when it is whole. 0: none. */
int64_t user_size_of(world_host *host, const char *begin);

/* A fifo by its name, which the user opens and does not read yet. */
world_reader *user_fifo(world_host *host, const char *path);
/* What a reader has taken, what a terminal has shown. */
const char *user_taken(const world_reader *reader);
const char *user_shown(const world_terminal *terminal);
/* A terminal's shell: this tool is in the foreground from now on. */
void user_foreground(world_terminal *terminal, const user_tool *tool);

/* --- Others at the wire --- */

/* A program of the user's own at a UDP port: a made-up sensor, a stranger. */
typedef struct user_peer user_peer;
typedef struct user_mail {
    uint32_t from; /* IPv4 as a number */
    uint16_t port;
    const uint8_t *bytes;
    size_t size;
} user_mail;
/* answer, if any, is called with each datagram that comes; it may send, and
 * must not wait. port 0: any that is free. */
user_peer *user_peer_new(world_host *host, const char *address, uint16_t port,
                         void (*answer)(user_peer *peer, const user_mail *mail,
                                        void *argument),
                         void *argument);
uint16_t user_port_of(const user_peer *peer);
/* From the peer's address and port. Does not wait. */
void user_send(user_peer *peer, uint32_t to, uint16_t port, const void *bytes,
               size_t size);
/* Datagrams that came; NULL: not so many. */
size_t user_mails(const user_peer *peer);
const user_mail *user_mail_at(const user_peer *peer, size_t i);
/* Its socket is closed. Waits, so only for the story itself. */
void user_peer_leave(user_peer *peer);

#endif
