/* Winsock's start, end and errors. */
#ifndef LUM_NET_WINSOCK_H
#define LUM_NET_WINSOCK_H

#ifndef _WIN32_WINNT
#define _WIN32_WINNT 0x0600
#endif
#define WIN32_LEAN_AND_MEAN
#include <winsock2.h>
#include <ws2tcpip.h>

#include "lum/base/error.h"

/* Start Winsock once more; each success wants a lum_winsock_stop(). 0 or -1. */
int lum_winsock_start(lum_error *error);
void lum_winsock_stop(void);

/* The last error as a code of errno.h, or as Winsock's if there is none. */
int lum_winsock_errno(void);

/* A UDP socket that does not block and gets no errors of earlier sends;
 * INVALID_SOCKET and a message. */
SOCKET lum_winsock_udp(lum_error *error);

#endif
