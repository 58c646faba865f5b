#define _POSIX_C_SOURCE 200809L
#include "client.h"

#include <libwebsockets.h>
#include <string.h>
#include <sys/socket.h>

/* What has been handed to the system is not the newest any more. */
#define SEND_BUFFER_BYTES (512 * 1024)

#define CLOSE_REASON_BYTES 64u

struct client_refusal {
    enum lws_close_status code;
    const char *reason;
};

static const struct client_refusal binary = {
    LWS_CLOSE_STATUS_UNACCEPTABLE_OPCODE, "only text is understood"};
static const struct client_refusal unknown = {LWS_CLOSE_STATUS_POLICY_VIOLATION,
                                              "no such command"};

/* --- Connections --- */

int clients_init(struct clients *clients, const struct options *options)
{
    return viewers_init(&clients->viewers, options, LWS_PRE);
}

void clients_free(struct clients *clients)
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

void clients_add(struct clients *clients, struct client *client,
                 struct lws *wsi)
{
    *client = (struct client){.wsi = wsi};
    viewers_add(&clients->viewers, &client->viewer);
    bound_send_buffer(wsi);
    (void)lws_callback_on_writable(wsi);
}

void clients_remove(struct clients *clients, struct client *client)
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

void clients_wake(struct clients *clients)
{
    if (clients->viewers.feed != NULL) {
        viewers_wake(&clients->viewers);
        ask_to_write(clients);
    }
}

void clients_tick(struct clients *clients)
{
    viewers_tick(&clients->viewers);
    ask_to_write(clients);
}

/* --- Sending --- */

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
int clients_write(struct clients *clients, struct client *client)
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

/* --- Receiving --- */

/* The close is sent after all earlier data is sent: otherwise libwebsockets
 * would leave it out. */
static void refuse(struct client *client, const struct client_refusal *why)
{
    client->refusal = why;
    (void)lws_callback_on_writable(client->wsi);
}

void clients_read(struct clients *clients, struct client *client,
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
