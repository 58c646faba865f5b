/* Texts to poses. */
#include "poses_internal.h"

#include "base/grow.h"

#include <ctype.h>
#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FIELDS_MAX  64u
#define TUM_FIELDS  8u
#define KITTI_CELLS 12u
#define READ_BYTES  65536u
#define SECONDS_MAX 4e9 /* above this a time is of another unit */

enum column {
    T,
    X,
    Y,
    Z,
    QX,
    QY,
    QZ,
    QW,
    COLUMNS
};

typedef struct field {
    const char *at;
    size_t len;
} field;

typedef struct reader {
    const char *name;
    const char *at;
    const char *end;
    size_t line; /* number of the last one that was read, from 1 */
    field fields[FIELDS_MAX];
    size_t count;
    bool is_comment;
} reader;

/* Which number of a line is what. */
typedef struct format {
    bool is_matrix;
    size_t fields; /* of each line; 0: not known yet */
    size_t place[COLUMNS];
    int exponent; /* from the time's unit to nanoseconds */
} format;

typedef struct parser {
    reader lines;
    reader *times; /* of KITTI; NULL: none */
    format format;
    lum_poses *poses;
    lum_poses_mark before;
    lum_error *error;
} parser;

static int refuse(const reader *r, lum_error *error, const char *what)
{
    errno = EINVAL;
    return lum_error_set(error, "%.250s: line %zu: %s", r->name, r->line, what);
}

/* --- Lines --- */

static bool is_separator(char c)
{
    return c == ' ' || c == '\t' || c == ',' || c == ';' || c == '\r';
}

static void split(reader *r, const char *at, const char *end)
{
    r->count = 0;
    while (at < end) {
        if (is_separator(*at)) {
            at++;
            continue;
        }
        const char *begin = at;
        while (at < end && !is_separator(*at)) {
            at++;
        }
        if (r->count < FIELDS_MAX) {
            r->fields[r->count] = (field){begin, (size_t)(at - begin)};
        }
        r->count++;
    }
}

/* The next line that is not empty, comments too. */
static bool next_line(reader *r)
{
    r->count = 0;
    while (r->at < r->end && r->count == 0) {
        const char *end = memchr(r->at, '\n', (size_t)(r->end - r->at));
        const char *stop = end != NULL ? end : r->end;
        const char *at = r->at;
        r->line++;
        while (at < stop && is_separator(*at)) {
            at++;
        }
        r->is_comment = at < stop && *at == '#';
        split(r, r->is_comment ? at + 1 : at, stop);
        r->at = end != NULL ? end + 1 : r->end;
    }
    return r->count > 0;
}

static bool next_data(reader *r)
{
    bool is_there = next_line(r);
    while (is_there && r->is_comment) {
        is_there = next_line(r);
    }
    return is_there;
}

static reader reader_of(const lum_poses_text *text)
{
    static const char mark[] = "\xef\xbb\xbf";
    const bool has_mark = text->len >= 3u && memcmp(text->at, mark, 3u) == 0;
    return (reader){.name = text->name,
                    .at = text->at + (has_mark ? 3 : 0),
                    .end = text->at + text->len};
}

/* --- Numbers --- */

static int refuse_field(const reader *r, size_t i, lum_error *error)
{
    const field *f = &r->fields[i];
    char shown[24];
    size_t n = 0;
    for (; n < f->len && n < sizeof shown - 1u; n++) {
        const unsigned char c = (unsigned char)f->at[n];
        shown[n] = isprint(c) != 0 && c < 128u ? f->at[n] : '?';
    }
    shown[n] = '\0';
    errno = EINVAL;
    return lum_error_set(
        error, "%.250s: line %zu: '%s' is not a number such as 12.5 or 1.25e1",
        r->name, r->line, shown);
}

static int take_number(const reader *r, size_t i, double *out, lum_error *error)
{
    lum_decimal d;
    if (!lum_decimal_parse(r->fields[i].at, r->fields[i].len, &d)) {
        return refuse_field(r, i, error);
    }
    *out = lum_decimal_double(&d);
    return fabs(*out) <= DBL_MAX ? 0 : refuse_field(r, i, error);
}

