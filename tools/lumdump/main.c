/* lumdump: captures to clouds. */
#define _POSIX_C_SOURCE 200809L
#include "../common/interrupt.h"
#include "../common/number.h"
#include "convert.h"
#include "options.h"
#include "output.h"
#include "progress.h"
#include "summary.h"

#include "lum/io/config.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum exit_status {
    EXIT_DONE = 0,
    EXIT_FAILED = 1,
    EXIT_BAD = 2
};

static enum exit_status complain(const lum_error *error,
                                 enum exit_status status)
{
    (void)fprintf(stderr, "lumdump: %s\n", error->text);
    return status;
}

static void warn(const struct options *o, const char *text)
{
    if (!o->quiet) {
        (void)fprintf(stderr, "lumdump: warning: %s: %s\n", o->source, text);
    }
}

static int load(const struct options *o, lum_layout *layout,
                lum_projector *projector, lum_error *error)
{
    lum_calibration calibration;
    lum_profile profile;
    lum_calibration_default(&calibration);
    lum_profile_default(&profile);
    if (o->calibration != NULL &&
        lum_calibration_load(o->calibration, &calibration, error) != 0) {
        return -1;
    }
    if (o->profile != NULL &&
        lum_profile_load(o->profile, &profile, error) != 0) {
        return -1;
    }
    if (lum_layout_init(layout, &profile, NULL, NULL) != LUM_OK ||
        lum_projector_init(projector, &calibration, layout) != LUM_OK) {
        return lum_error_set(error, "the calibration or the profile is out of "
                                    "range; see docs/formats.md");
    }
    return 0;
}

/* A path, or - for one of the standard streams. */
static bool find_file(const char *path, int standard, struct stat *out)
{
    return (strcmp(path, "-") == 0 ? fstat(standard, out) : stat(path, out)) ==
               0 &&
           S_ISREG(out->st_mode);
}

static bool is_same_file(const char *source, const char *output)
{
    struct stat s;
    struct stat o;
    return find_file(source, STDIN_FILENO, &s) &&
           find_file(output, STDOUT_FILENO, &o) && s.st_dev == o.st_dev &&
           s.st_ino == o.st_ino;
}

/* An output grows as OUTPUT.part. */
static bool is_its_part(const struct options *o)
{
    char part[4096];
    const int n = snprintf(part, sizeof part, "%s.part", o->output);
    return n > 0 && (size_t)n < sizeof part && is_same_file(o->source, part);
}

static bool is_regular(const char *path)
{
    struct stat s;
    return stat(path, &s) == 0 && S_ISREG(s.st_mode);
}

/* A name that stands for no file yet will be one that can. */
static bool can_seek(const char *output)
{
    struct stat s;
    if (strcmp(output, "-") == 0) {
        return fstat(STDOUT_FILENO, &s) == 0 && S_ISREG(s.st_mode);
    }
    return stat(output, &s) != 0 || S_ISREG(s.st_mode);
}

static int check_output(const struct options *o, lum_error *error)
{
    const int pattern = output_name_pattern(o->output);
    if (pattern < 0) {
        return lum_error_set(error,
                             "%s: a %% in the name stands for the frame "
                             "number and has to read %%d or %%04d, once",
                             o->output);
    }
    if (pattern == 1 && o->format == FORMAT_PCAP) {
        return lum_error_set(error,
                             "%s: a capture holds packets, not frames: "
                             "name one file",
                             o->output);
    }
    if (is_same_file(o->source, o->output) || is_its_part(o)) {
        return lum_error_set(error,
                             "%s is the source itself, or would be written "
                             "over it: name another output",
                             o->output);
    }
    return 0;
}

/* Whether the output's header has to be known before it can begin. */
static bool needs_rehearsal(const struct options *o)
{
    return o->format != FORMAT_PCAP &&
           lum_format_needs_count((lum_format)o->format) &&
           !can_seek(o->output);
}

static void print_sensors(const struct pass *pass)
{
    for (size_t i = 0; i < lum_demux_sensor_count(pass->demux); i++) {
        lum_demux_sensor sensor;
        char address[16];
        lum_demux_get_sensor(pass->demux, i, &sensor);
        (void)fprintf(stderr, " %s",
                      number_format_address(sensor.address, address));
    }
    (void)fputc('\n', stderr);
}

static enum exit_status name_sensors(const struct pass *pass)
{
    (void)fprintf(stderr,
                  "lumdump: %s: packets of several sensors; choose one by "
                  "--sensor:",
                  pass->options->source);
    print_sensors(pass);
    return EXIT_BAD;
}

static bool lacks_asked_sensor(const struct pass *pass)
{
    for (size_t i = 0; i < lum_demux_sensor_count(pass->demux); i++) {
        lum_demux_sensor sensor;
        lum_demux_get_sensor(pass->demux, i, &sensor);
        if (sensor.address == pass->options->sensor) {
            return false;
        }
    }
    return pass->options->has_sensor && lum_demux_sensor_count(pass->demux) > 0;
}

static enum exit_status refuse_sensor(const struct pass *pass)
{
    char wanted[16];
    (void)fprintf(stderr, "lumdump: %s: no data of %s in it, but of",
                  pass->options->source,
                  number_format_address(pass->options->sensor, wanted));
    print_sensors(pass);
    return EXIT_FAILED;
}

/* Packets of ours, and no data among them. */
static bool lacks_data(const struct pass *pass)
{
    lum_demux_counters total;
    lum_demux_total(pass->demux, &total);
    return total.packets[LUM_PACKET_DATA] == 0 &&
           pass->diagnosis.shape_count > 0;
}

