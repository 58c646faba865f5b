/* lumview: captures and sensors in a browser. */
#define _POSIX_C_SOURCE 200809L

#include "../common/geometry.h"
#include "../common/input_files.h"
#include "../common/interrupt.h"
#include "../common/json.h"
#include "../common/number.h"
#include "feed.h"
#include "open.h"
#include "options.h"
#include "redirect.h"
#include "served.h"
#include "server.h"

#include <errno.h>
#include <signal.h>
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

/* What a run is told of the sensor. */
struct files {
    struct geometry geometry;
    lum_profile second; /* where there is one */
    lum_rig_files rig;  /* likewise */
    struct served served;
    lum_poses *poses;
};

/* Of the second profile too standard input is one input at most. */
static int check_stdin(const struct options *o, lum_error *error)
{
    const struct input_file inputs[] = {
        {o->calibration, "--calibration"},
        {o->profile, "the first --profile"},
        {o->second, "the second --profile"},
        {sources_find_stdin(&o->sources), "the source"}};
    return o->second == NULL
               ? 0
               : input_files_check_once(
                     inputs, sizeof inputs / sizeof inputs[0], error);
}

static int load_second(const struct options *o, struct files *out,
                       lum_error *error)
{
    struct geometry tried = out->geometry;
    lum_profile_default(&out->second);
    if (geometry_read(NULL, o->second, NULL, &out->second, error) != 0) {
        return -1;
    }
    tried.profile = out->second;
    return geometry_set(&tried, &o->set, error);
}

static int refuse_name(const struct options *o, const lum_rig *rig,
                       lum_error *error)
{
    char names[LUM_RIG_SENSORS_MAX * (LUM_RIG_NAME_BYTES + 2u)] = "";
    size_t len = 0;
    for (size_t i = 0; i < rig->count; i++) {
        len += (size_t)snprintf(names + len, sizeof names - len, "%s%s",
                                i > 0 ? ", " : "", rig->sensor[i].name);
    }
    return lum_error_set(error,
                         "--sensor: '%s' is not a sensor of %s, which "
                         "has %s",
                         o->sensor.text, o->rig_path, names);
}

/* The sensor of --sensor becomes the first, and the only one that is shown. */
static int choose_sensor(struct options *o, lum_rig_files *files,
                         lum_error *error)
{
    lum_rig *rig = &files->rig;
    size_t i = 0;
    while (i < rig->count && strcmp(rig->sensor[i].name, o->sensor.text) != 0) {
        i++;
    }
    if (i == rig->count) {
        return refuse_name(o, rig, error);
    }
    const lum_rig_sensor first = rig->sensor[0];
    const lum_rig_sensor_files its = files->sensor[0];
    rig->sensor[0] = rig->sensor[i];
    files->sensor[0] = files->sensor[i];
    rig->sensor[i] = first;
    files->sensor[i] = its;
    o->shown = 1;
    return 0;
}

static int load_rig(struct options *o, lum_rig_files *out, lum_error *error)
{
    const struct input_file inputs[] = {
        {o->rig_path, "--rig"},
        {sources_find_stdin(&o->sources), "the source"}};
    if (o->rig_path == NULL) {
        return 0;
    }
    if (input_files_check_once(inputs, sizeof inputs / sizeof inputs[0],
                               error) != 0 ||
        geometry_read_rig(o->rig_path, out, error) != 0) {
        return -1;
    }
    o->shown = out->rig.count;
    if (o->sensor.is_given && choose_sensor(o, out, error) != 0) {
        return -1;
    }
    o->rig = out;
    return 0;
}

/* What is known beside the points. */
static int load_beside(struct beside_options *o, struct files *out,
                       lum_error *error)
{
    if (served_add(&out->served, "/labels", o->labels, error) != 0 ||
        served_add(&out->served, "/truth", o->truth, error) != 0) {
        return -1;
    }
    o->served = &out->served;
    if (o->poses_path == NULL) {
        return 0;
    }
    const int failed =
        lum_poses_read(o->poses_path, NULL, NULL, &out->poses, error);
    o->poses = out->poses;
    return failed;
}

/* What a source says of itself comes under the keys that are set: they are only
 * tried here, which separates a bad configuration from a bad source. */
