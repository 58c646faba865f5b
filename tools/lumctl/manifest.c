#define _POSIX_C_SOURCE 200809L
#include "manifest.h"

#include "../common/json.h"
#include "../common/make_folder.h"
#include "ctl_session.h"
#include "file_writer.h"
#include "status_report.h"

#include "base/claim.h"
#include "base/crc32.h"
#include "base/outfile.h"
#include "lum/base/time.h"
#include "lum/version.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define FILE_BYTES_MAX (8u << 20)
#define CLAIM_NS       INT64_C(5000000000)
#define AGAIN_NS       INT64_C(50000000)

/* A step: how its line begins, by which it is known again, and the line. */
struct line {
    char *begin;
    char *text;
    bool was_done; /* by an earlier run */
};

struct manifest {
    const struct ctl *ctl;
    const char *folder;
    const char *plan;
    char path[MANIFEST_PATH_BYTES];
    struct report_utc begun;
    char *earlier; /* the text of an earlier one; NULL: none */
    struct line *lines;
    size_t count;
    size_t known; /* steps that the earlier one has as done, by their begin */
    lum_claim claim;    /* to the folder's sweep */
    bool has_strangers; /* files of steps, without a manifest */
    bool has_begun;     /* to be written */
    struct file_writer *writer;
};

/* --- An earlier one --- */

/* The whole text; NULL with the reason in errno. */
static char *read_text(const char *path)
{
    FILE *file = fopen(path, "rb");
    char *text = file != NULL ? malloc(FILE_BYTES_MAX + 1u) : NULL;
    size_t len = 0;
    if (text != NULL) {
        len = fread(text, 1, FILE_BYTES_MAX, file);
        text[len] = '\0';
    }
    if (text != NULL && ferror(file) != 0) {
        free(text);
        text = NULL;
    }
    if (file != NULL) {
        (void)fclose(file);
    }
    return text;
}

/* In the line of a step; in a text its quotes would be escaped. */
static const char is_done[] = ", \"done\": true";

/* The earlier line of a step that is the same in this plan, up to its end;
 * NULL: none, or it was not done. */
static char *find_earlier(const struct manifest *m, const char *begin)
{
    const char *at = m->earlier;
    const char *found = at != NULL ? strstr(at, begin) : NULL;
    if (found == NULL ||
        strncmp(found + strlen(begin), is_done, sizeof is_done - 1) != 0) {
        return NULL;
    }
    const size_t len = strcspn(found, "\n");
    const bool has_comma = len > 0 && found[len - 1] == ',';
    return strndup(found, has_comma ? len - 1 : len);
}

/* --- Its beginning --- */

/* As put_all() writes it, from its begin to its end. */
static bool is_ours(const char *text)
{
    static const char begin[] = "{\"version\": 1, \"program\": \"lumctl ";
    static const char end[] = "}\n]}\n";
    const size_t len = strlen(text);
    return strncmp(text, begin, sizeof begin - 1) == 0 &&
           len > sizeof end - 1 &&
           strcmp(text + len - (sizeof end - 1), end) == 0;
}

/* A run that was just told to end switches its laser off first. */
static int claim(struct manifest *m, const char *mark, lum_error *error)
{
    const int64_t end = lum_time_monotonic_ns() + CLAIM_NS;
    int result = lum_claim_take(mark, m->folder, &m->claim, error);
    while (result != 0 && errno == EBUSY && lum_time_monotonic_ns() < end &&
           !lum_cancel_is_raised(m->ctl->cancel)) {
        lum_claim_drop(&m->claim);
        lum_time_sleep_until(lum_time_monotonic_ns() + AGAIN_NS);
        result = lum_claim_take(mark, m->folder, &m->claim, error);
    }
    return result;
}

static enum exit_status open_folder(struct manifest *m, bool goes_on)
{
    lum_error error = {""};
    char mark[MANIFEST_PATH_BYTES];
    if (make_folder(m->folder) != 0 && errno != EEXIST) {
        return ctl_complain(EXIT_FAILED, "%s: %s", m->folder, strerror(errno));
    }
    if (snprintf(m->path, sizeof m->path, "%s/manifest.json", m->folder) >=
        (int)sizeof m->path) {
        return ctl_complain(EXIT_BAD, "%s: the name is too long", m->folder);
    }
    (void)snprintf(mark, sizeof mark, "%.4000s/sweep", m->folder);
    if (claim(m, mark, &error) != 0) {
        return ctl_complain(EXIT_FAILED, "%s", error.text);
    }
    m->earlier = read_text(m->path);
    if (m->earlier == NULL && errno != ENOENT) {
        return ctl_complain(EXIT_FAILED, "%s: %s", m->path, strerror(errno));
    }
    if (m->earlier != NULL && !is_ours(m->earlier)) {
        return ctl_complain(
            EXIT_BAD,
            "%s is damaged, or lumctl did not write it: name another "
            "folder with -o",
            m->path);
    }
    if (m->earlier != NULL && !goes_on) {
        return ctl_complain(EXIT_BAD,
                            "%s is there: with --continue only what is missing "
                            "is done; or name another folder with -o",
                            m->path);
    }
    return EXIT_DONE;
}

