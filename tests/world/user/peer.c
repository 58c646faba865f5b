#include "internal.h"

#include "kernel/net_internal.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/socket.h>

#define MAIL_BYTES 65536

typedef struct noted {
    struct noted *next;
    user_mail mail;
} noted;

struct user_peer {
    world_file *file;
    bool leaves;
    world_task *task;
    void (*answer)(user_peer *peer, const user_mail *mail, void *argument);
    void *argument;
    noted *first, *last;
    size_t count;
};

static struct sockaddr_in to_socket(uint32_t address, uint16_t port)
{
    struct sockaddr_in out;
    memset(&out, 0, sizeof out);
    out.sin_family = AF_INET;
    out.sin_addr.s_addr = htonl(address);
    out.sin_port = htons(port);
    return out;
}

static void note_mail(user_peer *peer, const struct sockaddr_in *from,
                      const void *bytes, size_t size)
{
    noted *n = user_keep(sizeof *n);
    n->mail = (user_mail){.from = ntohl(from->sin_addr.s_addr),
                          .port = ntohs(from->sin_port),
                          .bytes = (uint8_t *)user_keep_text(bytes, size),
                          .size = size};
    if (peer->last != NULL) {
        peer->last->next = n;
    } else {
        peer->first = n;
    }
    peer->last = n;
    peer->count++;
    if (peer->answer != NULL) {
        peer->answer(peer, &n->mail, peer->argument);
    }
    user_has_changed();
}

/* False: nothing is there. */
static bool take_mail(user_peer *peer)
{
    static char bytes[MAIL_BYTES];
    struct sockaddr_in from;
    struct iovec part = {bytes, sizeof bytes};
    struct msghdr message = {.msg_name = &from,
                             .msg_namelen = sizeof from,
                             .msg_iov = &part,
                             .msg_iovlen = 1};
    const ssize_t size =
        peer->file->kind->recvmsg(peer->file, &message, MSG_DONTWAIT);
    if (size >= 0) {
        note_mail(peer, &from, bytes, (size_t)size);
    }
    return size >= 0 || errno != EAGAIN;
}

static void *serve(void *argument)
{
    user_peer *peer = argument;
    while (!peer->leaves) {
        if (!take_mail(peer)) {
            world_wait_deaf(peer->file->changed, WORLD_NEVER);
        }
    }
    world_file_drop(peer->file);
    peer->file = NULL;
    return NULL;
}

user_peer *user_peer_new(world_host *host, const char *address, uint16_t port,
                         void (*answer)(user_peer *peer, const user_mail *mail,
                                        void *argument),
                         void *argument)
{
    user_peer *peer = user_keep(sizeof *peer);
    const struct sockaddr_in at = to_socket(user_ip(address), port);
    peer->file = world_udp_file(host, O_RDWR);
    peer->answer = answer;
    peer->argument = argument;
    if (peer->file->kind->bind(peer->file, (const struct sockaddr *)&at,
                               sizeof at) != 0) {
        user_fail(USER_HERE, "%s:%u: %s", address, (unsigned)port,
                  strerror(errno));
    }
    peer->task = world_task_begin(NULL, serve, peer);
    return peer;
}

uint16_t user_port_of(const user_peer *peer)
{
    struct sockaddr_in at;
    socklen_t size = sizeof at;
    (void)peer->file->kind->getsockname(peer->file, (struct sockaddr *)&at,
                                        &size);
    return ntohs(at.sin_port);
}

void user_send(user_peer *peer, uint32_t to, uint16_t port, const void *bytes,
               size_t size)
{
    struct sockaddr_in at = to_socket(to, port);
    struct iovec part = {(void *)bytes, size};
    const struct msghdr message = {.msg_name = &at,
                                   .msg_namelen = sizeof at,
                                   .msg_iov = &part,
                                   .msg_iovlen = 1};
    if (peer->file != NULL) {
        (void)peer->file->kind->sendmsg(peer->file, &message, MSG_DONTWAIT);
    }
}

size_t user_mails(const user_peer *peer)
{
    return peer->count;
}

const user_mail *user_mail_at(const user_peer *peer, size_t i)
{
    const noted *n = peer->first;
    while (n != NULL && i-- > 0) {
        n = n->next;
    }
    return n != NULL ? &n->mail : NULL;
}

void user_peer_leave(user_peer *peer)
{
    user_trace("a program leaves its port");
    peer->leaves = true;
    if (peer->file != NULL) {
        world_wake_all(peer->file->changed);
        (void)world_task_join(peer->task);
    }
}
