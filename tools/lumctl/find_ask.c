#include "find.h"

#include "../common/terminal.h"
#include "beside.h"
#include "session.h"

#include "lum/base/time.h"
#include "lum/wire.h"

#include "net/route.h"

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
#define TAKE_MAX      64u /* of one interface in a step */
#define AGAIN_PASSES  2u
#define BESIDE_PASSES 4u
#define AGAIN_NS      INT64_C(250000000) /* after each */

/* An interface that is listened to as it is on the wire. */
struct ear {
    const struct host_interface *interface;
    struct arp *arp;
    struct find_ear *ip;
    bool is_busy; /* was asked in this step */
};

struct question {
    uint32_t sequence; /* of the last time that it was sent */
    int64_t sent_ns;   /* 0: not yet */
    bool is_answered;
    bool has_mac; /* one that answered ARP for the address */
    uint8_t mac[INTERFACE_MAC_BYTES];
};

struct search {
    struct ctl *ctl;
    struct find_plan *plan;
    struct find_result *out;
    lum_socket *sockets[FIND_SOCKETS_MAX];
    const struct host_interface *of[FIND_SOCKETS_MAX]; /* NULL: by routes */
    size_t socket_count;
    int socket_at[FIND_RANGES_MAX];     /* of a range; -1: none */
    unsigned index_of[FIND_RANGES_MAX]; /* of its first question */
    struct ear ears[FIND_SOCKETS_MAX];
    size_t ear_count;
    struct question *questions;
    unsigned total;
    uint32_t sequence; /* the first */
    int64_t progress_ns;
    int64_t alive_ns;
    bool has_line;                   /* of progress, on the terminal */
    bool has_no_right;               /* to listen to the wire */
    char no_right[FIND_NAMES_BYTES]; /* interfaces that this leaves out */
};

/* --- Sockets and ears --- */

static unsigned size_of(const struct find_range *range)
{
    return range->last - range->first + 1u;
}

static enum exit_status add_socket(struct search *s,
                                   const struct host_interface *interface,
                                   int *at)
{
    const lum_socket_options options = {
        .struct_size = sizeof options,
        .interface_name = interface != NULL ? interface->name : NULL};
    lum_error error = {""};
    for (size_t i = 0; i < s->socket_count; i++) {
        if (s->of[i] == interface) {
            *at = (int)i;
            return EXIT_DONE;
        }
    }
    if (s->socket_count == FIND_SOCKETS_MAX) {
        (void)snprintf(find_leave_out(&s->plan->left_out), FIND_LEFT_OUT_BYTES,
                       "%s was not searched: more than %u interfaces; name it "
                       "by --interface",
                       interface->name, FIND_SOCKETS_MAX);
        return EXIT_DONE;
    }
    if (lum_socket_open(&options, &s->sockets[s->socket_count], &error) !=
        LUM_NET_OK) {
        return ctl_complain(EXIT_FAILED, "%s", error.text);
    }
    s->of[s->socket_count] = interface;
    *at = (int)s->socket_count++;
    return EXIT_DONE;
}

static struct ear *find_ear(struct search *s,
                            const struct host_interface *interface)
{
    for (size_t i = 0; i < s->ear_count; i++) {
        if (s->ears[i].interface == interface) {
            return &s->ears[i];
        }
    }
    return NULL;
}

static bool can_ask(struct search *s, size_t range)
{
    const struct find_range *r = &s->plan->ranges[range];
    const struct ear *ear = r->by_arp ? find_ear(s, r->interface) : NULL;
    return r->by_arp ? ear != NULL && ear->arp != NULL
                     : s->socket_at[range] >= 0;
}

/* Without the right to listen, all that is asked by UDP is asked all the same.
 */
