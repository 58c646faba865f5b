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

/* Frames of a run without --frames; 640 lines on the network have fewer. */
#define FRAMES_USUAL 10

/* A simulated sensor whose data is later than this skips lines. */
#define FEED_LAG_MAX_NS INT64_C(200000000)

/* A capture that is written. */
struct capture_options {
    const char *output; /* "-": standard output */
    uint32_t client;    /* address in host order */
    uint16_t client_port;
    double drift_ppm; /* by which the capture's clock is faster */
    double batch_ms;  /* 0: each packet has its own stamp */
};

/* What is written beside it. */
struct truth_options {
    const char *points;      /* the exact ones */
    const char *calibration; /* the true one, as YAML */
    bool is_utc;             /* times of points */
};

/* A sensor that moves, and what is written of that. */
struct moving_options {
    const char *path;   /* as it was given */
    const char *poses;  /* of each line */
    const char *labels; /* of each exact point */
    lum_pose *given;    /* those of a file of --path; moving_free() frees it */
    double *given_s;    /* their times; likewise */
    bool has_velocity;  /* --velocity was given */
};

/* A sensor on the network. */
struct live_options {
    const char *interface;
    uint16_t port;
    uint32_t clock_us; /* at boot */
    uint16_t boot_status;
    double duration_s; /* 0: until a signal comes */
    const char *log;   /* "-": standard output */
};

/* What becomes of its data, of its answers on their way. */
struct delivery_options {
    double faults[LUM_FAULT_KINDS]; /* probabilities */
    double jitter_ms;
    bool joined; /* data packets of one size go as one message, or stand in a
                    capture as one */
};
struct answer_options {
    double loss; /* a probability */
    double delay_ms;
};

/* Whose data of a capture is replayed. */
struct replayed_sensor {
    uint32_t address; /* 0: the only one that there is; it is an error if there
                         are several */
    char interface[LUM_INTERFACE_BYTES]; /* empty: none was named */
    uint16_t port;                       /* of sensors there; 0: LUM_PORT */
};

/* A capture that is sent. */
struct replay_options {
    const char *path;
    struct replayed_sensor sensor;
    double speed;
    bool loops;
};

/* The sensors of a vehicle, whose file names them. */
struct rig_options {
    const char *path;        /* of the file */
    struct rig_files *files; /* what was read; rig_free() frees it */
    struct options *sensors; /* of each those of its own; likewise */
    size_t count;            /* of sensors */
    const char *name;        /* in the options of one: its own */
    const char *interface;   /* likewise; empty: it has none */
};

/* Texts are NULL where the option was not given. */
struct options {
    enum mode mode;
    lum_render_options render;
    struct capture_options capture;
    struct truth_options truth;
    struct moving_options moving;
    struct live_options live;
    struct delivery_options delivery;
    struct answer_options answers;
    struct replay_options replay;
    struct rig_options rig;
    struct timeline timeline;
    const char *calibration;
    const char *profile;
    struct set_keys set; /* on top of these */
    int64_t frames;      /* 0: as many as suit the number of lines */
    uint32_t sensor;     /* address in host order; 0: as suits the mode */
    bool has_walls;      /* --walls was given */
    bool quiet;
};

/* complaint.c: say what is wrong, as a line on standard error. Returns false.
 */
LUM_PRINTF(1, 2) bool complain(const char *format, ...);

/* Reads the command line and the files it names; complains on standard error.
 * Returns -1 when the run may begin, else the exit status. */
int options_parse(int argc, char **argv, struct options *out);

#endif
