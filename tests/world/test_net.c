#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "kernel/file.h"
#include "kernel/net.h"
#include "kernel/net_internal.h"
#include "kernel/task.h"
#include "kernel/time.h"
#include "kernel/trace.h"
#include "kernel/world.h"

#include <arpa/inet.h>
#include <errno.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>

#define SEED   7
#define HOST   WORLD_ADDRESS(10, 42, 0, 1)
#define SENSOR WORLD_ADDRESS(10, 42, 0, 37)
#define NOBODY WORLD_ADDRESS(10, 42, 0, 99)
#define ALL    WORLD_ADDRESS(10, 42, 0, 255)
#define PORT   4000

static world_host *bench, *sensor;
static world_segment *wire;
static world_interface *eth0, *far;
static void (*script)(void);

/* --- what was seen of each datagram --- */

#define SEEN_MAX 200000u

static struct {
    uint64_t sent, ended;
    uint64_t fates[WORLD_FATES];
    uint8_t state[SEEN_MAX]; /* 1: sent, 2: ended */
    uint64_t altered;
} seen;

static void note(void *context, const world_datagram *datagram)
{
    (void)context;
    assert_in_range(datagram->number, 1, SEEN_MAX - 1u);
    uint8_t *state = &seen.state[datagram->number];
    if (datagram->fate == WORLD_UNDER_WAY) {
        assert_int_equal(*state, 0);
        *state = 1;
        seen.sent++;
    } else {
        assert_int_equal(*state, 1);
        *state = 2;
        seen.ended++;
        seen.fates[datagram->fate]++;
        seen.altered += datagram->is_altered ? 1 : 0;
    }
}

static void *run_user(void *argument)
{
    (void)argument;
    bench = world_host_new("bench");
    sensor = world_host_new("sensor");
    wire = world_segment_new("wire");
    eth0 = world_interface_new(bench, wire, "eth0");
    far = world_interface_new(sensor, wire, "eth0");
    world_interface_add(eth0, HOST, 24);
    world_interface_add(far, SENSOR, 24);
    memset(&seen, 0, sizeof seen);
    world_net_watch(note, NULL);
    script();
    return NULL;
}

static void run_with(uint64_t seed, void (*user)(void))
{
    script = user;
    world_begin(seed);
    const bool has_ended =
        world_run(world_task_begin(NULL, run_user, NULL), WORLD_NEVER);
    assert_string_equal(world_failure(), "");
    assert_true(has_ended);
    world_file_reset();
    world_net_check();
    assert_string_equal(world_failure(), "");
    assert_int_equal(seen.sent, world_net_sent());
    for (unsigned i = 0; i < WORLD_FATES; i++) {
        assert_int_equal(i == WORLD_UNDER_WAY ? seen.sent - seen.ended
                                              : seen.fates[i],
                         world_net_count((world_fate)i));
    }
    world_end();
}

static void run(void (*user)(void))
{
    run_with(SEED, user);
}

/* --- sockets of the user --- */

static struct sockaddr_in at(uint32_t address, uint16_t port)
{
    struct sockaddr_in in;
    memset(&in, 0, sizeof in);
    in.sin_family = AF_INET;
    in.sin_addr.s_addr = htonl(address);
    in.sin_port = htons(port);
    return in;
}

static world_file *open_at(world_host *host)
{
    return world_udp_file(host, O_RDWR | O_NONBLOCK);
}

/* 0, or an errno. */
static int bind_to(world_file *file, uint32_t address, uint16_t port)
{
    const struct sockaddr_in in = at(address, port);
    return file->kind->bind(file, (const struct sockaddr *)&in, sizeof in) == 0
               ? 0
               : errno;
}

static int connect_to(world_file *file, uint32_t address, uint16_t port)
{
    const struct sockaddr_in in = at(address, port);
    return file->kind->connect(file, (const struct sockaddr *)&in, sizeof in) ==
                   0
               ? 0
               : errno;
}

static world_file *bound(world_host *host, uint32_t address, uint16_t port)
{
    world_file *file = open_at(host);
    assert_int_equal(bind_to(file, address, port), 0);
    return file;
}

static int send_bytes(world_file *file, uint32_t address, uint16_t port,
                      const void *bytes, size_t size)
{
    struct sockaddr_in in = at(address, port);
    struct iovec part = {.iov_len = size};
    const struct msghdr message = {.msg_name = port != 0 ? &in : NULL,
                                   .msg_namelen = sizeof in,
                                   .msg_iov = &part,
                                   .msg_iovlen = 1};
    memcpy(&part.iov_base, &bytes, sizeof bytes);
    const ssize_t n = file->kind->sendmsg(file, &message, 0);
    assert_true(n < 0 || (size_t)n == size);
    return n < 0 ? errno : 0;
}

static int send_to(world_file *file, uint32_t address, uint16_t port,
                   const char *text)
{
    return send_bytes(file, address, port, text, strlen(text));
}

static int send_sized(world_file *file, uint32_t address, uint16_t port,
                      size_t size)
{
    static const uint8_t zeros[65536];
    return send_bytes(file, address, port, zeros, size);
}

static char received[65536];
static struct sockaddr_in from;

/* The size, or minus an errno. */
static int receive(world_file *file)
{
    struct iovec part = {.iov_base = received, .iov_len = sizeof received - 1u};
    struct msghdr message = {.msg_name = &from,
                             .msg_namelen = sizeof from,
                             .msg_iov = &part,
                             .msg_iovlen = 1};
    const ssize_t n = file->kind->recvmsg(file, &message, 0);
    received[n < 0 ? 0 : n] = '\0';
    return n < 0 ? -errno : (int)n;
}

static void expect(world_file *file, const char *text)
{
    assert_int_equal(receive(file), strlen(text));
    assert_string_equal(received, text);
}

static int set(world_file *file, int level, int name, int value)
{
    return file->kind->setsockopt(file, level, name, &value, sizeof value) == 0
               ? 0
               : errno;
}

static int get(world_file *file, int level, int name)
{
    int value = 0;
    socklen_t size = sizeof value;
    assert_int_equal(file->kind->getsockopt(file, level, name, &value, &size),
                     0);
    return value;
}

static uint32_t drops_of(world_file *file)
{
    uint32_t values[9];
    socklen_t size = sizeof values;
    assert_int_equal(
        file->kind->getsockopt(file, SOL_SOCKET, SO_MEMINFO, values, &size), 0);
    assert_int_equal(size, sizeof values);
    return values[8];
}

