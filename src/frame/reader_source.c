/* The capture of a reader, opened, and opened again. */
#include "reader_internal.h"

#include "base/text.h"
#include "capture/capture_internal.h"

#include <stdlib.h>
#include <string.h>

static int capture_next(void *context, lum_record *out, lum_error *error)
{
    return lum_capture_next(context, out, error);
}

static void capture_progress(void *context, uint64_t *done, uint64_t *total)
{
    lum_capture_progress(context, done, total);
}

static void capture_close(void *context)
{
    lum_capture_close(context);
}

static void close_records(const lum_record_source *records)
{
    if (records->close != NULL) {
        records->close(records->context);
    }
}

static int open_capture(lum_reader *r, const lum_capture_from *from,
                        lum_error *error)
{
    if (lum_capture_open_from(from, &r->capture, error) != 0) {
        r->capture = NULL;
        return -1;
    }
    r->source = (lum_record_source){.struct_size = sizeof r->source,
                                    .next = capture_next,
                                    .progress = capture_progress,
                                    .close = capture_close,
                                    .context = r->capture};
    return 0;
}

void lum_reader_close_source(lum_reader *r)
{
    close_records(&r->source);
    for (size_t i = 0; r->paths != NULL && i < r->path_count; i++) {
        free(r->paths[i]);
    }
    free((void *)r->paths);
    r->paths = NULL;
}

/* Files can be opened again, and pipes cannot. */
static int keep_paths(lum_reader *r, const lum_capture_from *from,
                      lum_error *error)
{
    uint64_t done = 0;
    uint64_t total = 0;
    bool can_open = from->count != 0;
    lum_capture_progress(r->capture, &done, &total);
    for (size_t i = 0; i < from->count; i++) {
        can_open = can_open && strcmp(from->paths[i], "-") != 0;
    }
    if (!can_open || total == 0) {
        return 0;
    }
    r->paths = calloc(from->count, sizeof *r->paths);
    r->path_count = from->count;
    for (size_t i = 0; r->paths != NULL && i < from->count; i++) {
        r->paths[i] = lum_text_copy(from->paths[i]);
        can_open = can_open && r->paths[i] != NULL;
    }
    return r->paths != NULL && can_open ? 0
                                        : lum_error_set(error, "out of memory");
}

int lum_reader_open_source(lum_reader *r, const lum_reader_options *o,
                           lum_error *error)
{
    const lum_capture_from from = {
        .source = o->source,
        .paths = o->path != NULL ? &o->path : o->paths,
        .count = o->path != NULL ? 1u : o->path_count,
        .go_on = &r->go_on};
    return open_capture(r, &from, error) == 0 ? keep_paths(r, &from, error)
                                              : -1;
}

int lum_reader_reopen(lum_reader *reader, lum_error *error)
{
    const lum_capture_from from = {.paths = (const char *const *)reader->paths,
                                   .count = reader->path_count,
                                   .go_on = &reader->go_on};
    close_records(&reader->source);
    reader->source = (lum_record_source){.struct_size = sizeof reader->source};
    return open_capture(reader, &from, error);
}
