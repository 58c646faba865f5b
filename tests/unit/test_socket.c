#define _GNU_SOURCE

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "lum/base/time.h"
#include "lum/net/socket.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#if defined(__linux__)
#include <linux/filter.h>
#include <linux/seccomp.h>
#include <netinet/in.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#endif

/* What a child says that could not look. */
#define SKIPPED 77

#define NS_PER_MS INT64_C(1000000)

/* Long enough to be seen as a hang. */
#define A_MINUTE (60000 * NS_PER_MS)

/* 127.61.1.1: this test's alone. */
#define HERE UINT32_C(0x7f3d0101)

#if !defined(LUM_TEST_PLAIN)

/* What the kernel was given, and what it says. */
static struct {
    size_t calls;
    size_t messages; /* of all calls */
    bool is_old;     /* it does not know datagrams that are joined */
    int refusal;     /* errno for those that are; 0: it takes them */
    int each;        /* what comes is said to be joined of this size; 0: not */
} kernel;

/* In the place of the C library's. */
int sendmmsg(int fd, struct mmsghdr *messages, unsigned count, int flags)
{
    unsigned n = 0;
    kernel.calls++;
    while (n < count &&
           (kernel.refusal == 0 || messages[n].msg_hdr.msg_controllen == 0)) {
        n++;
    }
    kernel.messages += n;
    if (n == 0) {
        errno = kernel.refusal;
        return -1;
    }
    return (int)syscall(SYS_sendmmsg, fd, messages, n, flags);
}

/* Says that a message consists of datagrams of this size. */
static void say_joined(struct msghdr *message, size_t room)
{
    struct cmsghdr head = {.cmsg_len = CMSG_LEN(sizeof kernel.each),
                           .cmsg_level = IPPROTO_UDP,
                           .cmsg_type = 104 /* UDP_GRO */};
    uint8_t *at = (uint8_t *)message->msg_control + message->msg_controllen;
    assert_true(room - message->msg_controllen >=
                CMSG_SPACE(sizeof kernel.each));
    memcpy(at, &head, sizeof head);
    memcpy(at + CMSG_LEN(0), &kernel.each, sizeof kernel.each);
    message->msg_controllen += CMSG_SPACE(sizeof kernel.each);
}

int recvmmsg(int fd, struct mmsghdr *messages, unsigned count, int flags,
             struct timespec *wait)
{
    const size_t room = messages[0].msg_hdr.msg_controllen;
    const int n = (int)syscall(SYS_recvmmsg, fd, messages, count, flags, wait);
    for (int i = 0; i < n && kernel.each != 0; i++) {
        say_joined(&messages[i].msg_hdr, room);
    }
    return n;
}

int setsockopt(int fd, int level, int name, const void *value, socklen_t len)
{
    if (kernel.is_old && level == IPPROTO_UDP) {
        errno = ENOPROTOOPT;
        return -1;
    }
    return (int)syscall(SYS_setsockopt, fd, level, name, value, len);
}

#endif

static lum_socket *open_with(const lum_socket_options *options)
{
    lum_socket *socket = NULL;
    lum_error error = {""};
    if (lum_socket_open(options, &socket, &error) != LUM_NET_OK) {
        fail_msg("%s", error.text);
    }
    assert_string_equal(error.text, "");
    return socket;
}

static lum_socket *open_here(size_t receive_buffer)
{
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .local = {.address = HERE},
                                        .receive_buffer = receive_buffer};
    return open_with(&options);
}

static lum_socket *open_for_joined(size_t receive_buffer)
{
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .local = {.address = HERE},
                                        .receive_buffer = receive_buffer,
                                        .takes_joined = true};
    return open_with(&options);
}

static lum_endpoint end_of(const lum_socket *socket)
{
    lum_endpoint local;
    lum_socket_local(socket, &local);
    return local;
}

static void send_bytes(lum_socket *from, const lum_socket *to,
                       const void *bytes, size_t len)
{
    lum_error error = {""};
    const lum_outgoing datagram = {
        .bytes = bytes, .len = len, .to = end_of(to)};
    assert_int_equal(lum_socket_send(from, &datagram, &error), LUM_NET_OK);
    assert_string_equal(error.text, "");
}

/* Numbers first..first + count - 1, a datagram each. */
static void send_numbers(lum_socket *from, const lum_socket *to, uint32_t first,
                         size_t count)
{
    uint32_t numbers[LUM_SOCKET_BATCH];
    lum_outgoing datagrams[LUM_SOCKET_BATCH];
    size_t sent = 0;
    for (size_t i = 0; i < count; i++) {
        numbers[i] = first + (uint32_t)i;
        datagrams[i] = (lum_outgoing){
            .bytes = &numbers[i], .len = sizeof numbers[i], .to = end_of(to)};
    }
    assert_int_equal(lum_socket_send_batch(from, datagrams, count, &sent, NULL),
                     LUM_NET_OK);
    assert_int_equal(sent, count);
}

static lum_received *receive(lum_socket *socket, size_t count)
{
    lum_received *out = NULL;
    lum_error error = {""};
    size_t got = 99;
    assert_int_equal(lum_socket_receive(socket, &out, &got, &error),
                     LUM_NET_OK);
    assert_string_equal(error.text, "");
    assert_int_equal(got, count);
    return out;
}

static uint32_t number_in(const lum_received *datagram)
{
    uint32_t number = 0;
    assert_int_equal(datagram->len, sizeof number);
    memcpy(&number, datagram->bytes, sizeof number);
    return number;
}

static lum_net_result refuse(const lum_socket_options *options,
                             lum_error *error)
{
    lum_socket *socket = NULL;
    const int before = dup(STDIN_FILENO);
    close(before);
    const lum_net_result result = lum_socket_open(options, &socket, error);
    const int after = dup(STDIN_FILENO);
    close(after);
    assert_null(socket);
    assert_int_equal(before, after);
    return result;
}

