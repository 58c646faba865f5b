/* Asks the addresses of a plan, in passes at a limited rate, listens meanwhile,
 * and asks once more for what was found. */
#include "find_search.h"

#include "../common/terminal.h"
#include "beside.h"
#include "ctl_session.h"

#include "lum/base/time.h"
#include "lum/wire.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A question to an address that nobody has stays in the kernel's table of
 * neighbours for three seconds, and it holds 1024: this leaves room. */
#define RATE          256
#define STEP_NS       (INT64_C(1000000000) / RATE)
#define PASSES        2u
#define PROGRESS_NS   INT64_C(100000000)
#define KEEP_ALIVE_NS INT64_C(50000000)
#define AGAIN_PASSES  2u
#define BESIDE_PASSES 4u
#define AGAIN_NS      INT64_C(250000000) /* after each */

/* --- Progress --- */

static unsigned sensors_of(const struct find_result *r)
{
    unsigned n = 0;
    for (size_t i = 0; i < r->count; i++) {
        n += r->found[i].how >= FIND_SENDS ? 1u : 0u;
    }
    return n;
}

static void show_progress(struct search *s, int64_t now)
{
    if (now < s->progress_ns || s->ctl->options.quiet) {
        return;
    }
    s->progress_ns = now + PROGRESS_NS;
    if (terminal_is_foreground(stderr)) {
        const unsigned n = sensors_of(s->out);
        s->has_line = true;
        (void)fprintf(
            stderr, "\r%u of %u addresses asked, %u %s found  Ctrl-C ends ",
            s->out->asked, s->out->wanted, n, n == 1 ? "sensor" : "sensors");
        (void)fflush(stderr);
    }
}

static void clear_progress(const struct search *s)
{
    if (s->has_line && terminal_is_foreground(stderr)) {
        (void)fputs("\r\033[K", stderr);
    }
}

/* --- Listening --- */

/* A shell's session continues: it may keep a laser on. */
static void keep_alive(struct search *s, int64_t now)
{
    if (now >= s->alive_ns) {
        s->alive_ns = now + KEEP_ALIVE_NS;
        session_keep_alive(s->ctl);
    }
}

/* Takes arrivals until then. EXIT_FAILED also when the command should end. */
static enum exit_status listen_until(struct search *s, int64_t end)
{
    for (;;) {
        const int64_t now = lum_time_monotonic_ns();
        keep_alive(s, now);
        show_progress(s, now);
        const int64_t step = now + STEP_NS;
        const lum_net_result result =
            lum_socket_wait(s->links.sockets, s->links.socket_count, -1,
                            s->ctl->cancel, step < end ? step : end);
        if (result == LUM_NET_CANCELLED) {
            s->out->is_cut_short = true;
            return EXIT_FAILED;
        }
        if (find_hear(s) != EXIT_DONE) {
            return EXIT_FAILED;
        }
        if (lum_time_monotonic_ns() >= end) {
            return EXIT_DONE;
        }
    }
}

/* --- Asking one range after another --- */

static unsigned size_of(const struct find_range *range)
{
    return range->last - range->first + 1u;
}

/* Numbers the questions, and counts the addresses that can be asked. */
static enum exit_status number_all(struct search *s)
{
    for (size_t i = 0; i < s->plan->range_count; i++) {
        const struct find_range *r = &s->plan->ranges[i];
        s->index_of[i] = s->total;
        s->total += size_of(r);
        for (unsigned k = 0; k < size_of(r) && r->is_askable; k++) {
            s->out->wanted +=
                find_is_repeated(s->plan, i, r->first + k) ? 0u : 1u;
        }
    }
    s->questions = calloc(s->total > 0 ? s->total : 1u, sizeof *s->questions);
    return s->questions != NULL
               ? EXIT_DONE
               : ctl_complain(EXIT_FAILED, "no memory for a search");
}

