#include "file_columns.h"

#include "base/text.h"
#include "le.h"
#include "text_columns.h"

#include <errno.h>

#define NS_MAX 9e18

/* PLY types by the names that Open3D knows: it knows uint16, but not uint or
 * ushort. */
const lum_file_column_spec lum_file_column_specs[LUM_FILE_COLUMNS] = {
    [LUM_FILE_X] = {"x", "x", "float", 'F', 4, true},
    [LUM_FILE_Y] = {"y", "y", "float", 'F', 4, true},
    [LUM_FILE_Z] = {"z", "z", "float", 'F', 4, true},
    [LUM_FILE_RANGE] = {"range", "range", "float", 'F', 4, false},
    [LUM_FILE_AZIMUTH] = {"azimuth", "azimuth", "float", 'F', 4, false},
    [LUM_FILE_ELEVATION] = {"elevation", "elevation", "float", 'F', 4, false},
    [LUM_FILE_PULSE_WIDTH] = {"pulse_width", "intensity", "float", 'F', 4,
                              true},
    [LUM_FILE_TIMESTAMP] = {"timestamp", "timestamp", "double", 'F', 8, false},
    [LUM_FILE_FRAME] = {"frame", "frame", "int", 'I', 4, false},
    [LUM_FILE_EYE] = {"eye", "eye", "uchar", 'U', 1, false},
    [LUM_FILE_LINE] = {"line", "line", "int", 'U', 4, false},
    [LUM_FILE_PIXEL] = {"pixel", "pixel", "uint16", 'U', 2, false},
    [LUM_FILE_RETURN_NUMBER] = {"return_number", "return_number", "uint16", 'U',
                                2, false},
    [LUM_FILE_NUMBER_OF_RETURNS] = {"number_of_returns", "number_of_returns",
                                    "uint16", 'U', 2, false},
    [LUM_FILE_EDGE] = {"edge", "edge", "uchar", 'U', 1, false},
    [LUM_FILE_TIME] = {"time", "time", "float", 'F', 4, false},
};

const lum_column_list lum_csv_columns = {
    15,
    {LUM_FILE_X, LUM_FILE_Y, LUM_FILE_Z, LUM_FILE_RANGE, LUM_FILE_AZIMUTH,
     LUM_FILE_ELEVATION, LUM_FILE_PULSE_WIDTH, LUM_FILE_TIMESTAMP,
     LUM_FILE_FRAME, LUM_FILE_EYE, LUM_FILE_LINE, LUM_FILE_PIXEL,
     LUM_FILE_RETURN_NUMBER, LUM_FILE_NUMBER_OF_RETURNS, LUM_FILE_EDGE}};

const lum_column_list lum_cloud_columns = {
    15,
    {LUM_FILE_X, LUM_FILE_Y, LUM_FILE_Z, LUM_FILE_PULSE_WIDTH, LUM_FILE_RANGE,
     LUM_FILE_AZIMUTH, LUM_FILE_ELEVATION, LUM_FILE_TIMESTAMP, LUM_FILE_FRAME,
     LUM_FILE_EYE, LUM_FILE_LINE, LUM_FILE_PIXEL, LUM_FILE_RETURN_NUMBER,
     LUM_FILE_NUMBER_OF_RETURNS, LUM_FILE_EDGE}};

/* --- Lists --- */

static const char *name_of(const lum_extras *extras, unsigned column)
{
    return column < LUM_FILE_COLUMNS ? lum_file_column_specs[column].name
                                     : extras->name[column - LUM_FILE_COLUMNS];
}

static unsigned known_columns(const lum_extras *extras)
{
    return (unsigned)LUM_FILE_COLUMNS + extras->count;
}

static int refuse(lum_error *error, const lum_extras *extras, const char *name,
                  size_t n)
{
    char all[256] = "";
    for (unsigned i = 0; i < known_columns(extras); i++) {
        lum_text_list(all, sizeof all, ", ", name_of(extras, i));
    }
    errno = EINVAL;
    return lum_error_set(error, "'%.*s' is not a column; columns are %s",
                         n < 40u ? (int)n : 40, name, all);
}

static bool find(const lum_extras *extras, const char *name, size_t n,
                 unsigned *out)
{
    for (unsigned i = 0; i < known_columns(extras); i++) {
        const char *known = name_of(extras, i);
        if (strncmp(known, name, n) == 0 && known[n] == '\0') {
            *out = i;
            return true;
        }
    }
    return false;
}

bool lum_column_list_has(const lum_column_list *list, lum_file_column column)
{
    return memchr(list->at, (int)column, list->count) != NULL;
}

