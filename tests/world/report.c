#include "report.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LINE_WIDTH 118

void report_begin(report *r)
{
    memset(r, 0, sizeof *r);
    coverage_begin(&r->met);
}

static bool has_finding_of(const report *r, const char *rule)
{
    for (uint64_t i = 0; i < r->finding_count; i++) {
        if (strcmp(r->findings[i].rule, rule) == 0) {
            return true;
        }
    }
    return false;
}

static void add_finding(report *r, const telling *t)
{
    if (r->finding_count == r->finding_room) {
        r->finding_room = r->finding_room == 0 ? 16 : 2 * r->finding_room;
        r->findings = realloc(r->findings,
                              r->finding_room * sizeof(struct report_finding));
        if (r->findings == NULL) {
            abort();
        }
    }
    struct report_finding *f = &r->findings[r->finding_count++];
    f->seed = telling_seed(t->index);
    telling_name(t->index, f->name, sizeof f->name);
    memcpy(f->rule, t->rule, sizeof f->rule);
    (void)snprintf(f->failure, sizeof f->failure, "%.*s",
                   (int)sizeof f->failure - 1, t->result.failure);
}

bool report_add(report *r, const telling *t)
{
    r->tellings++;
    r->programs += t->programs;
    r->lasted_ns += t->result.lasted_ns;
    r->cpu_ns += t->cpu_ns;
    coverage_add(&r->met, &t->met);
    if (t->result.failure[0] == '\0') {
        return false;
    }
    const bool is_first = !has_finding_of(r, t->rule);
    r->failures++;
    add_finding(r, t);
    return is_first;
}

/* --- For people --- */

/* Those of one rule, from the first of them on. */
static void print_seeds(const report *r, uint64_t first)
{
    const char *rule = r->findings[first].rule;
    uint64_t count = 0;
    for (uint64_t i = first; i < r->finding_count; i++) {
        count += strcmp(r->findings[i].rule, rule) == 0 ? 1 : 0;
    }
    int used = printf("  %s, %" PRIu64 ":", rule, count);
    for (uint64_t i = first; i < r->finding_count; i++) {
        if (strcmp(r->findings[i].rule, rule) != 0) {
            continue;
        }
        if (used > LINE_WIDTH - 12) {
            used = printf("\n   ") - 1;
        }
        used += printf(" %" PRIu64, r->findings[i].seed);
    }
    printf("\n");
}

static bool is_first_of_rule(const report *r, uint64_t i)
{
    for (uint64_t j = 0; j < i; j++) {
        if (strcmp(r->findings[i].rule, r->findings[j].rule) == 0) {
            return false;
        }
    }
    return true;
}

static void print_findings(const report *r)
{
    if (r->finding_count > 0) {
        printf("seeds that failed, by rule\n");
    }
    for (uint64_t i = 0; i < r->finding_count; i++) {
        if (is_first_of_rule(r, i)) {
            print_seeds(r, i);
        }
    }
    if (r->finding_count > 0) {
        printf("\n");
    }
}

void report_print(const report *r, double seconds, bool has_coverage)
{
    const double hours = (double)r->lasted_ns / 3600e9;
    const double cpu_s = (double)r->cpu_ns / 1e9;
    if (has_coverage) {
        coverage_print(&r->met, stdout);
        print_findings(r);
        printf("%" PRIu64 " sessions, seeds %" PRIu64 " to %" PRIu64
               ", with %" PRIu64 " runs of programs\n",
               r->tellings, telling_seed(0), telling_seed(r->tellings - 1),
               r->programs);
    }
    printf("%.2f simulated hours in %.1f s, and %.1f s of processors (%.0f "
           "times as fast)\n%" PRIu64 " passed, %" PRIu64 " failed\n",
           hours, seconds, cpu_s, cpu_s > 0 ? hours * 3600.0 / cpu_s : 0.0,
           r->tellings - r->failures, r->failures);
}

/* --- For programs --- */

static void print_text_json(const char *text, FILE *out)
{
    (void)fputc('"', out);
    for (const char *c = text; *c != '\0'; c++) {
        if (*c == '"' || *c == '\\') {
            (void)fprintf(out, "\\%c", *c);
        } else if ((unsigned char)*c < 0x20) {
            (void)fprintf(out, "\\u%04x", (unsigned)*c);
        } else {
            (void)fputc(*c, out);
        }
    }
    (void)fputc('"', out);
}

static void print_json(const report *r, double seconds, FILE *out)
{
    (void)fprintf(out,
                  "{\n \"hours\": %.4f,\n \"sessions\": %" PRIu64
                  ",\n \"first_seed\": %" PRIu64 ",\n \"last_seed\": %" PRIu64
                  ",\n \"programs\": %" PRIu64 ",\n \"failed\": %" PRIu64
                  ",\n \"processor_s\": %.1f,\n \"clock_s\": %.1f,\n"
                  " \"findings\": [",
                  (double)r->lasted_ns / 3600e9, r->tellings, telling_seed(0),
                  telling_seed(r->tellings - 1), r->programs, r->failures,
                  (double)r->cpu_ns / 1e9, seconds);
    for (uint64_t i = 0; i < r->finding_count; i++) {
        const struct report_finding *f = &r->findings[i];
        (void)fprintf(out, "%s\n  {\"seed\": %" PRIu64 ", \"rule\": \"%s\", ",
                      i > 0 ? "," : "", f->seed, f->rule);
        (void)fputs("\"replay\": ", out);
        print_text_json(f->name, out);
        (void)fputs(", \"text\": ", out);
        print_text_json(f->failure, out);
        (void)fputc('}', out);
    }
    (void)fputs("\n ],\n", out);
    coverage_print_json(&r->met, out);
    (void)fputs("\n}\n", out);
}

bool report_write(const report *r, double seconds, const char *path)
{
    FILE *out = fopen(path, "w");
    if (out == NULL) {
        return false;
    }
    print_json(r, seconds, out);
    const bool is_bad = ferror(out) != 0;
    return fclose(out) == 0 && !is_bad;
}
