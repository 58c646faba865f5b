/* What is added to an open writer: lines, parts, frames and status go to its
 * format; the first failure stays; the end. */
#include "base/sized.h"
#include "part.h"
#include "writer_internal.h"

#include <errno.h>
#include <inttypes.h>
#include <stdlib.h>

/* The end of a call, which fails or not. The first failure is remembered:
 * whatever is called next repeats it. */
static int conclude(lum_writer *writer, bool fails, lum_error *error)
{
    const int code = errno;
    if (!writer->failed && !fails) {
        return 0;
    }
    if (!writer->failed) {
        writer->failed = true;
        writer->failure_code = code;
    }
    errno = writer->failure_code;
    return lum_error_set(error, "%s", writer->failure.text);
}

/* --- Lines --- */

static int begin_rows(lum_writer *writer, uint32_t rows, lum_error *error)
{
    if (!writer->options.organized || writer->has_rows ||
        rows > LUM_WRITER_ROWS_MAX) {
        errno = EINVAL;
        return lum_error_set(
            error, "%s: %lu rows: %s", lum_sink_name(writer->sink),
            (unsigned long)rows,
            !writer->options.organized ? "the file is not organised"
            : writer->has_rows         ? "it has begun, and holds one frame"
                                       : "there are too many");
    }
    writer->has_rows = true;
    writer->rows = rows;
    return writer->ops->begin(writer, error);
}

int lum_writer_set_rows(lum_writer *writer, uint32_t rows, lum_error *error)
{
    const bool fails =
        !writer->failed && begin_rows(writer, rows, &writer->failure) != 0;
    return conclude(writer, fails, error);
}

static int check_voxels(const lum_writer *writer, const lum_line_samples *line,
                        lum_error *error)
{
    if (!writer->options.voxels ||
        (line->counts != NULL && line->times_ns != NULL)) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(error, "%s: samples of voxels lack counts or times_ns",
                         lum_sink_name(writer->sink));
}

static int check_extra(const lum_writer *writer, const lum_line_samples *line,
                       lum_error *error)
{
    if (writer->extras.count == 0 || line->extra != NULL) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(
        error, "%s: the file has extra columns, but the line's extra is NULL",
        lum_sink_name(writer->sink));
}

static int check_row(const lum_writer *writer, const lum_line_samples *line,
                     lum_error *error)
{
    if (!writer->options.organized ||
        (writer->has_rows && line->count == LUM_LINE_PIXELS &&
         writer->points < (uint64_t)LUM_LINE_PIXELS * writer->rows)) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(error,
                         "%s: a line of %zu points: the file is of %lu rows of "
                         "%u, and has %" PRIu64 " points",
                         lum_sink_name(writer->sink), line->count,
                         (unsigned long)writer->rows, LUM_LINE_PIXELS,
                         writer->points);
}

int lum_writer_add(lum_writer *writer, const lum_line_samples *line,
                   lum_error *error)
{
    lum_line_samples known;
    if (lum_sized_take(&known, sizeof known, line, "the line",
                       "lum_line_samples", error) != 0) {
        return -1;
    }
    const bool fails =
        !writer->failed && known.count > 0 &&
        (check_row(writer, &known, &writer->failure) != 0 ||
         check_voxels(writer, &known, &writer->failure) != 0 ||
         check_extra(writer, &known, &writer->failure) != 0 ||
         writer->ops->add(writer, &known, &writer->failure) != 0);
    if (conclude(writer, fails, error) != 0) {
        return -1;
    }
    writer->points += known.count;
    return 0;
}

/* --- Parts --- */

uint64_t lum_writer_part_points(const lum_writer *part)
{
    return part->points;
}

void lum_writer_clear_part(lum_writer *part)
{
    lum_sink_clear(part->sink);
    part->points = 0;
}

int lum_writer_add_part(lum_writer *writer, lum_writer *part, lum_error *error)
{
    const uint64_t points = part->points;
    const bool fails =
        !writer->failed &&
        lum_sink_move(writer->sink, part->sink, &writer->failure) != 0;
    const int result = conclude(writer, fails, error);
    const int code = errno;
    lum_writer_clear_part(part);
    errno = code;
    writer->points += result == 0 ? points : 0;
    return result;
}

/* --- Frames and status --- */