void lum_column_list_append(lum_column_list *list, const lum_extras *extras)
{
    for (unsigned i = 0; i < extras->count; i++) {
        list->at[list->count++] = (uint8_t)(LUM_FILE_COLUMNS + i);
    }
}

int lum_column_list_read(const char *names, const lum_extras *extras,
                         lum_column_list *out, lum_error *error)
{
    lum_column_list list = {0};
    const char *p = names;
    for (;;) {
        const size_t n = strcspn(p, ",");
        unsigned column = LUM_FILE_X;
        if (!find(extras, p, n, &column)) {
            return refuse(error, extras, p, n);
        }
        if (memchr(list.at, (int)column, list.count) != NULL) {
            errno = EINVAL;
            return lum_error_set(error, "the column %s is named twice",
                                 name_of(extras, column));
        }
        list.at[list.count++] = (uint8_t)column;
        if (p[n] == '\0') {
            *out = list;
            return 0;
        }
        p += n + 1u;
    }
}

/* --- Rows --- */

/* Where a column's numbers are. */
enum kind {
    OF_LINE,  /* made once for each line; `at` is its index */
    OF_FLOAT, /* of a sample; `at` is its offset */
    OF_COUNT,
    OF_EDGE,
    OF_TIMES
};

static const struct {
    uint8_t kind;
    uint8_t at;
    uint8_t decimals;
} places[LUM_FILE_COLUMNS] = {
    [LUM_FILE_X] = {OF_FLOAT, offsetof(lum_sample, x), LUM_METRE_DECIMALS},
    [LUM_FILE_Y] = {OF_FLOAT, offsetof(lum_sample, y), LUM_METRE_DECIMALS},
    [LUM_FILE_Z] = {OF_FLOAT, offsetof(lum_sample, z), LUM_METRE_DECIMALS},
    [LUM_FILE_RANGE] = {OF_FLOAT, offsetof(lum_sample, range),
                        LUM_METRE_DECIMALS},
    [LUM_FILE_AZIMUTH] = {OF_FLOAT, offsetof(lum_sample, azimuth),
                          LUM_DEGREE_DECIMALS},
    [LUM_FILE_ELEVATION] = {OF_FLOAT, offsetof(lum_sample, elevation),
                            LUM_DEGREE_DECIMALS},
    [LUM_FILE_PULSE_WIDTH] = {OF_FLOAT, offsetof(lum_sample, pulse_width),
                              LUM_WIDTH_DECIMALS},
    [LUM_FILE_TIMESTAMP] = {OF_LINE, 0, 0},
    [LUM_FILE_FRAME] = {OF_LINE, 1, 0},
    [LUM_FILE_EYE] = {OF_LINE, 2, 0},
    [LUM_FILE_LINE] = {OF_LINE, 3, 0},
    [LUM_FILE_PIXEL] = {OF_COUNT, offsetof(lum_sample, pixel), 0},
    [LUM_FILE_RETURN_NUMBER] = {OF_COUNT, offsetof(lum_sample, return_number),
                                0},
    [LUM_FILE_NUMBER_OF_RETURNS] = {OF_COUNT,
                                    offsetof(lum_sample, number_of_returns), 0},
    [LUM_FILE_EDGE] = {OF_EDGE, offsetof(lum_sample, edge), 0},
    [LUM_FILE_TIME] = {OF_TIMES, 0, 0},
};

/* In binary. */
static size_t bytes_of(const lum_file_rows *rows, unsigned column)
{
    return column < LUM_FILE_COLUMNS
               ? lum_file_column_specs[column].bytes
               : lum_number_types[rows->extras->type[column - LUM_FILE_COLUMNS]]
                     .bytes;
}

void lum_file_rows_begin(lum_file_rows *rows, const lum_column_list *columns,
                         const lum_extras *extras, const lum_line_samples *line,
                         char separator)
{
    lum_text_line text;
    const char *p = text.line;
    rows->columns = columns;
    rows->separator = separator;
    rows->samples = line->samples;
    rows->times = line->times;
    rows->extras = extras;
    rows->extra = line->extra;
    rows->row_bytes = 0;
    for (unsigned k = 0; k < columns->count; k++) {
        rows->row_bytes += bytes_of(rows, columns->at[k]);
    }
    lum_text_line_begin(&text, line, separator);
    for (unsigned i = 0; i < 4u; i++) {
        const char *end = (const char *)memchr(p, separator, LUM_DECIMAL_ROOM);
        rows->text_bytes[i] = (uint8_t)(end - p);
        memcpy(rows->text[i], p, rows->text_bytes[i]);
        p = end + 1;
    }
    (void)lum_put_f64(rows->bytes[0], lum_timestamp_number(line->timestamp_us));
    (void)lum_put_le32(rows->bytes[1], (uint32_t)lum_frame_i32(line->frame));
    (void)lum_put_u8(rows->bytes[2], line->eye);
    (void)lum_put_le32(rows->bytes[3], line->line);
}