static void expect_says(const lum_error *error, const char *says)
{
    if (strstr(error->text, says) == NULL) {
        fail_msg("\"%s\" does not say \"%s\"", error->text, says);
    }
}

/* Run in a child, which may give up rights. */
static void expect_in_child(int (*run)(void))
{
    int status = -1;
    fflush(NULL);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        _exit(run());
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    if (WEXITSTATUS(status) == SKIPPED) {
        skip();
    }
    assert_int_equal(WEXITSTATUS(status), 0);
}

static long number_from(const char *path)
{
    long number = -1;
    FILE *file = fopen(path, "r");
    if (file != NULL) {
        char text[32] = "";
        text[fread(text, 1, sizeof text - 1u, file)] = '\0';
        number = strtol(text, NULL, 10);
        fclose(file);
    }
    return number;
}

static void datagrams_come_in_order_with_their_sender(void **state)
{
    (void)state;
    lum_socket *to = open_here(0);
    lum_socket *from = open_here(0);
    for (uint32_t i = 0; i < 5; i++) {
        send_numbers(from, to, 1000 + i, 1);
    }
    const lum_received *got = receive(to, 5);
    for (uint32_t i = 0; i < 5; i++) {
        assert_int_equal(number_in(&got[i]), 1000 + i);
        assert_int_equal(got[i].from.address, HERE);
        assert_int_equal(got[i].from.port, end_of(from).port);
        assert_false(got[i].cut_short);
    }
    receive(to, 0);
    receive(from, 0);
    lum_socket_close(to);
    lum_socket_close(from);
    lum_socket_close(NULL);
}

static void a_receive_takes_no_more_than_a_batch(void **state)
{
    static const size_t batches[] = {64, 64, 22};
    uint32_t next = 7;
    (void)state;
    lum_socket *to = open_here(1u << 20);
    lum_socket *from = open_here(0);
    for (size_t i = 0; i < 3; i++) {
        send_numbers(from, to, next, batches[i]);
        next += (uint32_t)batches[i];
    }
    next = 7;
    for (size_t i = 0; i < 3; i++) {
        const lum_received *got = receive(to, batches[i]);
        for (size_t j = 0; j < batches[i]; j++) {
            assert_int_equal(number_in(&got[j]), next++);
        }
    }
    receive(to, 0);
    lum_socket_close(to);
    lum_socket_close(from);
}

static void expect_long_ones_to_be_cut(lum_socket *to)
{
    static const size_t sizes[] = {LUM_SOCKET_BYTES + 1u, LUM_SOCKET_BYTES, 0,
                                   60000, 1};
    static uint8_t bytes[60000];
    lum_socket *from = open_here(0);
    for (size_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = (uint8_t)(i * 31u >> 3);
    }
    for (size_t i = 0; i < 5; i++) {
        send_bytes(from, to, bytes, sizes[i]);
    }
    const lum_received *got = receive(to, 5);
    for (size_t i = 0; i < 5; i++) {
        const bool cut = sizes[i] > LUM_SOCKET_BYTES;
        assert_int_equal(got[i].cut_short, cut);
        assert_int_equal(got[i].len, cut ? LUM_SOCKET_BYTES : sizes[i]);
        assert_memory_equal(got[i].bytes, bytes, got[i].len);
    }
    lum_socket_close(to);
    lum_socket_close(from);
}

static void what_is_too_long_is_cut_and_marked(void **state)
{
    (void)state;
    expect_long_ones_to_be_cut(open_here(1u << 20));
    expect_long_ones_to_be_cut(open_for_joined(1u << 20));
}

/* The clock may be set, and the kernel's time stamps take a moment to begin,
 * so one good attempt is enough. */
static bool time_is_of_the_arrival(lum_socket *from, lum_socket *to)
{
    const int64_t before = lum_time_utc_ns();
    send_numbers(from, to, 1, 1);
    const int64_t sent = lum_time_utc_ns();
    lum_time_sleep_until(lum_time_monotonic_ns() + 2 * NS_PER_MS);
    const int64_t at = receive(to, 1)->utc_ns;
    /* Some systems tell microseconds. */
    return at >= before - 1000 && at <= sent;
}

static void arrivals_have_the_time_when_the_kernel_had_them(void **state)
{
    bool good = false;
    (void)state;
    lum_socket *to = open_here(0);
    lum_socket *from = open_here(0);
    for (int i = 0; i < 200 && !good; i++) {
        good = time_is_of_the_arrival(from, to);
    }
    assert_true(good);
    lum_socket_close(to);
    lum_socket_close(from);
}

static size_t receive_all(lum_socket *socket)
{
    lum_received *out = NULL;
    size_t all = 0;
    for (size_t got = 1; got > 0; all += got) {
        assert_int_equal(lum_socket_receive(socket, &out, &got, NULL),
                         LUM_NET_OK);
    }
    return all;
}

static void what_was_sent_was_received_or_counted_as_dropped(void **state)
{
    static const uint8_t bytes[1000];
    uint64_t sent = 0;
    uint64_t received = 0;
    uint64_t drops = 0;
    (void)state;
    lum_socket *to = open_here(8192);
    lum_socket *from = open_here(0);
#if defined(LUM_TEST_PLAIN)
    assert_false(lum_socket_counts_drops(to));
    assert_true(lum_socket_drops(to) == 0);
    lum_socket_close(to);
    lum_socket_close(from);
    skip();
#endif
    assert_true(lum_socket_counts_drops(to));
    assert_true(lum_socket_drops(to) == 0);
    for (int round = 0; round < 3; round++) {
        for (int i = 0; i < 300; i++, sent++) {
            send_bytes(from, to, bytes, sizeof bytes);
        }
        /* Now, not with a datagram that comes later. */
        const uint64_t before = lum_socket_drops(to);
        assert_true(before > drops);
        received += receive_all(to);
        drops = lum_socket_drops(to);
        assert_true(drops == before);
        assert_true(received > 0);
        assert_true(received + drops == sent);
    }
    lum_socket_close(to);
    lum_socket_close(from);
}

