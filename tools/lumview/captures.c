#include "captures.h"

#include "../common/file_look.h"
#include "../common/source_walk.h"
#include "base/text.h"
#include "capture/capture_internal.h"
#include "thread_monitor.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct captures {
    const struct sources *sources;
    bool is_quiet;
    const char *rig; /* NULL: none */
};

/* --- Opening and closing --- */

/* Standard input, a pipe, a device. */
static bool is_stream(const char *path)
{
    struct file_look look;
    return input_files_is_stdin(path) ||
           (file_look(path, &look) &&
            (look.kind == FILE_PIPE || look.kind == FILE_DEVICE));
}

/* Files. What can be read once is opened when it is read: that waits. */
static int try_files(const struct captures *c, lum_error *error)
{
    lum_capture *capture = NULL;
    size_t count = 0;
    const char **files = calloc(c->sources->count + 1u, sizeof *files);
    if (files == NULL) {
        return lum_error_set(error, "out of memory");
    }
    for (size_t i = 0; i < c->sources->count; i++) {
        if (!is_stream(c->sources->paths[i])) {
            files[count++] = c->sources->paths[i];
        }
    }
    const int result =
        count > 0 ? lum_capture_open_several(files, count, &capture, error) : 0;
    lum_capture_close(capture);
    free(files);
    return result;
}

static int start(struct captures *c, lum_error *error)
{
    for (size_t i = 0; i < c->sources->count; i++) {
        if (!thread_exists() && is_stream(c->sources->paths[i])) {
            return lum_error_set(error,
                                 "%s: it is not a file, and only files can be "
                                 "read here",
                                 c->sources->paths[i]);
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
    c->is_quiet = is_quiet;
    c->rig = rig;
    if (start(c, error) != 0) {
        captures_free(c);
        return -1;
    }
    *out = c;
    return 0;
}

void captures_free(struct captures *captures)
{
    free(captures);
}

bool captures_are_files(const struct captures *captures)
{
    size_t i = 0;
    while (i < captures->sources->count &&
           !is_stream(captures->sources->paths[i])) {
        i++;
    }
    return i == captures->sources->count;
}

int captures_open(const struct captures *captures, lum_go_on *go_on,
                  lum_capture **out, lum_error *error)
{
    const lum_capture_from from = {.paths = captures->sources->paths,
                                   .count = captures->sources->count,
                                   .go_on = go_on};
    return lum_capture_open_from(&from, out, error);
}

/* --- What is odd about them --- */

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
    char text[LUM_ERROR_BYTES / 4];
    while (source_walk_step(&walk)) {
        if (seam->is_it(&walk) && ++count == 1u) {
            const double s = (double)walk.gap_ns * 1e-9;
            lum_text_add(out, room, "%s%.3f %s%s", *out != '\0' ? "; " : "",
                         s < 0 ? -s : s,
                         source_walk_text(&walk, text, sizeof text),
                         seam->meaning);
        }
    }
    if (count > 1u) {
        lum_text_add(out, room, "; there are %zu more %s", count - 1u,
                     seam->more);
    }
}

/* "" where none are. */
static void write_seams(const lum_capture *capture, char *out, size_t room)
{
    *out = '\0';
    for (size_t i = 0; i < sizeof seams / sizeof seams[0]; i++) {
        add_seam(&seams[i], capture, out, room);
    }
}

/* Likewise. */
static void write_remarks(const lum_capture *capture, const lum_demux *demux,
                          char *out, size_t room)
{
    lum_error remark = {""};
    (void)lum_capture_damaged(capture, &remark);
    (void)snprintf(out, room, "%s", remark.text);
    for (size_t i = 0; lum_capture_remark(capture, demux, 0, i, &remark); i++) {
        lum_text_list(out, room, "; ", remark.text);
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
        write_seams(capture, text, sizeof text);
        warn(text);
        write_remarks(capture, demux, text, sizeof text);
        warn(text);
    }
}

/* --- What they say of themselves --- */

static bool is_of_stream(const struct captures *c, const char *name)
{
    for (size_t i = 0; i < c->sources->count; i++) {
        const char *path = c->sources->paths[i];
        const bool is_stdin = input_files_is_stdin(path);
        if (is_stream(path) &&
            strcmp(is_stdin ? "standard input" : path, name) == 0) {
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
    } else if (is_of_stream(c, o->source)) {
        (void)snprintf(out, room,
                       "%.200s: it has a %s of its own, which is not used: "
                       "save it as a file and show that, or name its %s by "
                       "--%s",
                       o->source, o->what, o->what, o->what);
    } else if (o->speaker == NULL || strcmp(o->speaker, o->source) == 0) {
        (void)snprintf(out, room,
                       "%.200s: a later part of it has another calibration or "
                       "profile: those at its start are used for all",
                       o->source);
    } else {
        (void)snprintf(out, room,
                       "%.200s: its calibration or its profile is not that of "
                       "%.200s, which is used for all",
                       o->source, o->speaker);
    }
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
    write_seams(capture, text, LUM_ERROR_BYTES);
    stage_set_text(stage, FEED_GAPS, text);
    write_remarks(capture, demux, text, sizeof text);
    stage_set_text(stage, FEED_REMARKS, text);
}
