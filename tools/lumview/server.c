#define _POSIX_C_SOURCE 200809L
#include "server.h"

#include "../common/interrupt.h"
#include "../common/number.h"
#include "client.h"
#include "crowd.h"
#include "http.h"
#include "place.h"

#include <libwebsockets.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <sys/socket.h>

#define HEADERS_BYTES 8192u
#define IDLE_S        5 /* for a request to come, and for the next */
#define PING_S        5 /* without a sign of life */
#define HANGUP_S      20
#define TICK_US       500000

struct server {
    struct lws_context *lws;
    struct lws_vhost *host;
    struct guard guard;
    struct clients clients;
    struct lws_protocol_vhost_options headers[5];
    char policy[HTTP_POLICY_BYTES];
    lws_sorted_usec_list_t tick;
    struct crowd crowd;
    uint32_t arriving; /* address of the connection that is being accepted */
};

static struct server *server_of(struct lws *wsi)
{
    return lws_context_user(lws_get_context(wsi));
}

/* 0 where it is gone already. */
static uint32_t find_peer(lws_sockfd_type fd)
{
    struct sockaddr_in peer = {.sin_family = AF_INET};
    socklen_t len = sizeof peer;
    return getpeername(fd, (struct sockaddr *)&peer, &len) == 0
               ? ntohl(peer.sin_addr.s_addr)
               : 0;
}

/* What a callback returns: 0, it may come in. */
static int admit(struct server *server, lws_sockfd_type fd)
{
    server->arriving = find_peer(fd);
    return crowd_has_room(&server->crowd, server->arriving) ? 0 : 1;
}

/* Right after it was admitted. */
static int enter(struct lws *wsi)
{
    struct server *server = server_of(wsi);
    struct crowd_place *place = crowd_enter(&server->crowd, server->arriving);
    lws_set_opaque_user_data(wsi, place);
    return place != NULL ? 0 : -1;
}

/* The socket that listens has no place. */
static void leave(struct lws *wsi)
{
    struct crowd_place *place = lws_get_opaque_user_data(wsi);
    if (place != NULL) {
        place->is_taken = false;
    }
}

static int serve_http(struct lws *wsi, enum lws_callback_reasons reason,
                      void *user, void *in, size_t len)
{
    struct server *server = server_of(wsi);
    (void)len;
    switch (reason) {
    case LWS_CALLBACK_FILTER_NETWORK_CONNECTION:
        return admit(server, (lws_sockfd_type)(intptr_t)in);
    case LWS_CALLBACK_SERVER_NEW_CLIENT_INSTANTIATED:
        return enter(wsi);
    case LWS_CALLBACK_WSI_DESTROY:
        leave(wsi);
        return 0;
    case LWS_CALLBACK_HTTP_CONFIRM_UPGRADE:
        return http_check_upgrade(wsi, &server->guard, in);
    case LWS_CALLBACK_HTTP:
        return http_begin(wsi, &server->guard,
                          server->clients.viewers.options->beside.served, in,
                          user);
    case LWS_CALLBACK_HTTP_WRITEABLE:
        return http_go_on(wsi, user);
    case LWS_CALLBACK_HTTP_BODY:
    case LWS_CALLBACK_HTTP_BODY_COMPLETION:
        return -1;
    case LWS_CALLBACK_EVENT_WAIT_CANCELLED:
        clients_wake(&server->clients);
        return 0;
    default:
        return 0;
    }
}

static int serve_socket(struct lws *wsi, enum lws_callback_reasons reason,
                        void *user, void *in, size_t len)
{
    struct clients *clients = &server_of(wsi)->clients;
    switch (reason) {
    case LWS_CALLBACK_ESTABLISHED:
        clients_add(clients, user, wsi);
        return 0;
    case LWS_CALLBACK_CLOSED:
        clients_remove(clients, user);
        return 0;
    case LWS_CALLBACK_SERVER_WRITEABLE:
        return clients_write(clients, user);
    case LWS_CALLBACK_RECEIVE:
        clients_read(clients, user, in, len);
        return 0;
    default:
        return 0;
    }
}

static const struct lws_protocols protocols[] = {
    {.name = "http",
     .callback = serve_http,
     .per_session_data_size = sizeof(struct http_answer)},
    {.name = SOCKET_PROTOCOL,
     .callback = serve_socket,
     .per_session_data_size = sizeof(struct client),
     .rx_buffer_size = 4096},
    {.name = NULL},
};

static const lws_retry_bo_t patience = {
    .secs_since_valid_ping = PING_S,
    .secs_since_valid_hangup = HANGUP_S,
};

