/* What lumdump was asked to do, and what that says of each output. */
#ifndef LUMDUMP_OPTIONS_H
#define LUMDUMP_OPTIONS_H

#include "../common/provenance.h"
#include "../common/sources.h"

#include "lum/cloud/writer.h"
#include "lum/net/socket.h"
#include "lum/points.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A cloud in one of the library's formats, or the datagrams themselves. */
#define FORMAT_PCAP   LUM_FORMATS
#define FORMAT_PCAPNG (LUM_FORMATS + 1u)

/* A folder of MCAP files; only what --format says. */
#define FORMAT_ROSBAG2 (LUM_FORMATS + 2u)

#define OUTPUTS_MAX 16u

struct output_options {
    const char *name;
    unsigned format; /* a lum_format, or FORMAT_PCAP or FORMAT_PCAPNG */
    bool is_folder;  /* of rosbag2, with files of this format */
};

/* Options that choose or change what comes out, as they were given. */
#define FILTERS_MAX 13u

struct filter {
    char text[256];     /* such as "--eye=blue" */
    bool is_of_packets; /* captures too are chosen by it */
};

/* What the points' times are. */
enum time_base {
    TIME_SENSOR,  /* the sensor's clock */
    TIME_UTC,     /* that, fitted to arrivals */
    TIME_ARRIVAL, /* when the line's first packet came */
};

/* When an output continues in a new file, or how much of its files is kept; at
 * most one is not 0. */
struct rotation {
    uint64_t bytes;
    int64_t ns;
};

struct options {
    const char *source;     /* its name in messages */
    struct sources sources; /* captures */
    bool is_live;
    lum_endpoint address;  /* live: the sensor's */
    const char *interface; /* live; may be NULL */
    bool laser;            /* live: switch it on, and off at the end */
    bool guards;           /* live: the same, but do not switch it on */
    uint64_t buffer;       /* live: bytes between network and outputs; 0: as
                              many as are usual */
    size_t receive_buffer; /* live: bytes that may wait in the kernel */
    struct output_options outputs[OUTPUTS_MAX];
    size_t output_count; /* 0: only a summary */
    struct rotation rotation;
    struct rotation keep;
    struct set_keys set; /* on top of these */
    const char *calibration;
    const char *profile;
    unsigned format; /* what --format says */
    bool has_format;
    bool has_sensor; /* one was chosen, as a live run always does */
    uint32_t sensor;
    char sensor_interface[LUM_INTERFACE_BYTES]; /* empty: none was named */
    uint16_t port; /* of sensors in a capture; 0: as ever */
    lum_selection selection;
    unsigned eyes; /* bit 1 << LUM_EYE_... */
    int64_t frame_first;
    int64_t frame_last;
    uint32_t whole;      /* so many whole frames; 0: these */
    int64_t duration_ns; /* 0: all */
    bool drop_incomplete;
    bool has_packets;       /* --packets was given */
    bool all_packets;       /* of the time range, into captures that are cut */
    uint32_t smooth_window; /* of angles; 0: none */
    uint32_t smooth_order;
    enum time_base time;
    bool ascii;
    bool comments;            /* in csv and xyz */
    const char *columns;      /* of csv, ply and pcd; NULL: their own */
    const char *preset;       /* of csv, ply, pcd and mcap; NULL: none */
    const char *check_preset; /* look at a cloud, and nothing else */
    bool has_times;           /* these have a column of times */
    bool organized;           /* pcd: a frame as rows of pixels */
    bool has_compression;     /* --compression was given, */
    bool is_plain;            /* and says none; mcap */
    unsigned mcap;            /* of lum_mcap_content; 0: --mcap was not given */
    const char *frame_id;     /* of messages; NULL: as the library's */
    unsigned lines;           /* of a frame, for rings of messages; 0: as the
                                 frames show */
    unsigned threads;         /* 0: by the cores */
    bool infer;               /* find the layout, and nothing else */
    bool json;
    bool quiet;
    struct filter filters[FILTERS_MAX];
    size_t filter_count;
    /* What outputs say of themselves: clouds, and captures. Not the command
     * line's; known once the source is open. */
    const struct provenance *about_points;
    const struct provenance *about_packets;
    const lum_calibration *calibrated; /* that of the points */
};

/* A question about the i-th output. */
typedef bool options_question(const struct options *options, size_t i);

/* Whether the answer is yes for any output. */
bool options_any(const struct options *options, options_question *is_so);

/* The format by a name's ending. False: that shows none. */
bool options_find_format(const char *name, unsigned *out);

/* Whether a format is one of captures. */
bool options_is_capture(unsigned format);

/* Whether the i-th output holds datagrams; a capture does, and an MCAP file
 * may. */
bool options_takes_packets(const struct options *options, size_t i);

/* Whether it holds them alone, so that nothing is decoded for it. */
bool options_is_recording(const struct options *options, size_t i);

/* Whether the i-th output has the fields of --preset. */
bool options_has_preset(const struct options *options, size_t i);

/* Whether the i-th output has clouds as messages. */
bool options_has_messages(const struct options *options, size_t i);

/* Whether the i-th output is standard output. */
bool options_is_standard_output(const struct options *options, size_t i);

/* Whether the i-th output is made of whole frames and not of lines as they
 * come: in these alone it is known where a point stands, and when they began.
 */
bool options_takes_frames(const struct options *options, size_t i);

/* Whether a name means one file for each frame. 0 no, 1 yes, -1: it has a %
 * that cannot be a frame number. */
int options_pattern(const char *name);

/* Whether the i-th output continues in new files. */
bool options_rotates(const struct options *options, size_t i);

/* Whether frames were chosen, by number or as whole ones. */
bool options_has_frames(const struct options *options);

/* Whether it is one picture; of one frame, as none was asked for, and not of
 * all that come. */
bool options_is_picture(const struct options *options, size_t i);
bool options_draws_one(const struct options *options, size_t i);

/* Whether it is an organised cloud. */
bool options_is_organized(const struct options *options, size_t i);

#endif
