/* The open files of one output: one file, a file for each frame, or a series of
 * numbered files, where --rotate says when the next one begins. */
#ifndef LUMDUMP_FILE_SET_H
#define LUMDUMP_FILE_SET_H

#include "bag_folder.h"
#include "closer.h"
#include "options.h"
#include "output_file.h"
#include "retention.h"

#include "base/claim.h"

/* Frames whose files are open at once; the eyes are seldom two apart. */
#define FILE_SET_OPEN_MAX 16u

#define FILE_NAME_BYTES 4096u

/* The names of its files, and the run's right to them. */
struct file_names {
    enum {
        FILE_NAMES_ONE,       /* the output is one file */
        FILE_NAMES_OF_FRAMES, /* each frame has a file */
        FILE_NAMES_NUMBERED,  /* one after another */
        FILE_NAMES_IN_FOLDER  /* of rosbag2, one after another */
    } kind;
    const struct options *options;
    const char *name;            /* as the option gives it */
    unsigned number;             /* of the newest numbered file; 0: none */
    lum_claim claim;             /* to the name of which others are made */
    struct retention *retention; /* NULL: no file is removed */
    struct bag_folder *folder;   /* NULL: there is none */
};

/* When a series goes on in its next file. Times are since 1970. */
struct series {
    const struct rotation *limit; /* of a file; NULL: none */
    enum {
        SERIES_NO_TIME, /* none was passed yet */
        SERIES_FILLS,   /* the present file */
        SERIES_DUE      /* a new file is to begin */
    } state;
    int64_t began_ns; /* when the present file was to begin */
    int64_t now_ns;
    int64_t last_ns; /* of the last data */
    int64_t due_ns;
    int64_t top; /* the highest frame in the present file of a cloud */
};

struct file_set {
    struct file_names names;
    struct file_format format;
    bool is_in_place;      /* read as it comes */
    struct closer *closer; /* NULL: finished here */
    /* Of a series the present file, and one that takes the last lines of its
     * frames. */
    struct output_file open[FILE_SET_OPEN_MAX];
    size_t count;
    int64_t ended; /* a file for each frame: they are finished up to this one */
    struct series series;
};

/* That of the i-th output, with no file yet. To be ended by file_set_abort().
 */
void file_set_prepare(const struct options *options, size_t i,
                      struct file_set *out);

/* Take the names, open the first file. rehearsal: NULL, or a set that took the
 * lines to come. */
int file_set_open(struct file_set *set, const struct file_set *rehearsal,
                  lum_error *error);

/* Take lines and write nothing. */
int file_set_rehearse(struct file_set *set, lum_error *error);

/* Pass the time: a file that is full or old enough ends with its frame. */
int file_set_set_time(struct file_set *set, int64_t time_ns, lum_error *error);

/* The file for points of a frame, opened where there is none. *out is NULL if
 * it is finished already. It is valid until the next call. */
int file_set_of_frame(struct file_set *set, int64_t frame,
                      struct output_file **out, lum_error *error);

/* Add it to the present file of messages; in a file of one frame it would be
 * that of others. */
int file_set_add_status(struct file_set *set, const lum_writer_status *status,
                        lum_error *error);

/* Add it to the present file. begins_frame: the next file may begin with it. */
int file_set_add_datagram(struct file_set *set, const lum_record *record,
                          bool begins_frame, lum_error *error);

/* What output_act() says of them; as output_find_lost(). */
int file_set_end_frame(struct file_set *set, int64_t frame, lum_error *error);
int file_set_flush(struct file_set *set, bool files, lum_error *error);
bool file_set_find_lost(struct file_set *set, lum_error *out);

/* Finish all of them, wait until that is done. To be followed by
 * file_set_abort(). */
int file_set_close(struct file_set *set, lum_error *error);

/* Remove unfinished files, except recordings; give the names back. */
void file_set_abort(struct file_set *set);

/* Whether files of an earlier, longer run follow the newest one; out says so.
 */
bool file_names_find_stale(const struct file_names *names, lum_error *out);

#endif
