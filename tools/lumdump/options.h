/* What lumdump was asked to do, and what that says of each output. */
#ifndef LUMDUMP_OPTIONS_H
#define LUMDUMP_OPTIONS_H

#include "../common/option_table.h"
#include "../common/provenance.h"
#include "../common/sources.h"

#include "lum/cloud/writer.h"
#include "lum/frame/move.h"
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

/* That of the name's ending. */
#define FORMAT_BY_NAME (LUM_FORMATS + 3u)

#define OUTPUTS_MAX 16u

struct output_options {
    const char *name;
    unsigned format; /* a lum_format, or FORMAT_PCAP or FORMAT_PCAPNG */
    bool is_folder;  /* of rosbag2, with files of this format */
    unsigned sensor; /* of a rig: 1 + which of them it is of; 0: of all */
};

/* A sensor, of a live run. */
struct live_options {
    lum_endpoint address;
    const char *interface; /* may be NULL */
    bool laser;            /* switch it on, and off at the end */
    bool guards;           /* the same, but do not switch it on */
    uint64_t buffer;       /* bytes between network and outputs; 0: as many as
                              are usual */
    size_t receive_buffer; /* bytes that may wait in the kernel */
};

/* Whose packets are used. */
struct sensor_options {
    bool is_chosen;   /* a live run always does */
    const char *text; /* as --sensor names it; of a rig the name */
    uint32_t address;
    char interface[LUM_INTERFACE_BYTES]; /* empty: none was named */
    uint16_t port; /* of sensors in a capture; 0: as ever */
};

/* When an output continues in a new file, or how much of its files is kept; at
 * most one is not 0. */
struct rotation {
    uint64_t bytes;
    int64_t ns;
};

struct file_options {
    struct rotation rotation;
    struct rotation keep;
};

/* Names of files, and keys on top of them. */
struct config_options {
    struct set_keys set;
    const char *calibration;
    const char *profile;
    const char *rig; /* NULL: there is none */
};

/* Which points, lines and packets. */
struct choice_options {
    lum_selection points;
    unsigned eyes; /* bit 1 << LUM_EYE_... */
    int64_t frame_first;
    int64_t frame_last;
    uint32_t whole;      /* so many whole frames; 0: these */
    int64_t duration_ns; /* 0: all */
    bool drop_incomplete;
    bool has_packets; /* --packets was given */
    bool all_packets; /* of the time range, into captures that are cut */
};

/* What the points' times are. */
enum time_base {
    TIME_SENSOR,  /* the sensor's clock */
    TIME_UTC,     /* that, fitted to arrivals */
    TIME_ARRIVAL, /* when the line's first packet came */
};

/* Where points are moved to. */
struct motion_options {
    const char *poses; /* a file; NULL: points stay where they were seen */
    const char *times; /* of KITTI's poses; NULL: they have their own */
    lum_move_to to;
    bool has_to; /* --to was given */
};

/* How lines become points. */
struct point_options {
    uint32_t smooth_window; /* of angles; 0: none */
    uint32_t smooth_order;
    enum time_base time;
    bool has_time;    /* --time was given */
    unsigned threads; /* 0: by the cores */
    struct motion_options motion;
};

/* How pictures are drawn. */
struct picture_options {
    bool has_colour; /* --colour was given */
    unsigned colour; /* a lum_picture_colour */
    unsigned width;  /* pixels; 0: as usual */
    unsigned height;
};

/* What is in clouds. */
struct cloud_options {
    bool ascii;
    bool comments;       /* in csv and xyz */
    const char *columns; /* of csv, ply and pcd; NULL: their own */
    const char *preset;  /* of csv, ply, pcd and mcap; NULL: none */
    bool has_times;      /* the columns have times among them */
    bool wants_sensor;   /* likewise, the sensor of a rig */
    bool organized;      /* pcd: a frame as rows of pixels */
    double voxel; /* metres, of points thinned to voxels; 0: all of them */
    struct picture_options picture;
};

