#define _POSIX_C_SOURCE 200809L
#include "client.h"

#include "lum/base/time.h"

#include <libwebsockets.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

/* What has been handed to the system is not the newest any more. */
#define SEND_BUFFER_BYTES (512 * 1024)

#define CLOSE_REASON_BYTES 64u

#define AT_COUNT 52u /* of the frames shown so far; see frame.h */

struct client_refusal {
    enum lws_close_status code;
    const char *reason;
};

static const struct client_refusal binary = {
    LWS_CLOSE_STATUS_UNACCEPTABLE_OPCODE, "only text is understood"};
static const struct client_refusal unknown = {LWS_CLOSE_STATUS_POLICY_VIOLATION,
                                              "no such command"};

static const struct feed_view default_view = {LUM_EDGES_RISING, 0};

/* --- Clients and the views they want --- */

int clients_init(struct clients *clients, const struct options *options)
{
    *clients = (struct clients){.options = options};
    clients->piece = malloc(LWS_PRE + CLIENT_PIECE_BYTES);
    return clients->piece != NULL ? 0 : -1;
}

/* Those of all browsers but one. */
static struct feed_views collect_views(const struct clients *clients,
                                       const struct client *but)
{
    struct feed_views views = {.count = 0};
    for (const struct client *c = clients->first; c != NULL; c = c->next) {
        if (c != but && views.count < FEED_VIEWS_MAX &&
            feed_views_find(&views, &c->view) == views.count) {
            views.at[views.count++] = c->view;
        }
    }
    return views;
}

static void want_views(struct clients *clients)
{
    const struct feed_views views = collect_views(clients, NULL);
    if (clients->feed != NULL) {
        feed_want(clients->feed, views.at, views.count);
    }
}

/* As many as the browser that shows most. */
static void keep_frames(const struct clients *clients)
{
    unsigned most = 1;
    for (const struct client *c = clients->first; c != NULL; c = c->next) {
        most = c->frames > most ? c->frames : most;
    }
    if (clients->feed != NULL) {
        feed_keep(clients->feed, most);
    }
}

/* Where all places are taken, a browser keeps the view that it has. */
static void set_view(struct clients *clients, struct client *client,
                     const struct feed_view *view)
{
    const struct feed_views views = collect_views(clients, client);
    if (views.count < FEED_VIEWS_MAX ||
        feed_views_find(&views, view) < views.count) {
        client->view = *view;
        client->past = 0;
        want_views(clients);
    }
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
    const struct feed_views views = collect_views(clients, NULL);
    *client = (struct client){.wsi = wsi, .frames = 1, .wants_status = true};
    client->view = views.count < FEED_VIEWS_MAX ? default_view : views.at[0];
    client->next = clients->first;
    clients->first = client;
    clients->status.browsers++;
    bound_send_buffer(wsi);
    want_views(clients);
    (void)lws_callback_on_writable(wsi);
}

void clients_remove(struct clients *clients, struct client *client)
{
    struct client **at = &clients->first;
    while (*at != NULL && *at != client) {
        at = &(*at)->next;
    }
    if (*at == NULL) {
        return;
    }
    *at = client->next;
    clients->status.browsers--;
    frame_release(client->frame);
    client->frame = NULL;
    want_views(clients);
    keep_frames(clients);
}

/* --- Waking --- */

static bool is_newer(const struct client *client, struct frame *frame)
{
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(frame, &len);
    return !client->has_last ||
           memcmp(bytes, client->last, sizeof client->last) != 0;
}

static bool has_newer(const struct clients *clients,
                      const struct client *client)
{
    struct frame *frame = feed_newest(clients->feed, &client->view);
    const bool out = frame != NULL && is_newer(client, frame);
    frame_release(frame);
    return out;
}

void clients_wake(struct clients *clients)
{
    struct feed_status now;
    if (clients->feed == NULL) {
        return;
    }
    feed_look(clients->feed, &now);
    const bool differs = status_differs(&clients->status.feed, &now);
    if (differs) {
        status_update(&clients->status, &now, 0, false);
    }
    for (struct client *c = clients->first; c != NULL; c = c->next) {
        c->wants_status = c->wants_status || differs;
        if (differs || (c->frame == NULL && has_newer(clients, c))) {
            (void)lws_callback_on_writable(c->wsi);
        }
    }
}

void clients_tick(struct clients *clients)
{
    struct feed_status now;
    feed_look(clients->feed, &now);
    status_update(&clients->status, &now, lum_time_monotonic_ns(), true);
    for (struct client *c = clients->first; c != NULL; c = c->next) {
        c->wants_status = true;
        (void)lws_callback_on_writable(c->wsi);
    }
}

/* --- Sending --- */

static int send_text(struct client *client, int failed, struct text *text)
{
    if (failed != 0) {
        return -1;
    }
    const int n = lws_write(client->wsi, (unsigned char *)text->bytes,
                            text->len, LWS_WRITE_TEXT);
    free(text->memory);
    return n < 0 ? -1 : 0;
}

static int send_hello(const struct clients *clients, struct client *client)
{
    struct text text;
    client->had_hello = true;
    const int failed =
        status_hello(clients->options, clients->feed, LWS_PRE, &text);
    return send_text(client, failed, &text);
}