static void add_ear(struct search *s, const struct find_range *range)
{
    const struct host_interface *interface = range->interface;
    lum_error error = {""};
    struct arp *arp = NULL;
    if (interface == NULL || interface->is_loopback ||
        s->ear_count == FIND_SOCKETS_MAX || find_ear(s, interface) != NULL) {
        return;
    }
    const enum arp_opened opened = arp_open(interface, &arp, &error);
    if (opened == ARP_NO_RIGHT) {
        s->has_no_right = true;
    }
    if (opened != ARP_OPENED) {
        arp = NULL;
    }
    s->ears[s->ear_count++] =
        (struct ear){.interface = interface,
                     .arp = arp,
                     .ip = find_ear_open(interface, s->ctl->options.host.port)};
}

/* Addresses that could only be asked by ARP, but cannot be. */
static void leave_out_arp(struct search *s)
{
    const struct host_interface *last = NULL;
    for (size_t i = 0; i < s->plan->range_count; i++) {
        const struct find_range *r = &s->plan->ranges[i];
        if (r->by_arp && r->interface != last && !r->is_askable) {
            find_add_name(s->no_right, r->interface->name);
            last = r->interface;
        }
    }
    if (s->no_right[0] != '\0') {
        (void)snprintf(find_leave_out(&s->plan->left_out), FIND_LEFT_OUT_BYTES,
                       "%s: no address in a sensor's subnet, and not asked by "
                       "ARP%s",
                       s->no_right,
                       s->has_no_right
                           ? ", since only root may: say sudo lumctl find"
                           : ", which this system does not allow");
    }
}

/* The addresses that can be asked, and how many they are. */
static void count_all(struct search *s)
{
    for (size_t i = 0; i < s->plan->range_count; i++) {
        struct find_range *r = &s->plan->ranges[i];
        r->is_askable = can_ask(s, i);
        s->index_of[i] = s->total;
        s->total += size_of(r);
        for (unsigned k = 0; k < size_of(r) && r->is_askable; k++) {
            s->out->wanted +=
                find_is_repeated(s->plan, i, r->first + k) ? 0u : 1u;
        }
    }
}

static enum exit_status open_all(struct search *s)
{
    enum exit_status status = EXIT_DONE;
    for (size_t i = 0; i < s->plan->range_count && status == EXIT_DONE; i++) {
        const struct find_range *range = &s->plan->ranges[i];
        s->socket_at[i] = -1;
        add_ear(s, range);
        if (!range->by_arp) {
            status = add_socket(s, range->interface, &s->socket_at[i]);
        }
    }
    count_all(s);
    leave_out_arp(s);
    s->questions = calloc(s->total > 0 ? s->total : 1u, sizeof *s->questions);
    return status != EXIT_DONE || s->questions != NULL
               ? status
               : ctl_complain(EXIT_FAILED, "no memory for a search");
}

static void close_all(struct search *s)
{
    for (size_t i = 0; i < s->socket_count; i++) {
        lum_socket_close(s->sockets[i]);
    }
    for (size_t i = 0; i < s->ear_count; i++) {
        arp_close(s->ears[i].arp);
        find_ear_close(s->ears[i].ip);
    }
    free(s->questions);
}

/* --- Answers of sensors --- */

/* The socket by which an address is asked on this interface by UDP; NULL:
 * none. */
static struct question *question_for(const struct search *s,
                                     const struct host_interface *on,
                                     uint32_t address)
{
    for (size_t i = 0; i < s->plan->range_count && on != NULL; i++) {
        const struct find_range *r = &s->plan->ranges[i];
        if (!r->by_arp && r->interface == on && find_is_in(r, address)) {
            return &s->questions[s->index_of[i] + (address - r->first)];
        }
    }
    return NULL;
}

static void recall_mac(const struct search *s, struct find_found *f)
{
    const struct question *q = question_for(s, f->interface, f->host.address);
    if (q != NULL && q->has_mac) {
        find_note_mac(f, q->mac, false);
    }
}

static enum find_how how_of(const struct search *s, const uint8_t *bytes,
                            size_t len, bool *is_ours)
{
    uint8_t type = 0;
    const lum_result result = lum_header_decode(bytes, len, &type);
    *is_ours = result == LUM_OK || result == LUM_E_TYPE;
    const bool is_known =
        result == LUM_OK &&
        ((type >= LUM_TYPE_SET_IP && type <= LUM_TYPE_HEARTBEAT) ||
         type == s->ctl->layout.profile.data_packet_type);
    return is_known ? FIND_SENDS : FIND_OTHER;
}