enum exit_status manifest_open(struct ctl *ctl, const char *folder,
                               const char *plan, size_t steps, bool goes_on,
                               struct manifest **out)
{
    struct manifest *m = calloc(1, sizeof *m);
    lum_error error = {""};
    *out = m;
    if (m == NULL) {
        return ctl_complain(EXIT_FAILED, "out of memory");
    }
    m->claim = LUM_CLAIM_NONE;
    m->ctl = ctl;
    m->folder = folder;
    m->plan = plan;
    m->count = steps;
    m->lines = calloc(steps, sizeof *m->lines);
    m->begun = report_utc(lum_time_utc_ns());
    if (m->lines == NULL) {
        return ctl_complain(EXIT_FAILED, "out of memory");
    }
    const enum exit_status status = open_folder(m, goes_on);
    if (status != EXIT_DONE) {
        return status;
    }
    m->writer = file_writer_new(NULL, "", m->path, &error);
    return m->writer != NULL ? EXIT_DONE
                             : ctl_complain(EXIT_FAILED, "%s", error.text);
}

/* --- The lines --- */

/* The table that an elevation comes to depends on the calibration. */
static void put_table(struct json *json, const struct settings_plan *settings)
{
    char text[16];
    lum_crc32 crc;
    if (settings->has_table) {
        const struct yscan_table *table = &settings->table;
        lum_crc32_init(&crc);
        (void)snprintf(text, sizeof text, "%08" PRIx32,
                       lum_crc32_add(&crc, 0, table->raw,
                                     table->count * sizeof table->raw[0]));
        json_text(json, "table_crc", text);
    }
}

static void put_begin(const struct manifest *m, FILE *out, size_t step,
                      const struct settings_plan *settings,
                      const lum_sweep_step *what)
{
    struct json json;
    json_begin_line(&json, out);
    json_uint(&json, "step", step + 1u);
    json_text(&json, "sensor", session_name(session_host(m->ctl)).text);
    json_bool(&json, "laser", m->ctl->options.owner.laser);
    json_open_object(&json, "settings");
    for (size_t i = 0; i < settings->count; i++) {
        json_text(&json, settings->items[i].setting, settings->items[i].value);
    }
    json_close_object(&json);
    put_table(&json, settings);
    json_real(&json, "record_s", (double)what->record_ns / 1e9, 3);
    json_uint(&json, "record_frames", what->frames);
    json_real(&json, "settle_s", (double)what->settle_ns / 1e9, 3);
}

bool manifest_name(struct manifest *m, size_t step,
                   const struct settings_plan *settings,
                   const lum_sweep_step *what)
{
    struct line *line = &m->lines[step];
    size_t len = 0;
    FILE *out = open_memstream(&line->begin, &len);
    if (out == NULL) {
        return false;
    }
    put_begin(m, out, step, settings, what);
    if (fclose(out) != 0) {
        return false;
    }
    char name[32];
    char path[MANIFEST_PATH_BYTES];
    manifest_file(m, step, name, path);
    const bool records = what->record_ns > 0 || what->frames > 0;
    if (m->earlier == NULL && access(path, F_OK) == 0) {
        m->has_strangers = true;
    }
    char *earlier = find_earlier(m, line->begin);
    m->known += earlier != NULL ? 1u : 0u;
    line->was_done = earlier != NULL && (!records || access(path, R_OK) == 0);
    if (line->was_done) {
        line->text = earlier;
    } else {
        free(earlier);
    }
    return true;
}

/* Else what is there would be replaced, or stay beside what is another's. */
enum exit_status manifest_check(const struct manifest *m)
{
    size_t done = 0;
    if (m->has_strangers) {
        return ctl_complain(EXIT_BAD,
                            "%s has recordings of steps and no manifest: name "
                            "another folder with -o",
                            m->folder);
    }
    const char *at = m->earlier != NULL ? strstr(m->earlier, is_done) : NULL;
    while (at != NULL) {
        done++;
        at = strstr(at + 1, is_done);
    }
    return done == m->known
               ? EXIT_DONE
               : ctl_complain(EXIT_BAD,
                              "%s: %u steps were done with another plan, "
                              "sensor or calibration, or differ in --laser: "
                              "name another folder with -o",
                              m->path, (unsigned)(done - m->known));
}

bool manifest_is_done(const struct manifest *m, size_t step)
{
    return m->lines[step].was_done;
}

void manifest_file(const struct manifest *m, size_t step, char name[32],
                   char path[MANIFEST_PATH_BYTES])
{
    (void)snprintf(name, 32, "step-%04u.pcapng", (unsigned)step + 1u);
    (void)snprintf(path, MANIFEST_PATH_BYTES, "%.4000s/%s", m->folder, name);
}

