#include "net/socket_messages.h"
#include "net/endpoint.h"
#include "net/program.h"

#include <errno.h>
#include <string.h>

static lum_net_result say_taken(lum_endpoint local, lum_error *error)
{
    (void)lum_error_set(error,
                        "UDP port %s is taken by %s: end it, or use another "
                        "address or port",
                        lum_endpoint_show(local).text,
                        lum_program_show(lum_program_of_port(local)).text);
    return LUM_NET_BUSY;
}

lum_net_result lum_socket_say_unbound(lum_endpoint local, int code,
                                      lum_error *error)
{
    const lum_endpoint_text where = lum_endpoint_show(local);
    if (code == EADDRINUSE) {
        return say_taken(local, error);
    }
    if (code == EACCES || code == EPERM) {
        (void)lum_error_set(error,
                            "no permission for UDP port %s: use a port above "
                            "1023, or run with more rights",
                            where.text);
        return LUM_NET_DENIED;
    }
    if (code == EADDRNOTAVAIL) {
        (void)lum_error_set(error,
                            "cannot use UDP port %s: no interface of this "
                            "host has that address",
                            where.text);
    } else {
        (void)lum_error_set(error, "cannot use UDP port %s: %s", where.text,
                            strerror(code));
    }
    return LUM_NET_FAILED;
}

/* What a send's error means, and what helps. */
typedef struct send_error {
    int code;
    lum_net_result result;
    const char *says;
} send_error;

static const send_error send_errors[] = {
    {EPERM, LUM_NET_DENIED, "the firewall of this host forbids it"},
    {EACCES, LUM_NET_DENIED,
     "it is a broadcast address, or the firewall of this host forbids it"},
    {ENETUNREACH, LUM_NET_FAILED,
     "this host has no route there; give an interface an address in that "
     "network"},
    {EHOSTUNREACH, LUM_NET_FAILED,
     "the host does not answer on the local network; look at cable, power and "
     "address"},
    {ENETDOWN, LUM_NET_FAILED, "the interface is down"},
    {ENODEV, LUM_NET_FAILED, "the interface is gone"},
    {ENXIO, LUM_NET_FAILED, "the interface is gone"},
    {EADDRNOTAVAIL, LUM_NET_FAILED,
     "this host has lost the address that the socket is bound to"},
    {EMSGSIZE, LUM_NET_FAILED, "it is too long for a datagram"},
    {EINVAL, LUM_NET_FAILED,
     "it cannot be reached from there; look at address, port and interface"},
    {EAGAIN, LUM_NET_FAILED,
     "the send buffer is full; the link is slower than the data"},
    {EWOULDBLOCK, LUM_NET_FAILED,
     "the send buffer is full; the link is slower than the data"},
    {ENOBUFS, LUM_NET_FAILED,
     "the interface's queue is full; the link is slower than the data"},
};

lum_net_result lum_socket_say_unsent(const lum_outgoing *datagram, int code,
                                     lum_error *error)
{
    const char *says = strerror(code);
    lum_net_result result = LUM_NET_FAILED;
    for (size_t i = 0; i < sizeof send_errors / sizeof send_errors[0]; i++) {
        if (send_errors[i].code == code) {
            says = send_errors[i].says;
            result = send_errors[i].result;
            break;
        }
    }
    (void)lum_error_set(error, "cannot send %lu bytes to %s: %s",
                        (unsigned long)datagram->len,
                        lum_endpoint_show(datagram->to).text, says);
    return result;
}

lum_net_result lum_socket_say_too_many(size_t count, lum_error *error)
{
    (void)lum_error_set(error, "%lu datagrams in one send, at most %u",
                        (unsigned long)count, LUM_SOCKET_BATCH);
    return LUM_NET_FAILED;
}

lum_net_result lum_socket_say_broken(lum_endpoint local, int code,
                                     lum_error *error)
{
    (void)lum_error_set(error, "cannot receive at %s any more: %s",
                        lum_endpoint_show(local).text, strerror(code));
    return LUM_NET_FAILED;
}

lum_net_result lum_socket_say_no_interface(const char *name, const char *list,
                                           lum_error *error)
{
    (void)lum_error_set(error, "there is no interface %s; this host has: %s",
                        name, list);
    return LUM_NET_FAILED;
}
