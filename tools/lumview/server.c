#define _POSIX_C_SOURCE 200809L
#include "server.h"

#include "../common/interrupt.h"
#include "../common/number.h"
#include "http.h"
#include "net/program.h"
#include "viewer.h"

#include <errno.h>
#include <libwebsockets.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#define HEADERS_BYTES 8192u
#define IDLE_S        5 /* for a request to come, and for the next */
#define PING_S        5 /* without a sign of life */
#define HANGUP_S      20
#define TICK_US       500000

#define LOOPBACK 0x7f000001u

#define CONNECTIONS_MAX      100u
#define CONNECTIONS_PEER_MAX 30u /* of one address */

/* What has been handed to the system is not the newest any more. */
#define SEND_BUFFER_BYTES (512 * 1024)

#define CLOSE_REASON_BYTES 64u

struct client_refusal {
    enum lws_close_status code;
    const char *reason;
};

struct client {
    struct lws *wsi;
    struct viewer viewer;
    const struct client_refusal *refusal; /* it is to be closed; else NULL */
    char command[COMMAND_BYTES];          /* so far */
    size_t command_len;
};

struct clients {
    struct viewers viewers;
};

/* A place that a connection has. */
struct place {
    uint32_t address; /* at its other end */
    bool is_taken;
};

struct server {
    struct lws_context *lws;
    struct lws_vhost *host;
    struct guard guard;
    struct clients clients;
    struct lws_protocol_vhost_options headers[5];
    char policy[HTTP_POLICY_BYTES];
    lws_sorted_usec_list_t tick;
    struct place places[CONNECTIONS_MAX];
    uint32_t arriving; /* address of the connection that is being accepted */
};

static struct server *server_of(struct lws *wsi)
{
    return lws_context_user(lws_get_context(wsi));
}

static const struct client_refusal binary = {
    LWS_CLOSE_STATUS_UNACCEPTABLE_OPCODE, "only text is understood"};
static const struct client_refusal unknown = {LWS_CLOSE_STATUS_POLICY_VIOLATION,
                                              "no such command"};

/* --- The connected browsers --- */

static int clients_init(struct clients *clients, const struct options *options)
{
    return viewers_init(&clients->viewers, options, LWS_PRE);
}

static void clients_free(struct clients *clients)
{
    viewers_free(&clients->viewers);
}

/* If it fails, a slow browser shows older frames. */
static void bound_send_buffer(struct lws *wsi)
{
    const int bytes = SEND_BUFFER_BYTES;
    (void)setsockopt(lws_get_socket_fd(wsi), SOL_SOCKET, SO_SNDBUF, &bytes,
                     sizeof bytes);
}

static void clients_add(struct clients *clients, struct client *client,
                        struct lws *wsi)
{
    *client = (struct client){.wsi = wsi};
    viewers_add(&clients->viewers, &client->viewer);
    bound_send_buffer(wsi);
    (void)lws_callback_on_writable(wsi);
}

static void clients_remove(struct clients *clients, struct client *client)
{
    viewers_remove(&clients->viewers, &client->viewer);
}

static void ask_to_write(const struct clients *clients)
{
    const struct viewers *viewers = &clients->viewers;
    for (struct viewer *v = viewers->first; v != NULL; v = v->next) {
        if (viewer_has_next(viewers, v)) {
            const struct client *client =
                lws_container_of(v, struct client, viewer);
            (void)lws_callback_on_writable(client->wsi);
        }
    }
}

/* The feed has something new. */
static void clients_wake(struct clients *clients)
{
    if (clients->viewers.feed != NULL) {
        viewers_wake(&clients->viewers);
        ask_to_write(clients);
    }
}

/* Half a second has passed. */
static void clients_tick(struct clients *clients)
{
    viewers_tick(&clients->viewers);
    ask_to_write(clients);
}

/* --- What is sent to one --- */

static int send_message(const struct client *client,
                        const struct viewer_message *message)
{
    const int sent =
        lws_write(client->wsi, message->bytes, message->len,
                  message->is_text ? LWS_WRITE_TEXT : LWS_WRITE_BINARY);
    return sent < 0 ? -1 : 0;
}

static int send_close(const struct client *client)
{
    unsigned char reason[CLOSE_REASON_BYTES];
    const size_t len = strlen(client->refusal->reason);
    (void)memcpy(reason, client->refusal->reason, len);
    lws_close_reason(client->wsi, client->refusal->code, reason, len);
    return -1;
}

/* One message at a time; before the next, the socket is asked again
 * whether it takes more. */
static int clients_write(struct clients *clients, struct client *client)
{
    struct viewers *viewers = &clients->viewers;
    struct viewer_message message;
    if (client->refusal != NULL) {
        return send_close(client);
    }
    const int found = viewer_next(viewers, &client->viewer, &message);
    if (found < 0 || (found > 0 && send_message(client, &message) != 0)) {
        return -1;
    }
    if (viewer_has_next(viewers, &client->viewer)) {
        (void)lws_callback_on_writable(client->wsi);
    }
    return 0;
}

