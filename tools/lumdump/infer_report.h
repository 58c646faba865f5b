/* What was found out about a layout, for people and for programs. */
#ifndef LUMDUMP_INFER_REPORT_H
#define LUMDUMP_INFER_REPORT_H

#include "lum/infer/infer.h"

#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>

struct infer_report {
    const char *source;
    const char *capture; /* of it, as a word of a shell */
    const char *profile; /* file that it is written to, as such; NULL: none */
    uint64_t records;    /* that were read */
    bool is_truncated;
    uint64_t damaged; /* parts that could not be read and were passed over */
    lum_infer_result result;
    char yaml[LUM_INFER_YAML_BYTES]; /* empty: no layout was found */
};

void infer_report_text(const struct infer_report *report, FILE *out);
void infer_report_json(const struct infer_report *report, FILE *out);

#endif