static int ask_arp(const struct search *s,
                   const struct host_interface *interface, uint32_t address,
                   lum_error *error)
{
    struct arp *arp = find_links_arp(&s->links, interface);
    return arp != NULL ? arp_ask(arp, address, error) : 0;
}

/* The kernel asks ARP only for whom it does not know, and takes one answer. */
static int send_question(struct search *s, size_t range, uint32_t address,
                         uint32_t sequence, lum_error *error)
{
    const struct find_range *r = &s->plan->ranges[range];
    const lum_timestamp request = {sequence, 0};
    uint8_t packet[LUM_TIMESTAMP_BYTES];
    if (r->by_arp) {
        return ask_arp(s, r->interface, address, error);
    }
    (void)ask_arp(s, r->interface, address, NULL);
    lum_timestamp_encode(packet, &request);
    const lum_outgoing datagram = {
        packet, sizeof packet, {address, s->ctl->options.host.port}};
    return lum_socket_send(s->links.socket_of[range], &datagram, error) ==
                   LUM_NET_OK
               ? 0
               : -1;
}

static void ask_one(struct search *s, size_t range, unsigned i, unsigned pass)
{
    const uint32_t address = s->plan->ranges[range].first + i;
    const unsigned index = s->index_of[range] + i;
    struct question *q = &s->questions[index];
    lum_error error = {""};
    const uint32_t sequence = s->sequence + pass * s->total + index;
    if (pass == 0) {
        s->out->questions++;
        s->out->asked += find_is_repeated(s->plan, range, address) ? 0u : 1u;
    }
    if (send_question(s, range, address, sequence, &error) == 0) {
        q->sequence = sequence;
        q->sent_ns = lum_time_monotonic_ns();
    } else if (pass == 0) {
        s->out->unsent++;
        s->out->error = s->out->unsent == 1 ? error : s->out->error;
    }
}

/* Asks one more address of a range. False: all were asked. */
static bool ask_next(struct search *s, size_t range, unsigned *next,
                     unsigned pass)
{
    const struct find_range *r = &s->plan->ranges[range];
    const unsigned size = size_of(r);
    const struct question *q = &s->questions[s->index_of[range]];
    while (*next < size && q[*next].is_answered) {
        ++*next;
    }
    if (!r->is_askable || *next == size) {
        return false;
    }
    ask_one(s, range, (*next)++, pass);
    return true;
}

/* Asks one address by UDP and, at each interface, one only by ARP, without the
 * kernel's table. False: all were asked. */
static bool ask_step(struct search *s, unsigned next[FIND_RANGES_MAX],
                     unsigned pass)
{
    bool is_busy[FIND_SOCKETS_MAX + 1u] = {false}; /* the last: by UDP */
    bool has_asked = false;
    for (size_t i = 0; i < s->plan->range_count; i++) {
        const struct find_range *r = &s->plan->ranges[i];
        bool *is_lane_busy =
            &is_busy[r->by_arp ? find_links_listener(&s->links, r->interface)
                               : FIND_SOCKETS_MAX];
        if (!*is_lane_busy && ask_next(s, i, &next[i], pass)) {
            *is_lane_busy = true;
            has_asked = true;
        }
    }
    return has_asked;
}

static enum exit_status ask_pass(struct search *s, unsigned pass)
{
    unsigned next[FIND_RANGES_MAX] = {0};
    while (ask_step(s, next, pass)) {
        const enum exit_status status =
            listen_until(s, lum_time_monotonic_ns() + STEP_NS);
        if (status != EXIT_DONE) {
            return status;
        }
    }
    return EXIT_DONE;
}

/* Nobody is asked again before he has had the time to answer. */
static enum exit_status ask_all(struct search *s)
{
    const struct request_options *options = &s->ctl->options.requests;
    const int64_t wait_ns = options->timeout_ms * INT64_C(1000000);
    const unsigned passes =
        options->has_retries ? options->retries + 1u : PASSES;
    for (unsigned pass = 0; pass < passes; pass++) {
        const bool is_last = pass + 1u == passes;
        const int64_t began = lum_time_monotonic_ns();
        enum exit_status status = ask_pass(s, pass);
        if (status == EXIT_DONE) {
            status = listen_until(
                s, (is_last ? lum_time_monotonic_ns() : began) + wait_ns);
        }
        if (status != EXIT_DONE) {
            return status;
        }
    }
    return EXIT_DONE;
}

