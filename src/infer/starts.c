#include "starts.h"
#include "fields.h"

#include <stdlib.h>

/* Corruption spoils fewer elevations than one in this many, at either end. */
#define SPOILED 50u

bool lum_infer_is_start(const lum_infer_state *state,
                        const lum_infer_packet *packet)
{
    return packet->kind == LUM_INFER_ANGLES &&
           lum_infer_value(packet->bytes,
                           state->field[LUM_FIELD_FIRST_SAMPLE_INDEX].field) ==
               0;
}

static int compare(const void *a, const void *b)
{
    return *(const int16_t *)a - *(const int16_t *)b;
}

/* The range of the elevations. */
static int height_of(const lum_infer_starts *starts, int16_t *sorted)
{
    const size_t n = starts->count;
    for (size_t i = 0; i < n; i++) {
        sorted[i] = (int16_t)(starts->at[i] == NULL ? 0 : starts->at[i]->calm);
    }
    qsort(sorted, n, sizeof *sorted, compare);
    return n == 0 ? 0 : sorted[n - 1 - n / SPOILED] - sorted[n / SPOILED];
}

int lum_infer_find_starts(const lum_infer_state *state, lum_infer_starts *out)
{
    *out = (lum_infer_starts){.state = state};
    out->at = calloc(LUM_INFER_STARTS_MAX, sizeof(void *));
    int16_t *sorted = malloc(LUM_INFER_STARTS_MAX * sizeof *sorted);
    if (out->at == NULL || sorted == NULL) {
        free(sorted);
        return -1;
    }
    for (size_t i = 0;
         i < state->good.count && out->count < LUM_INFER_STARTS_MAX; i++) {
        if (lum_infer_is_start(state, state->good.at[i])) {
            out->at[out->count++] = state->good.at[i];
        }
    }
    out->height = height_of(out, sorted);
    free(sorted);
    return 0;
}

void lum_infer_free_starts(lum_infer_starts *starts)
{
    free(starts->at);
    starts->at = NULL;
}

unsigned lum_infer_bit_of(const lum_infer_packet *packet, unsigned bit)
{
    return bit >= LUM_INFER_HEAD_BITS
               ? 0u
               : packet->bytes[bit / 8u] >> bit % 8u & 1u;
}

bool lum_infer_has_bit(const lum_infer_bits *bits, unsigned bit)
{
    return (bits->byte[bit / 8u] >> bit % 8u & 1u) != 0;
}

double lum_infer_share_of_ones(const lum_infer_starts *starts, unsigned bit)
{
    size_t n = 0;
    for (size_t i = 0; i < starts->count; i++) {
        n += lum_infer_bit_of(starts->at[i], bit);
    }
    return starts->count == 0 ? 0.0 : (double)n / (double)starts->count;
}

bool lum_infer_is_same_split(const lum_infer_starts *starts, unsigned a,
                             unsigned b)
{
    size_t same = 0;
    for (size_t i = 0; i < starts->count; i++) {
        same += lum_infer_bit_of(starts->at[i], a) ==
                lum_infer_bit_of(starts->at[i], b);
    }
    return same * 100 > starts->count * 95 || same * 100 < starts->count * 5;
}

/* How often a bit is 1 among the lines of each eye. */
static void count_by_eye(const lum_infer_starts *starts, unsigned bit,
                         unsigned eye_bit, size_t n[2], size_t ones[2])
{
    n[0] = n[1] = ones[0] = ones[1] = 0;
    for (size_t i = 0; i < starts->count; i++) {
        const unsigned eye = lum_infer_bit_of(starts->at[i], eye_bit);
        n[eye]++;
        ones[eye] += lum_infer_bit_of(starts->at[i], bit);
    }
}

bool lum_infer_is_changing(const lum_infer_starts *starts, unsigned bit,
                           unsigned eye_bit)
{
    size_t n[2];
    size_t ones[2];
    bool changes = false;
    count_by_eye(starts, bit, eye_bit, n, ones);
    for (unsigned eye = 0; eye < 2; eye++) {
        const size_t rare =
            ones[eye] * 2 > n[eye] ? n[eye] - ones[eye] : ones[eye];
        changes = changes || rare * 20 > n[eye];
    }
    return changes;
}

unsigned lum_infer_changing(const lum_infer_starts *starts, unsigned at,
                            unsigned eye_bit, unsigned *differs)
{
    unsigned out = 0;
    unsigned by_eye = 0;
    for (unsigned b = 0; b < 8; b++) {
        size_t n[2];
        size_t ones[2];
        count_by_eye(starts, 8u * at + b, eye_bit, n, ones);
        const bool first = ones[0] * 2 > n[0];
        const bool second = ones[1] * 2 > n[1];
        by_eye |= first != second ? 1u << b : 0u;
        out |=
            lum_infer_is_changing(starts, 8u * at + b, eye_bit) ? 1u << b : 0u;
    }
    if (differs != NULL) {
        *differs = by_eye & ~out;
    }
    return out;
}