static int set_device(world_file *file, const char *name)
{
    return file->kind->setsockopt(file, SOL_SOCKET, SO_BINDTODEVICE, name,
                                  (socklen_t)strlen(name)) == 0
               ? 0
               : errno;
}

static void pause_for(int64_t ns)
{
    world_queue nothing = {NULL, NULL};
    world_wait_deaf(&nothing, world_now() + ns);
}

/* ARP is done. */
static void know(world_file *there)
{
    assert_int_equal(send_to(open_at(bench), SENSOR, PORT, "known"), 0);
    pause_for(WORLD_MS);
    expect(there, "known");
}

/* --- a good network --- */

static void one_there_and_back(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    assert_int_equal(send_to(here, SENSOR, PORT, "hello"), 0);
    assert_int_equal(receive(there), -EAGAIN);
    assert_int_equal(there->kind->poll(there) & POLLIN, 0);
    pause_for(WORLD_MS);
    assert_int_not_equal(there->kind->poll(there) & POLLIN, 0);
    expect(there, "hello");
    assert_int_equal(ntohl(from.sin_addr.s_addr), HOST);
    assert_int_equal(send_to(there, HOST, ntohs(from.sin_port), "and you"), 0);
    pause_for(WORLD_MS);
    expect(here, "and you");
    assert_int_equal(world_net_count(WORLD_RECEIVED), 2);
    const world_socket_log *log = world_net_sockets();
    assert_int_equal(log->sent[WORLD_RECEIVED], 1);
    assert_int_equal(log->got[WORLD_RECEIVED], 1);
    assert_int_equal(log->next->port, PORT);
}

static void a_datagram_gets_there_and_its_answer_back(void **state)
{
    (void)state;
    run(one_there_and_back);
}

static void many_in_order(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    char text[24];
    eth0->out.jitter_ns = 500 * WORLD_US;
    far->in.jitter_ns = 3 * WORLD_MS;
    for (int i = 0; i < 200; i++) {
        (void)snprintf(text, sizeof text, "%d", i);
        assert_int_equal(send_to(here, SENSOR, PORT, text), 0);
        world_spend(10 * WORLD_US);
    }
    pause_for(WORLD_S);
    for (int i = 0; i < 200; i++) {
        (void)snprintf(text, sizeof text, "%d", i);
        expect(there, text);
    }
}

static void jitter_keeps_the_order(void **state)
{
    (void)state;
    run(many_in_order);
}

static void one_to_oneself(void)
{
    world_file *a = bound(bench, WORLD_LOOPBACK, PORT);
    world_file *b = bound(bench, HOST, PORT);
    world_file *c = open_at(bench);
    assert_int_equal(send_to(c, WORLD_LOOPBACK, PORT, "lo"), 0);
    expect(a, "lo");
    assert_int_equal(ntohl(from.sin_addr.s_addr), WORLD_LOOPBACK);
    assert_int_equal(send_to(c, HOST, PORT, "own"), 0);
    expect(b, "own");
    assert_int_equal(ntohl(from.sin_addr.s_addr), HOST);
    assert_int_equal(receive(a), -EAGAIN);
    /* 0.0.0.0 is oneself. */
    assert_int_equal(send_to(c, 0, PORT, "nought"), 0);
    expect(a, "nought");
    assert_int_equal(send_sized(c, WORLD_LOOPBACK, PORT, 65507), 0);
    assert_int_equal(receive(a), 65507);
    assert_int_equal(send_sized(c, WORLD_LOOPBACK, PORT, 65508), EMSGSIZE);
}

static void a_host_reaches_itself_without_a_wire(void **state)
{
    (void)state;
    run(one_to_oneself);
}

/* --- faults --- */

#define MANY 1000

static void send_many(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    assert_int_equal(set(there, SOL_SOCKET, SO_RCVBUF, 200000), 0);
    for (int i = 0; i < MANY; i++) {
        assert_int_equal(send_to(here, SENSOR, PORT, "0123456789"), 0);
        pause_for(100 * WORLD_US);
        while (receive(there) >= 0) {
        }
    }
    pause_for(WORLD_S);
    while (receive(there) >= 0) {
    }
    assert_int_equal(world_net_count(WORLD_UNDER_WAY), 0);
}

static void lose_out(void)
{
    eth0->out.lose = 0.25;
    send_many();
    assert_in_range(world_net_count(WORLD_LOST_LINK), 180, 320);
    assert_int_equal(world_net_count(WORLD_LOST_LINK) +
                         world_net_count(WORLD_RECEIVED),
                     MANY);
}

static void lose_in(void)
{
    far->in.lose = 0.25;
    send_many();
    assert_in_range(world_net_count(WORLD_LOST_LINK), 180, 320);
}

static void lose_the_other_way(void)
{
    assert_int_equal(send_to(open_at(bench), SENSOR, PORT, "known"), 0);
    pause_for(WORLD_MS);
    eth0->in.lose = 0.9;
    far->out.lose = 0.9;
    send_many();
    assert_int_equal(world_net_count(WORLD_LOST_LINK), 0);
}

static void lose_some(void)
{
    eth0->out.lose_next = 3;
    send_many();
    assert_int_equal(world_net_count(WORLD_LOST_LINK), 3);
    assert_int_equal(eth0->out.lose_next, 0);
}

static bool is_chosen(void *context, const world_datagram *datagram)
{
    (void)context;
    return datagram->number % 10u == 0;
}

static void lose_chosen(void)
{
    far->in.loses = is_chosen;
    send_many();
    assert_int_equal(world_net_count(WORLD_LOST_LINK), MANY / 10);
}

/* Of 41 fragments, each is lost by itself. */
static void lose_fragments(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    know(there);
    eth0->out.lose = 0.02;
    for (int i = 0; i < 100; i++) {
        assert_int_equal(send_sized(here, SENSOR, PORT, 60000), 0);
        pause_for(WORLD_MS);
        (void)receive(there);
    }
    assert_in_range(world_net_count(WORLD_LOST_LINK), 40, 72);
}

static void a_direction_of_a_cable_loses(void **state)
{
    (void)state;
    run(lose_fragments);
    run(lose_out);
    run(lose_in);
    run(lose_the_other_way);
    run(lose_some);
    run(lose_chosen);
}

