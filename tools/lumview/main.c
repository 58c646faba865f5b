/* lumview: captures and sensors in a browser. */
#define _POSIX_C_SOURCE 200809L

#include "../common/interrupt.h"
#include "../common/json.h"
#include "../common/number.h"
#include "browser.h"
#include "feed.h"
#include "options.h"
#include "served.h"
#include "server.h"
#include "setting_files.h"
#include "true_points.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

enum exit_status {
    EXIT_DONE = 0,
    EXIT_FAILED = 1,
    EXIT_BAD = 2
};

static enum exit_status complain(const lum_error *error,
                                 enum exit_status status)
{
    (void)fprintf(stderr, "lumview: %s\n", error->text);
    return status;
}

static enum exit_status finish_stdout(void)
{
    if (fflush(stdout) == 0 && !ferror(stdout)) {
        return EXIT_DONE;
    }
    (void)fprintf(stderr, "lumview: standard output: cannot be written: %s\n",
                  strerror(errno));
    return EXIT_FAILED;
}

/* What the options lead to. */
struct loaded {
    struct files files;
    struct served served;
};

/* An array, or a capture. */
static int load_truth(const struct options *o, const struct geometry *geometry,
                      struct served *out, lum_error *error)
{
    const char *name = o->beside.truth;
    struct truth truth;
    if (name == NULL || served_is_array(name)) {
        return served_add(out, "/truth", name, error);
    }
    if (truth_read(o, geometry, &name, 1, &truth, error) != 0) {
        return -1;
    }
    served_put(out, "/truth", truth.bytes, truth.len);
    return 0;
}

/* What is known beside the points, for the page alone. */
static int load_served(struct options *o, struct loaded *out, lum_error *error)
{
    if (served_add(&out->served, "/labels", o->beside.labels, error) != 0 ||
        load_truth(o, &out->files.geometry, &out->served, error) != 0) {
        return -1;
    }
    o->beside.served = &out->served;
    return 0;
}

static enum exit_status print_json(const struct guard *guard, const char *url)
{
    struct json json;
    json_begin_line(&json, stdout);
    json_text(&json, "url", url);
    json_text(&json, "address", number_address(guard->address).text);
    json_uint(&json, "port", guard->port);
    json_end_line(&json);
    return finish_stdout();
}

static enum exit_status announce(const struct options *o,
                                 const struct guard *guard,
                                 struct browser *browser)
{
    char url[GUARD_TEXT_BYTES];
    guard_url(guard, url);
    if (o->json && print_json(guard, url) != EXIT_DONE) {
        return EXIT_FAILED;
    }
    if (!o->quiet) {
        (void)fprintf(stderr, "lumview: %s (Ctrl-C ends it)\n", url);
    }
    if (!o->stays_closed &&
        !browser_open(browser, url, guard->token[0] != '\0') && !o->quiet) {
        (void)fputs("lumview: no browser could be started: open this URL in "
                    "one\n",
                    stderr);
    }
    return EXIT_DONE;
}

static enum exit_status close_feed(const struct options *o, struct feed *feed)
{
    lum_error error = {""};
    if (o->live.laser) {
        interrupt_hold();
    }
    const int failed = feed_close(feed, &error);
    if (o->live.laser) {
        interrupt_release();
    }
    return failed == 0 ? EXIT_DONE : complain(&error, EXIT_FAILED);
}

static enum exit_status serve(const struct options *o,
                              const struct files *files, struct server *server)
{
    lum_error error = {""};
    struct feed *feed = NULL;
    struct browser browser = {.folder = ""};
    if (feed_open(o, &files->geometry,
                  o->second != NULL ? &files->second : NULL, server_wake,
                  server, &feed, &error) != 0) {
        return complain(&error, EXIT_FAILED);
    }
    enum exit_status status = announce(o, server_guard(server), &browser);
    if (status == EXIT_DONE && server_run(server, feed, &error) != 0) {
        status = complain(&error, EXIT_FAILED);
    }
    browser_forget(&browser);
    const enum exit_status closed = close_feed(o, feed);
    return status == EXIT_DONE ? closed : status;
}

static enum exit_status run(struct options *o, struct loaded *loaded)
{
    lum_error error = {""};
    struct server *server = NULL;
    if (o->is_live) {
        interrupt_insist(); /* its heartbeats keep a laser on */
    }
    if (files_load(o, &loaded->files, &error) != 0 ||
        load_served(o, loaded, &error) != 0) {
        return complain(&error, EXIT_BAD);
    }
    const enum exit_status status = server_open(o, &server, &error) == 0
                                        ? serve(o, &loaded->files, server)
                                        : complain(&error, EXIT_FAILED);
    server_close(server);
    return status;
}

static int parse_and_run(int argc, char **argv, struct options *options,
                         struct loaded *loaded)
{
    switch (options_parse(argc, argv, options)) {
    case PARSED_DONE:
        return (int)finish_stdout();
    case PARSED_BAD:
        return EXIT_BAD;
    case PARSED_RUN:
    default:
        return (int)run(options, loaded);
    }
}

int main(int argc, char **argv)
{
    struct options options;
    struct loaded loaded = {.files = {.poses = NULL}};
    interrupt_catch();
    const int status = parse_and_run(argc, argv, &options, &loaded);
    sources_free(&options.sources);
    served_free(&loaded.served);
    lum_poses_free(loaded.files.poses);
    return status;
}
