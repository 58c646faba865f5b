/* The WebSocket, as the page asks for it. */
#ifndef LUMVIEW_SOCKET_NAME_H
#define LUMVIEW_SOCKET_NAME_H

#define SOCKET_PATH     "/ws"
#define SOCKET_PROTOCOL "lumview.1"

#endif