static void repeat_some(void)
{
    eth0->out.repeat = 0.1;
    far->in.repeat = 0.1;
    send_many();
    assert_in_range(world_net_sent(), MANY + 150, MANY + 280);
    assert_int_equal(world_net_count(WORLD_RECEIVED), world_net_sent());
}

static void a_repeated_datagram_is_a_further_one(void **state)
{
    (void)state;
    run(repeat_some);
}

static void reorder_some(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    char text[24];
    int back = 0;
    int before = -1;
    eth0->out.reorder = 0.1;
    eth0->out.reorder_ns = 2 * WORLD_MS;
    far->in.late = 0.01;
    far->in.late_ns = 50 * WORLD_MS;
    for (int i = 0; i < 200; i++) {
        (void)snprintf(text, sizeof text, "%d", i);
        assert_int_equal(send_to(here, SENSOR, PORT, text), 0);
        pause_for(200 * WORLD_US);
    }
    pause_for(WORLD_S);
    for (int i = 0; i < 200; i++) {
        assert_true(receive(there) > 0);
        const int now = (int)strtol(received, NULL, 10);
        back += now < before ? 1 : 0;
        before = now;
    }
    assert_in_range(back, 5, 40);
    assert_int_equal(world_net_count(WORLD_RECEIVED), 200);
}

static void what_is_held_back_is_overtaken(void **state)
{
    (void)state;
    run(reorder_some);
}

static void corrupt_some(void)
{
    far->in.corrupt = 0.2;
    far->in.pass = 0.1;
    send_many();
    assert_in_range(world_net_count(WORLD_LOST_CHECKSUM), 130, 240);
    assert_in_range(seen.altered, 5, 40);
    assert_int_equal(world_net_count(WORLD_LOST_CHECKSUM) +
                         world_net_count(WORLD_RECEIVED),
                     MANY);
}

/* As Linux: poll() speaks of it, and a receive finds nothing. */
static void corrupt_one(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    far->in.corrupt = 1;
    assert_int_equal(send_to(here, SENSOR, PORT, "hello"), 0);
    pause_for(WORLD_MS);
    assert_int_not_equal(there->kind->poll(there) & POLLIN, 0);
    assert_int_equal(receive(there), -EAGAIN);
    assert_int_equal(drops_of(there), 1);
    there->flags &= ~O_NONBLOCK;
    assert_int_equal(send_to(here, SENSOR, PORT, "hello"), 0);
    pause_for(WORLD_MS);
    assert_int_equal(there->kind->poll(there) & POLLIN, 0);
    /* A closed port does not answer it. */
    assert_int_equal(connect_to(here, SENSOR, PORT + 1), 0);
    assert_int_equal(send_to(here, SENSOR, PORT + 1, "hello"), 0);
    pause_for(WORLD_MS);
    assert_int_equal(get(here, SOL_SOCKET, SO_ERROR), 0);
    assert_int_equal(world_net_count(WORLD_LOST_CHECKSUM), 3);
}

static void repeat_what_is_corrupt(void)
{
    (void)bound(sensor, 0, PORT);
    eth0->out.corrupt = 1;
    far->in.repeat = 1;
    assert_int_equal(send_to(open_at(bench), SENSOR, PORT, "hello"), 0);
    pause_for(WORLD_MS);
    world_file_reset();
    assert_int_equal(world_net_count(WORLD_LOST_CHECKSUM), 2);
}

static void what_is_corrupt_is_dropped_by_its_checksum_nearly_always(
    void **state)
{
    (void)state;
    run(corrupt_some);
    run(corrupt_one);
    run(repeat_what_is_corrupt);
}

static void cut_cables(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    assert_int_equal(send_to(here, SENSOR, PORT, "known"), 0);
    pause_for(WORLD_MS);
    expect(there, "known");
    far->in.is_cut = true;
    assert_int_equal(send_to(here, SENSOR, PORT, "1"), 0);
    assert_int_equal(send_to(there, HOST, PORT, "heard, and closed"), 0);
    pause_for(WORLD_MS);
    assert_int_equal(world_net_count(WORLD_LOST_CUT), 1);
    assert_int_equal(world_net_count(WORLD_LOST_NO_SOCKET), 1);
    far->in.is_cut = false;
    far->island = 1;
    assert_int_equal(send_to(here, SENSOR, PORT, "2"), 0);
    pause_for(WORLD_MS);
    far->island = 0;
    assert_int_equal(send_to(here, SENSOR, PORT, "3"), 0);
    far->in.is_cut = true; /* while it is under way */
    pause_for(WORLD_MS);
    assert_int_equal(world_net_count(WORLD_LOST_CUT), 3);
    world_net_heal();
    assert_false(far->in.is_cut);
    assert_int_equal(send_to(here, SENSOR, PORT, "healed"), 0);
    pause_for(WORLD_MS);
    expect(there, "healed");
    world_interface_set_carrier(far, false);
    assert_int_equal(send_to(here, SENSOR, PORT, "4"), 0);
    world_interface_set_carrier(eth0, false);
    assert_int_equal(send_to(here, SENSOR, PORT, "5"), 0);
    pause_for(WORLD_MS);
    assert_int_equal(world_net_count(WORLD_LOST_CUT), 5);
}

static void nothing_crosses_a_cut(void **state)
{
    (void)state;
    run(cut_cables);
}

/* 1,000 bytes and their headers at 8.336 Mbit/s: one a millisecond. */
static void fill_a_link(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    int sent = 0;
    know(there);
    eth0->out.bits_per_s = 8336000;
    while (send_sized(here, SENSOR, PORT, 1000) == 0) {
        sent++;
    }
    assert_int_equal(errno, EAGAIN);
    assert_int_equal(sent, (212992 + 2303) / 2304);
    assert_int_equal(here->kind->poll(here) & POLLOUT, 0);
    /* There is room, but not yet as much as poll() wants. */
    pause_for(10 * WORLD_MS);
    assert_int_equal(here->kind->poll(here) & POLLOUT, 0);
    pause_for(40 * WORLD_MS + WORLD_US);
    assert_int_not_equal(here->kind->poll(here) & POLLOUT, 0);
    int came = 0;
    while (receive(there) == 1000) {
        came++;
    }
    assert_int_equal(came, 50 - 1);
    pause_for(WORLD_S);
    assert_int_equal(world_net_count(WORLD_UNDER_WAY), sent - came);
}

