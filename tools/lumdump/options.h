/* What lumdump was asked to do. */
#ifndef LUMDUMP_OPTIONS_H
#define LUMDUMP_OPTIONS_H

#include "lum/io/writer.h"
#include "lum/points.h"

#include <stdbool.h>
#include <stdint.h>

/* A cloud in one of the library's formats, or the datagrams themselves. */
#define FORMAT_PCAP LUM_FORMATS

struct options {
    const char *source;
    const char *output; /* NULL: a summary alone */
    const char *calibration;
    const char *profile;
    unsigned format; /* a lum_format, or FORMAT_PCAP */
    bool has_format;
    bool has_sensor;
    uint32_t sensor;
    lum_selection selection;
    unsigned eyes; /* bit 1 << LUM_EYE_... */
    int64_t frame_first;
    int64_t frame_last;
    int64_t duration_ns; /* 0: all */
    bool drop_incomplete;
    bool utc;
    bool ascii;
    bool json;
    bool quiet;
};

enum parsed {
    PARSED_RUN,  /* go on */
    PARSED_DONE, /* help or version was printed */
    PARSED_BAD   /* a message was printed */
};

enum parsed options_parse(int argc, char **argv, struct options *out);

#endif