static int take_time(const reader *r, size_t i, int exponent, int64_t *out,
                     lum_error *error)
{
    lum_decimal d;
    if (!lum_decimal_parse(r->fields[i].at, r->fields[i].len, &d)) {
        return refuse_field(r, i, error);
    }
    const double value = lum_decimal_double(&d);
    if (exponent == 9 && fabs(value) > SECONDS_MAX) {
        errno = EINVAL;
        return lum_error_set(error,
                             "%.250s: line %zu: the time %.0f is too large to "
                             "be seconds; use seconds, or a CSV column "
                             "t_ms, t_us or t_ns",
                             r->name, r->line, value);
    }
    if (!lum_decimal_whole(&d, exponent, out)) {
        return refuse(r, error,
                      "the time is too large for nanoseconds in 64 bits; use "
                      "the unit in the column's name");
    }
    return 0;
}

/* --- What a line is --- */

static bool is_name(const field *f, size_t len, const char *name)
{
    size_t i = 0;
    while (i < len && name[i] != '\0' &&
           tolower((unsigned char)f->at[i]) == name[i]) {
        i++;
    }
    return i == len && name[i] == '\0';
}

/* Whether it names a time; then its unit too. */
static bool is_time(const field *f, int *exponent)
{
    static const struct {
        const char *ending;
        int exponent;
    } endings[] = {{"_ns", 0}, {"_us", 3}, {"_ms", 6}, {"_s", 9}, {"", 9}};
    static const char *const names[] = {"t", "time", "timestamp"};
    for (size_t u = 0; u < sizeof endings / sizeof *endings; u++) {
        const size_t n = strlen(endings[u].ending);
        const field tail = {f->at + f->len - (n < f->len ? n : f->len), n};
        for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
            if (n < f->len && is_name(&tail, n, endings[u].ending) &&
                is_name(f, f->len - n, names[i])) {
                *exponent = endings[u].exponent;
                return true;
            }
        }
    }
    return false;
}

static enum column column_of(const field *f, int *exponent)
{
    static const char *const names[] = {"x",  "y",  "z",  "qx", "qy",
                                        "qz", "qw", "tx", "ty", "tz"};
    static const enum column of[] = {X, Y, Z, QX, QY, QZ, QW, X, Y, Z};
    if (is_time(f, exponent)) {
        return T;
    }
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (is_name(f, f->len, names[i])) {
            return of[i];
        }
    }
    return COLUMNS;
}

/* A line of names. Returns a column that it lacks, or COLUMNS; -1: it has one
 * twice. */
static int take_names(const reader *r, format *out)
{
    bool has[COLUMNS] = {false};
    *out = (format){.fields = r->count};
    for (size_t i = 0; i < r->count && i < FIELDS_MAX; i++) {
        const enum column c = column_of(&r->fields[i], &out->exponent);
        if (c == COLUMNS) {
            continue;
        }
        if (has[c]) {
            return -1;
        }
        has[c] = true;
        out->place[c] = i;
    }
    int lacks = 0;
    while (lacks < (int)COLUMNS && has[lacks]) {
        lacks++;
    }
    return lacks;
}

static int refuse_names(const parser *p, int lacks)
{
    static const char *const names[] = {"t",  "x",  "y",  "z",
                                        "qx", "qy", "qz", "qw"};
    errno = EINVAL;
    return lum_error_set(
        p->error,
        "%.250s: line %zu: %s%s; use numbers (TUM: t x y z qx qy qz qw; KITTI: "
        "12 of a matrix), or a CSV with a line of names: t,x,y,z,qx,qy,qz,qw",
        p->lines.name, p->lines.line,
        lacks < 0 ? "names a column twice" : "has names, but lacks ",
        lacks < 0 ? "" : names[lacks]);
}

static bool has_letter(const field *f)
{
    return f->len > 0 && isalpha((unsigned char)f->at[0]) != 0 &&
           !is_name(f, f->len, "nan") && !is_name(f, f->len, "inf");
}

/* By the first line that is no comment, or by the names in one above it. */
static int find_format(parser *p)
{
    reader *r = &p->lines;
    format named = {.fields = 0};
    bool is_there = next_line(r);
    while (is_there && r->is_comment) {
        format found;
        if (take_names(r, &found) == (int)COLUMNS) {
            named = found;
        }
        is_there = next_line(r);
    }
    if (!is_there) {
        return lum_poses_end(p->poses, r->name, p->error);
    }
    if (has_letter(&r->fields[0])) {
        const int lacks = take_names(r, &p->format);
        if (lacks != (int)COLUMNS) {
            return refuse_names(p, lacks);
        }
        (void)next_data(r);
        return 0;
    }
    if (named.fields == r->count) {
        p->format = named;
        return 0;
    }
    p->format = (format){.is_matrix = r->count == KITTI_CELLS,
                         .fields = r->count,
                         .place = {0, 1, 2, 3, 4, 5, 6, 7},
                         .exponent = 9};
    if (r->count != KITTI_CELLS && r->count != TUM_FIELDS) {
        errno = EINVAL;
        return lum_error_set(p->error,
                             "%.250s: line %zu has %zu values; use 8 (TUM: t x "
                             "y z qx qy qz qw), 12 (KITTI: 3 rows of 4), or a "
                             "CSV with a line of names (t,x,y,z,qx,qy,qz,qw)",
                             r->name, r->line, r->count);
    }
    return 0;
}