static void fill_a_queue(void)
{
    world_file *there = bound(sensor, 0, PORT);
    eth0->out.bits_per_s = 1000000;
    for (int i = 0; i < 12; i++) {
        world_file *here = bound(bench, 0, 0);
        for (int k = 0; k < 92; k++) {
            assert_int_equal(send_sized(here, SENSOR, PORT, 1000), 0);
        }
        pause_for(WORLD_MS);
    }
    assert_in_range(world_net_count(WORLD_LOST_QUEUE), 12 * 92 - 1003,
                    12 * 92 - 1000);
    assert_int_equal(receive(there), 1000);
}

static void fill_the_switch(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    far->in.bits_per_s = 8336000;
    for (int i = 0; i < 1100; i++) {
        assert_int_equal(send_sized(here, SENSOR, PORT, 1000), 0);
        pause_for(10 * WORLD_US);
    }
    assert_in_range(world_net_count(WORLD_LOST_QUEUE), 80, 110);
    assert_in_range(receive(there), 1000, 1000);
}

static void bandwidth_fills_the_send_buffer_and_then_the_queue(void **state)
{
    (void)state;
    run(fill_a_link);
    run(fill_a_queue);
    run(fill_the_switch);
}

static void fill_a_buffer(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    const uint32_t on = 1;
    uint8_t control[64];
    assert_int_equal(set(there, SOL_SOCKET, SO_RCVBUF, 20000), 0);
    assert_int_equal(get(there, SOL_SOCKET, SO_RCVBUF), 40000);
    assert_int_equal(set(there, SOL_SOCKET, SO_RXQ_OVFL, (int)on), 0);
    know(there);
    for (int i = 0; i < 100; i++) {
        assert_int_equal(send_sized(here, SENSOR, PORT, 1206), 0);
    }
    pause_for(WORLD_S);
    /* As Linux 6.18 counts 100 of them. */
    assert_int_equal(drops_of(there), 83);
    assert_int_equal(world_net_count(WORLD_LOST_BUFFER), 83);
    assert_int_equal(receive(there), 1206);
    assert_int_equal(send_sized(here, SENSOR, PORT, 1206), 0);
    pause_for(WORLD_S);
    for (int i = 0; i < 16; i++) {
        assert_int_equal(receive(there), 1206);
    }
    struct iovec part = {.iov_base = received, .iov_len = 100};
    struct msghdr message = {.msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control,
                             .msg_controllen = sizeof control};
    assert_int_equal(there->kind->recvmsg(there, &message, 0), 100);
    assert_int_equal(message.msg_flags, MSG_TRUNC);
    const struct cmsghdr *head = CMSG_FIRSTHDR(&message);
    assert_non_null(head);
    uint32_t drops = 0;
    assert_int_equal(head->cmsg_type, SO_RXQ_OVFL);
    memcpy(&drops, CMSG_DATA(head), sizeof drops);
    assert_int_equal(drops, 83);
    const world_socket_log *log = world_net_sockets()->next;
    assert_int_equal(log->got[WORLD_LOST_BUFFER], 83);
    assert_int_equal(log->got[WORLD_RECEIVED], 1 + 18);
}

static void a_full_buffer_drops_and_tells_how_many(void **state)
{
    (void)state;
    run(fill_a_buffer);
}

static void close_early(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(send_to(here, SENSOR, PORT, "unread"), 0);
    }
    pause_for(WORLD_MS);
    assert_int_equal(send_to(here, SENSOR, PORT, "under way"), 0);
    expect(there, "unread");
    world_file_drop(there);
    world_file_drop(here);
    pause_for(WORLD_MS);
    assert_int_equal(world_net_count(WORLD_LOST_UNREAD), 4);
    assert_int_equal(world_net_count(WORLD_LOST_NO_SOCKET), 1);
    assert_int_equal(world_net_count(WORLD_RECEIVED), 1);
}

static void what_was_not_read_before_the_close_is_counted(void **state)
{
    (void)state;
    run(close_early);
}

static uint64_t digest;

static void all_faults(void)
{
    eth0->out.lose = far->in.lose = 0.05;
    eth0->out.repeat = far->in.repeat = 0.05;
    eth0->out.reorder = far->in.reorder = 0.05;
    eth0->out.corrupt = far->in.corrupt = 0.05;
    eth0->out.jitter_ns = WORLD_MS;
    far->in.pass = 0.2;
    far->in.bits_per_s = 10000000;
    send_many();
    digest = world_digest();
}

static void a_seed_gives_one_run(void **state)
{
    (void)state;
    run_with(1, all_faults);
    const uint64_t first = digest;
    run_with(2, all_faults);
    assert_true(first != digest);
    run_with(1, all_faults);
    assert_true(first == digest);
}

/* --- ways --- */

static void closed_ports(void)
{
    world_file *here = open_at(bench);
    world_file *other = open_at(bench);
    assert_int_equal(connect_to(here, SENSOR, PORT), 0);
    assert_int_equal(send_to(here, 0, 0, "x"), 0);
    assert_int_equal(send_to(other, SENSOR, PORT, "x"), 0);
    pause_for(WORLD_MS);
    assert_int_not_equal(here->kind->poll(here) & POLLERR, 0);
    assert_int_equal(receive(here), -ECONNREFUSED);
    assert_int_equal(receive(here), -EAGAIN);
    assert_int_equal(send_to(here, 0, 0, "x"), 0);
    pause_for(WORLD_MS);
    assert_int_equal(send_to(here, 0, 0, "x"), ECONNREFUSED);
    assert_int_equal(send_to(here, 0, 0, "x"), 0);
    pause_for(WORLD_MS);
    assert_int_equal(get(here, SOL_SOCKET, SO_ERROR), ECONNREFUSED);
    assert_int_equal(receive(other), -EAGAIN); /* is not connected */
    eth0->in.is_cut = true;
    assert_int_equal(send_to(here, 0, 0, "x"), 0);
    pause_for(WORLD_MS);
    assert_int_equal(receive(here), -EAGAIN); /* the answer is lost */
    assert_int_equal(world_net_count(WORLD_LOST_NO_SOCKET), 5);
}

static void a_closed_port_refuses_those_that_are_connected(void **state)
{
    (void)state;
    run(closed_ports);
}