static void what_the_kernel_granted_is_looked_at(void **state)
{
    static const size_t asked[] = {0, 1u << 16, 1u << 20, 1u << 25, INT_MAX};
    (void)state;
    for (size_t i = 0; i < sizeof asked / sizeof asked[0]; i++) {
        lum_socket *socket = open_here(asked[i]);
        const size_t granted = lum_socket_receive_buffer(socket);
        assert_true(granted > 0);
#if defined(LUM_TEST_PLAIN)
        assert_int_equal(lum_socket_has_room(socket), granted >= asked[i]);
#else
        assert_int_equal(lum_socket_has_room(socket), granted / 2 >= asked[i]);
        assert_true(lum_socket_has_room(socket) || asked[i] > 1u << 16);
        assert_true(!lum_socket_has_room(socket) || asked[i] < INT_MAX);
#endif
        lum_socket_close(socket);
    }
}

static int ask_for_more_than_allowed(void)
{
    const long most = number_from("/proc/sys/net/core/rmem_max");
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .local = {.address = HERE},
                                        .receive_buffer = (size_t)most * 4u};
    lum_socket *socket = NULL;
    if (most <= 0 || most > INT_MAX / 8 ||
        (geteuid() == 0 && setuid(65534) != 0)) {
        return SKIPPED;
    }
    if (lum_socket_open(&options, &socket, NULL) != LUM_NET_OK) {
        return 1;
    }
    const bool has_room = lum_socket_has_room(socket);
    const size_t granted = lum_socket_receive_buffer(socket);
    lum_socket_close(socket);
    return has_room || granted != 2u * (size_t)most;
}

static void a_buffer_that_was_not_granted_is_told(void **state)
{
    (void)state;
    expect_in_child(ask_for_more_than_allowed);
}

/* What a real stream needs: the requested amount of payload, in datagrams of
 * full size, without a drop. */
static void the_room_holds_the_payload_asked_for(void **state)
{
    static const uint8_t bytes[1472];
    const size_t room = 2u << 20;
    (void)state;
    lum_socket *to = open_here(room);
    lum_socket *from = open_here(0);
    if (!lum_socket_has_room(to)) {
        lum_socket_close(to);
        lum_socket_close(from);
        skip();
    }
    const size_t count = room / sizeof bytes;
    for (size_t i = 0; i < count; i++) {
        send_bytes(from, to, bytes, sizeof bytes);
    }
    assert_true(lum_socket_drops(to) == 0);
    assert_int_equal(receive_all(to), count);
    lum_socket_close(to);
    lum_socket_close(from);
}

#if defined(LUM_TEST_PLAIN)

static void own_name(char *out, size_t room)
{
    snprintf(out, room, "another program");
}

#else

/* Under valgrind and emulators the program has another name. */
static void own_name(char *out, size_t room)
{
    char name[32] = "";
    FILE *file = fopen("/proc/self/comm", "r");
    assert_non_null(file);
    assert_non_null(fgets(name, sizeof name, file));
    fclose(file);
    name[strcspn(name, "\n")] = '\0';
    snprintf(out, room, "%s (process %ld)", name, (long)getpid());
}

#endif

static void a_port_that_is_taken_names_the_program(void **state)
{
    lum_error error = {""};
    char name[64];
    char says[160];
    (void)state;
    lum_socket *first = open_here(0);
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .local = end_of(first)};
    assert_int_equal(refuse(&options, &error), LUM_NET_BUSY);
    own_name(name, sizeof name);
    snprintf(says, sizeof says, "UDP port 127.61.1.1:%u is taken by %s: ",
             (unsigned)options.local.port, name);
    expect_says(&error, says);
    const lum_socket_options any = {.struct_size = sizeof any,
                                    .local = {.port = options.local.port}};
    assert_int_equal(refuse(&any, &error), LUM_NET_BUSY);
    lum_socket_close(first);
    lum_socket_close(open_with(&options));
}

#if !defined(LUM_TEST_PLAIN)

/* A child that opens and closes sockets until it is killed. */
static pid_t start_churn(void)
{
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .local = {.address = HERE}};
    lum_socket *sockets[100] = {NULL};
    fflush(NULL);
    const pid_t child = fork();
    if (child != 0) {
        return child;
    }
    (void)prctl(PR_SET_PDEATHSIG, SIGKILL);
    for (size_t i = 0;; i = (i + 37) % 100) {
        lum_socket_close(sockets[i]);
        if (lum_socket_open(&options, &sockets[i], NULL) != LUM_NET_OK) {
            _exit(1);
        }
    }
}

static void a_port_has_its_program_while_others_come_and_go(void **state)
{
    char name[64];
    lum_error error = {""};
    int status = 0;
    (void)state;
    own_name(name, sizeof name);
    const pid_t child = start_churn(); /* which must not have the socket */
    assert_true(child > 0);
    lum_socket *first = open_here(0);
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .local = end_of(first)};
    bool is_named = true;
    for (int i = 0; i < 300 && is_named; i++) {
        lum_socket *second = NULL;
        is_named = lum_socket_open(&options, &second, &error) == LUM_NET_BUSY &&
                   strstr(error.text, name) != NULL;
    }
    (void)kill(child, SIGKILL);
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status));
    assert_true(is_named);
    expect_says(&error, name);
    lum_socket_close(first);
}

#endif

static void an_interface_that_is_not_there_is_refused(void **state)
{
    lum_error error = {""};
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .interface_name = "nonesuch0"};
    (void)state;
    assert_int_equal(refuse(&options, &error), LUM_NET_FAILED);
    expect_says(&error, "there is no interface nonesuch0; this host has: ");
    expect_says(&error, "lo");
}