/* The question that a time stamp answers; NULL: none. */
static struct question *question_of(struct search *s, const uint8_t *bytes,
                                    size_t len, uint32_t *clock_us,
                                    bool *is_last)
{
    lum_timestamp answer;
    if (s->total == 0 || lum_timestamp_decode(bytes, len, &answer) != LUM_OK) {
        return NULL;
    }
    struct question *q =
        &s->questions[(answer.sequence - s->sequence) % s->total];
    *clock_us = answer.clock_us;
    *is_last = q->sequence == answer.sequence;
    return q->sent_ns != 0 ? q : NULL;
}

/* The finding for the sender of a packet with our magic; NULL: it has no magic,
 * or there is no room. */
static struct find_found *take_packet(struct search *s,
                                      const struct host_interface *on,
                                      lum_endpoint from, const uint8_t *bytes,
                                      size_t len)
{
    bool is_ours = false;
    bool is_last = false;
    uint32_t clock_us = 0;
    const enum find_how how = how_of(s, bytes, len, &is_ours);
    struct question *q = question_of(s, bytes, len, &clock_us, &is_last);
    struct find_found *f =
        is_ours ? find_entry(s->out, from, on, q != NULL ? FIND_ANSWERS : how)
                : NULL;
    if (f == NULL) {
        return NULL;
    }
    f->host = from;
    f->how = how > f->how ? how : f->how;
    recall_mac(s, f);
    if (q != NULL && f->how != FIND_ANSWERS) {
        f->how = FIND_ANSWERS;
        f->clock_us = clock_us;
        f->round_trip_ns = is_last ? lum_time_monotonic_ns() - q->sent_ns : 0;
        q->is_answered = true;
    }
    return f;
}

/* Where a datagram came in that the routes led to its sender. */
static const struct host_interface *routed(const struct search *s,
                                           uint32_t address)
{
    char name[INTERFACE_NAME_BYTES];
    return lum_route_interface(address, name, sizeof name)
               ? interfaces_find(s->plan->interfaces, s->plan->interface_count,
                                 name)
               : NULL;
}

static enum exit_status take_datagrams(struct search *s, size_t at)
{
    lum_received *datagrams = NULL;
    lum_error error = {""};
    size_t count = 0;
    if (lum_socket_receive(s->sockets[at], &datagrams, &count, &error) !=
        LUM_NET_OK) {
        return ctl_complain(EXIT_FAILED, "%s", error.text);
    }
    for (size_t i = 0; i < count; i++) {
        const struct host_interface *on =
            s->of[at] != NULL ? s->of[at]
                              : routed(s, datagrams[i].from.address);
        (void)take_packet(s, on, datagrams[i].from, datagrams[i].bytes,
                          datagrams[i].len);
    }
    return EXIT_DONE;
}

/* --- Devices that were heard --- */

/* Whether an address was asked for on this interface by ARP. */
static bool is_asked(const struct search *s, const struct ear *ear,
                     uint32_t address)
{
    for (size_t i = 0; i < s->plan->range_count; i++) {
        const struct find_range *r = &s->plan->ranges[i];
        if (r->by_arp && r->interface == ear->interface &&
            find_is_in(r, address)) {
            return true;
        }
    }
    return false;
}

/* A device that has an address proposed for this host is not a finding: it was
 * asked only for that. */
static bool is_beside(struct search *s, const struct ear *ear, uint32_t address)
{
    for (size_t i = 0; i < s->out->beside_count; i++) {
        struct find_subnet_beside *b = &s->out->besides[i];
        if (b->interface == ear->interface &&
            b->network == (address & BESIDE_MASK)) {
            find_note_taken(&b->taken, b->network, address);
            return (address & ~BESIDE_MASK) <= BESIDE_LAST;
        }
    }
    return false;
}