static void no_answer(void)
{
    world_file *here = open_at(bench);
    assert_int_equal(connect_to(here, NOBODY, PORT), 0);
    assert_int_equal(send_to(here, 0, 0, "1"), 0);
    pause_for(2990 * WORLD_MS);
    assert_int_equal(send_to(here, 0, 0, "2"), 0);
    assert_int_equal(world_net_count(WORLD_UNDER_WAY), 2);
    pause_for(20 * WORLD_MS);
    assert_int_equal(world_net_count(WORLD_LOST_NO_ANSWER), 2);
    /* As Linux: only those hear of it that asked for all errors. */
    assert_int_equal(receive(here), -EAGAIN);
    assert_int_equal(set(here, IPPROTO_IP, IP_RECVERR, 1), 0);
    assert_int_equal(send_to(here, 0, 0, "3"), 0);
    pause_for(4 * WORLD_S);
    assert_int_equal(receive(here), -EHOSTUNREACH);
    assert_int_equal(world_net_count(WORLD_LOST_NO_ANSWER), 3);
    /* Somebody comes. */
    assert_int_equal(send_to(here, 0, 0, "4"), 0);
    world_interface_add(far, NOBODY, 24);
    world_file *there = bound(sensor, NOBODY, PORT);
    pause_for(2 * WORLD_S);
    expect(there, "4");
    /* And goes: it is believed for a while that it is there. */
    world_interface_remove(far, NOBODY);
    assert_int_equal(send_to(here, 0, 0, "5"), 0);
    pause_for(WORLD_S);
    assert_int_equal(world_net_count(WORLD_LOST_FOREIGN), 1);
    pause_for(60 * WORLD_S);
    assert_int_equal(send_to(here, 0, 0, "6"), 0);
    pause_for(4 * WORLD_S);
    assert_int_equal(world_net_count(WORLD_LOST_NO_ANSWER), 4);
}

static void an_address_that_nobody_has_is_asked_for_three_seconds(void **state)
{
    (void)state;
    run(no_answer);
}

/* Requests and answers of ARP are lost like all else, and asked again. */
static void lost_answers(void)
{
    world_file *there = bound(sensor, 0, PORT);
    far->out.lose = 1;
    assert_int_equal(send_to(open_at(bench), SENSOR, PORT, "1"), 0);
    pause_for(500 * WORLD_MS);
    assert_int_equal(receive(there), -EAGAIN);
    far->out.lose = 0;
    pause_for(WORLD_S);
    expect(there, "1");
    /* Whoever waits for one is lost with the cable. */
    assert_int_equal(send_to(open_at(bench), NOBODY, PORT, "2"), 0);
    world_interface_set_carrier(eth0, false);
    assert_int_equal(world_net_count(WORLD_LOST_CUT), 1);
    world_interface_set_carrier(eth0, true);
    assert_int_equal(send_to(open_at(bench), SENSOR, PORT, "3"), 0);
    pause_for(WORLD_S);
    expect(there, "3");
}

static void arp_is_asked_again_when_it_was_lost(void **state)
{
    (void)state;
    run(lost_answers);
}

static void many_neighbours(void)
{
    world_file *here = open_at(bench);
    world_file *other = NULL;
    world_interface_add(eth0, WORLD_ADDRESS(10, 60, 0, 1), 16);
    assert_int_equal(set(here, IPPROTO_IP, IP_RECVERR, 1), 0);
    for (uint32_t i = 0; i < 1024; i++) {
        if (i % 200 == 0) {
            other = open_at(bench); /* its send buffer has room */
        }
        assert_int_equal(
            send_to(other, WORLD_ADDRESS(10, 60, 1, 0) + i, PORT, "x"), 0);
    }
    assert_int_equal(send_to(here, WORLD_ADDRESS(10, 60, 9, 0), PORT, "x"),
                     ENOBUFS);
    pause_for(4 * WORLD_S);
    assert_int_equal(send_to(here, WORLD_ADDRESS(10, 60, 9, 0), PORT, "x"), 0);
    pause_for(4 * WORLD_S);
    assert_int_equal(world_net_count(WORLD_LOST_NO_ANSWER), 1025);
}

static void the_table_of_neighbours_has_1024(void **state)
{
    (void)state;
    run(many_neighbours);
}

static void wrong_subnets(void)
{
    const uint32_t elsewhere = WORLD_ADDRESS(10, 99, 0, 1);
    world_file *here = open_at(bench);
    assert_int_equal(send_to(here, elsewhere, PORT, "x"), ENETUNREACH);
    assert_int_equal(connect_to(here, elsewhere, PORT), ENETUNREACH);
    assert_int_equal(send_to(here, WORLD_EVERYBODY, PORT, "x"), ENETUNREACH);
    assert_int_equal(send_to(here, SENSOR, 0, "x"), EDESTADDRREQ);
    assert_int_equal(send_to(here, ALL, PORT, "x"), EACCES);
    /* On the link, if the socket says by which interface. */
    assert_int_equal(set_device(here, "eth0"), 0);
    assert_int_equal(send_to(here, elsewhere, PORT, "x"), 0);
    world_interface_set_up(eth0, false);
    assert_int_equal(send_to(here, SENSOR, PORT, "x"), ENETUNREACH);
    world_file *other = open_at(bench);
    assert_int_equal(send_to(other, SENSOR, PORT, "x"), ENETUNREACH);
    assert_int_equal(bind_to(other, HOST, PORT), 0);
    world_interface_set_up(eth0, true);
    assert_int_equal(send_to(other, SENSOR, PORT, "x"), 0);
    world_interface_remove(eth0, HOST);
    world_interface_add(eth0, WORLD_ADDRESS(10, 42, 0, 2), 24);
    assert_int_equal(send_to(other, SENSOR, PORT, "x"), ENETUNREACH);
    world_route_add(eth0, elsewhere, 32, 0);
    world_route_add(eth0, 0, 0, SENSOR);
    world_file *third = open_at(bench);
    assert_int_equal(connect_to(third, elsewhere, PORT), 0);
    world_route_remove(eth0, elsewhere, 32);
    assert_int_equal(send_to(third, elsewhere, PORT, "by a gateway"), 0);
    pause_for(WORLD_S);
    assert_int_equal(world_net_count(WORLD_LOST_FOREIGN), 1);
    /* An interface without an address sends with that of another. */
    world_segment *other_wire = world_segment_new("other");
    world_interface *eth1 = world_interface_new(bench, other_wire, "eth1");
    world_route_add(eth1, NOBODY, 32, 0);
    world_file *fourth = open_at(bench);
    struct sockaddr_in name;
    socklen_t size = sizeof name;
    assert_int_equal(connect_to(fourth, NOBODY, PORT), 0);
    assert_int_equal(
        fourth->kind->getsockname(fourth, (struct sockaddr *)&name, &size), 0);
    assert_int_equal(ntohl(name.sin_addr.s_addr), WORLD_ADDRESS(10, 42, 0, 2));
    world_route_remove(eth0, 0, 0);
    assert_int_equal(send_to(third, elsewhere, PORT, "x"), ENETUNREACH);
}