static void an_address_of_another_host_is_refused(void **state)
{
    lum_error error = {""};
    const lum_socket_options options = {
        .struct_size = sizeof options,
        .local = {.address = UINT32_C(0xc0000201), .port = 5517}};
    (void)state;
    assert_int_equal(refuse(&options, &error), LUM_NET_FAILED);
    expect_says(&error, "cannot use UDP port 192.0.2.1:5517: no interface of "
                        "this host has that address");
}

static int open_a_low_port(void)
{
    lum_error error = {""};
    lum_socket *socket = NULL;
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .local = {HERE, 100}};
    if (number_from("/proc/sys/net/ipv4/ip_unprivileged_port_start") <= 100 ||
        (geteuid() == 0 && setuid(65534) != 0)) {
        return SKIPPED;
    }
    return lum_socket_open(&options, &socket, &error) != LUM_NET_DENIED ||
           strstr(error.text, "no permission for UDP port 127.61.1.1:100") ==
               NULL;
}

static void a_low_port_needs_permission(void **state)
{
    (void)state;
    expect_in_child(open_a_low_port);
}

static void expect_unsent(lum_socket *socket, size_t len, lum_endpoint to,
                          const char *says)
{
    static const uint8_t bytes[70000];
    lum_error error = {""};
    const lum_outgoing datagram = {.bytes = bytes, .len = len, .to = to};
    assert_int_equal(lum_socket_send(socket, &datagram, &error),
                     LUM_NET_FAILED);
    expect_says(&error, says);
}

static void what_cannot_be_sent_has_a_message(void **state)
{
    const lum_endpoint outside = {UINT32_C(0xc0000201), 5517};
    (void)state;
    lum_socket *socket = open_here(0);
    expect_unsent(socket, 70000, end_of(socket),
                  "cannot send 70000 bytes to 127.61.1.1:");
    expect_unsent(socket, 70000, end_of(socket), "it is too long");
    expect_unsent(socket, 4, outside,
                  "cannot send 4 bytes to 192.0.2.1:5517: ");
    expect_unsent(socket, 4, (lum_endpoint){HERE, 0}, "look at address, port");
    send_numbers(socket, socket, 1, 1);
    receive(socket, 1);
    lum_socket_close(socket);
}

static void a_batch_ends_at_the_first_that_cannot_leave(void **state)
{
    const uint32_t number = 5;
    lum_outgoing datagrams[4];
    lum_error error = {""};
    size_t sent = 99;
    (void)state;
    lum_socket *socket = open_here(0);
    for (size_t i = 0; i < 4; i++) {
        datagrams[i] = (lum_outgoing){&number, sizeof number, end_of(socket)};
    }
    datagrams[2].to.port = 0;
    assert_int_equal(lum_socket_send_batch(socket, datagrams, 4, &sent, &error),
                     LUM_NET_FAILED);
    assert_int_equal(sent, 2);
    expect_says(&error, "127.61.1.1:0: ");
    receive(socket, 2);
    assert_int_equal(lum_socket_send_batch(socket, datagrams, 0, &sent, NULL),
                     LUM_NET_OK);
    assert_int_equal(sent, 0);
    assert_int_equal(lum_socket_send_batch(socket, datagrams,
                                           LUM_SOCKET_BATCH + 1u, &sent, NULL),
                     LUM_NET_FAILED);
    lum_socket_close(socket);
}

/* Datagram i of the batch below is bytes i..; each case is the first of a run,
 * in a run, or ends one. */
static const size_t run_sizes[] = {40, 40, 40, 40, 7,    40,   40,   41,
                                   0,  0,  1,  1,  1,    9,    200,  9,
                                   9,  9,  9,  9,  1472, 1472, 1472, 1471};

#define RUN_COUNT (sizeof run_sizes / sizeof run_sizes[0])

/* Those that are one message with others: 40*4 7, 40*2, 1*3, 200 9, 9*4,
 * 1472*3 1471. */
#define RUN_JOINED (5u + 2u + 3u + 2u + 4u + 4u)

static const uint8_t *run_bytes(size_t i)
{
    static uint8_t bytes[2048];
    for (size_t k = 0; bytes[1] == 0 && k < sizeof bytes; k++) {
        bytes[k] = (uint8_t)(k * 29u >> 2);
    }
    return bytes + i;
}

static void send_runs(lum_socket *from, const lum_socket *to)
{
    lum_outgoing datagrams[RUN_COUNT];
    lum_error error = {""};
    size_t sent = 0;
    for (size_t i = 0; i < RUN_COUNT; i++) {
        datagrams[i] = (lum_outgoing){run_bytes(i), run_sizes[i], end_of(to)};
    }
    assert_int_equal(
        lum_socket_send_batch(from, datagrams, RUN_COUNT, &sent, &error),
        LUM_NET_OK);
    assert_int_equal(sent, RUN_COUNT);
}

static void expect_run(const lum_received *got, size_t i)
{
    assert_int_equal(got->len, run_sizes[i]);
    assert_memory_equal(got->bytes, run_bytes(i), run_sizes[i]);
    assert_false(got->cut_short);
}

static void expect_runs(lum_socket *to)
{
    const lum_received *got = receive(to, RUN_COUNT);
    for (size_t i = 0; i < RUN_COUNT; i++) {
        expect_run(&got[i], i);
    }
}

static void a_batch_comes_as_the_datagrams_that_it_was(void **state)
{
    (void)state;
    lum_socket *to = open_here(1u << 20);
    lum_socket *from = open_here(0);
    for (int round = 0; round < 3; round++) {
        send_runs(from, to);
        expect_runs(to);
    }
    lum_socket_close(to);
    lum_socket_close(from);
}

