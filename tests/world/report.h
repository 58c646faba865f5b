/* What a run of tellings came to, for people and for programs. */
#ifndef WORLD_REPORT_H
#define WORLD_REPORT_H

#include "telling.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct report {
    uint64_t tellings, failures, programs;
    int64_t lasted_ns, cpu_ns;
    uint64_t finding_count, finding_room;
    struct report_finding {
        uint64_t seed;
        char name[160]; /* options that tell it again */
        char rule[48];
        char failure[240]; /* its beginning */
    } * findings;          /* in the order of the tellings */
    coverage met;
} report;

void report_begin(report *r);
/* True: its failure is the first of its rule. */
bool report_add(report *r, const telling *t);

/* seconds: on the clock. */
void report_print(const report *r, double seconds, bool has_coverage);
/* All of it, as JSON, to a file; false and errno. */
bool report_write(const report *r, double seconds, const char *path);

#endif