static void put_time(struct json *json, const char *key, int64_t utc_ns)
{
    if (utc_ns != 0) {
        json_text(json, key, report_utc(utc_ns).text);
    }
}

static void put_counts(struct json *json, const struct recorder_counts *c)
{
    put_time(json, "first_packet", c->first_utc_ns);
    put_time(json, "last_packet", c->last_utc_ns);
    json_real(json, "longest_gap_s", (double)c->longest_gap_ns / 1e9, 3);
    json_uint(json, "packets", c->packets);
    json_uint(json, "packets_not_written", c->dropped);
    json_uint(json, "lines", c->losses.lines);
    json_uint(json, "lines_incomplete", c->losses.lines_incomplete);
    json_uint(json, "lines_missing", c->losses.lines_missing);
    json_uint(json, "lost_words", c->losses.words_lost);
    json_uint(json, "refused", c->losses.refused);
}

static void put_rest(FILE *out, const struct manifest_result *r)
{
    struct json json;
    json_init(&json, out);
    json.has_before = true;
    json.depth = 1; /* put_begin() has begun it */
    json_bool(&json, "done", r->is_done);
    if (r->is_done && r->file[0] != '\0') {
        json_text(&json, "file", r->file);
    }
    put_time(&json, "set", r->set_utc_ns);
    if (r->has_status) {
        json_uint(&json, "status", r->status);
    }
    if (r->is_done && r->file[0] != '\0') {
        put_counts(&json, &r->counts);
    }
    if (!r->is_done) {
        json_text(&json, "why", r->why);
    }
    json_close_object(&json);
}

static void put_all(const struct manifest *m, FILE *out, const char *why,
                    int status)
{
    static const struct manifest_result unbegun = {.why = "it was not begun"};
    struct json json;
    json_begin_line(&json, out);
    json_uint(&json, "version", 1);
    json_text(&json, "program", "lumctl " LUM_VERSION);
    json_text(&json, "sensor", session_name(session_host(m->ctl)).text);
    json_text(&json, "plan", m->plan);
    json_text(&json, "begun", m->begun.text);
    json_text(&json, "written", report_utc(lum_time_utc_ns()).text);
    if (status >= 0) {
        json_int(&json, "exit_status", status);
        json_text(&json, "why", why);
    }
    json_open_array(&json, "steps");
    for (size_t i = 0; i < m->count; i++) {
        const struct line *line = &m->lines[i];
        (void)fprintf(out, "%s\n%s", i > 0 ? "," : "",
                      line->text != NULL ? line->text : line->begin);
        if (line->text == NULL) {
            put_rest(out, &unbegun);
        }
    }
    (void)fputc('\n', out);
    json_close_array(&json);
    json_end_line(&json);
}

/* The whole text, to be freed; NULL: no memory. */
static char *make_text(const struct manifest *m, const char *why, int status)
{
    char *text = NULL;
    size_t len = 0;
    FILE *out = open_memstream(&text, &len);
    if (out == NULL) {
        return NULL;
    }
    put_all(m, out, why, status);
    if (fclose(out) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

static void write_all(struct manifest *m, const char *why, int status)
{
    char *text = make_text(m, why, status);
    if (text != NULL) {
        file_writer_turn(m->writer, text);
    }
    free(text);
}

bool manifest_begin(struct manifest *m, lum_error *error)
{
    char *text = make_text(m, "", -1);
    const bool is_written =
        text != NULL &&
        lum_outfile_save(m->path, text, strlen(text), error) == 0;
    if (text == NULL) {
        (void)lum_error_set(error, "out of memory");
    }
    free(text);
    m->has_begun = is_written;
    return is_written;
}

void manifest_note(struct manifest *m, size_t step,
                   const struct manifest_result *result)
{
    struct line *line = &m->lines[step];
    char *text = NULL;
    size_t len = 0;
    FILE *out = open_memstream(&text, &len);
    if (out == NULL) {
        return;
    }
    (void)fputs(line->begin, out);
    put_rest(out, result);
    if (fclose(out) == 0) {
        free(line->text);
        line->text = text;
    }
    write_all(m, "", -1);
}

bool manifest_tell(struct manifest *m, lum_error *out)
{
    return file_writer_tell(m->writer, out);
}

bool manifest_end(struct manifest *m, const char *why, enum exit_status status)
{
    if (m == NULL) {
        return true;
    }
    if (m->has_begun) {
        write_all(m, why, (int)status);
    }
    const struct file_writer_rest rest = file_writer_end(m->writer);
    for (size_t i = 0; m->lines != NULL && i < m->count; i++) {
        free(m->lines[i].begin);
        free(m->lines[i].text);
    }
    if (!rest.hangs) { /* else it may write yet */
        lum_claim_drop(&m->claim);
    }
    free(m->lines);
    free(m->earlier);
    free(m);
    return !rest.page_failed;
}