static void each_datagram_of_a_batch_goes_where_it_should(void **state)
{
    uint32_t numbers[12];
    lum_outgoing datagrams[12];
    size_t sent = 0;
    (void)state;
    lum_socket *to[] = {open_here(0), open_here(0)};
    lum_socket *from = open_here(0);
    for (uint32_t i = 0; i < 12; i++) {
        numbers[i] = i;
        datagrams[i] = (lum_outgoing){&numbers[i], sizeof numbers[i],
                                      end_of(to[i / 3 % 2])};
    }
    assert_int_equal(lum_socket_send_batch(from, datagrams, 12, &sent, NULL),
                     LUM_NET_OK);
    for (uint32_t k = 0; k < 2; k++) {
        const lum_received *got = receive(to[k], 6);
        for (uint32_t i = 0; i < 6; i++) {
            assert_int_equal(number_in(&got[i]), i + 3 * (i / 3) + 3 * k);
        }
        lum_socket_close(to[k]);
    }
    lum_socket_close(from);
}

#if !defined(LUM_TEST_PLAIN)

static lum_socket *open_to_send_joined(void)
{
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .local = {.address = HERE},
                                        .sends_joined = true};
    return open_with(&options);
}

static void datagrams_of_one_size_are_one_message(void **state)
{
    (void)state;
    lum_socket *to = open_here(1u << 20);
    lum_socket *from = open_to_send_joined();
    memset(&kernel, 0, sizeof kernel);
    send_numbers(from, to, 0, LUM_SOCKET_BATCH);
    assert_int_equal(kernel.messages, 1);
    receive(to, LUM_SOCKET_BATCH);
    memset(&kernel, 0, sizeof kernel);
    send_runs(from, to);
    /* 40*4 7, 40*2, 41, 0, 0, 1*3, 9, 200 9, 9*4, 1472*3 1471 */
    assert_int_equal(kernel.messages, 10);
    expect_runs(to);
    lum_socket_close(to);
    lum_socket_close(from);
}

/* Joined, they would be more than a datagram can be. */
static void long_datagrams_are_several_messages(void **state)
{
    static uint8_t bytes[9000];
    lum_outgoing datagrams[16];
    size_t sent = 0;
    (void)state;
    lum_socket *to = open_here(1u << 20);
    lum_socket *from = open_to_send_joined();
    for (size_t i = 0; i < 16; i++) {
        datagrams[i] = (lum_outgoing){bytes, sizeof bytes, end_of(to)};
    }
    memset(&kernel, 0, sizeof kernel);
    assert_int_equal(lum_socket_send_batch(from, datagrams, 16, &sent, NULL),
                     LUM_NET_OK);
    assert_int_equal(kernel.messages, 3);
    const lum_received *got = receive(to, 16);
    for (size_t i = 0; i < 16; i++) {
        assert_int_equal(got[i].len, sizeof bytes);
    }
    lum_socket_close(to);
    lum_socket_close(from);
}

static void what_cannot_be_joined_there_goes_one_by_one(void **state)
{
    static const int codes[] = {EIO, EINVAL, EMSGSIZE, EOPNOTSUPP};
    (void)state;
    lum_socket *to = open_here(1u << 20);
    for (size_t i = 0; i < sizeof codes / sizeof codes[0]; i++) {
        lum_socket *from = open_to_send_joined();
        memset(&kernel, 0, sizeof kernel);
        kernel.refusal = codes[i];
        send_runs(from, to);
        expect_runs(to);
        kernel.refusal = 0;
        kernel.calls = 0;
        kernel.messages = 0;
        send_runs(from, to);
        assert_int_equal(kernel.messages, RUN_COUNT);
        assert_int_equal(kernel.calls, 1);
        expect_runs(to);
        lum_socket_close(from);
    }
    lum_socket_close(to);
}

static void what_the_kernel_joined_is_taken_apart(void **state)
{
    (void)state;
    lum_socket *to = open_for_joined(1u << 20);
    lum_socket *from = open_to_send_joined();
    for (uint64_t round = 1; round <= 3; round++) {
        const int64_t before = lum_time_utc_ns() - NS_PER_MS;
        send_runs(from, to);
        const lum_received *got = receive(to, RUN_COUNT);
        for (size_t i = 0; i < RUN_COUNT; i++) {
            expect_run(&got[i], i);
            assert_int_equal(got[i].from.address, HERE);
            assert_int_equal(got[i].from.port, end_of(from).port);
            assert_true(got[i].utc_ns >= before);
        }
        assert_true(lum_socket_joined(to) == round * RUN_JOINED);
    }
    assert_true(lum_socket_drops(to) == 0);
    lum_socket_close(to);
    lum_socket_close(from);
}

static void a_receive_may_give_more_than_a_batch_of_joined_ones(void **state)
{
    enum {
        BATCHES = 70
    };
    uint32_t next = 0;
    (void)state;
    lum_socket *to = open_for_joined(1u << 22);
    lum_socket *from = open_to_send_joined();
    for (uint32_t i = 0; i < BATCHES; i++) {
        send_numbers(from, to, i * LUM_SOCKET_BATCH, LUM_SOCKET_BATCH);
    }
    const size_t all = (size_t)BATCHES * LUM_SOCKET_BATCH;
    const size_t first = (size_t)LUM_SOCKET_BATCH * LUM_SOCKET_BATCH;
    const lum_received *got = receive(to, first);
    while (next < first) {
        assert_int_equal(number_in(&got[next]), next);
        next++;
    }
    got = receive(to, all - first);
    for (size_t i = 0; next < all; i++) {
        assert_int_equal(number_in(&got[i]), next++);
    }
    receive(to, 0);
    assert_true(lum_socket_joined(to) == all);
    lum_socket_close(to);
    lum_socket_close(from);
}

