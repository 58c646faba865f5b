#include "net/winsock.h"

#include <errno.h>

/* Older headers lack the name. */
#ifndef SIO_UDP_CONNRESET
#define SIO_UDP_CONNRESET _WSAIOW(IOC_VENDOR, 12)
#endif

typedef struct code_pair {
    int winsock;
    int portable;
} code_pair;

static const code_pair codes[] = {
    {WSAEACCES, EACCES},
    {WSAEADDRINUSE, EADDRINUSE},
    {WSAEADDRNOTAVAIL, EADDRNOTAVAIL},
    {WSAEFAULT, EFAULT},
    {WSAEHOSTUNREACH, EHOSTUNREACH},
    {WSAEINTR, EINTR},
    {WSAEINVAL, EINVAL},
    {WSAEMFILE, EMFILE},
    {WSAEMSGSIZE, EMSGSIZE},
    {WSAENETDOWN, ENETDOWN},
    {WSAENETUNREACH, ENETUNREACH},
    {WSAENOBUFS, ENOBUFS},
    {WSAENOTSOCK, ENOTSOCK},
    {WSAEWOULDBLOCK, EAGAIN},
};

int lum_winsock_start(lum_error *error)
{
    WSADATA data;
    const int code = WSAStartup(MAKEWORD(2, 2), &data);
    if (code != 0) {
        return lum_error_set(error, "cannot start Winsock 2.2: error %d", code);
    }
    return 0;
}

void lum_winsock_stop(void)
{
    (void)WSACleanup();
}

int lum_winsock_errno(void)
{
    const int code = WSAGetLastError();
    for (size_t i = 0; i < sizeof codes / sizeof codes[0]; i++) {
        if (codes[i].winsock == code) {
            return codes[i].portable;
        }
    }
    return code;
}

SOCKET lum_winsock_udp(lum_error *error)
{
    u_long on = 1;
    BOOL off = FALSE;
    DWORD len = 0;
    const SOCKET out = WSASocketW(AF_INET, SOCK_DGRAM, IPPROTO_UDP, NULL, 0, 0);
    if (out == INVALID_SOCKET || ioctlsocket(out, (long)FIONBIO, &on) != 0) {
        (void)lum_error_set(error, "cannot make a UDP socket: Winsock error %d",
                            WSAGetLastError());
        (void)closesocket(out);
        return INVALID_SOCKET;
    }
    (void)SetHandleInformation((HANDLE)out, HANDLE_FLAG_INHERIT, 0);
    (void)WSAIoctl(out, SIO_UDP_CONNRESET, &off, sizeof off, NULL, 0, &len,
                   NULL, NULL);
    return out;
}
