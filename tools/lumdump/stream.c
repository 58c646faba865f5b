#include "stream.h"

#include "../common/source_walk.h"

#include <inttypes.h>

/* Rows of gaps and overlaps; JSON has all. */
#define ROWS_MAX 20u

uint64_t stream_records(const lum_capture *capture)
{
    uint64_t records = 0;
    const size_t n = lum_capture_source_count(capture);
    for (size_t i = 0; i < n; i++) {
        lum_capture_source source = {.struct_size = sizeof source};
        (void)lum_capture_get_source(capture, i, &source);
        records += source.records;
    }
    return records;
}

static void print_gap(const struct source_walk *w, FILE *out)
{
    char text[SOURCE_WALK_TEXT_BYTES];
    const double seconds = (double)w->gap_ns * 1e-9;
    (void)fprintf(out, "%-10s %14.3f  %s\n", "",
                  seconds < 0 ? -seconds : seconds,
                  source_walk_text(w, text, sizeof text));
}

void stream_print_text(const lum_capture *capture, FILE *out)
{
    struct source_walk walk = {.capture = capture,
                               .source.struct_size = sizeof walk.source};
    size_t rows = 0;
    const size_t n = lum_capture_source_count(capture);
    if (n < 2) {
        return;
    }
    (void)fprintf(out, "%-10s %14zu  captures, read as one stream\n", "sources",
                  n);
    while (source_walk_step(&walk)) {
        if (!source_walk_is_gap(&walk) && !source_walk_is_overlap(&walk)) {
            continue;
        }
        if (++rows <= ROWS_MAX) {
            print_gap(&walk, out);
        }
    }
    if (rows > ROWS_MAX) {
        (void)fprintf(out, "%-10s %14zu  more gaps and overlaps: see --json\n",
                      "", rows - ROWS_MAX);
    }
}

static void print_source(const struct source_walk *w,
                         void (*print_text)(const char *text, FILE *out),
                         FILE *out)
{
    static const char *const ends[] = {[LUM_CAPTURE_UNDER_WAY] = "not reached",
                                       [LUM_CAPTURE_WHOLE] = "whole",
                                       [LUM_CAPTURE_BROKEN] = "broken off",
                                       [LUM_CAPTURE_UNREAD] = "unread"};
    const lum_capture_source *s = &w->source;
    (void)fputs("    {\"name\": ", out);
    print_text(s->name, out);
    (void)fprintf(out,
                  ", \"records\": %" PRIu64 ", \"end\": \"%s\""
                  ", \"damaged\": %" PRIu64,
                  s->records, ends[s->end], s->damaged);
    if (s->records > 0) {
        (void)fprintf(out, ", \"first_s\": %.6f, \"last_s\": %.6f",
                      (double)s->first_ns * 1e-9, (double)s->last_ns * 1e-9);
    }
    if (w->has_before && s->records > 0) {
        (void)fprintf(out, ", \"gap_s\": %.6f", (double)w->gap_ns * 1e-9);
    }
    (void)fputc('}', out);
}

void stream_print_json(const lum_capture *capture,
                       void (*print_text)(const char *text, FILE *out),
                       FILE *out)
{
    struct source_walk walk = {.capture = capture,
                               .source.struct_size = sizeof walk.source};
    const char *divider = "\n";
    (void)fputs("  \"sources\": [", out);
    while (source_walk_step(&walk)) {
        (void)fputs(divider, out);
        print_source(&walk, print_text, out);
        divider = ",\n";
    }
    (void)fputs("\n  ],\n", out);
}