static void only_what_has_a_way_is_sent(void **state)
{
    (void)state;
    run(wrong_subnets);
}

static void everybody(void)
{
    world_host *third = world_host_new("third");
    world_interface *its = world_interface_new(third, wire, "eth0");
    world_interface_add(its, NOBODY, 24);
    world_file *here = bound(bench, HOST, 0);
    world_file *own = bound(bench, 0, PORT);
    world_file *a = bound(sensor, 0, PORT);
    world_file *b = bound(third, 0, PORT);
    world_file *second = open_at(third);
    world_file *deaf = bound(sensor, SENSOR, PORT + 1);
    assert_int_equal(set(b, SOL_SOCKET, SO_REUSEADDR, 1), 0);
    assert_int_equal(set(second, SOL_SOCKET, SO_REUSEADDR, 1), 0);
    assert_int_equal(bind_to(second, 0, PORT), 0);
    assert_int_equal(set(here, SOL_SOCKET, SO_BROADCAST, 1), 0);
    assert_int_equal(send_to(here, ALL, PORT, "all"), 0);
    pause_for(WORLD_MS);
    expect(own, "all");
    expect(a, "all");
    expect(b, "all");
    expect(second, "all");
    assert_int_equal(world_net_sent(), 4);
    assert_int_equal(send_to(here, WORLD_EVERYBODY, PORT, "everybody"), 0);
    pause_for(WORLD_MS);
    expect(a, "everybody");
    assert_int_equal(send_to(here, ALL, PORT + 1, "who has the address"), 0);
    pause_for(WORLD_MS);
    assert_int_equal(receive(deaf), -EAGAIN);
    assert_int_equal(world_net_count(WORLD_LOST_NO_SOCKET), 2);
}

static void a_broadcast_reaches_all_that_do_not_say_an_address(void **state)
{
    (void)state;
    run(everybody);
}

static void two_ways(void)
{
    world_segment *other_wire = world_segment_new("other");
    world_interface *eth1 = world_interface_new(bench, other_wire, "eth1");
    world_interface *its =
        world_interface_new(world_host_new("other"), other_wire, "eth0");
    world_interface_add(eth1, WORLD_ADDRESS(10, 42, 0, 2), 24);
    world_interface_add(its, SENSOR, 24);
    world_file *there = bound(its->host, 0, PORT);
    world_file *first = bound(sensor, 0, PORT);
    world_file *here = open_at(bench);
    assert_int_equal(send_to(here, SENSOR, PORT, "first"), 0);
    assert_int_equal(set_device(here, "eth7"), ENODEV);
    assert_int_equal(set_device(here, "eth1"), 0);
    assert_int_equal(set_device(here, "eth0"), EPERM);
    assert_int_equal(send_to(here, SENSOR, PORT, "second"), 0);
    world_file *by_index = open_at(bench);
    assert_int_equal(
        set(by_index, IPPROTO_IP, IP_UNICAST_IF, (int)htonl(eth1->index)), 0);
    assert_int_equal(set(by_index, IPPROTO_IP, IP_UNICAST_IF, (int)htonl(77)),
                     EADDRNOTAVAIL);
    assert_int_equal(send_to(by_index, SENSOR, PORT, "third"), 0);
    pause_for(WORLD_MS);
    expect(first, "first");
    expect(there, "second");
    assert_int_equal(ntohl(from.sin_addr.s_addr), WORLD_ADDRESS(10, 42, 0, 2));
    const uint16_t port = ntohs(from.sin_port);
    expect(there, "third");
    /* What comes by another interface is not for a socket of one. */
    assert_int_equal(send_to(first, WORLD_ADDRESS(10, 42, 0, 2), port, "no"),
                     0);
    assert_int_equal(send_to(there, WORLD_ADDRESS(10, 42, 0, 2), port, "yes"),
                     0);
    pause_for(WORLD_MS);
    expect(here, "yes");
    assert_int_equal(receive(here), -EAGAIN);
    world_file *one = open_at(bench);
    world_file *two = open_at(bench);
    assert_int_equal(set_device(one, "eth0"), 0);
    assert_int_equal(set_device(two, "eth1"), 0);
    assert_int_equal(bind_to(one, 0, PORT), 0);
    assert_int_equal(bind_to(two, 0, PORT), 0);
    world_net_rights_of(bench)->may_bind_device = false;
    assert_int_equal(set_device(open_at(bench), "eth0"), EPERM);
}

static void two_interfaces_of_one_subnet_are_told_apart(void **state)
{
    (void)state;
    run(two_ways);
}

/* A sensor's host has no address of its own. */
static void roam(void)
{
    const uint32_t next = WORLD_ADDRESS(192, 168, 7, 9);
    world_interface_remove(far, SENSOR);
    world_interface_roam(far, 24);
    world_file *here = open_at(bench);
    world_file *device = bound(sensor, SENSOR, PORT);
    assert_int_equal(connect_to(here, SENSOR, PORT), 0);
    assert_int_equal(send_to(here, 0, 0, "move"), 0);
    pause_for(WORLD_MS);
    expect(device, "move");
    world_file *moved = bound(sensor, next, PORT);
    assert_int_equal(send_to(device, HOST, ntohs(from.sin_port), "done"), 0);
    world_file_drop(device);
    pause_for(WORLD_MS);
    expect(here, "done");
    assert_int_equal(far->address_count, 1);
    assert_int_equal(connect_to(here, next, PORT), ENETUNREACH);
    world_interface_add(eth0, WORLD_ADDRESS(192, 168, 7, 1), 24);
    world_file *again = open_at(bench);
    assert_int_equal(send_to(again, next, PORT, "found"), 0);
    pause_for(WORLD_MS);
    expect(moved, "found");
    assert_int_equal(send_to(moved, ntohl(from.sin_addr.s_addr),
                             ntohs(from.sin_port), "here"),
                     0);
    pause_for(WORLD_MS);
    expect(again, "here");
    /* Two sockets of one address: it stays for the second. */
    world_file *twin = bound(sensor, next, PORT + 1);
    world_file_drop(moved);
    assert_int_equal(far->address_count, 1);
    world_file_drop(twin);
    assert_int_equal(far->address_count, 0);
    assert_int_equal(bind_to(open_at(bench), next, PORT), EADDRNOTAVAIL);
}