/* A device that is asked by UDP is not a finding because of its ARP. Two
 * devices of one address are, because one of them may be a sensor that no
 * packet reaches. */
static bool is_finding(struct search *s, const struct ear *ear,
                       const struct arp_speaker *speaker)
{
    struct question *q = question_for(s, ear->interface, speaker->address);
    if (q == NULL) {
        return interfaces_subnet(ear->interface, speaker->address) == NULL ||
               is_asked(s, ear, speaker->address);
    }
    if (q->has_mac && memcmp(q->mac, speaker->mac, sizeof q->mac) != 0) {
        return true;
    }
    q->has_mac = true;
    (void)memcpy(q->mac, speaker->mac, sizeof q->mac);
    return false;
}

/* False: he is not known yet. */
static bool note_speaker(struct search *s, const struct ear *ear,
                         const struct arp_speaker *speaker)
{
    bool is_known = false;
    for (size_t i = 0; i < s->out->count; i++) {
        struct find_found *f = &s->out->found[i];
        if (f->host.address == speaker->address &&
            f->interface == ear->interface) {
            find_note_mac(f, speaker->mac, false);
            is_known = true;
        }
    }
    return is_known;
}

static void take_speaker(struct search *s, const struct ear *ear,
                         const struct arp_speaker *speaker)
{
    const lum_endpoint host = {speaker->address, s->ctl->options.host.port};
    if (note_speaker(s, ear, speaker) ||
        interfaces_owner(s->plan->interfaces, s->plan->interface_count,
                         speaker->address, NULL) != NULL ||
        is_beside(s, ear, speaker->address) || !is_finding(s, ear, speaker)) {
        return;
    }
    struct find_found *f = find_entry(s->out, host, ear->interface, FIND_ARP);
    if (f != NULL) {
        recall_mac(s, f);
        find_note_mac(f, speaker->mac, false);
    }
}

static void take_ear(struct search *s, const struct ear *ear)
{
    struct arp_speaker speaker;
    struct find_heard heard;
    for (unsigned n = 0;
         n < TAKE_MAX && ear->arp != NULL && arp_receive(ear->arp, 0, &speaker);
         n++) {
        take_speaker(s, ear, &speaker);
    }
    for (unsigned n = 0;
         n < TAKE_MAX && ear->ip != NULL && find_ear_take(ear->ip, &heard);
         n++) {
        struct find_found *f =
            take_packet(s, ear->interface, heard.from, heard.bytes, heard.len);
        if (f != NULL) {
            find_note_taken(&f->sends_to, f->host.address & BESIDE_MASK,
                            heard.to);
        }
        if (f != NULL && heard.has_mac) {
            find_note_mac(f, heard.mac, f->how >= FIND_SENDS);
        }
    }
}

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

static enum exit_status take_all(struct search *s)
{
    for (size_t i = 0; i < s->socket_count; i++) {
        if (take_datagrams(s, i) != EXIT_DONE) {
            return EXIT_FAILED;
        }
    }
    for (size_t i = 0; i < s->ear_count; i++) {
        take_ear(s, &s->ears[i]);
    }
    return EXIT_DONE;
}

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
            lum_socket_wait(s->sockets, s->socket_count, -1, s->ctl->cancel,
                            step < end ? step : end);
        if (result == LUM_NET_CANCELLED) {
            s->out->is_cut_short = true;
            return EXIT_FAILED;
        }
        if (take_all(s) != EXIT_DONE) {
            return EXIT_FAILED;
        }
        if (lum_time_monotonic_ns() >= end) {
            return EXIT_DONE;
        }
    }
}

/* --- Asking one range after another --- */