/* The kernel counts those that it joined as one. */
static void drops_of_joined_ones_are_a_lower_bound(void **state)
{
    uint64_t received = 0;
    const uint64_t sent = UINT64_C(300) * LUM_SOCKET_BATCH;
    (void)state;
    lum_socket *to = open_for_joined(8192);
    lum_socket *from = open_to_send_joined();
    for (uint32_t i = 0; i < 300; i++) {
        send_numbers(from, to, i, LUM_SOCKET_BATCH);
    }
    received = receive_all(to);
    assert_true(received > 0);
    assert_true(lum_socket_joined(to) == received);
    assert_true(lum_socket_drops(to) > 0);
    assert_true(received + lum_socket_drops(to) < sent);
    lum_socket_close(to);
    lum_socket_close(from);
}

static void nothing_is_joined_unless_it_is_asked_for(void **state)
{
    (void)state;
    lum_socket *to = open_here(1u << 20);
    lum_socket *from = open_to_send_joined();
    send_runs(from, to);
    receive(to, RUN_COUNT);
    assert_true(lum_socket_joined(to) == 0);
    lum_socket *plain = open_here(0);
    memset(&kernel, 0, sizeof kernel);
    send_runs(plain, to);
    assert_int_equal(kernel.messages, RUN_COUNT);
    receive(to, RUN_COUNT);
    lum_socket_close(plain);
    lum_socket_close(to);
    lum_socket_close(from);
}

/* No kernel does this. */
static void more_joined_ones_than_there_is_room_for_are_marked(void **state)
{
    static uint8_t bytes[300];
    (void)state;
    lum_socket *to = open_for_joined(1u << 20);
    lum_socket *from = open_to_send_joined();
    for (size_t i = 0; i < sizeof bytes; i++) {
        bytes[i] = (uint8_t)i;
    }
    send_bytes(from, to, bytes, sizeof bytes);
    kernel.each = 1;
    const lum_received *got = receive(to, 128);
    kernel.each = 0;
    for (size_t i = 0; i < 128; i++) {
        assert_int_equal(got[i].len, i < 127 ? 1 : sizeof bytes - 127);
        assert_int_equal(got[i].bytes[0], bytes[i]);
        assert_int_equal(got[i].cut_short, i == 127);
    }
    lum_socket_close(to);
    lum_socket_close(from);
}

static void an_old_kernel_gets_nothing_joined(void **state)
{
    (void)state;
    memset(&kernel, 0, sizeof kernel);
    kernel.is_old = true;
    lum_socket *to = open_here(1u << 20);
    lum_socket *from = open_to_send_joined();
    send_runs(from, to);
    assert_int_equal(kernel.messages, RUN_COUNT);
    expect_runs(to);
    lum_socket_close(to);
    to = open_for_joined(1u << 20);
    send_runs(from, to);
    expect_runs(to);
    assert_true(lum_socket_joined(to) == 0);
    kernel.is_old = false;
    lum_socket_close(to);
    lum_socket_close(from);
}

#endif

static void a_port_that_nobody_listens_at_is_no_failure(void **state)
{
    (void)state;
    lum_socket *to = open_here(0);
    lum_socket *from = open_here(0);
    const uint32_t number = 1;
    const lum_outgoing datagram = {&number, sizeof number, end_of(to)};
    lum_socket_close(to);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(lum_socket_send(from, &datagram, NULL), LUM_NET_OK);
        receive(from, 0);
    }
    send_numbers(from, from, 8, 1);
    assert_int_equal(number_in(receive(from, 1)), 8);
    lum_socket_close(from);
}

static lum_net_result wait_for(lum_socket *const *sockets, size_t count,
                               int extra_fd, const lum_cancel *cancel,
                               int64_t ns)
{
    return lum_socket_wait(sockets, count, extra_fd, cancel,
                           lum_time_monotonic_ns() + ns);
}

static void a_wait_ends_when_any_socket_has_something(void **state)
{
    (void)state;
    lum_socket *both[] = {open_here(0), open_here(0)};
    assert_int_equal(wait_for(both, 2, -1, NULL, 0), LUM_NET_TIMEOUT);
    for (size_t i = 0; i < 2; i++) {
        send_numbers(both[0], both[i], 4, 1);
        assert_int_equal(wait_for(both, 2, -1, NULL, A_MINUTE), LUM_NET_OK);
        receive(both[1 - i], 0);
        receive(both[i], 1);
        assert_int_equal(wait_for(both, 2, -1, NULL, 0), LUM_NET_TIMEOUT);
    }
    lum_socket_close(both[0]);
    lum_socket_close(both[1]);
}

static void a_wait_ends_at_its_deadline_and_not_before(void **state)
{
    (void)state;
    lum_socket *socket = open_here(0);
    const int64_t deadline = lum_time_monotonic_ns() + 20 * NS_PER_MS + 1;
    assert_int_equal(lum_socket_wait(&socket, 1, -1, NULL, deadline),
                     LUM_NET_TIMEOUT);
    assert_true(lum_time_monotonic_ns() >= deadline);
    assert_int_equal(lum_socket_wait(&socket, 1, -1, NULL, INT64_MIN),
                     LUM_NET_TIMEOUT);
    send_numbers(socket, socket, 1, 1);
    assert_int_equal(lum_socket_wait(&socket, 1, -1, NULL, INT64_MAX),
                     LUM_NET_OK);
    assert_int_equal(lum_socket_wait(&socket, 1, -1, NULL, 0), LUM_NET_OK);
    lum_socket_close(socket);
}

static void a_cancel_comes_before_data(void **state)
{
    lum_cancel *cancel = NULL;
    (void)state;
    assert_int_equal(lum_cancel_new(&cancel, NULL), 0);
    lum_socket *socket = open_here(0);
    send_numbers(socket, socket, 1, 1);
    assert_int_equal(wait_for(&socket, 1, -1, cancel, A_MINUTE), LUM_NET_OK);
    lum_cancel_raise(cancel);
    assert_int_equal(wait_for(&socket, 1, -1, cancel, A_MINUTE),
                     LUM_NET_CANCELLED);
    lum_cancel_reset(cancel);
    assert_int_equal(wait_for(&socket, 1, -1, cancel, A_MINUTE), LUM_NET_OK);
    lum_socket_close(socket);
    lum_cancel_free(cancel);
}