/* --- What one sends --- */

/* The close is sent after all earlier data is sent: otherwise libwebsockets
 * would leave it out. */
static void refuse(struct client *client, const struct client_refusal *why)
{
    client->refusal = why;
    (void)lws_callback_on_writable(client->wsi);
}

/* A piece of a message came. What is no command ends the connection. */
static void clients_read(struct clients *clients, struct client *client,
                         const char *bytes, size_t len)
{
    if (client->refusal != NULL) {
        return;
    }
    if (lws_frame_is_binary(client->wsi)) {
        refuse(client, &binary);
        return;
    }
    if (len > sizeof client->command - client->command_len) {
        refuse(client, &unknown);
        return;
    }
    (void)memcpy(client->command + client->command_len, bytes, len);
    client->command_len += len;
    if (!lws_is_final_fragment(client->wsi)) {
        return;
    }
    if (!viewer_take(&clients->viewers, &client->viewer, client->command,
                     client->command_len)) {
        refuse(client, &unknown);
        return;
    }
    client->command_len = 0;
    (void)lws_callback_on_writable(client->wsi);
}

/* --- How many connections there are --- */

/* 0 where it is gone already. */
static uint32_t find_peer(lws_sockfd_type fd)
{
    struct sockaddr_in peer = {.sin_family = AF_INET};
    socklen_t len = sizeof peer;
    return getpeername(fd, (struct sockaddr *)&peer, &len) == 0
               ? ntohl(peer.sin_addr.s_addr)
               : 0;
}

/* What a callback returns: 0, it may come in. One host cannot take all places.
 */
static int admit(struct server *server, lws_sockfd_type fd)
{
    size_t all = 0;
    size_t own = 0;
    server->arriving = find_peer(fd);
    for (size_t i = 0; i < CONNECTIONS_MAX; i++) {
        const struct place *place = &server->places[i];
        all += place->is_taken ? 1u : 0u;
        own += place->is_taken && place->address == server->arriving ? 1u : 0u;
    }
    return all < CONNECTIONS_MAX && own < CONNECTIONS_PEER_MAX ? 0 : 1;
}

/* Right after it was admitted. */
static int enter(struct lws *wsi)
{
    struct server *server = server_of(wsi);
    size_t i = 0;
    while (i < CONNECTIONS_MAX && server->places[i].is_taken) {
        i++;
    }
    struct place *place = i < CONNECTIONS_MAX ? &server->places[i] : NULL;
    lws_set_opaque_user_data(wsi, place);
    if (place == NULL) {
        return -1;
    }
    *place = (struct place){server->arriving, true};
    return 0;
}

/* The socket that listens has no place. */
static void leave(struct lws *wsi)
{
    struct place *place = lws_get_opaque_user_data(wsi);
    if (place != NULL) {
        place->is_taken = false;
    }
}

/* --- What libwebsockets asks for --- */

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

/* --- Where it listens --- */

static int explain(uint32_t address, uint16_t port, int reason,
                   lum_error *error)
{
    char text[16];
    (void)number_format_address(address, text);
    if (reason == EADDRINUSE) {
        const lum_endpoint place = {address, port};
        const lum_program_text who =
            lum_program_show(lum_program_of_tcp_port(place));
        return lum_error_set(error,
                             "--port: port %u of %s is taken by %s: choose "
                             "another, or none for any that is free",
                             (unsigned)port, text, who.text);
    }
    if (reason == EADDRNOTAVAIL) {
        return lum_error_set(
            error, "--bind: %s is not an address of this host; see: ip addr",
            text);
    }
    return lum_error_set(error, "%s:%u: cannot be listened on: %s", text,
                         (unsigned)port, strerror(reason));
}

/* As a server would bind, so that what fails here is what would fail there. */
static int try_place(int fd, uint32_t address, uint16_t *port)
{
    const int yes = 1;
    struct sockaddr_in there = {.sin_family = AF_INET,
                                .sin_port = htons(*port),
                                .sin_addr.s_addr = htonl(address)};
    socklen_t len = sizeof there;
    if (setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
        bind(fd, (const struct sockaddr *)&there, sizeof there) != 0 ||
        listen(fd, 1) != 0 ||
        getsockname(fd, (struct sockaddr *)&there, &len) != 0) {
        return errno;
    }
    *port = ntohs(there.sin_port);
    return 0;
}

static int find_place(const struct listen_options *options, uint32_t *address,
                      uint16_t *port, lum_error *error)
{
    *address = options->has_address ? options->address : LOOPBACK;
    *port = options->port;
    const int fd = socket(AF_INET, SOCK_STREAM, 0);
    const int reason = fd < 0 ? errno : try_place(fd, *address, port);
    if (fd >= 0) {
        (void)close(fd);
    }
    return reason == 0 ? 0 : explain(*address, *port, reason, error);
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
    if (find_place(&options->listen, &server->guard.address,
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
    return failed == 0
               ? 0
               : lum_error_set(
                     error, "the server failed: libwebsockets cannot continue");
}