static int load_files(struct options *o, struct files *out, lum_error *error)
{
    const struct input_file inputs[] = {{o->calibration, "the calibration"},
                                        {o->profile, "the profile"},
                                        {o->rig_path, "the rig"},
                                        {o->second, "the second profile"}};
    if (o->json &&
        sources_check(&o->sources, inputs, sizeof inputs / sizeof inputs[0],
                      "-", error) != 0) {
        return -1;
    }
    if (check_stdin(o, error) != 0 || load_rig(o, &out->rig, error) != 0 ||
        load_beside(&o->beside, out, error) != 0 ||
        geometry_load(o->calibration, o->profile, &o->sources, &out->geometry,
                      error) != 0) {
        return -1;
    }
    struct geometry tried = out->geometry;
    if (geometry_set(&tried, &o->set, error) != 0) {
        return -1;
    }
    return o->second != NULL ? load_second(o, out, error) : 0;
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

/* A URL with a token goes by a file. */
static bool start_browser(const struct guard *guard, char *url,
                          struct redirect *redirect)
{
    if (guard->token[0] == '\0') {
        return open_browser(url);
    }
    return redirect_write(redirect, url) == 0 && open_browser(redirect->url);
}

static enum exit_status announce(const struct options *o,
                                 const struct guard *guard,
                                 struct redirect *redirect)
{
    char url[GUARD_TEXT_BYTES];
    guard_url(guard, url);
    if (o->json && print_json(guard, url) != EXIT_DONE) {
        return EXIT_FAILED;
    }
    if (!o->quiet) {
        (void)fprintf(stderr, "lumview: %s (Ctrl-C ends it)\n", url);
    }
    if (!o->stays_closed && !start_browser(guard, url, redirect) && !o->quiet) {
        (void)fputs("lumview: no browser could be started: open this URL in "
                    "one\n",
                    stderr);
    }
    return EXIT_DONE;
}

/* Signals are for the main thread, which waits: the feed's would not notice. */
static int open_feed(const struct options *o, const struct files *files,
                     struct server *server, struct feed **feed,
                     lum_error *error)
{
    sigset_t all;
    sigset_t before;
    (void)sigfillset(&all);
    (void)pthread_sigmask(SIG_BLOCK, &all, &before);
    const int failed = feed_open(o, &files->geometry,
                                 o->second != NULL ? &files->second : NULL,
                                 server_wake, server, feed, error);
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
    return failed;
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
    struct redirect redirect = {.folder = ""};
    if (open_feed(o, files, server, &feed, &error) != 0) {
        return complain(&error, EXIT_FAILED);
    }
    enum exit_status status = announce(o, server_guard(server), &redirect);
    if (status == EXIT_DONE && server_run(server, feed, &error) != 0) {
        status = complain(&error, EXIT_FAILED);
    }
    redirect_remove(&redirect);
    const enum exit_status closed = close_feed(o, feed);
    return status == EXIT_DONE ? closed : status;
}

static enum exit_status run(struct options *o, struct files *files)
{
    lum_error error = {""};
    struct server *server = NULL;
    if (o->is_live) {
        interrupt_insist(); /* its heartbeats keep a laser on */
    }
    if (load_files(o, files, &error) != 0) {
        return complain(&error, EXIT_BAD);
    }
    const enum exit_status status = server_open(o, &server, &error) == 0
                                        ? serve(o, files, server)
                                        : complain(&error, EXIT_FAILED);
    server_close(server);
    return status;
}

static int parse_and_run(int argc, char **argv, struct options *options,
                         struct files *files)
{
    switch (options_parse(argc, argv, options)) {
    case PARSED_DONE:
        return (int)finish_stdout();
    case PARSED_BAD:
        return EXIT_BAD;
    case PARSED_RUN:
    default:
        return (int)run(options, files);
    }
}

int main(int argc, char **argv)
{
    struct options options;
    struct files files = {.poses = NULL}; /* the options lead there */
    interrupt_catch();
    const int status = parse_and_run(argc, argv, &options, &files);
    sources_free(&options.sources);
    served_free(&files.served);
    lum_poses_free(files.poses);
    return status;
}
