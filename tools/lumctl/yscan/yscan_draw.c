#include "yscan_draw.h"

#include <string.h>

#define ROWS_MAX 24
#define UDEG     1000000
#define LEFT     20 /* columns in front of the bar */
#define RIGHT    10 /* and behind it */
#define BAR_MIN  10
#define BAR_MAX  200

/* Heights of a row, in microdegrees. */
static const int32_t heights[] = {UDEG / 20, UDEG / 10, UDEG / 5, UDEG / 2,
                                  UDEG,      2 * UDEG,  5 * UDEG, 10 * UDEG};

/* The row that an elevation lies in; row 0 is the one above the horizon. */
static int32_t row_of(int32_t udeg, int32_t height)
{
    return udeg >= 0 ? udeg / height : -((-udeg - 1) / height) - 1;
}

static int32_t choose_height(int32_t min, int32_t max)
{
    const size_t count = sizeof heights / sizeof heights[0];
    size_t i = 0;
    while (i + 1 < count &&
           row_of(max - 1, heights[i]) - row_of(min, heights[i]) >= ROWS_MAX) {
        i++;
    }
    return heights[i];
}

static size_t count_row(const int32_t *udeg, size_t n, int32_t row,
                        int32_t height, int32_t last)
{
    size_t count = 0;
    for (size_t i = 0; i < n; i++) {
        const int32_t at = row_of(udeg[i], height);
        count += at == row || (row == last && at > last);
    }
    return count;
}

static void put_bar(FILE *out, size_t count, size_t most, size_t columns)
{
    char bar[BAR_MAX + 1];
    const size_t len = (count * columns + most - 1) / most;
    memset(bar, '#', len);
    bar[len] = '\0';
    (void)fprintf(out, "|%s%s%lu\n", bar, len > 0 ? " " : "",
                  (unsigned long)count);
}

static void put_horizon(FILE *out, size_t columns)
{
    char dashes[BAR_MAX + 1];
    memset(dashes, '-', columns);
    dashes[columns] = '\0';
    (void)fprintf(out, "%*s%s horizon\n", LEFT, "+", dashes);
}

void yscan_draw(FILE *out, unsigned columns, const int32_t *udeg, size_t n,
                int32_t min_udeg, int32_t max_udeg)
{
    const int32_t height = choose_height(min_udeg, max_udeg);
    const int32_t top = row_of(max_udeg - 1, height);
    const int32_t bottom = row_of(min_udeg, height);
    size_t room =
        columns > LEFT + RIGHT + BAR_MIN ? columns - LEFT - RIGHT : BAR_MIN;
    size_t most = 1;
    room = room < BAR_MAX ? room : BAR_MAX;
    for (int32_t row = bottom; row <= top; row++) {
        const size_t count = count_row(udeg, n, row, height, top);
        most = count > most ? count : most;
    }
    (void)fprintf(out, "%*s  lines\n", LEFT - 1, "degrees ");
    for (int32_t row = top; row >= bottom; row--) {
        (void)fprintf(out, "%7.2f .. %6.2f ", row * (height / 1e6),
                      (row + 1) * (height / 1e6));
        put_bar(out, count_row(udeg, n, row, height, top), most, room);
        if (row == 0 && bottom < 0) {
            put_horizon(out, room);
        }
    }
}