int lum_writer_begin_frame(lum_writer *writer, int64_t utc_ns, lum_error *error)
{
    const bool fails =
        !writer->failed && writer->ops->begin_frame != NULL &&
        writer->ops->begin_frame(writer, utc_ns, &writer->failure) != 0;
    return conclude(writer, fails, error);
}

int lum_writer_end_frame(lum_writer *writer, lum_error *error)
{
    const bool fails = !writer->failed && writer->ops->end_frame != NULL &&
                       writer->ops->end_frame(writer, &writer->failure) != 0;
    return conclude(writer, fails, error);
}

int lum_writer_set_sensor(lum_writer *writer, size_t sensor, lum_error *error)
{
    const bool fails =
        !writer->failed && writer->ops->set_sensor != NULL &&
        writer->ops->set_sensor(writer, sensor, &writer->failure) != 0;
    return conclude(writer, fails, error);
}

int lum_writer_add_status(lum_writer *writer, const lum_writer_status *status,
                          lum_error *error)
{
    lum_writer_status known;
    if (lum_sized_take(&known, sizeof known, status, "the status",
                       "lum_writer_status", error) != 0) {
        return -1;
    }
    const bool fails =
        !writer->failed && writer->ops->add_status != NULL &&
        writer->ops->add_status(writer, &known, &writer->failure) != 0;
    return conclude(writer, fails, error);
}

int lum_writer_add_datagram(lum_writer *writer,
                            const lum_writer_datagram *datagram,
                            lum_error *error)
{
    const bool fails =
        !writer->failed && writer->ops->add_datagram != NULL &&
        writer->ops->add_datagram(writer, datagram, &writer->failure) != 0;
    return conclude(writer, fails, error);
}

/* --- The output --- */

uint64_t lum_writer_bytes(const lum_writer *writer)
{
    return lum_sink_bytes(writer->sink);
}

static int flush(lum_writer *writer, lum_error *error)
{
    return writer->ops->flush != NULL ? writer->ops->flush(writer, error)
                                      : lum_sink_flush(writer->sink, error);
}

int lum_writer_flush(lum_writer *writer, lum_error *error)
{
    const bool fails = !writer->failed && flush(writer, &writer->failure) != 0;
    return conclude(writer, fails, error);
}

int lum_writer_check(lum_writer *writer, lum_error *error)
{
    return writer->sink != NULL ? lum_sink_check(writer->sink, error) : 0;
}

/* --- The end --- */

/* One without a frame has no rows. */
static int finish_rows(lum_writer *writer, lum_error *error)
{
    const uint64_t wanted = (uint64_t)LUM_LINE_PIXELS * writer->rows;
    if (!writer->options.organized) {
        return 0;
    }
    if (!writer->has_rows) {
        return begin_rows(writer, 0, error);
    }
    if (writer->points == wanted) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(error,
                         "%s: %" PRIu64 " points of an organised file of "
                         "%" PRIu64,
                         lum_sink_name(writer->sink), writer->points, wanted);
}

static int check_count(const lum_writer *writer, lum_error *error)
{
    if (!writer->was_rehearsed || writer->rehearsed == writer->points) {
        return 0;
    }
    errno = EINVAL;
    return lum_error_set(error,
                         "%s: %" PRIu64 " points were rehearsed and %" PRIu64
                         " came; the source has changed in between",
                         lum_sink_name(writer->sink), writer->rehearsed,
                         writer->points);
}

static int finish_format(lum_writer *writer, lum_error *error)
{
    if (check_count(writer, error) != 0 || finish_rows(writer, error) != 0) {
        return -1;
    }
    return writer->ops->finish != NULL ? writer->ops->finish(writer, error) : 0;
}

/* errno stays. */
static void destroy(lum_writer *writer)
{
    const int code = errno;
    if (writer->ops->release != NULL && writer->state != NULL) {
        writer->ops->release(writer);
    }
    free(writer->state);
    free(writer->comment);
    free(writer);
    errno = code;
}

int lum_writer_close(lum_writer *writer, lum_error *error)
{
    const bool fails =
        !writer->failed && finish_format(writer, &writer->failure) != 0;
    if (conclude(writer, fails, error) != 0) {
        lum_writer_abort(writer);
        return -1;
    }
    const int result = lum_sink_close(writer->sink, error);
    destroy(writer);
    return result;
}

void lum_writer_abort(lum_writer *writer)
{
    if (writer == NULL) {
        return;
    }
    lum_sink_abort(writer->sink);
    destroy(writer);
}
