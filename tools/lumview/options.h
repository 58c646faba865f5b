/* What lumview was asked to do. */
#ifndef LUMVIEW_OPTIONS_H
#define LUMVIEW_OPTIONS_H

#include "../common/set_keys.h"
#include "../common/sources.h"
#include "lum/capture/record.h"
#include "lum/config/rig.h"
#include "lum/frame/poses.h"
#include "lum/net/socket.h"

#include <stdbool.h>
#include <stdint.h>

struct served;

/* Of several sensors of a capture. */
struct sensor_choice {
    bool is_given;    /* this one; else the first that sends data */
    const char *text; /* as it was given; the name of a rig's sensor */
    uint32_t address; /* host order */
    char interface[LUM_INTERFACE_BYTES]; /* empty: none was named */
    uint16_t port;                       /* the sensors'; 0: as ever */
};

/* How a capture is played at first. */
struct play_options {
    bool loops;
    bool paused;  /* at its first frame */
    double speed; /* 1: as it was */
};

/* A sensor, and how to use it. */
struct live_options {
    lum_endpoint address;
    const char *interface; /* may be NULL */
    bool laser;            /* switch it on, and off at the end */
};

/* Where the server listens. */
struct listen_options {
    uint16_t port;    /* 0: any that is free */
    bool has_address; /* elsewhere than on 127.0.0.1 */
    uint32_t address; /* host order */
};

/* What is known beside the points. */
struct beside_options {
    const char *labels;          /* an array of NumPy; NULL: none */
    const char *truth;           /* likewise, or a capture */
    const char *poses_path;      /* NULL: none */
    const struct served *served; /* as arrays, once they are read */
    const lum_poses *poses;      /* likewise; NULL: there are none */
};

struct options {
    const char *source;     /* what it is called: captures, or udp://ADDRESS */
    struct sources sources; /* captures; "-": on standard input */
    bool is_live;
    struct live_options live;
    struct sensor_choice sensor;
    struct play_options play;
    struct listen_options listen;
    struct beside_options beside;
    const char *calibration;  /* NULL: the default */
    struct set_keys set;      /* on top of files */
    const char *profile;      /* NULL: the default */
    const char *rig_path;     /* in place of both; NULL: no rig */
    const lum_rig_files *rig; /* once it is read; of --sensor that one first */
    size_t shown;             /* of it: the first ones */
    const char *second;       /* another to show beside it; NULL: none */
    bool stays_closed;        /* no browser is started */
    bool json;
    bool quiet;
};

enum parsed {
    PARSED_RUN,  /* go on */
    PARSED_DONE, /* help or version was printed */
    PARSED_BAD   /* a message was printed */
};

/* out: its sources are to be freed by sources_free() whatever the result. */
enum parsed options_parse(int argc, char **argv, struct options *out);

/* What --help prints. */
extern const char help_text[];

#endif
