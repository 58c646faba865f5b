/* What lumsim was asked to do. */
#ifndef LUMSIM_OPTIONS_H
#define LUMSIM_OPTIONS_H

#include "../common/set_keys.h"
#include "lum/capture/record.h"
#include "sim/fault.h"
#include "sim/render.h"
#include "timeline.h"

#include <stdbool.h>
#include <stdint.h>

/* What a run is; options say with which of them they go. */
enum mode {
    MODE_FILE = 1,  /* writes a capture */
    MODE_SCENE = 2, /* a sensor on the network that looks at a scene */
    MODE_REPLAY = 4 /* one that sends what a capture holds */
};

/* Whose data of a capture is replayed. */
struct replayed_sensor {
    uint32_t address; /* 0: the only one that there is; it is an error if there
                         are several */
    char interface[LUM_INTERFACE_BYTES]; /* empty: none was named */
    uint16_t port;                       /* of sensors there; 0: LUM_PORT */
};

/* Texts are NULL where the option was not given. */
struct options {
    enum mode mode;
    lum_render_options render;
    double faults[LUM_FAULT_KINDS]; /* probabilities */
    double answer_loss;             /* a probability */
    const char *output;             /* "-": standard output */
    const char *truth;              /* the exact points */
    const char *true_calibration;   /* as YAML */
    struct set_keys set;            /* on top of these */
    const char *calibration;
    const char *profile;
    const char *interface;
    const char *log; /* "-": standard output */
    const char *replay;
    int64_t frames;  /* 0: as many as suit the number of lines */
    uint32_t sensor; /* addresses in host order; 0: as suits the mode */
    uint32_t client;
    struct replayed_sensor replayed;
    uint32_t clock_us; /* at boot */
    uint16_t boot_status;
    uint16_t client_port;
    uint16_t port;
    double duration_s; /* 0: until a signal comes */
    double jitter_ms;
    double drift_ppm; /* by which the capture's clock is faster */
    double batch_ms;  /* 0: each packet has its own stamp */
    bool truth_is_utc;
    bool has_walls; /* --walls was given */
    double answer_delay_ms;
    double speed; /* of a replay */
    struct timeline timeline;
    bool loop;
    bool joined; /* data packets of one size go as one message, or stand in a
                    capture as one */
    bool quiet;
};

/* Reads the command line and the files it names; complains on standard error.
 * Returns -1 when the run may begin, else the exit status. */
int options_parse(int argc, char **argv, struct options *out);

/* What --help prints, in two parts. */
extern const char options_help_outputs[];
extern const char options_help_scene[];

#endif