static int ask_arp(struct search *s, const struct host_interface *interface,
                   uint32_t address, lum_error *error)
{
    const struct ear *ear = find_ear(s, interface);
    return ear != NULL && ear->arp != NULL ? arp_ask(ear->arp, address, error)
                                           : 0;
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
    return lum_socket_send(s->sockets[s->socket_at[range]], &datagram, error) ==
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
    bool is_busy = false;
    bool has_asked = false;
    for (size_t i = 0; i < s->ear_count; i++) {
        s->ears[i].is_busy = false;
    }
    for (size_t i = 0; i < s->plan->range_count; i++) {
        const struct find_range *r = &s->plan->ranges[i];
        struct ear *ear = r->by_arp ? find_ear(s, r->interface) : NULL;
        bool *lane = ear != NULL ? &ear->is_busy : &is_busy;
        if (!*lane && ask_next(s, i, &next[i], pass)) {
            *lane = true;
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
    const struct ctl_options *options = &s->ctl->options;
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
    const struct ear *ear = find_ear(s, b->interface);
    enum exit_status status = EXIT_DONE;
    b->is_asked = ear != NULL && ear->arp != NULL;
    for (uint32_t last = 1;
         last <= BESIDE_LAST && b->is_asked && status == EXIT_DONE; last++) {
        if ((b->taken >> last & 1u) == 0) {
            b->is_asked = arp_ask(ear->arp, b->network | last, NULL) == 0;
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
        const struct ear *ear = find_ear(s, f->interface);
        if (ear != NULL && ear->arp != NULL) {
            (void)arp_ask(ear->arp, f->host.address, NULL);
            status = listen_until(s, lum_time_monotonic_ns() + STEP_NS);
        }
    }
    return status;
}

static enum exit_status ask_besides(struct search *s)
{
    struct find_result *r = s->out;
    enum exit_status status = EXIT_DONE;
    for (size_t i = 0; i < r->beside_count && status == EXIT_DONE; i++) {
        status = ask_beside(s, &r->besides[i]);
    }
    return status;
}

/* --- Asking again --- */

static bool has_arp(const struct search *s)
{
    for (size_t i = 0; i < s->ear_count; i++) {
        if (s->ears[i].arp != NULL) {
            return true;
        }
    }
    return false;
}

/* Using an address of another device would cut that device off the network, so
 * all addresses that could be proposed are asked first. */
static enum exit_status ask_again(struct search *s)
{
    struct find_result *r = s->out;
    enum exit_status status = EXIT_DONE;
    find_plan_besides(s->plan, r);
    const unsigned passes = r->beside_count > 0 ? BESIDE_PASSES : AGAIN_PASSES;
    const bool has_any = r->count > 0 && has_arp(s);
    for (unsigned pass = 0; pass < passes && has_any && status == EXIT_DONE;
         pass++) {
        status = pass < AGAIN_PASSES ? ask_found(s) : EXIT_DONE;
        status = status == EXIT_DONE ? ask_besides(s) : status;
        if (status == EXIT_DONE) {
            status = listen_until(s, lum_time_monotonic_ns() + AGAIN_NS);
        }
    }
    if (status != EXIT_DONE) {
        r->beside_count = 0; /* not all were asked */
    }
    return status;
}

static void tell_lost(struct search *s)
{
    const struct find_result *r = s->out;
    if (r->lost_count > 0) {
        (void)snprintf(find_leave_out(&s->plan->left_out), FIND_LEFT_OUT_BYTES,
                       "seen and not shown, beyond the %u that there is room "
                       "for: %u %s%s; --interface and --subnet search a part",
                       FIND_FOUND_MAX, (unsigned)r->lost_count,
                       r->lost_count == 1 ? "address" : "addresses",
                       r->has_lost_more ? " and more" : "");
    }
}

enum exit_status find_ask(struct ctl *ctl, struct find_plan *plan,
                          struct find_result *out)
{
    struct search s = {.ctl = ctl, .plan = plan, .out = out};
    memset(out, 0, sizeof *out);
    s.sequence = ctl->options.has_sequence ? ctl->options.sequence
                                           : (uint32_t)lum_time_monotonic_ns();
    enum exit_status status = open_all(&s);
    if (status == EXIT_DONE) {
        status = ask_all(&s);
    }
    if (status == EXIT_DONE) {
        status = ask_again(&s);
    }
    tell_lost(&s);
    clear_progress(&s);
    close_all(&s);
    return out->is_cut_short ? EXIT_DONE : status;
}
