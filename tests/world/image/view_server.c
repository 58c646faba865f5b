/* lumview's server for the world, which has no browsers: the default view is
 * wanted as long as it runs, and each change of the feed is a line on standard
 * output. */
#define _POSIX_C_SOURCE 200809L
#include "lumview/assets.h"
#include "lumview/browser.h"
#include "lumview/page_guard.h"
#include "lumview/server.h"

#include "common/interrupt.h"

#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

struct server {
    struct guard guard;
    int woken[2]; /* a pipe: the feed's threads write, the server waits */
    struct feed_status told;
};

static const char *name_of(enum feed_state state)
{
    switch (state) {
    case FEED_WAITING:
        return "waiting";
    case FEED_PLAYING:
        return "playing";
    case FEED_PAUSED:
        return "paused";
    case FEED_ENDED:
        return "ended";
    case FEED_SILENT:
        return "silent";
    case FEED_FAILED:
    default:
        return "failed";
    }
}

int server_open(const struct options *options, struct server **out,
                lum_error *error)
{
    struct server *server = calloc(1, sizeof *server);
    (void)options;
    if (server == NULL || pipe(server->woken) != 0) {
        free(server);
        return lum_error_set(error, "cannot make a server");
    }
    *out = server;
    return 0;
}

void server_close(struct server *server)
{
    if (server != NULL) {
        (void)close(server->woken[0]);
        (void)close(server->woken[1]);
        free(server);
    }
}

const struct guard *server_guard(const struct server *server)
{
    return &server->guard;
}

void server_wake(void *context)
{
    const struct server *server = context;
    const ssize_t written = write(server->woken[1], "", 1);
    (void)written;
}

static void tell(struct server *server, const struct feed_status *now)
{
    struct feed_status *told = &server->told;
    if (now->state != told->state || now->has_laser != told->has_laser ||
        now->laser != told->laser ||
        strcmp(now->texts[FEED_MESSAGE], told->texts[FEED_MESSAGE]) != 0) {
        (void)printf("%s, frames %llu, laser ", name_of(now->state),
                     (unsigned long long)now->frames);
        (void)(now->has_laser ? printf("0x%04x", (unsigned)now->laser)
                              : printf("unknown"));
        (void)printf("%s%s\n", now->texts[FEED_MESSAGE][0] != '\0' ? ": " : "",
                     now->texts[FEED_MESSAGE]);
        (void)fflush(stdout);
    }
    *told = *now;
}

/* The newest frame is taken and given back, as for a browser. */
static void take_frame(struct feed *feed, const struct feed_view *view)
{
    frame_release(feed_newest(feed, view));
}

/* The ticks that follow a signal end a wait that it came just before. */
int server_run(struct server *server, struct feed *feed, lum_error *error)
{
    const struct feed_view view = {LUM_EDGES_RISING, 0};
    struct pollfd wait = {.fd = server->woken[0], .events = POLLIN};
    char bytes[64];
    (void)error;
    feed_want(feed, &view, 1);
    while (interrupt_signal() == 0) {
        struct feed_status now;
        if (poll(&wait, 1, -1) > 0 &&
            read(server->woken[0], bytes, sizeof bytes) > 0) {
            take_frame(feed, &view);
        }
        feed_look(feed, &now);
        tell(server, &now);
    }
    const uint64_t lost =
        server->told.dropped.kernel + server->told.dropped.ring;
    (void)printf("frames %llu, points %llu, lost by the network %llu words, "
                 "by the system %llu datagrams\n",
                 (unsigned long long)server->told.frames,
                 (unsigned long long)server->told.decoded.points,
                 (unsigned long long)server->told.decoded.lost_words,
                 (unsigned long long)lost);
    return 0;
}

/* --- what only a browser has --- */

void guard_url(const struct guard *guard, char out[GUARD_TEXT_BYTES])
{
    (void)guard;
    (void)snprintf(out, GUARD_TEXT_BYTES, "no page");
}

bool browser_open(struct browser *browser, char *url, bool is_secret)
{
    (void)browser;
    (void)url;
    (void)is_secret;
    return false;
}

void browser_forget(struct browser *browser)
{
    (void)browser;
}

const struct asset assets[] = {
    {"/licenses.txt", "text/plain", "see lumview\n", 12, false}};
const size_t assets_count = 1;