static int send_status(const struct clients *clients, struct client *client)
{
    struct text text;
    client->wants_status = false;
    const int failed =
        status_text(&clients->status, client->skipped, LWS_PRE, &text);
    return send_text(client, failed, &text);
}

static int send_piece(const struct clients *clients, struct client *client)
{
    size_t len = 0;
    const uint8_t *bytes = frame_bytes(client->frame, &len);
    const size_t left = len - client->sent;
    const bool is_last = left <= CLIENT_PIECE_BYTES;
    const size_t n = is_last ? left : CLIENT_PIECE_BYTES;
    const int flags =
        lws_write_ws_flags(LWS_WRITE_BINARY, client->sent == 0, is_last);
    (void)memcpy(clients->piece + LWS_PRE, bytes + client->sent, n);
    if (lws_write(client->wsi, clients->piece + LWS_PRE, n,
                  (enum lws_write_protocol)flags) < 0) {
        return -1;
    }
    client->sent += n;
    if (is_last) {
        frame_release(client->frame);
        client->frame = NULL;
    }
    return 0;
}

static uint32_t read_count(const uint8_t *head)
{
    const uint8_t *at = head + AT_COUNT;
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 |
           (uint32_t)at[3] << 24;
}

/* Frames between the last one and this were never sent. */
static void count_skipped(struct client *client, const uint8_t *head)
{
    const uint32_t step = read_count(head) - read_count(client->last);
    if (client->has_last && step > 1u && step < UINT32_MAX / 2u) {
        client->skipped += step - 1u;
    }
    (void)memcpy(client->last, head, sizeof client->last);
    client->has_last = true;
}

/* The newest that was asked for and that there is; NULL: none. */
static struct frame *take_past(const struct clients *clients,
                               struct client *client)
{
    struct frame *frame = NULL;
    for (int64_t i = 1; client->past != 0 && frame == NULL; i++) {
        if ((client->past & 1u) != 0) {
            frame = feed_past(clients->feed, &client->view,
                              client->past_before - i);
        }
        client->past >>= 1;
        client->past_before -= frame != NULL ? i : 0;
    }
    return frame;
}

/* Those that were asked for come behind the newest. */
static int begin_frame(const struct clients *clients, struct client *client)
{
    size_t len = 0;
    struct frame *frame = feed_newest(clients->feed, &client->view);
    if (frame != NULL && is_newer(client, frame)) {
        count_skipped(client, frame_bytes(frame, &len));
    } else {
        frame_release(frame);
        frame = take_past(clients, client);
    }
    client->frame = frame;
    client->sent = 0;
    return frame != NULL ? send_piece(clients, client) : 0;
}

static int send_close(const struct client *client)
{
    unsigned char reason[CLOSE_REASON_BYTES];
    const size_t len = strlen(client->refusal->reason);
    (void)memcpy(reason, client->refusal->reason, len);
    lws_close_reason(client->wsi, client->refusal->code, reason, len);
    return -1;
}

/* One message or piece at a time; before the next, the socket is asked again
 * whether it takes more. Texts go between frames. */
int clients_write(struct clients *clients, struct client *client)
{
    int failed = 0;
    if (client->refusal != NULL) {
        failed = send_close(client);
    } else if (client->frame != NULL) {
        failed = send_piece(clients, client);
    } else if (!client->had_hello) {
        failed = send_hello(clients, client);
    } else if (client->wants_status) {
        failed = send_status(clients, client);
    } else {
        failed = begin_frame(clients, client);
    }
    if (failed != 0) {
        return -1;
    }
    if (client->frame != NULL || client->wants_status || client->past != 0 ||
        has_newer(clients, client)) {
        (void)lws_callback_on_writable(client->wsi);
    }
    return 0;
}

/* --- Receiving --- */

static void obey(struct clients *clients, struct client *client,
                 const struct command *command)
{
    struct feed *feed = clients->feed;
    switch (command->kind) {
    case COMMAND_VIEW:
        set_view(clients, client, &command->view);
        (void)lws_callback_on_writable(client->wsi);
        break;
    case COMMAND_FRAMES:
        client->frames = (unsigned)command->number;
        keep_frames(clients);
        break;
    case COMMAND_PAST:
        client->past_before = command->number;
        client->past = command->past;
        (void)lws_callback_on_writable(client->wsi);
        break;
    case COMMAND_PLAY:
    case COMMAND_PAUSE:
        feed_play(feed, command->kind == COMMAND_PLAY);
        break;
    case COMMAND_STEP:
        feed_step(feed, command->number);
        break;
    case COMMAND_SEEK:
        feed_seek(feed, command->number);
        break;
    case COMMAND_SPEED:
        feed_speed(feed, command->speed);
        break;
    case COMMAND_LOOP:
    default:
        feed_loop(feed, command->loops);
        break;
    }
}

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
    struct command command;
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
    if (!command_parse(client->command, client->command_len, &command)) {
        refuse(client, &unknown);
        return;
    }
    client->command_len = 0;
    obey(clients, client, &command);
}