static void input_elsewhere_ends_a_wait_too(void **state)
{
    int ends[2];
    (void)state;
    lum_socket *socket = open_here(0);
    assert_int_equal(pipe(ends), 0);
    assert_int_equal(wait_for(&socket, 1, ends[0], NULL, 0), LUM_NET_TIMEOUT);
    assert_int_equal(write(ends[1], "x", 1), 1);
    assert_int_equal(wait_for(&socket, 1, ends[0], NULL, A_MINUTE), LUM_NET_OK);
    close(ends[1]);
    assert_int_equal(wait_for(&socket, 1, ends[0], NULL, A_MINUTE), LUM_NET_OK);
    close(ends[0]);
    assert_int_equal(wait_for(&socket, 1, ends[0], NULL, A_MINUTE),
                     LUM_NET_FAILED);
    lum_socket_close(socket);
}

static void a_wait_has_a_limit_of_sockets(void **state)
{
    lum_socket *many[LUM_SOCKET_WAIT_MAX + 1u];
    (void)state;
    for (size_t i = 0; i < LUM_SOCKET_WAIT_MAX + 1u; i++) {
        many[i] = open_here(0);
    }
    send_numbers(many[0], many[LUM_SOCKET_WAIT_MAX - 1u], 1, 1);
    assert_int_equal(wait_for(many, LUM_SOCKET_WAIT_MAX, -1, NULL, A_MINUTE),
                     LUM_NET_OK);
    assert_int_equal(wait_for(many, LUM_SOCKET_WAIT_MAX + 1u, -1, NULL, 0),
                     LUM_NET_FAILED);
    for (size_t i = 0; i < LUM_SOCKET_WAIT_MAX + 1u; i++) {
        lum_socket_close(many[i]);
    }
}

static void programs_that_are_started_do_not_get_the_descriptor(void **state)
{
    (void)state;
    const int fd = dup(STDIN_FILENO);
    close(fd);
    lum_socket *socket = open_here(0);
    assert_int_equal(fcntl(fd, F_GETFD) & FD_CLOEXEC, FD_CLOEXEC);
    assert_int_equal(fcntl(fd, F_GETFL) & O_NONBLOCK, O_NONBLOCK);
    lum_socket_close(socket);
}

static void the_loopback_can_be_named(void **state)
{
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .local = {.address = HERE},
                                        .interface_name = "lo"};
    (void)state;
    lum_socket *to = open_with(&options);
    lum_socket *from = open_here(0);
    send_numbers(from, to, 3, 2);
    assert_int_equal(number_in(receive(to, 2)), 3);
    send_numbers(to, from, 5, 1);
    receive(from, 1);
    lum_socket_close(to);
    lum_socket_close(from);
}

#if !defined(LUM_TEST_PLAIN)

static bool other_interface(char *name)
{
    struct if_nameindex *all = if_nameindex();
    bool found = false;
    for (size_t i = 0; all != NULL && all[i].if_index != 0 && !found; i++) {
        found = strcmp(all[i].if_name, "lo") != 0;
        if (found) {
            snprintf(name, IF_NAMESIZE, "%s", all[i].if_name);
        }
    }
    if_freenameindex(all);
    return found;
}

/* How many of two datagrams from the loopback come to a socket that is for one
 * interface alone; negative: it cannot be opened. */
static int count_on(const char *interface)
{
    const lum_socket_options to_options = {.struct_size = sizeof to_options,
                                           .interface_name = interface};
    const lum_socket_options from_options = {.struct_size = sizeof from_options,
                                             .local = {.address = HERE}};
    lum_socket *to = NULL;
    lum_socket *from = NULL;
    lum_received *out = NULL;
    size_t sent = 0;
    size_t got = 0;
    if (lum_socket_open(&to_options, &to, NULL) != LUM_NET_OK ||
        lum_socket_open(&from_options, &from, NULL) != LUM_NET_OK) {
        return -1;
    }
    const lum_endpoint there = {HERE, end_of(to).port};
    const lum_outgoing two[] = {{"a", 1, there}, {"b", 1, there}};
    if (lum_socket_send_batch(from, two, 2, &sent, NULL) != LUM_NET_OK ||
        lum_socket_receive(to, &out, &got, NULL) != LUM_NET_OK) {
        return -2;
    }
    lum_socket_close(to);
    lum_socket_close(from);
    return (int)got;
}

static int count_on_both(void)
{
    char other[IF_NAMESIZE];
    if (!other_interface(other)) {
        return SKIPPED;
    }
    return count_on("lo") != 2 || count_on(other) != 0;
}

static void only_what_comes_on_the_interface_is_received(void **state)
{
    (void)state;
    expect_in_child(count_on_both);
}

/* As on systems that lack an option, or have it for root alone: a call with it
 * is not permitted. The filter reads the half of an argument that is the lower
 * one on little-endian machines. */
static bool forbid(uint32_t call, uint32_t option)
{
    const uint16_t one = 1;
    struct sock_filter code[] = {
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(struct seccomp_data, nr)),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, call, 0, 3),
        BPF_STMT(BPF_LD | BPF_W | BPF_ABS,
                 offsetof(struct seccomp_data, args[2])),
        BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, option, 0, 1),
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | 1u), /* EPERM */
        BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
    };
    const struct sock_fprog program = {
        .len = (unsigned short)(sizeof code / sizeof code[0]), .filter = code};
    return *(const uint8_t *)&one == 1 &&
           prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 &&
           prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program, 0, 0) == 0;
}