static float float_at(const lum_sample *sample, size_t at)
{
    float v;
    memcpy(&v, (const unsigned char *)sample + at, sizeof v);
    return v;
}

static uint16_t count_at(const lum_sample *sample, size_t at)
{
    uint16_t v;
    memcpy(&v, (const unsigned char *)sample + at, sizeof v);
    return v;
}

/* A pixel may last a tenth of a microsecond. */
static char *put_seconds(char *p, float seconds)
{
    const double ns = (double)seconds * 1e9;
    return ns > -NS_MAX && ns < NS_MAX
               ? lum_put_nanoseconds(p, (int64_t)(ns + (ns < 0 ? -0.5 : 0.5)))
               : lum_put_large(p, seconds, 0);
}

static char *put_extra(char *p, const lum_file_rows *rows, unsigned i,
                       const lum_sample *s)
{
    p = lum_number_print(p, (lum_number_type)rows->extras->type[i],
                         rows->extra[i], (size_t)(s - rows->samples));
    *p = rows->separator;
    return p + 1;
}

/* A cell and its separator. */
static char *put_cell(char *p, const lum_file_rows *rows, unsigned column,
                      const lum_sample *s)
{
    if (column >= LUM_FILE_COLUMNS) {
        return put_extra(p, rows, column - LUM_FILE_COLUMNS, s);
    }
    const size_t at = places[column].at;
    switch ((enum kind)places[column].kind) {
    case OF_FLOAT:
        return lum_put_column(p, float_at(s, at), places[column].decimals,
                              rows->separator);
    case OF_COUNT:
        return lum_put_count(p, count_at(s, at), rows->separator);
    case OF_EDGE:
        return lum_put_count(p, s->edge != 0, rows->separator);
    case OF_TIMES:
        p = put_seconds(p, rows->times[s - rows->samples]);
        break;
    case OF_LINE:
    default:
        memcpy(p, rows->text[at], rows->text_bytes[at]);
        p += rows->text_bytes[at];
        break;
    }
    *p = rows->separator;
    return p + 1;
}

char *lum_file_rows_put_text(char *p, void *context, const lum_sample *samples,
                             size_t n)
{
    const lum_file_rows *rows = context;
    for (size_t i = 0; i < n; i++) {
        for (unsigned k = 0; k < rows->columns->count; k++) {
            p = put_cell(p, rows, rows->columns->at[k], &samples[i]);
        }
        p[-1] = '\n';
    }
    return p;
}

/* A column of n rows, the first of which has it at p. */
static void put_numbers(unsigned char *p, const lum_file_rows *rows,
                        unsigned column, const lum_sample *s, size_t n)
{
    const size_t row = rows->row_bytes;
    const size_t first = (size_t)(s - rows->samples);
    if (column >= LUM_FILE_COLUMNS) {
        const unsigned k = column - LUM_FILE_COLUMNS;
        for (size_t i = 0; i < n; i++) {
            (void)lum_number_put(p + i * row,
                                 (lum_number_type)rows->extras->type[k],
                                 rows->extra[k], first + i);
        }
        return;
    }
    const size_t at = places[column].at;
    switch ((enum kind)places[column].kind) {
    case OF_FLOAT:
        for (size_t i = 0; i < n; i++) {
            (void)lum_put_f32(p + i * row, float_at(&s[i], at));
        }
        break;
    case OF_COUNT:
        for (size_t i = 0; i < n; i++) {
            (void)lum_put_le16(p + i * row, count_at(&s[i], at));
        }
        break;
    case OF_EDGE:
        for (size_t i = 0; i < n; i++) {
            (void)lum_put_u8(p + i * row, s[i].edge);
        }
        break;
    case OF_TIMES:
        for (size_t i = 0; i < n; i++) {
            (void)lum_put_f32(p + i * row, rows->times[first + i]);
        }
        break;
    case OF_LINE:
    default:
        for (size_t i = 0; i < n; i++) {
            memcpy(p + i * row, rows->bytes[at], bytes_of(rows, column));
        }
        break;
    }
}

char *lum_file_rows_put_binary(char *p, void *context,
                               const lum_sample *samples, size_t n)
{
    const lum_file_rows *rows = context;
    unsigned char *to = (unsigned char *)p;
    for (unsigned k = 0; k < rows->columns->count; k++) {
        put_numbers(to, rows, rows->columns->at[k], samples, n);
        to += bytes_of(rows, rows->columns->at[k]);
    }
    return p + n * rows->row_bytes;
}
