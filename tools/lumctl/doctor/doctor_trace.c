#define _GNU_SOURCE

#include "doctor_trace.h"

#include "../../common/number.h"
#include "doctor_program.h"

#include "lum/base/time.h"

#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MS_NS      INT64_C(1000000)
#define LINE_BYTES 4096u

/* Before every other chain. */
#define FIRST "-2147483647"

/* Whole lines that a program prints. */
struct lines {
    char bytes[LINE_BYTES];
    size_t len;
};

struct trace {
    struct program editor;  /* nft -i, which owns the table */
    struct program monitor; /* nft monitor trace */
    char table[32];
    struct lines edited;
    struct lines seen;
    struct trace_reader reader;
};

int trace_allowed(lum_error *error)
{
    char path[PROGRAM_PATH_BYTES];
    if (geteuid() != 0) {
        return lum_error_set(error, "--trace needs root: sudo lumctl doctor "
                                    "--trace");
    }
    if (!program_find("nft", path)) {
        return lum_error_set(error, "--trace needs nft, which is not installed "
                                    "(package nftables)");
    }
    return 0;
}

/* Adds what a program has printed by now. False: it has ended. */
static bool fill(struct lines *l, int fd)
{
    if (l->len == sizeof l->bytes) {
        l->len = 0; /* a line of this length is not one of ours */
    }
    const ssize_t n = read(fd, l->bytes + l->len, sizeof l->bytes - l->len);
    l->len += n > 0 ? (size_t)n : 0;
    return n > 0;
}

/* The next whole line, without its end. */
static bool next_line(struct lines *l, char out[LINE_BYTES])
{
    const char *end = memchr(l->bytes, '\n', l->len);
    if (end == NULL) {
        return false;
    }
    const size_t n = (size_t)(end - l->bytes);
    memcpy(out, l->bytes, n);
    out[n] = '\0';
    l->len -= n + 1u;
    memmove(l->bytes, end + 1, l->len);
    return true;
}

/* Whether a program printed more; waits until the given time. */
static bool wait_for(struct lines *l, int fd, int64_t end_ns)
{
    const int64_t left = end_ns - lum_time_monotonic_ns();
    struct pollfd wait = {.fd = fd, .events = POLLIN};
    return left > 0 && poll(&wait, 1, (int)(left / MS_NS) + 1) > 0 &&
           fill(l, fd);
}

/* Only packets between the sensor and one socket of ours are marked; data of
 * other programs passes as before. Not every kernel has chains of devices, so
 * these chains have a separate table. */
static bool add_tables(struct trace *t, const char *interface,
                       lum_endpoint sensor, uint16_t port)
{
    char text[1536];
    const struct number_address address = number_address(sensor.address);
    const int n = snprintf(
        text, sizeof text,
        "add table netdev %s { flags owner; chain comes { type filter hook "
        "ingress device \"%s\" priority " FIRST "; ip saddr %s udp dport %u "
        "meta nftrace set 1; }; }\n"
        "add table ip %s { flags owner; "
        "chain comes { type filter hook prerouting priority " FIRST "; "
        "ip saddr %s udp dport %u meta nftrace set 1; }; "
        "chain leaves { type filter hook output priority " FIRST "; "
        "ip daddr %s udp sport %u meta nftrace set 1; }; }\n"
        "list tables ip\n",
        t->table, interface, address.text, (unsigned)port, t->table,
        address.text, (unsigned)port, address.text, (unsigned)port);
    return n > 0 && (size_t)n < sizeof text &&
           write(t->editor.in, text, (size_t)n) == n;
}

/* nft lists the table once it is there; else it prints an error for the
 * line. */
int trace_ready(struct trace *t, int wait_ms, lum_error *error)
{
    const int64_t end = lum_time_monotonic_ns() + wait_ms * MS_NS;
    char line[LINE_BYTES];
    char wanted[64];
    (void)snprintf(wanted, sizeof wanted, "table ip %s", t->table);
    do {
        while (next_line(&t->edited, line)) {
            if (strcmp(line, wanted) == 0) {
                return 1;
            }
        }
    } while (wait_for(&t->edited, t->editor.out, end));
    (void)lum_error_set(error,
                        "nft or the kernel cannot trace with a table that is "
                        "taken out by itself (nft 0.9.9 and Linux 5.12 can)");
    return lum_time_monotonic_ns() < end ? -1 : 0;
}

int trace_start(const char *interface, lum_endpoint sensor, uint16_t port,
                struct trace **out, lum_error *error)
{
    static char *const edit[] = {"nft", "-i", NULL};
    static char *const monitor[] = {"nft", "monitor", "trace", NULL};
    struct trace *t = calloc(1, sizeof *t);
    if (t == NULL) {
        return lum_error_set(error, "no memory for a trace");
    }
    (void)snprintf(t->table, sizeof t->table, "lumctl_%ld", (long)getpid());
    t->reader.table = t->table;
    t->editor = program_none();
    t->monitor = program_none();
    if (!program_start(&t->monitor, monitor) ||
        !program_start(&t->editor, edit) ||
        !add_tables(t, interface, sensor, port)) {
        trace_stop(t);
        return lum_error_set(error, "nft cannot be started");
    }
    *out = t;
    return 0;
}

const struct trace_reader *trace_follow(struct trace *t, int wait_ms)
{
    const int64_t end = lum_time_monotonic_ns() + wait_ms * MS_NS;
    char line[LINE_BYTES];
    do {
        while (next_line(&t->seen, line)) {
            trace_read(&t->reader, line);
        }
    } while (wait_for(&t->seen, t->monitor.out, end));
    return &t->reader;
}

void trace_stop(struct trace *t)
{
    if (t != NULL) {
        program_end(&t->editor);
        program_end(&t->monitor);
        free(t);
    }
}
