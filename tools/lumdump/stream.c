#include "stream.h"

#include <inttypes.h>

/* Longer than a sensor with a session is silent: it answers five heartbeats a
 * second. */
#define GAP_NS INT64_C(500000000)

/* More than packets of several queues of one network card are out of order. */
#define OVERLAP_NS INT64_C(10000000)

/* Rows of gaps and overlaps; JSON has all. */
#define ROWS_MAX 20u

/* A walk over the sources that were read. */
struct walk {
    const lum_capture *capture;
    size_t next;
    lum_capture_source source; /* the present one */
    bool has_before;
    int64_t reach_ns; /* latest time of those before it */
    int64_t gap_ns;   /* from there; below 0: an overlap */
};

/* False: there is no other. One without a record has no gap. */
static bool step(struct walk *w)
{
    if (w->next > 0 && w->source.records > 0) {
        w->reach_ns = w->has_before && w->reach_ns > w->source.last_ns
                          ? w->reach_ns
                          : w->source.last_ns;
        w->has_before = true;
    }
    if (w->next == lum_capture_source_count(w->capture)) {
        return false;
    }
    lum_capture_get_source(w->capture, w->next++, &w->source);
    w->gap_ns = w->has_before && w->source.records > 0
                    ? w->source.first_ns - w->reach_ns
                    : 0;
    return true;
}

static void print_gap(const struct walk *w, FILE *out)
{
    const double seconds = (double)w->gap_ns * 1e-9;
    if (w->gap_ns > 0) {
        (void)fprintf(out,
                      "%-10s %14.3f  seconds without a capture before %s\n", "",
                      seconds, w->source.name);
    } else {
        (void)fprintf(out,
                      "%-10s %14.3f  seconds by which %s begins before the end "
                      "of those before it\n",
                      "", -seconds, w->source.name);
    }
}

void stream_print_text(const lum_capture *capture, FILE *out)
{
    struct walk walk = {.capture = capture,
                        .source.struct_size = sizeof walk.source};
    size_t rows = 0;
    const size_t n = lum_capture_source_count(capture);
    if (n < 2) {
        return;
    }
    (void)fprintf(out, "%-10s %14zu  captures, read as one stream\n", "sources",
                  n);
    while (step(&walk)) {
        if (walk.gap_ns < GAP_NS && walk.gap_ns > -OVERLAP_NS) {
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

static void print_source(const struct walk *w,
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
    (void)fprintf(out, ", \"records\": %" PRIu64 ", \"end\": \"%s\"",
                  s->records, ends[s->end]);
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
    struct walk walk = {.capture = capture,
                        .source.struct_size = sizeof walk.source};
    const char *divider = "\n";
    (void)fputs("  \"sources\": [", out);
    while (step(&walk)) {
        (void)fputs(divider, out);
        print_source(&walk, print_text, out);
        divider = ",\n";
    }
    (void)fputs("\n  ],\n", out);
}