static int count_without_the_right(void)
{
    const int fd = socket(AF_INET, SOCK_DGRAM, 0);
    if (!forbid(SYS_setsockopt, SO_BINDTODEVICE) ||
        setsockopt(fd, SOL_SOCKET, SO_BINDTODEVICE, "lo", 2) == 0) {
        return SKIPPED;
    }
    return count_on_both();
}

static void without_the_right_to_bind_it_is_the_same(void **state)
{
    (void)state;
    expect_in_child(count_without_the_right);
}

/* A datagram reports the drops before it. */
static bool counts_drops_with_arrivals(lum_socket *to, lum_socket *from)
{
    static const uint8_t bytes[1000];
    for (int i = 0; i < 300; i++) {
        send_bytes(from, to, bytes, sizeof bytes);
    }
    if (!lum_socket_counts_drops(to) || lum_socket_drops(to) != 0) {
        return false;
    }
    size_t received = receive_all(to);
    send_bytes(from, to, bytes, sizeof bytes);
    received += receive_all(to);
    return lum_socket_drops(to) != 0 && lum_socket_drops(to) + received == 301u;
}

static int count_drops_with_arrivals(void)
{
    lum_socket *to = open_here(8192);
    lum_socket *from = open_here(0);
    const int option = 55; /* SO_MEMINFO */
    uint32_t values[16];
    socklen_t len = sizeof values;
    int result = SKIPPED;
    if (forbid(SYS_getsockopt, (uint32_t)option) &&
        getsockopt(STDIN_FILENO, SOL_SOCKET, option, values, &len) != 0 &&
        errno == EPERM) {
        result = counts_drops_with_arrivals(to, from) ? 0 : 1;
    }
    lum_socket_close(to);
    lum_socket_close(from);
    return result;
}

static void drops_are_told_by_the_next_datagram_at_the_latest(void **state)
{
    (void)state;
    expect_in_child(count_drops_with_arrivals);
}

static int send_without_a_network(void)
{
    const lum_socket_options options = {.struct_size = sizeof options,
                                        .receive_buffer = 0};
    const lum_outgoing datagram = {"x", 1, {UINT32_C(0x0a2a0025), 5517}};
    lum_socket *socket = NULL;
    lum_error error = {""};
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
        return SKIPPED;
    }
    if (lum_socket_open(&options, &socket, &error) != LUM_NET_OK) {
        return 1;
    }
    const lum_net_result result = lum_socket_send(socket, &datagram, &error);
    lum_socket_close(socket);
    return result != LUM_NET_FAILED ||
           strstr(error.text, "cannot send 1 bytes to 10.42.0.37:5517: this "
                              "host has no route there") == NULL;
}

static void without_a_route_the_message_says_so(void **state)
{
    (void)state;
    expect_in_child(send_without_a_network);
}

#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(datagrams_come_in_order_with_their_sender),
        cmocka_unit_test(a_receive_takes_no_more_than_a_batch),
        cmocka_unit_test(what_is_too_long_is_cut_and_marked),
        cmocka_unit_test(arrivals_have_the_time_when_the_kernel_had_them),
        cmocka_unit_test(what_was_sent_was_received_or_counted_as_dropped),
        cmocka_unit_test(what_the_kernel_granted_is_looked_at),
        cmocka_unit_test(a_buffer_that_was_not_granted_is_told),
        cmocka_unit_test(the_room_holds_the_payload_asked_for),
        cmocka_unit_test(a_port_that_is_taken_names_the_program),
#if !defined(LUM_TEST_PLAIN)
        cmocka_unit_test(a_port_has_its_program_while_others_come_and_go),
#endif
        cmocka_unit_test(an_interface_that_is_not_there_is_refused),
        cmocka_unit_test(an_address_of_another_host_is_refused),
        cmocka_unit_test(a_low_port_needs_permission),
        cmocka_unit_test(what_cannot_be_sent_has_a_message),
        cmocka_unit_test(a_batch_ends_at_the_first_that_cannot_leave),
        cmocka_unit_test(a_batch_comes_as_the_datagrams_that_it_was),
        cmocka_unit_test(each_datagram_of_a_batch_goes_where_it_should),
        cmocka_unit_test(a_port_that_nobody_listens_at_is_no_failure),
        cmocka_unit_test(a_wait_ends_when_any_socket_has_something),
        cmocka_unit_test(a_wait_ends_at_its_deadline_and_not_before),
        cmocka_unit_test(a_cancel_comes_before_data),
        cmocka_unit_test(input_elsewhere_ends_a_wait_too),
        cmocka_unit_test(a_wait_has_a_limit_of_sockets),
        cmocka_unit_test(programs_that_are_started_do_not_get_the_descriptor),
        cmocka_unit_test(the_loopback_can_be_named),
#if !defined(LUM_TEST_PLAIN)
        cmocka_unit_test(datagrams_of_one_size_are_one_message),
        cmocka_unit_test(long_datagrams_are_several_messages),
        cmocka_unit_test(what_cannot_be_joined_there_goes_one_by_one),
        cmocka_unit_test(what_the_kernel_joined_is_taken_apart),
        cmocka_unit_test(a_receive_may_give_more_than_a_batch_of_joined_ones),
        cmocka_unit_test(drops_of_joined_ones_are_a_lower_bound),
        cmocka_unit_test(nothing_is_joined_unless_it_is_asked_for),
        cmocka_unit_test(more_joined_ones_than_there_is_room_for_are_marked),
        cmocka_unit_test(an_old_kernel_gets_nothing_joined),
        cmocka_unit_test(only_what_comes_on_the_interface_is_received),
        cmocka_unit_test(without_the_right_to_bind_it_is_the_same),
        cmocka_unit_test(drops_are_told_by_the_next_datagram_at_the_latest),
        cmocka_unit_test(without_a_route_the_message_says_so),
#endif
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