/* What is in MCAP files. */
struct mcap_options {
    bool has_compression; /* --compression was given, */
    bool is_plain;        /* and says none */
    unsigned contents;    /* of lum_mcap_content; 0: --mcap was not given */
    const char *frame_id; /* NULL: as the library's */
    unsigned lines;       /* of a frame, for rings; 0: as the frames show */
};

/* Options that choose or change what comes out, as they were given. */
#define FILTERS_MAX 18u

struct filter {
    char text[256];     /* such as "--eye=blue" */
    bool is_of_packets; /* captures too are chosen by it */
};

struct filters {
    struct filter list[FILTERS_MAX];
    size_t count;
};

/* What outputs say of themselves: clouds, and captures. Not the command
 * line's; known once the source is open. */
struct about {
    const struct provenance *points;
    const struct provenance *packets;
    const lum_calibration *calibration; /* that of the points */
    double origin[3];                   /* of the world's coordinates */
};

/* What is done instead of a conversion. */
struct other_work {
    const char *check_preset; /* look at a cloud, and nothing else */
    bool infer;               /* find the layout, and nothing else */
};

struct options {
    const char *source;     /* its name in messages */
    struct sources sources; /* captures */
    bool is_live;
    struct live_options live;
    struct sensor_options sensor;
    struct output_options outputs[OUTPUTS_MAX];
    size_t output_count; /* 0: only a summary */
    unsigned format;     /* what --format says; FORMAT_BY_NAME: nothing */
    struct file_options files;
    struct config_options config;
    struct choice_options choice;
    struct point_options points;
    struct cloud_options cloud;
    struct mcap_options mcap;
    struct rig *rig; /* NULL: there is none */
    struct other_work instead;
    bool json;
    bool quiet;
    struct filters filters;
    struct about about;
};

/* A question about the i-th output. */
typedef bool options_question(const struct options *options, size_t i);

/* Whether the answer is yes for any output. */
bool options_any(const struct options *options, options_question *is_so);

/* Whether a name has an ending, and more. */
bool options_has_ending(const char *name, const char *ending);

/* Whether there is a limit. */
bool options_is_rotation(const struct rotation *rotation);

/* Whether files of a format say where the points come from; many readers of
 * text do not skip comments. */
bool options_has_comment(const struct options *options, unsigned format);

/* The format by a name's ending. False: that shows none. */
bool options_find_format(const char *name, unsigned *out);

/* Whether a format is one of captures. */
bool options_is_capture(unsigned format);

/* Whether a name means one file for each frame. 0 no, 1 yes, -1: it has a %
 * that cannot be a frame number. */
int options_pattern(const char *name);

/* Whether frames were chosen, by number or as whole ones. */
bool options_has_frames(const struct options *options);

/* Whether an output holds datagrams; a capture does, and an MCAP file may. */
options_question options_takes_packets;

/* Whether it holds them alone, so that nothing is decoded for it. */
options_question options_is_recording;

/* Whether it has the fields of --preset; clouds as messages. */
options_question options_has_preset;
options_question options_has_messages;

options_question options_is_standard_output;
options_question options_is_organized;

/* Which numbers of a line's samples none of the outputs reads, as
 * lum_format_leaves(). */
unsigned options_leaves(const struct options *options);

/* Whether it is made of whole frames and not of lines as they come: in these
 * alone it is known where a point stands, and when they began. */
options_question options_takes_frames;

/* Whether points are moved into the poses' fixed frame. */
bool options_is_in_world(const struct options *options);

/* Whether all frames become one map. */
bool options_makes_map(const struct options *options);

/* Whether it continues in new files. */
options_question options_rotates;

/* How many threads are asked for, or as many as there are cores, up to 8. */
unsigned options_threads(const struct options *options);

/* Whether it is one picture; of one frame, as none was asked for, and not of
 * all that come. */
options_question options_is_picture;
options_question options_draws_one;

/* The options point into argv. To be freed by command_line_free() whatever the
 * result. */
enum option_end command_line_read(int argc, char **argv, struct options *out);

void command_line_free(struct options *options);

/* How many cores this process may use, at least 1. */
unsigned cores_count(void);

#endif
