/* A distribution of lines as text. */
#ifndef LUMCTL_YSCAN_DRAW_H
#define LUMCTL_YSCAN_DRAW_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* Draws how many lines lie at each elevation from min to max, uppermost first,
 * the horizon marked; no line of it is wider than this many columns, at least
 * 40. */
void yscan_draw(FILE *out, unsigned columns, const int32_t *udeg, size_t n,
                int32_t min_udeg, int32_t max_udeg);

#endif