static bool lacks_points(const struct pass *pass)
{
    uint64_t points = 0;
    uint64_t lines = 0;
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        const struct point_counts *p = &pass->summary.sensors[i];
        points += p->points;
        lines += p->lines[LUM_EYE_BLUE] + p->lines[LUM_EYE_GREEN];
    }
    return points == 0 && lines > 0;
}

static void warn_of_losses(const struct pass *pass)
{
    const struct options *o = pass->options;
    char text[160];
    if (pass->summary.truncated && !o->quiet) {
        /* it names the source itself */
        (void)fprintf(stderr, "lumdump: warning: %s\n", pass->warning.text);
    }
    if (!pass->summary.has_time) {
        warn(o, "no packet of a G2 was found: nothing whole to or from UDP "
                "port 5517 bears its magic");
    }
    if (lacks_points(pass)) {
        warn(o, "lines came, but no point is left of them: see no_angle and "
                "no_range in the summary, and the selection");
    }
    if (pass->output != NULL && output_left_out(pass->output) > 0) {
        (void)snprintf(text, sizeof text,
                       "%" PRIu64 " points came after the file of their frame "
                       "was finished and were left out",
                       output_left_out(pass->output));
        warn(o, text);
    }
}

/* A reader that has left is no failure. */
static enum exit_status flush_stdout(void)
{
    if (fflush(stdout) == 0 && !ferror(stdout)) {
        return EXIT_DONE;
    }
    if (errno == EPIPE) {
        return EXIT_DONE;
    }
    (void)fprintf(stderr, "lumdump: standard output: cannot be written: %s\n",
                  strerror(errno));
    return EXIT_FAILED;
}

static enum exit_status finish(struct pass *pass, lum_error *error)
{
    const struct options *o = pass->options;
    const bool has_output = pass->output != NULL;
    warn_of_losses(pass);
    if (has_output) {
        struct output *output = pass->output;
        pass->output = NULL;
        if (output_close(output, error) != 0) {
            return errno == EPIPE ? EXIT_DONE : complain(error, EXIT_FAILED);
        }
    }
    if (o->json) {
        summary_print_json(&pass->summary, stdout);
    } else if (!o->quiet) {
        summary_print_text(&pass->summary, has_output ? stderr : stdout);
    }
    return flush_stdout();
}

static enum exit_status conclude(struct pass *pass, enum pass_result result,
                                 lum_error *error)
{
    switch (result) {
    case PASS_SENSORS:
        return name_sensors(pass);
    case PASS_FAILED:
        return complain(error, EXIT_FAILED);
    case PASS_REFUSED:
        return complain(error, EXIT_BAD);
    case PASS_INTERRUPTED:
    case PASS_READER_LEFT:
        return EXIT_DONE;
    case PASS_DONE:
    default:
        break;
    }
    if (lacks_asked_sensor(pass)) {
        return refuse_sensor(pass);
    }
    if (lacks_data(pass)) {
        diagnosis_print(&pass->diagnosis, pass->options->source, stderr);
        return EXIT_FAILED;
    }
    return finish(pass, error);
}

/* The first of two passes; what it found out stays in pass where it did not
 * come to its end. */
static enum pass_result rehearse(struct pass *pass, struct output **rehearsal,
                                 lum_error *error)
{
    const struct pass fresh = *pass;
    if (!is_regular(pass->options->source)) {
        (void)lum_error_set(error,
                            "the format's header holds the number of points: "
                            "a source that can be read once cannot go to an "
                            "output that cannot seek; use -o FILE, or csv");
        return PASS_REFUSED;
    }
    if (output_rehearse(pass->options, pass->projector, &pass->output, error) !=
        0) {
        return PASS_FAILED;
    }
    const enum pass_result result = pass_run(pass, error);
    *rehearsal = pass->output;
    pass->output = NULL;
    if (result == PASS_DONE) {
        pass_free(pass);
        *pass = fresh;
    }
    return result;
}

static enum pass_result write_all(struct pass *pass, lum_error *error)
{
    const struct options *o = pass->options;
    struct output *rehearsal = NULL;
    enum pass_result result = PASS_DONE;
    if (o->output != NULL && needs_rehearsal(o)) {
        result = rehearse(pass, &rehearsal, error);
    }
    if (result == PASS_DONE && o->output != NULL &&
        output_open(o, pass->projector, rehearsal, &pass->output, error) != 0) {
        result = PASS_FAILED;
    }
    output_abort(rehearsal);
    return result == PASS_DONE ? pass_run(pass, error) : result;
}

static enum exit_status run(const struct options *o)
{
    lum_error error = {""};
    lum_layout layout;
    lum_projector projector;
    struct progress progress;
    progress_init(&progress, o->quiet);
    if (load(o, &layout, &projector, &error) != 0 ||
        (o->output != NULL && check_output(o, &error) != 0)) {
        return complain(&error, EXIT_BAD);
    }
    struct pass pass = {.options = o,
                        .layout = &layout,
                        .projector = &projector,
                        .progress = &progress};
    const enum pass_result result = write_all(&pass, &error);
    const enum exit_status status = conclude(&pass, result, &error);
    output_abort(pass.output);
    pass_free(&pass);
    return status;
}

int main(int argc, char **argv)
{
    struct options options;
    interrupt_catch();
    switch (options_parse(argc, argv, &options)) {
    case PARSED_DONE:
        return (int)flush_stdout();
    case PARSED_BAD:
        return EXIT_BAD;
    case PARSED_RUN:
    default:
        break;
    }
    const enum exit_status status = run(&options);
    if (interrupt_signal() != 0) {
        interrupt_die();
    }
    return (int)status;
}
