/* What lumview was asked to do. */
#ifndef LUMVIEW_OPTIONS_H
#define LUMVIEW_OPTIONS_H

#include "../common/set_keys.h"
#include "../common/sources.h"
#include "lum/capture/record.h"
#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

struct options {
    const char *source;     /* what it is called: captures, or udp://ADDRESS */
    struct sources sources; /* captures; "-": on standard input */
    bool is_live;
    lum_endpoint address;    /* live: the sensor's */
    const char *interface;   /* live; may be NULL */
    bool laser;              /* live: switch it on, and off at the end */
    const char *calibration; /* NULL: the default */
    struct set_keys set;     /* on top of files */
    const char *profile;     /* NULL: the default */
    const char *second;      /* another to show beside it; NULL: none */
    bool has_sensor;         /* capture: of several sensors this one */
    uint32_t sensor;
    char sensor_interface[LUM_INTERFACE_BYTES]; /* empty: none was named */
    uint16_t sensor_port; /* capture: the sensors'; 0: as ever */
    uint16_t port;        /* 0: any that is free */
    bool has_bind;        /* listens elsewhere than on 127.0.0.1 */
    uint32_t bind;        /* host order */
    bool stays_closed;    /* no browser is started */
    bool json;
    bool quiet;
    bool loops;   /* capture */
    bool paused;  /* capture: begins paused at its first frame */
    double speed; /* capture; 1: as it was */
};

enum parsed {
    PARSED_RUN,  /* go on */
    PARSED_DONE, /* help or version was printed */
    PARSED_BAD   /* a message was printed */
};

/* out: to be freed by options_free() whatever the result. */
enum parsed options_parse(int argc, char **argv, struct options *out);

void options_free(struct options *options);

#endif
