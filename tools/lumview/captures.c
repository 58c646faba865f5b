#define _POSIX_C_SOURCE 200809L
#include "captures.h"

#include "../common/source_walk.h"
#include "pump.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

struct captures {
    const struct sources *sources;
    const char **paths;  /* for reading them */
    struct pump **pumps; /* of inputs that can be read only once; else NULL */
    bool are_files;
    bool is_quiet;
    const char *rig; /* NULL: none */
};

/* --- Opening and closing --- */

/* Standard input, a pipe, a device. */
static bool is_stream(const char *path)
{
    struct stat st;
    return strcmp(path, "-") == 0 ||
           (stat(path, &st) == 0 && !S_ISREG(st.st_mode) &&
            !S_ISDIR(st.st_mode));
}

/* Pumps wait for what they are given. */
static int try_files(const struct captures *c, lum_error *error)
{
    lum_capture *capture = NULL;
    size_t count = 0;
    const char **files = calloc(c->sources->count, sizeof *files);
    if (files == NULL) {
        return lum_error_set(error, "out of memory");
    }
    for (size_t i = 0; i < c->sources->count; i++) {
        if (c->pumps[i] == NULL) {
            files[count++] = c->paths[i];
        }
    }
    const int result =
        count > 0 ? lum_capture_open_several(files, count, &capture, error) : 0;
    lum_capture_close(capture);
    free(files);
    return result;
}

static int start(struct captures *c, size_t i, lum_error *error)
{
    c->paths[i] = c->sources->paths[i];
    if (!is_stream(c->paths[i])) {
        return 0;
    }
    c->are_files = false;
    if (pump_start(c->paths[i], &c->pumps[i], error) != 0) {
        return -1;
    }
    c->paths[i] = pump_path(c->pumps[i]);
    return 0;
}

static int start_all(struct captures *c, lum_error *error)
{
    const size_t count = c->sources->count;
    c->paths = calloc(count, sizeof *c->paths);
    c->pumps = calloc(count, sizeof(struct pump *));
    if (c->paths == NULL || c->pumps == NULL) {
        return lum_error_set(error, "out of memory");
    }
    for (size_t i = 0; i < count; i++) {
        if (start(c, i, error) != 0) {
            return -1;
        }
    }
    return try_files(c, error);
}

int captures_new(const struct sources *sources, const char *rig, bool is_quiet,
                 struct captures **out, lum_error *error)
{
    if (sources_check_folders(sources, error) != 0) {
        return -1;
    }
    struct captures *c = calloc(1, sizeof *c);
    if (c == NULL) {
        return lum_error_set(error, "out of memory");
    }
    c->sources = sources;
    c->are_files = true;
    c->is_quiet = is_quiet;
    c->rig = rig;
    if (start_all(c, error) != 0) {
        captures_free(c);
        return -1;
    }
    *out = c;
    return 0;
}

void captures_stop(struct captures *captures)
{
    for (size_t i = 0; captures != NULL && i < captures->sources->count; i++) {
        pump_stop(captures->pumps[i]);
    }
}

void captures_free(struct captures *captures)
{
    if (captures == NULL) {
        return;
    }
    for (size_t i = 0; captures->pumps != NULL && i < captures->sources->count;
         i++) {
        pump_end(captures->pumps[i]);
    }
    free(captures->paths);
    free(captures->pumps);
    free(captures);
}

/* --- Names --- */

bool captures_are_files(const struct captures *captures)
{
    return captures->are_files;
}

static const char *name_of(const struct captures *c, size_t i)
{
    const char *path = c->sources->paths[i];
    return strcmp(path, "-") == 0 ? "standard input" : path;
}

static bool is_at(const char *text, const char *path)
{
    const size_t len = strlen(path);
    return strncmp(text, path, len) == 0 &&
           (text[len] < '0' || text[len] > '9');
}

/* In messages, the name of a pump is replaced by that of its source. */
static void name_source(const struct captures *c, size_t i, char *text,
                        size_t room)
{
    char rest[LUM_ERROR_BYTES];
    char *at = text;
    while (*at != '\0' && !is_at(at, c->paths[i])) {
        at++;
    }
    if (*at != '\0') {
        (void)snprintf(rest, sizeof rest, "%s", at + strlen(c->paths[i]));
        (void)snprintf(at, room - (size_t)(at - text), "%s%s", name_of(c, i),
                       rest);
    }
}

static void name_sources(const struct captures *c, char *text, size_t room)
{
    for (size_t i = 0; i < c->sources->count; i++) {
        if (c->pumps[i] != NULL) {
            name_source(c, i, text, room);
        }
    }
}

/* --- Reading --- */

int captures_open(const struct captures *captures, lum_capture **out,
                  lum_error *error)
{
    const int result = lum_capture_open_several(
        captures->paths, captures->sources->count, out, error);
    if (result != 0 && error != NULL) {
        name_sources(captures, error->text, sizeof error->text);
    }
    return result;
}

int captures_next(const struct captures *captures, lum_capture *capture,
                  lum_record *out, lum_error *error)
{
    const int status = lum_capture_next(capture, out, error);
    if (status < 0 && error != NULL) {
        name_sources(captures, error->text, sizeof error->text);
    }
    return status;
}

