#include "labels.h"

#include "cloud/le.h"
#include "cloud/sink.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROW_BYTES  24u
#define HEAD_BYTES 384u /* a multiple of 64, as NumPy makes them */
#define FORE_BYTES 10u  /* magic, version, length */

struct labels {
    lum_sink *sink;
    uint64_t count;
};

/* With the count that is known only at the end. */
static void make_head(uint64_t count, char out[HEAD_BYTES])
{
    char text[HEAD_BYTES];
    const int n = snprintf(
        text, sizeof text,
        "{'descr': [('frame', '<i8'), ('line', '<u4'), ('object', '<u4'), "
        "('pixel', '<u2'), ('return_number', '<u2'), ('eye', '|u1'), "
        "('class', '|u1'), ('mixed', '|b1'), ('number_of_returns', '|u1')], "
        "'fortran_order': False, 'shape': (%" PRIu64 ",)}",
        count);
    memset(out, ' ', HEAD_BYTES);
    memcpy(out, "\x93NUMPY\x01\x00", 8);
    (void)lum_put_le16((unsigned char *)out + 8, HEAD_BYTES - FORE_BYTES);
    memcpy(out + FORE_BYTES, text, (size_t)n);
    out[HEAD_BYTES - 1] = '\n';
}

int labels_open(const char *path, struct labels **out, lum_error *error)
{
    char head[HEAD_BYTES];
    struct labels *l = calloc(1, sizeof *l);
    if (l == NULL) {
        return lum_error_set(error, "%s: not enough memory", path);
    }
    make_head(0, head);
    if (lum_sink_open(path, &l->sink, error) != 0) {
        labels_abort(l);
        return -1;
    }
    if (!lum_sink_seekable(l->sink)) {
        (void)lum_error_set(error,
                            "--labels: %s is no regular file, and the number "
                            "of points is written into its beginning at the "
                            "end; give a file's name",
                            lum_sink_name(l->sink));
        labels_abort(l);
        return -1;
    }
    if (lum_sink_write(l->sink, head, sizeof head, error) != 0) {
        labels_abort(l);
        return -1;
    }
    *out = l;
    return 0;
}

int labels_add(struct labels *labels, const lum_sim_line *line,
               lum_error *error)
{
    for (size_t i = 0; i < line->truth_count; i++) {
        const lum_sample *s = &line->truth[i];
        const lum_label *is = &line->labels[i];
        char *room = lum_sink_reserve(labels->sink, ROW_BYTES, error);
        if (room == NULL) {
            return -1;
        }
        unsigned char *at = (unsigned char *)room;
        at = lum_put_le64(at, (uint64_t)line->frame);
        at = lum_put_le32(at, line->number);
        at = lum_put_le32(at, is->object);
        at = lum_put_le16(at, s->pixel);
        at = lum_put_le16(at, s->return_number);
        at = lum_put_u8(at, line->eye);
        at = lum_put_u8(at, is->thing);
        at = lum_put_u8(at, is->is_mixed);
        (void)lum_put_u8(at, (uint8_t)s->number_of_returns);
        lum_sink_commit(labels->sink, ROW_BYTES);
    }
    labels->count += line->truth_count;
    return 0;
}

int labels_close(struct labels *labels, lum_error *error)
{
    char head[HEAD_BYTES];
    make_head(labels->count, head);
    if (lum_sink_patch(labels->sink, 0, head, sizeof head, error) != 0) {
        labels_abort(labels);
        return -1;
    }
    const int result = lum_sink_close(labels->sink, error);
    free(labels);
    return result;
}

void labels_abort(struct labels *labels)
{
    if (labels != NULL) {
        lum_sink_abort(labels->sink);
        free(labels);
    }
}