/* --- Poses --- */

static int take_values(const parser *p, int64_t *time_ns, lum_pose *out)
{
    const reader *r = &p->lines;
    const size_t *place = p->format.place;
    if (take_time(r, place[T], p->format.exponent, time_ns, p->error) != 0) {
        return -1;
    }
    for (size_t i = 0; i < COLUMNS - 1u; i++) {
        double *to = i < 3u ? &out->at[i] : &out->turn[i - 3u];
        if (take_number(r, place[X + i], to, p->error) != 0) {
            return -1;
        }
    }
    return 0;
}

/* How far rows are from those of a rotation: from length 1, from being square
 * to each other, and from being right-handed. */
static double error_of_rows(const double m[KITTI_CELLS])
{
    double worst = 0.0;
    for (size_t a = 0; a < 3u; a++) {
        for (size_t b = a; b < 3u; b++) {
            double product = 0.0;
            for (size_t i = 0; i < 3u; i++) {
                product += m[4u * a + i] * m[4u * b + i];
            }
            worst = fmax(worst, fabs(product - (a == b ? 1.0 : 0.0)));
        }
    }
    const double determinant = m[0] * (m[5] * m[10] - m[6] * m[9]) -
                               m[1] * (m[4] * m[10] - m[6] * m[8]) +
                               m[2] * (m[4] * m[9] - m[5] * m[8]);
    return determinant > 0.0 ? worst : INFINITY;
}

/* From the largest of the four, so that nothing vanishes. */
static void quaternion_of(const double m[KITTI_CELLS], double q[4])
{
    const double d[4] = {m[0], m[5], m[10], m[0] + m[5] + m[10]};
    size_t largest = 0;
    for (size_t i = 1; i < 4u; i++) {
        largest = d[i] > d[largest] ? i : largest;
    }
    if (largest == 3u) {
        q[0] = m[9] - m[6];
        q[1] = m[2] - m[8];
        q[2] = m[4] - m[1];
        q[3] = 1.0 + d[3];
        return;
    }
    const size_t i = largest;
    const size_t j = (i + 1u) % 3u;
    const size_t k = (i + 2u) % 3u;
    q[i] = 1.0 + d[i] - d[j] - d[k];
    q[j] = m[4u * j + i] + m[4u * i + j];
    q[k] = m[4u * k + i] + m[4u * i + k];
    q[3] = m[4u * k + j] - m[4u * j + k];
}

static int take_matrix(const parser *p, lum_pose *out)
{
    double m[KITTI_CELLS];
    for (size_t i = 0; i < KITTI_CELLS; i++) {
        if (take_number(&p->lines, i, &m[i], p->error) != 0) {
            return -1;
        }
    }
    if (!(error_of_rows(m) <= 2.0 * LUM_POSES_UNIT_ERROR)) {
        return refuse(&p->lines, p->error,
                      "the first three columns are not a rotation; use "
                      "right-handed rows of length 1, square to each other");
    }
    for (size_t i = 0; i < 3u; i++) {
        out->at[i] = m[4u * i + 3u];
    }
    quaternion_of(m, out->turn);
    (void)lum_pose_normalize(out);
    return 0;
}

static int take_time_of_matrix(const parser *p, int64_t *out)
{
    if (p->times == NULL) {
        return refuse(&p->lines, p->error,
                      "a matrix of KITTI has no time: name the file of times "
                      "too, one a line");
    }
    if (!next_data(p->times)) {
        errno = EINVAL;
        return lum_error_set(p->error,
                             "%.200s has fewer times than %.200s has poses: "
                             "line %zu has none; use one for each",
                             p->times->name, p->lines.name, p->lines.line);
    }
    if (p->times->count != 1u) {
        return refuse(p->times, p->error, "use one time alone");
    }
    return take_time(p->times, 0, 9, out, p->error);
}