/* What may be between captures, and what it means. */
struct seam {
    bool (*is_it)(const struct source_walk *walk);
    const char *meaning;
    const char *more;
};

static const struct seam seams[] = {
    {source_walk_is_gap, "", "gaps"},
    {source_walk_is_overlap,
     ": where both have packets of the shown sensor, its frames have points of "
     "both",
     "overlaps"}};

/* The first one, and how many more there are. */
static void add_seam(const struct seam *seam, const lum_capture *capture,
                     char *out, size_t room)
{
    struct source_walk walk = {.capture = capture,
                               .source.struct_size = sizeof walk.source};
    size_t count = 0;
    size_t len = strlen(out);
    char text[LUM_ERROR_BYTES / 4];
    while (source_walk_step(&walk)) {
        if (seam->is_it(&walk) && ++count == 1u) {
            const double s = (double)walk.gap_ns * 1e-9;
            (void)snprintf(out + len, room - len, "%s%.3f %s%s",
                           len > 0 ? "; " : "", s < 0 ? -s : s,
                           source_walk_text(&walk, text, sizeof text),
                           seam->meaning);
        }
    }
    len = strlen(out);
    if (count > 1u) {
        (void)snprintf(out + len, room - len, "; there are %zu more %s",
                       count - 1u, seam->more);
    }
}

/* "" where none are. */
static void write_seams(const struct captures *c, const lum_capture *capture,
                        char *out, size_t room)
{
    *out = '\0';
    for (size_t i = 0; i < sizeof seams / sizeof seams[0]; i++) {
        add_seam(&seams[i], capture, out, room);
    }
    name_sources(c, out, room);
}

/* Likewise. */
static void write_remarks(const struct captures *c, const lum_capture *capture,
                          const lum_demux *demux, char *out, size_t room)
{
    lum_error remark = {""};
    (void)lum_capture_damaged(capture, &remark);
    (void)snprintf(out, room, "%s", remark.text);
    name_sources(c, out, room);
    size_t len = strlen(out);
    for (size_t i = 0; lum_capture_remark(capture, demux, 0, i, &remark); i++) {
        (void)snprintf(out + len, room - len, "%s%s", len > 0 ? "; " : "",
                       remark.text);
        len += strlen(out + len);
    }
}

static void warn(const char *text)
{
    if (text[0] != '\0') {
        (void)fprintf(stderr, "lumview: warning: %s\n", text);
    }
}

void captures_warn(const struct captures *captures, const lum_capture *capture,
                   const lum_demux *demux)
{
    char text[FEED_TEXT_BYTES];
    if (!captures->is_quiet) {
        write_seams(captures, capture, text, sizeof text);
        warn(text);
        write_remarks(captures, capture, demux, text, sizeof text);
        warn(text);
    }
}

/* --- What they say of themselves --- */

static bool is_pumped(const struct captures *c, const char *path)
{
    for (size_t i = 0; i < c->sources->count; i++) {
        if (c->pumps[i] != NULL && strcmp(c->paths[i], path) == 0) {
            return true;
        }
    }
    return false;
}

static void write_other(const struct captures *c,
                        const struct provenance_other *o, char *out,
                        size_t room)
{
    if (c->rig != NULL) {
        (void)snprintf(out, room,
                       "%.200s: it has a %s of its own, which is not used: "
                       "%.200s says which file each sensor has",
                       o->source, o->what, c->rig);
    } else if (is_pumped(c, o->source)) {
        (void)snprintf(out, room,
                       "%.200s: it has a %s of its own, which is not used: "
                       "save it as a file and show that, or name its %s by "
                       "--%s",
                       o->source, o->what, o->what, o->what);
    } else if (o->speaker == NULL || strcmp(o->speaker, o->source) == 0) {
        (void)snprintf(out, room,
                       "%.200s: a later part of it has another calibration or "
                       "profile: those of its begin are used for all",
                       o->source);
    } else {
        (void)snprintf(out, room,
                       "%.200s: its calibration or its profile is not that of "
                       "%.200s, which is used for all",
                       o->source, o->speaker);
    }
    name_sources(c, out, room);
}

void captures_tell_others(const struct captures *captures,
                          const lum_capture *capture,
                          const struct provenance_source *said,
                          struct stage *stage)
{
    char text[LUM_ERROR_BYTES];
    struct provenance_other other;
    if (provenance_find_other(capture, said, &other)) {
        write_other(captures, &other, text, sizeof text);
        stage_set_text(stage, FEED_OTHERS, text);
    }
}

void captures_tell(const struct captures *captures, const lum_capture *capture,
                   const lum_demux *demux, const struct provenance_source *said,
                   struct stage *stage)
{
    char text[FEED_TEXT_BYTES];
    captures_tell_others(captures, capture, said, stage);
    write_seams(captures, capture, text, LUM_ERROR_BYTES);
    stage_set_text(stage, FEED_GAPS, text);
    write_remarks(captures, capture, demux, text, sizeof text);
    stage_set_text(stage, FEED_REMARKS, text);
}
