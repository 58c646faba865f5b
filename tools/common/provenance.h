/* Where packets and points come from, and what it takes to read them: texts
 * that stand in comments of the files (docs/formats.md, "Provenance"). Each is
 * a YAML document whose first line tells its kind:
 *
 *   # lumsdk calibration 1
 */
#ifndef LUM_TOOLS_PROVENANCE_H
#define LUM_TOOLS_PROVENANCE_H

#include "geometry.h"
#include "sources.h"

#include "lum/capture/capture.h"
#include "lum/host/keys.h"

#include <stdbool.h>
#include <stddef.h>

#define PROVENANCE_MARK         "# lumsdk "
#define PROVENANCE_ORIGIN_BYTES 6144u

/* Bytes of a calibration's or a profile's text. */
#define PROVENANCE_KEYS_BYTES (LUM_KEYS_WRITE_BYTES + 64u)

/* Origins of the source, the nearest first; what is farther is left out. */
#define PROVENANCE_EARLIER_MAX 4u

/* What there is to say about a capture's comments. */
#define PROVENANCE_NOTES_MAX 8u

/* What a capture says of itself. */
struct provenance_source {
    char earlier[PROVENANCE_EARLIER_MAX][PROVENANCE_ORIGIN_BYTES];
    size_t earlier_count;
    lum_error notes[PROVENANCE_NOTES_MAX];
    size_t note_count;
    size_t speaker;   /* its first source that says something; those of a
                         calibration and a profile are taken from it alone */
    size_t looked_at; /* as many of the speaker's comments */
    size_t others;    /* comments of other sources that differ from these */
    const char *path; /* the speaker's, of what provenance_ask() found; NULL:
                         nothing */
    bool takes_calibration; /* the command line names none */
    bool takes_profile;     /* likewise */
};

/* What a run is about. */
struct provenance_run {
    const char *program;        /* such as "lumdump" */
    const char *source;         /* as it was named */
    const char *const *options; /* such as "--eye=blue" */
    size_t option_count;
    const char *const *sensors; /* of a rig, a line each; NULL: there is none */
    size_t sensor_count;
};

#define PROVENANCE_COMMENTS_MAX (3u + PROVENANCE_EARLIER_MAX)

/* What a file is to say. */
struct provenance {
    char program[64];
    char origin[PROVENANCE_ORIGIN_BYTES];
    char calibration[PROVENANCE_KEYS_BYTES];       /* empty: the built-in one */
    char profile[PROVENANCE_KEYS_BYTES];           /* likewise */
    const char *comments[PROVENANCE_COMMENTS_MAX]; /* of these and others */
    size_t comment_count;
    char text[PROVENANCE_ORIGIN_BYTES * (1u + PROVENANCE_EARLIER_MAX) +
              PROVENANCE_KEYS_BYTES * 2u]; /* all of them, as documents of one
                                              stream of YAML */
};

/* Take what a capture knows and the command line does not say. Of both the
 * command line's is used, and that is noted; so is what cannot be used, which
 * is ignored. Of several sources the first that says something is heard, and
 * noted is what others say that differs. */
void provenance_take(const lum_capture *capture, struct geometry *geometry,
                     struct provenance_source *out);

/* The same of files, for a tool that opens them later. Prints the notes, unless
 * it is to be quiet. Streams are not asked; where there are only such, or one
 * cannot be opened, nothing is taken. out: points into sources. */
void provenance_ask(const char *program, const struct sources *sources,
                    bool is_quiet, struct geometry *geometry,
                    struct provenance_source *out);

/* A source that has a calibration or a profile that is not used. */
struct provenance_other {
    const char *source;  /* lives as long as the capture, and so does speaker */
    const char *speaker; /* whose is used for all; the same as source: it says
                            else later on; NULL: nobody's */
    const char *what;    /* "calibration" or "profile" */
};

/* Find the first of them that has been read, of the sources of
 * provenance_ask(). What the command line names is no matter. False: there is
 * none. */
bool provenance_find_other(const lum_capture *capture,
                           const struct provenance_source *asked,
                           struct provenance_other *out);

/* Whether what has been read of the capture since brought another calibration
 * or another profile, of those that are taken from it. */
bool provenance_has_changed(const lum_capture *capture,
                            const struct provenance_source *source);

/* Make what a file says. source may be NULL. Points into itself and into the
 * source, so neither may move. */
void provenance_make(const struct provenance_run *run,
                     const struct geometry *geometry,
                     const struct provenance_source *source,
                     struct provenance *out);

#endif