static void a_sensors_address_is_that_of_its_program(void **state)
{
    (void)state;
    run(roam);
}

static unsigned winners;

static void same_address_twice(void)
{
    world_host *third = world_host_new("third");
    world_interface *its = world_interface_new(third, wire, "eth0");
    world_interface_add(its, SENSOR, 24);
    world_file *const one = bound(sensor, 0, PORT);
    world_file *const other = bound(third, 0, PORT);
    assert_int_equal(send_to(open_at(bench), SENSOR, PORT, "who"), 0);
    pause_for(WORLD_MS);
    assert_int_equal(send_to(open_at(bench), SENSOR, PORT, "still"), 0);
    pause_for(WORLD_MS);
    /* The first to answer gets both. */
    world_file *const first = receive(one) > 0 ? one : other;
    assert_true(first == one || receive(other) > 0);
    expect(first, "still");
    /* It is its own address: a stranger with it is not listened to. */
    world_interface_add(eth0, WORLD_ADDRESS(10, 42, 0, 3), 24);
    world_interface_add(its, HOST, 24);
    world_file *strange = bound(third, HOST, 0);
    (void)bound(bench, 0, PORT);
    assert_int_equal(send_to(strange, WORLD_ADDRESS(10, 42, 0, 3), PORT, "x"),
                     0);
    pause_for(WORLD_S);
    assert_int_equal(world_net_count(WORLD_LOST_FOREIGN), 1);
    assert_int_equal(world_net_count(WORLD_UNDER_WAY), 0);
    winners |= first == one ? 1u : 2u;
}

static void one_of_two_with_an_address_gets_it(void **state)
{
    (void)state;
    winners = 0;
    for (uint64_t seed = 1; seed <= 20; seed++) {
        run_with(seed, same_address_twice);
    }
    assert_int_equal(winners, 3);
}

/* --- binding and options --- */

static void binding(void)
{
    world_file *a = open_at(bench);
    struct sockaddr_in in = at(HOST, PORT);
    struct sockaddr_in name;
    socklen_t size = sizeof name;
    assert_int_equal(bind_to(a, NOBODY, PORT), EADDRNOTAVAIL);
    assert_int_equal(bind_to(a, HOST, 80), EACCES);
    in.sin_family = AF_INET6;
    assert_int_equal(a->kind->bind(a, (const struct sockaddr *)&in, sizeof in),
                     -1);
    assert_int_equal(errno, EAFNOSUPPORT);
    assert_int_equal(a->kind->bind(a, (const struct sockaddr *)&in, 8), -1);
    assert_int_equal(errno, EINVAL);
    assert_int_equal(bind_to(a, HOST, PORT), 0);
    assert_int_equal(bind_to(a, HOST, PORT), EINVAL);
    assert_int_equal(bind_to(open_at(bench), HOST, PORT), EADDRINUSE);
    assert_int_equal(bind_to(open_at(bench), 0, PORT), EADDRINUSE);
    assert_int_equal(bind_to(open_at(bench), WORLD_LOOPBACK, PORT), 0);
    assert_int_equal(bind_to(open_at(bench), ALL, PORT), 0);
    world_net_rights_of(bench)->is_root = true;
    assert_int_equal(bind_to(open_at(bench), HOST, 80), 0);
    world_file *any = open_at(bench);
    assert_int_equal(send_to(any, SENSOR, PORT, "x"), 0);
    assert_int_equal(
        any->kind->getsockname(any, (struct sockaddr *)&name, &size), 0);
    assert_in_range(ntohs(name.sin_port), 32768, 60999);
    assert_int_equal(name.sin_addr.s_addr, 0);
    assert_int_equal(connect_to(any, SENSOR, PORT), 0);
    assert_int_equal(
        any->kind->getsockname(any, (struct sockaddr *)&name, &size), 0);
    assert_int_equal(ntohl(name.sin_addr.s_addr), HOST);
    world_file_drop(a);
    assert_int_equal(bind_to(open_at(bench), HOST, PORT), 0);
}

static void a_port_is_bound_as_linux_does_it(void **state)
{
    (void)state;
    run(binding);
}

static void options(void)
{
    world_file *a = open_at(bench);
    assert_int_equal(get(a, SOL_SOCKET, SO_RCVBUF), 212992);
    assert_int_equal(set(a, SOL_SOCKET, SO_RCVBUF, 1), 0);
    assert_int_equal(get(a, SOL_SOCKET, SO_RCVBUF), 2304);
    assert_int_equal(set(a, SOL_SOCKET, SO_RCVBUF, 10000000), 0);
    assert_int_equal(get(a, SOL_SOCKET, SO_RCVBUF), 425984);
    assert_int_equal(set(a, SOL_SOCKET, SO_RCVBUFFORCE, 10000000), EPERM);
    world_net_rights_of(bench)->is_root = true;
    assert_int_equal(set(a, SOL_SOCKET, SO_RCVBUFFORCE, 10000000), 0);
    assert_int_equal(get(a, SOL_SOCKET, SO_RCVBUF), 20000000);
    assert_int_equal(set(a, SOL_SOCKET, SO_SNDBUF, 1), 0);
    assert_int_equal(get(a, SOL_SOCKET, SO_SNDBUF), 4608);
    assert_int_equal(get(a, SOL_SOCKET, SO_TYPE), SOCK_DGRAM);
    assert_int_equal(set(a, SOL_SOCKET, SO_KEEPALIVE, 1), ENOPROTOOPT);
    assert_int_equal(set(a, IPPROTO_TCP, 1, 1), ENOPROTOOPT);
}

static void options_are_those_of_linux(void **state)
{
    (void)state;
    run(options);
}

