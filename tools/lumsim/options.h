/* What lumsim was asked to do. */
#ifndef LUMSIM_OPTIONS_H
#define LUMSIM_OPTIONS_H

#include "sim/fault.h"
#include "sim/render.h"

#include <stdbool.h>
#include <stdint.h>

struct options {
    lum_render_options render;
    double faults[LUM_FAULT_KINDS]; /* probabilities */
    const char *output;             /* "-": standard output */
    const char *truth;              /* NULL: none */
    const char *calibration;        /* NULL: the default */
    const char *profile;            /* NULL: the default */
    int64_t frames;
    uint32_t sensor; /* addresses in host order */
    uint32_t client;
    uint16_t client_port;
    bool quiet;
};

/* Reads the command line and the files it names; complains on standard error.
 * Returns -1 when the run may begin, else the exit status. */
int options_parse(int argc, char **argv, struct options *out);

#endif
