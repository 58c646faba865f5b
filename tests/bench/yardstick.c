/* What lumdump's speed is held against, each a whole process:
 *
 *   yardstick write BYTES FILE    write() from memory, 1 MB a call, a new file,
 *                                 and fsync()
 *   yardstick read FILE           read() of all, 1 MB a call
 *   yardstick csv CAPTURE FILE    the rows of lumdump's CSV, by fprintf */
#define _POSIX_C_SOURCE 200809L
#include "lum/capture/demux.h"
#include "lum/points.h"

#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define BLOCK_BYTES 1000000u
#define LINE_WORDS  16384u

static int fail(const char *what)
{
    perror(what);
    return 1;
}

static int write_file(unsigned long long bytes, const char *path)
{
    static char block[BLOCK_BYTES];
    memset(block, 'x', sizeof block);
    const int fd = open(path, O_WRONLY | O_CREAT | O_EXCL, 0644);
    if (fd < 0) {
        return fail(path);
    }
    while (bytes > 0) {
        const size_t n = bytes < BLOCK_BYTES ? (size_t)bytes : BLOCK_BYTES;
        const ssize_t written = write(fd, block, n);
        if (written < 0) {
            return fail(path);
        }
        bytes -= (unsigned long long)written;
    }
    return fsync(fd) == 0 && close(fd) == 0 ? 0 : fail(path);
}

static int read_file(const char *path)
{
    static char block[BLOCK_BYTES];
    ssize_t n = 0;
    const int fd = open(path, O_RDONLY);
    if (fd < 0) {
        return fail(path);
    }
    while ((n = read(fd, block, sizeof block)) > 0) {
    }
    return n == 0 && close(fd) == 0 ? 0 : fail(path);
}

struct context {
    lum_demux *demux;
    lum_projector projector;
    lum_selection selection;
    lum_sample_workspace workspace;
    lum_return returns[LINE_WORDS];
    lum_sample samples[LINE_WORDS];
    FILE *out;
};

static void print_line(struct context *c, const lum_line *line)
{
    lum_point_losses losses = {0, 0};
    const size_t n = lum_samples_compute(&c->projector, line, &c->selection,
                                         &c->workspace, c->samples, &losses);
    for (size_t i = 0; i < n; i++) {
        const lum_sample *s = &c->samples[i];
        (void)fprintf(
            c->out,
            "%.4f,%.4f,%.4f,%.4f,%.5f,%.5f,%.3f,%" PRId64 ",%" PRId64
            ",%u,%" PRIu32 ",%u,%u,%u,%u\n",
            (double)s->x, (double)s->y, (double)s->z, (double)s->range,
            (double)s->azimuth, (double)s->elevation, (double)s->pulse_width,
            line->clock_us, line->frame, line->eye, line->number, s->pixel,
            s->return_number, s->number_of_returns, s->edge);
    }
}

static void handle(struct context *c, lum_result event)
{
    if (event == LUM_LINE_READY) {
        print_line(c, lum_assembler_line(lum_demux_current(c->demux)));
    }
}

static int print_csv(struct context *c, const char *source)
{
    lum_capture *capture = NULL;
    lum_record record;
    lum_error error;
    lum_result r = LUM_OK;
    if (lum_capture_open(source, &capture, &error) != 0) {
        (void)fprintf(stderr, "yardstick: %s\n", error.text);
        return 1;
    }
    while (lum_capture_next(capture, &record, &error) > 0) {
        while ((r = lum_demux_push(c->demux, &record, NULL)) > 0) {
            handle(c, r);
        }
    }
    while ((r = lum_demux_flush(c->demux)) > 0) {
        handle(c, r);
    }
    lum_capture_close(capture);
    return 0;
}

static int make_csv(const char *source, const char *path)
{
    struct context *c = calloc(1, sizeof *c);
    lum_demux_options options = {.struct_size = sizeof options,
                                 .has_sensor = false};
    lum_calibration calibration;
    if (c == NULL) {
        return fail("memory");
    }
    lum_layout_default(&options.layout);
    lum_assembler_config_default(&options.config);
    lum_calibration_default(&calibration);
    lum_selection_default(&c->selection);
    c->workspace.returns = c->returns;
    c->out = fopen(path, "wx");
    if (lum_demux_new(&options, &c->demux, NULL) != 0 || c->out == NULL ||
        lum_projector_init(&c->projector, &calibration, &options.layout) !=
            LUM_OK) {
        return fail(path);
    }
    (void)fputs("x,y,z,range,azimuth,elevation,pulse_width,timestamp,frame,eye,"
                "line,pixel,return_number,number_of_returns,edge\n",
                c->out);
    int status = print_csv(c, source);
    if (fclose(c->out) != 0) {
        status = fail(path);
    }
    lum_demux_free(c->demux);
    free(c);
    return status;
}

int main(int argc, char **argv)
{
    if (argc == 4 && strcmp(argv[1], "write") == 0) {
        return write_file(strtoull(argv[2], NULL, 10), argv[3]);
    }
    if (argc == 3 && strcmp(argv[1], "read") == 0) {
        return read_file(argv[2]);
    }
    if (argc == 4 && strcmp(argv[1], "csv") == 0) {
        return make_csv(argv[2], argv[3]);
    }
    (void)fputs("usage: yardstick write BYTES FILE | read FILE | csv CAPTURE "
                "FILE\n",
                stderr);
    return 2;
}