/* All the control messages that there are. */
static void tell_all(void)
{
    world_file *here = bound(bench, 0, 0);
    world_file *there = bound(sensor, 0, PORT);
    uint8_t control[256];
    struct iovec part = {.iov_base = received, .iov_len = 3};
    struct msghdr message = {.msg_name = &from,
                             .msg_namelen = sizeof from,
                             .msg_iov = &part,
                             .msg_iovlen = 1,
                             .msg_control = control,
                             .msg_controllen = sizeof control};
    assert_int_equal(set(there, SOL_SOCKET, SO_TIMESTAMPNS, 1), 0);
    assert_int_equal(set(there, IPPROTO_IP, IP_PKTINFO, 1), 0);
    world_host_step_utc(sensor, 100 * WORLD_S);
    assert_int_equal(send_to(here, SENSOR, PORT, "hello"), 0);
    pause_for(WORLD_S);
    assert_int_equal(
        there->kind->recvmsg(there, &message, MSG_PEEK | MSG_TRUNC), 5);
    assert_int_equal(message.msg_flags, MSG_TRUNC);
    const struct cmsghdr *head = CMSG_FIRSTHDR(&message);
    struct timespec stamp;
    assert_int_equal(head->cmsg_type, SCM_TIMESTAMPNS);
    memcpy(&stamp, CMSG_DATA(head), sizeof stamp);
    const int64_t age = world_host_utc_ns(sensor) -
                        ((int64_t)stamp.tv_sec * WORLD_S + stamp.tv_nsec);
    assert_in_range(age, 999 * WORLD_MS, WORLD_S);
    struct cmsghdr *next =
        CMSG_NXTHDR(&message, (struct cmsghdr *)(void *)head);
    struct in_pktinfo info;
    assert_int_equal(next->cmsg_type, IP_PKTINFO);
    memcpy(&info, CMSG_DATA(next), sizeof info);
    assert_int_equal(info.ipi_ifindex, far->index);
    assert_int_equal(ntohl(info.ipi_addr.s_addr), SENSOR);
    assert_null(CMSG_NXTHDR(&message, next));
    message.msg_controllen = CMSG_SPACE(sizeof stamp);
    assert_int_equal(there->kind->recvmsg(there, &message, 0), 3);
    assert_int_equal(message.msg_flags, MSG_TRUNC | MSG_CTRUNC);
    assert_int_equal(receive(there), -EAGAIN);
}

static void a_datagram_tells_when_and_where_it_came(void **state)
{
    (void)state;
    run(tell_all);
}

static void wait_with_a_limit(void)
{
    world_file *there = world_udp_file(sensor, O_RDWR);
    const struct timeval limit = {.tv_usec = 250000};
    assert_int_equal(bind_to(there, 0, PORT), 0);
    assert_int_equal(there->kind->setsockopt(there, SOL_SOCKET, SO_RCVTIMEO,
                                             &limit, sizeof limit),
                     0);
    assert_int_equal(receive(there), -EAGAIN);
    assert_int_equal(world_now(), 250 * WORLD_MS);
    assert_int_equal(send_to(open_at(bench), SENSOR, PORT, "x"), 0);
    expect(there, "x");
    assert_in_range(world_now(), 250 * WORLD_MS, 251 * WORLD_MS);
}

static void a_receive_waits_as_long_as_it_may(void **state)
{
    (void)state;
    run(wait_with_a_limit);
}

/* --- the most specific socket --- */

static void choose(void)
{
    world_file *any = open_at(sensor);
    world_file *exact = open_at(sensor);
    world_file *peer = open_at(sensor);
    world_file *const all[] = {peer, exact, any};
    for (size_t i = 0; i < 3; i++) {
        assert_int_equal(set(all[i], SOL_SOCKET, SO_REUSEADDR, 1), 0);
        assert_int_equal(bind_to(all[i], i == 2 ? 0 : SENSOR, PORT), 0);
    }
    world_file *here = bound(bench, 0, 5000);
    world_file *other = bound(bench, 0, 5001);
    assert_int_equal(connect_to(peer, HOST, 5000), 0);
    assert_int_equal(send_to(here, SENSOR, PORT, "peer"), 0);
    assert_int_equal(send_to(other, SENSOR, PORT, "exact"), 0);
    pause_for(WORLD_MS);
    expect(peer, "peer");
    expect(exact, "exact");
    world_file_drop(exact);
    assert_int_equal(send_to(other, SENSOR, PORT, "any"), 0);
    pause_for(WORLD_MS);
    expect(any, "any");
    assert_int_equal(receive(peer), -EAGAIN);
}

static void the_socket_that_says_most_gets_it(void **state)
{
    (void)state;
    run(choose);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_datagram_gets_there_and_its_answer_back),
        cmocka_unit_test(jitter_keeps_the_order),
        cmocka_unit_test(a_host_reaches_itself_without_a_wire),
        cmocka_unit_test(a_direction_of_a_cable_loses),
        cmocka_unit_test(a_repeated_datagram_is_a_further_one),
        cmocka_unit_test(what_is_held_back_is_overtaken),
        cmocka_unit_test(
            what_is_corrupt_is_dropped_by_its_checksum_nearly_always),
        cmocka_unit_test(nothing_crosses_a_cut),
        cmocka_unit_test(bandwidth_fills_the_send_buffer_and_then_the_queue),
        cmocka_unit_test(a_full_buffer_drops_and_tells_how_many),
        cmocka_unit_test(what_was_not_read_before_the_close_is_counted),
        cmocka_unit_test(a_seed_gives_one_run),
        cmocka_unit_test(a_closed_port_refuses_those_that_are_connected),
        cmocka_unit_test(an_address_that_nobody_has_is_asked_for_three_seconds),
        cmocka_unit_test(arp_is_asked_again_when_it_was_lost),
        cmocka_unit_test(the_table_of_neighbours_has_1024),
        cmocka_unit_test(only_what_has_a_way_is_sent),
        cmocka_unit_test(a_broadcast_reaches_all_that_do_not_say_an_address),
        cmocka_unit_test(two_interfaces_of_one_subnet_are_told_apart),
        cmocka_unit_test(a_sensors_address_is_that_of_its_program),
        cmocka_unit_test(one_of_two_with_an_address_gets_it),
        cmocka_unit_test(a_port_is_bound_as_linux_does_it),
        cmocka_unit_test(options_are_those_of_linux),
        cmocka_unit_test(a_datagram_tells_when_and_where_it_came),
        cmocka_unit_test(a_receive_waits_as_long_as_it_may),
        cmocka_unit_test(the_socket_that_says_most_gets_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