static void on_tick(lws_sorted_usec_list_t *tick)
{
    struct server *server = lws_container_of(tick, struct server, tick);
    clients_tick(&server->clients);
    lws_sul_schedule(server->lws, 0, tick, on_tick, TICK_US);
}

/* Headers that every answer has, also those that libwebsockets makes. */
static void set_headers(struct server *server)
{
    const struct lws_protocol_vhost_options headers[] = {
        {.name = "content-security-policy:", .value = server->policy},
        {.name = "x-content-type-options:", .value = "nosniff"},
        {.name = "referrer-policy:", .value = "no-referrer"},
        {.name = "cross-origin-opener-policy:", .value = "same-origin"},
        {.name = "cross-origin-resource-policy:", .value = "same-origin"},
    };
    const size_t count = sizeof headers / sizeof headers[0];
    for (size_t i = 0; i < count; i++) {
        server->headers[i] = headers[i];
        server->headers[i].next =
            i + 1u < count ? &server->headers[i + 1u] : NULL;
    }
}

static int make_token(struct server *server)
{
    static const char digits[] = "0123456789abcdef";
    unsigned char bytes[GUARD_TOKEN_DIGITS / 2u];
    if (lws_get_random(server->lws, bytes, sizeof bytes) != sizeof bytes) {
        return -1;
    }
    for (size_t i = 0; i < GUARD_TOKEN_DIGITS; i++) {
        server->guard.token[i] = digits[bytes[i / 2u] >> 4u * (i % 2u) & 15u];
    }
    server->guard.token[GUARD_TOKEN_DIGITS] = '\0';
    return 0;
}

static int listen_there(struct server *server,
                        const struct lws_context_creation_info *info,
                        lum_error *error)
{
    server->host = lws_create_vhost(server->lws, info);
    if (server->host == NULL) {
        return lum_error_set(error, "%s:%u: cannot be listened on",
                             number_address(server->guard.address).text,
                             (unsigned)server->guard.port);
    }
    return 0;
}

static int start(struct server *server, lum_error *error)
{
    const struct number_address address = number_address(server->guard.address);
    const struct lws_context_creation_info info = {
        .iface = address.text,
        .port = server->guard.port,
        .protocols = protocols,
        .headers = server->headers,
        .max_http_header_data2 = HEADERS_BYTES,
        .timeout_secs = IDLE_S,
        .timeout_secs_ah_idle = IDLE_S,
        .keepalive_timeout = IDLE_S,
        .retry_and_idle_policy = &patience,
        .gid = -1,
        .uid = -1,
        .user = server,
        .options = LWS_SERVER_OPTION_EXPLICIT_VHOSTS |
                   LWS_SERVER_OPTION_SKIP_SERVER_CANONICAL_NAME |
                   LWS_SERVER_OPTION_DISABLE_IPV6 |
                   LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND,
    };
    server->lws = lws_create_context(&info);
    if (server->lws == NULL) {
        return lum_error_set(error, "libwebsockets cannot start");
    }
    return listen_there(server, &info, error);
}

int server_open(const struct options *options, struct server **out,
                lum_error *error)
{
    struct server *server = calloc(1, sizeof *server);
    *out = server;
    if (server == NULL || clients_init(&server->clients, options) != 0) {
        return lum_error_set(error, "no memory for the server");
    }
    lws_set_log_level(0, NULL);
    set_headers(server);
    if (place_find(&options->listen, &server->guard.address,
                   &server->guard.port, error) != 0 ||
        start(server, error) != 0) {
        return -1;
    }
    if (options->listen.has_address && make_token(server) != 0) {
        return lum_error_set(error, "the system has no randomness for a token");
    }
    http_policy(&server->guard, server->policy);
    return 0;
}

void server_close(struct server *server)
{
    if (server != NULL) {
        if (server->lws != NULL) {
            lws_context_destroy(server->lws);
        }
        clients_free(&server->clients);
        free(server);
    }
}

const struct guard *server_guard(const struct server *server)
{
    return &server->guard;
}

void server_wake(void *server)
{
    lws_cancel_service(((struct server *)server)->lws);
}

int server_run(struct server *server, struct feed *feed, lum_error *error)
{
    int failed = 0;
    server->clients.viewers.feed = feed;
    clients_tick(&server->clients);
    lws_sul_schedule(server->lws, 0, &server->tick, on_tick, TICK_US);
    while (failed == 0 && interrupt_signal() == 0) {
        failed = lws_service(server->lws, 0) < 0 ? -1 : 0;
    }
    lws_sul_schedule(server->lws, 0, &server->tick, on_tick,
                     LWS_SET_TIMER_USEC_CANCEL);
    server->clients.viewers.feed = NULL;
    return failed == 0 ? 0
                       : lum_error_set(error, "the server broke down: "
                                              "libwebsockets cannot go on");
}
