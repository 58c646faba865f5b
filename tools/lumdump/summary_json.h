/* The summary of a run as JSON. */
#ifndef LUMDUMP_SUMMARY_JSON_H
#define LUMDUMP_SUMMARY_JSON_H

#include "summary.h"

#include <stdio.h>

void summary_json_print(const struct summary *summary, FILE *out);

#endif
