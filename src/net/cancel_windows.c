/* A wait that another thread can end, on Windows. */
#include "net/socket_system.h"

#include <stdlib.h>

/* A UDP socket that is connected to itself, and raised while there is a
 * datagram in it: a wait can look at it beside others. */
struct lum_cancel {
    SOCKET socket;
};

static int connect_to_itself(SOCKET socket)
{
    const lum_endpoint loopback = {.address = INADDR_LOOPBACK};
    struct sockaddr_in address = lum_sockaddr_of(loopback);
    int len = sizeof address;
    if (bind(socket, (const struct sockaddr *)&address, len) != 0 ||
        getsockname(socket, (struct sockaddr *)&address, &len) != 0) {
        return -1;
    }
    return connect(socket, (const struct sockaddr *)&address, len);
}

static int open_socket(lum_cancel *cancel, lum_error *error)
{
    cancel->socket = lum_winsock_udp(error);
    if (cancel->socket == INVALID_SOCKET) {
        return -1;
    }
    if (connect_to_itself(cancel->socket) != 0) {
        (void)closesocket(cancel->socket);
        return lum_error_set(error,
                             "cannot set up a cancel's socket at 127.0.0.1: "
                             "Winsock error %d",
                             WSAGetLastError());
    }
    return 0;
}

int lum_cancel_new(lum_cancel **out, lum_error *error)
{
    lum_cancel *cancel = malloc(sizeof *cancel);
    if (cancel == NULL) {
        return lum_error_set(error, "no memory left for a cancel");
    }
    if (lum_winsock_start(error) != 0) {
        free(cancel);
        return -1;
    }
    if (open_socket(cancel, error) != 0) {
        lum_winsock_stop();
        free(cancel);
        return -1;
    }
    *out = cancel;
    return 0;
}

void lum_cancel_free(lum_cancel *cancel)
{
    if (cancel != NULL) {
        (void)closesocket(cancel->socket);
        lum_winsock_stop();
        free(cancel);
    }
}

/* A buffer that is full is raised too. */
void lum_cancel_raise(lum_cancel *cancel)
{
    if (cancel != NULL) {
        const int kept = WSAGetLastError();
        (void)send(cancel->socket, "", 1, 0);
        WSASetLastError(kept);
    }
}

bool lum_cancel_is_raised(const lum_cancel *cancel)
{
    if (cancel == NULL) {
        return false;
    }
    WSAPOLLFD look = {.fd = cancel->socket, .events = POLLIN};
    return WSAPoll(&look, 1, 0) > 0;
}

void lum_cancel_reset(lum_cancel *cancel)
{
    char byte = 0;
    while (recv(cancel->socket, &byte, 1, 0) >= 0) {
    }
}

intptr_t lum_cancel_handle(const lum_cancel *cancel)
{
    return (intptr_t)cancel->socket;
}