/* --- Asking the addresses that were heard --- */

static enum exit_status ask_beside(struct search *s,
                                   struct find_subnet_beside *b)
{
    struct arp *arp = find_links_arp(&s->links, b->interface);
    enum exit_status status = EXIT_DONE;
    b->is_asked = arp != NULL;
    for (uint32_t last = 1;
         last <= BESIDE_LAST && b->is_asked && status == EXIT_DONE; last++) {
        if ((b->taken >> last & 1u) == 0) {
            b->is_asked = arp_ask(arp, b->network | last, NULL) == 0;
            status = listen_until(s, lum_time_monotonic_ns() + STEP_NS);
        }
    }
    return status;
}

/* For each finding, all devices with its address: one that UDP reached was not
 * asked twice, and a request may be lost. */
static enum exit_status ask_found(struct search *s)
{
    enum exit_status status = EXIT_DONE;
    for (size_t i = 0; i < s->out->count && status == EXIT_DONE; i++) {
        const struct find_found *f = &s->out->found[i];
        struct arp *arp = find_links_arp(&s->links, f->interface);
        if (arp != NULL) {
            (void)arp_ask(arp, f->host.address, NULL);
            status = listen_until(s, lum_time_monotonic_ns() + STEP_NS);
        }
    }
    return status;
}

/* --- Asking again --- */

/* Using an address of another device would cut that device off the network, so
 * all addresses that could be proposed are asked first. */
static enum exit_status ask_again(struct search *s)
{
    struct find_result *r = s->out;
    enum exit_status status = EXIT_DONE;
    find_plan_besides(s->plan, r);
    const unsigned passes = r->beside_count > 0 ? BESIDE_PASSES : AGAIN_PASSES;
    const bool has_any = r->count > 0 && s->links.has_arp;
    for (unsigned pass = 0; pass < passes && has_any && status == EXIT_DONE;
         pass++) {
        status = pass < AGAIN_PASSES ? ask_found(s) : EXIT_DONE;
        for (size_t i = 0; i < r->beside_count && status == EXIT_DONE; i++) {
            status = ask_beside(s, &r->besides[i]);
        }
        if (status == EXIT_DONE) {
            status = listen_until(s, lum_time_monotonic_ns() + AGAIN_NS);
        }
    }
    if (status != EXIT_DONE) {
        r->beside_count = 0; /* not all were asked */
    }
    return status;
}

static void tell_full(struct search *s)
{
    if (s->out->is_full) {
        (void)snprintf(find_leave_out(&s->plan->left_out), FIND_LEFT_OUT_BYTES,
                       "more devices were seen than the %u that are shown; "
                       "--interface and --subnet search a part",
                       FIND_FOUND_MAX);
    }
}

enum exit_status find_ask(struct ctl *ctl, struct find_plan *plan,
                          struct find_result *out)
{
    struct search s = {.ctl = ctl, .plan = plan, .out = out};
    memset(out, 0, sizeof *out);
    s.sequence = ctl->options.requests.has_sequence
                     ? ctl->options.requests.sequence
                     : (uint32_t)lum_time_monotonic_ns();
    enum exit_status status = find_links_open(&s.links, plan);
    status = status == EXIT_DONE ? number_all(&s) : status;
    status = status == EXIT_DONE ? ask_all(&s) : status;
    status = status == EXIT_DONE ? ask_again(&s) : status;
    tell_full(&s);
    clear_progress(&s);
    find_links_close(&s.links);
    free(s.questions);
    return out->is_cut_short ? EXIT_DONE : status;
}
