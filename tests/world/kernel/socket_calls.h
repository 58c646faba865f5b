/* Calls of processes about sockets, interfaces and names, as Linux has them. */
#ifndef WORLD_SOCKET_CALLS_H
#define WORLD_SOCKET_CALLS_H

#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <sys/socket.h>
#include <time.h>

int world_call_socket(int domain, int type, int protocol);
int world_call_bind(int fd, const struct sockaddr *address, socklen_t size);
int world_call_connect(int fd, const struct sockaddr *address, socklen_t size);
int world_call_listen(int fd, int backlog);
int world_call_accept(int fd, struct sockaddr *address, socklen_t *size);
int world_call_shutdown(int fd, int how);
int world_call_getsockname(int fd, struct sockaddr *out, socklen_t *size);
int world_call_getpeername(int fd, struct sockaddr *out, socklen_t *size);
int world_call_setsockopt(int fd, int level, int name, const void *value,
                          socklen_t size);
int world_call_getsockopt(int fd, int level, int name, void *value,
                          socklen_t *size);
ssize_t world_call_sendmsg(int fd, const struct msghdr *message, int flags);
ssize_t world_call_sendto(int fd, const void *bytes, size_t size, int flags,
                          const struct sockaddr *to, socklen_t to_size);
ssize_t world_call_send(int fd, const void *bytes, size_t size, int flags);
int world_call_sendmmsg(int fd, struct mmsghdr *messages, unsigned count,
                        int flags);
ssize_t world_call_recvmsg(int fd, struct msghdr *message, int flags);
ssize_t world_call_recvfrom(int fd, void *out, size_t size, int flags,
                            struct sockaddr *from, socklen_t *from_size);
ssize_t world_call_recv(int fd, void *out, size_t size, int flags);
int world_call_recvmmsg(int fd, struct mmsghdr *messages, unsigned count,
                        int flags, struct timespec *limit);

int world_call_getifaddrs(struct ifaddrs **out);
void world_call_freeifaddrs(struct ifaddrs *list);
unsigned world_call_if_nametoindex(const char *name);
char *world_call_if_indextoname(unsigned index, char *out);
struct if_nameindex *world_call_if_nameindex(void);
void world_call_if_freenameindex(struct if_nameindex *list);

int world_call_getaddrinfo(const char *node, const char *service,
                           const struct addrinfo *hints, struct addrinfo **out);
void world_call_freeaddrinfo(struct addrinfo *list);

#endif