static int take_pose(parser *p)
{
    reader *r = &p->lines;
    const lum_poses_mark mark = {r->name, r->line};
    int64_t time_ns = 0;
    lum_pose pose = lum_pose_identity();
    if (r->count != p->format.fields || r->count > FIELDS_MAX) {
        errno = EINVAL;
        return lum_error_set(
            p->error,
            "%.250s: line %zu has %zu values, the lines before "
            "%zu%s",
            r->name, r->line, r->count, p->format.fields,
            r->at == r->end ? ": was the file cut short?"
                            : ": use the same number in each");
    }
    const int result =
        p->format.is_matrix
            ? (take_time_of_matrix(p, &time_ns) == 0 ? take_matrix(p, &pose)
                                                     : -1)
            : take_values(p, &time_ns, &pose);
    if (result != 0 || lum_poses_add(p->poses, time_ns, &pose, &mark,
                                     &p->before, p->error) != 0) {
        return -1;
    }
    p->before = mark;
    return 0;
}

/* Times that no pose has. */
static int check_times(const parser *p)
{
    if (p->times == NULL) {
        return 0;
    }
    errno = EINVAL;
    if (!p->format.is_matrix) {
        return lum_error_set(p->error,
                             "%.200s has times of its own: leave out the file "
                             "of times, %.200s",
                             p->lines.name, p->times->name);
    }
    return next_data(p->times)
               ? refuse(p->times, p->error,
                        "there are more times than poses; use one for each")
               : 0;
}

static int parse_all(parser *p)
{
    if (find_format(p) != 0) {
        return -1;
    }
    for (bool is_there = p->lines.count > 0; is_there;
         is_there = next_data(&p->lines)) {
        if (take_pose(p) != 0) {
            return -1;
        }
    }
    return check_times(p) == 0
               ? lum_poses_end(p->poses, p->lines.name, p->error)
               : -1;
}

int lum_poses_parse(const lum_poses_text *text, const lum_poses_text *times,
                    const lum_poses_options *options, lum_poses **out,
                    lum_error *error)
{
    reader of_times = times != NULL ? reader_of(times) : (reader){.count = 0};
    parser p = {.lines = reader_of(text),
                .times = times != NULL ? &of_times : NULL,
                .poses = lum_poses_begin(options, error),
                .error = error};
    if (p.poses == NULL) {
        return -1;
    }
    if (parse_all(&p) != 0) {
        lum_poses_free(p.poses);
        return -1;
    }
    *out = p.poses;
    return 0;
}

/* --- Files --- */

static int fail_file(const char *path, int code, lum_error *error)
{
    errno = code;
    return lum_error_set(error, "%s: cannot be read: %s", path, strerror(code));
}

static int read_all(FILE *file, const char *path, char **bytes, size_t *len,
                    lum_error *error)
{
    size_t room = 0;
    size_t got = 0;
    do {
        char *more = lum_grown(*bytes, *len, READ_BYTES, 1, &room);
        if (more == NULL) {
            return fail_file(path, ENOMEM, error);
        }
        *bytes = more;
        errno = 0;
        got = fread(*bytes + *len, 1, room - *len, file);
        *len += got;
    } while (got > 0);
    return ferror(file) != 0 ? fail_file(path, errno, error) : 0;
}

/* out->at is to be freed, whatever is returned. */
static int read_file(const char *path, lum_poses_text *out, char **bytes,
                     lum_error *error)
{
    const bool is_stdin = strcmp(path, "-") == 0;
    const char *name = is_stdin ? "standard input" : path;
    FILE *file = is_stdin ? stdin : fopen(path, "rb");
    if (file == NULL) {
        return fail_file(name, errno, error);
    }
    size_t len = 0;
    const int result = read_all(file, name, bytes, &len, error);
    if (!is_stdin) {
        (void)fclose(file);
    }
    *out = (lum_poses_text){name, *bytes, len};
    return result;
}

int lum_poses_read(const char *path, const char *times_path,
                   const lum_poses_options *options, lum_poses **out,
                   lum_error *error)
{
    char *bytes = NULL;
    char *times_bytes = NULL;
    lum_poses_text text = {NULL, NULL, 0};
    lum_poses_text times = {NULL, NULL, 0};
    int result = read_file(path, &text, &bytes, error);
    if (result == 0 && times_path != NULL) {
        result = read_file(times_path, &times, &times_bytes, error);
    }
    if (result == 0) {
        result = lum_poses_parse(&text, times_path != NULL ? &times : NULL,
                                 options, out, error);
    }
    const int code = errno;
    free(bytes);
    free(times_bytes);
    errno = code;
    return result;
}
