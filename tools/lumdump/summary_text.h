/* The summary of a run as text for people. */
#ifndef LUMDUMP_SUMMARY_TEXT_H
#define LUMDUMP_SUMMARY_TEXT_H

#include "summary.h"

#include <stdio.h>

void summary_text_print(const struct summary *summary, FILE *out);

/* A sentence on what a picture shows. Returns out. */
const char *summary_text_drawn(const struct drawn *drawn, char *out,
                               size_t room);

#endif
