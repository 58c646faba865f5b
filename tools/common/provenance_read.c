/* What the comments of a capture say of its origin, its calibration and its
 * profile. */
#include "provenance.h"

#include "printable.h"

#include "lum/config/config.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define KIND_BYTES 24u
#define LINE_BYTES 400u /* more than we write */

enum kind {
    KIND_NONE, /* a comment of others */
    KIND_ORIGIN,
    KIND_CALIBRATION,
    KIND_PROFILE,
    KIND_UNKNOWN /* ours, of another version or kind */
};

static const char *const kind_names[] = {"", "origin", "calibration", "profile",
                                         ""};

/* A comment; a NUL follows its bytes. */
struct comment {
    const char *text;
    size_t len;
};

/* What is being read. */
struct reading {
    const lum_capture *capture;
    const char *name; /* of the source that is heard */
    struct geometry *geometry;
    struct provenance_source *out;
};

/* --- Comments --- */

static struct comment comment_at(const lum_capture *capture, size_t source,
                                 size_t i)
{
    struct comment c;
    c.text = lum_capture_comment(capture, source, i, &c.len);
    return c;
}

static size_t head_bytes(const struct comment *c)
{
    const char *end = memchr(c->text, '\n', c->len);
    return end != NULL ? (size_t)(end - c->text) : c->len;
}

static enum kind kind_of(const struct comment *c)
{
    const size_t mark = sizeof PROVENANCE_MARK - 1u;
    const size_t head = head_bytes(c);
    if (c->len < mark || memcmp(c->text, PROVENANCE_MARK, mark) != 0) {
        return KIND_NONE;
    }
    for (enum kind k = KIND_ORIGIN; k < KIND_UNKNOWN; k++) {
        char want[48];
        const int n =
            snprintf(want, sizeof want, PROVENANCE_MARK "%s 1", kind_names[k]);
        if ((size_t)n == head && memcmp(want, c->text, head) == 0) {
            return k;
        }
    }
    return KIND_UNKNOWN;
}

/* --- Notes and documents --- */

LUM_PRINTF(2, 3)
static void note(struct provenance_source *out, const char *format, ...)
{
    va_list arguments;
    if (out->note_count < PROVENANCE_NOTES_MAX) {
        va_start(arguments, format);
        (void)vsnprintf(out->notes[out->note_count].text, LUM_ERROR_BYTES,
                        format, arguments);
        va_end(arguments);
        out->note_count++;
    }
}

/* It is written again, into headers that no byte of another may end. */
static bool is_plain(const struct comment *c)
{
    size_t line = 0;
    for (size_t i = 0; i < c->len; i++) {
        const char b = c->text[i];
        line = b == '\n' ? 0 : line + 1u;
        if ((b != '\n' && (b < ' ' || b > '~')) || line > LINE_BYTES ||
            (b == '\n' && i > 0 && c->text[i - 1u] == '\n')) {
            return false;
        }
    }
    return c->len > 0 && c->text[c->len - 1u] == '\n' &&
           c->len < PROVENANCE_ORIGIN_BYTES;
}

static void take_origin(const struct reading *r, const struct comment *c)
{
    struct provenance_source *out = r->out;
    if (!is_plain(c)) {
        note(out,
             "%s: its origin cannot be read: it has to be lines of "
             "printable ASCII; it is ignored",
             r->name);
    } else if (out->earlier_count < PROVENANCE_EARLIER_MAX) {
        memcpy(out->earlier[out->earlier_count++], c->text, c->len + 1u);
    }
}

static struct comment heard(const struct reading *r, size_t i)
{
    return comment_at(r->capture, r->out->speaker, i);
}

static size_t count(const struct reading *r, enum kind kind)
{
    size_t n = 0;
    for (size_t i = 0; i < r->out->looked_at; i++) {
        const struct comment c = heard(r, i);
        n += kind_of(&c) == kind ? 1u : 0u;
    }
    return n;
}

static int parse(const struct reading *r, enum kind kind,
                 const struct comment *c, lum_error *error)
{
    char name[128];
    (void)snprintf(name, sizeof name, "%.80s: its %s", r->name,
                   kind_names[kind]);
    return kind == KIND_CALIBRATION
               ? lum_calibration_parse(c->text, c->len, name,
                                       &r->geometry->calibration, error)
               : lum_profile_parse(c->text, c->len, name, &r->geometry->profile,
                                   error);
}

/* The only comment of a kind. */
static struct comment find(const struct reading *r, enum kind kind)
{
    struct comment c = heard(r, 0);
    for (size_t i = 1; kind_of(&c) != kind; i++) {
        c = heard(r, i);
    }
    return c;
}

/* A calibration, or a profile. has: whether the command line names one. */
static void take_keys(const struct reading *r, enum kind kind, bool *has)
{
    const char *what = kind_names[kind];
    const size_t n = count(r, kind);
    lum_error error = {""};
    if (n == 0) {
        return;
    }
    if (*has) {
        note(r->out,
             "%s: it has a %s of its own, which is not used: --%s names "
             "another",
             r->name, what, what);
        return;
    }
    if (n > 1) {
        note(r->out,
             "%s: it has %zu %ss of its own, and it is unknown which is right: "
             "the built-in one is used; name one by --%s",
             r->name, n, what, what);
        return;
    }
    const struct comment c = find(r, kind);
    if (parse(r, kind, &c, &error) == 0) {
        *has = true;
        return;
    }
    if (LUM_WITH_CONFIG) {
        note(r->out, "%.300s; the built-in one is used: name another by --%s",
             error.text, what);
    } else {
        note(r->out,
             "%.300s; the built-in one is used, and outputs will not contain "
             "it: use a build that reads YAML",
             error.text);
    }
}

static void note_unknown(const struct reading *r, const struct comment *c)
{
    const size_t mark = sizeof PROVENANCE_MARK - 1u;
    char head[KIND_BYTES];
    (void)printable((const uint8_t *)c->text + mark, head_bytes(c) - mark, head,
                    sizeof head);
    note(r->out,
         "%s: it has the comment '%s', which this version does not know; it is "
         "ignored",
         r->name, head);
}

/* What each of them is, they may not be together. */
static void check_both(const struct reading *r, const struct geometry *before)
{
    lum_layout layout;
    lum_projector projector;
    lum_error error = {""};
    if (geometry_make(r->geometry, &layout, &projector, &error) != 0) {
        *r->geometry = *before;
        note(r->out,
             "%s: its calibration and its profile contradict each other; both "
             "are ignored",
             r->name);
    }
}

/* --- Several sources --- */

/* The first source with a comment of ours; the first of all if none has. */
static size_t find_speaker(const lum_capture *capture)
{
    const size_t n = lum_capture_source_count(capture);
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < lum_capture_comment_count(capture, i); k++) {
            const struct comment c = comment_at(capture, i, k);
            if (kind_of(&c) != KIND_NONE) {
                return i;
            }
        }
    }
    return 0;
}

static bool is_taken(const struct provenance_source *s, const struct comment *c)
{
    const enum kind kind = kind_of(c);
    return (kind == KIND_CALIBRATION && s->takes_calibration) ||
           (kind == KIND_PROFILE && s->takes_profile);
}

static bool is_said(const lum_capture *capture, size_t speaker,
                    size_t looked_at, const struct comment *c)
{
    for (size_t i = 0; i < looked_at; i++) {
        const struct comment said = comment_at(capture, speaker, i);
        if (said.len == c->len && memcmp(said.text, c->text, c->len) == 0) {
            return true;
        }
    }
    return false;
}

/* One of a source's comments. */
struct place {
    size_t source;
    enum kind kind;
};

/* What sources say of a calibration or a profile and the speaker did not. first
 * gets the first of them; NULL: any. */
static size_t count_others(const lum_capture *capture,
                           const struct provenance_source *s, size_t speaker,
                           struct place *first)
{
    const size_t sources = lum_capture_source_count(capture);
    size_t n = 0;
    for (size_t i = 0; i < sources; i++) {
        for (size_t k = 0; k < lum_capture_comment_count(capture, i); k++) {
            const struct comment c = comment_at(capture, i, k);
            if (is_taken(s, &c) &&
                !is_said(capture, speaker, s->looked_at, &c)) {
                n++;
                if (n == 1 && first != NULL) {
                    *first = (struct place){i, kind_of(&c)};
                }
            }
        }
    }
    return n;
}

static void note_others(const struct reading *r)
{
    struct provenance_source *out = r->out;
    struct place first = {0, KIND_NONE};
    lum_capture_source other = {.struct_size = sizeof other};
    out->others = count_others(r->capture, out, out->speaker, &first);
    if (out->others > 0) {
        lum_capture_get_source(r->capture, first.source, &other);
        note(out,
             "%.200s: its calibration or its profile is not that of %.200s, "
             "which is used for all",
             other.name, r->name);
    }
}

static void note_left_out(const struct reading *r)
{
    const size_t n = lum_capture_source_count(r->capture);
    for (size_t i = 0; i < n; i++) {
        lum_capture_source source = {.struct_size = sizeof source};
        if (lum_capture_comments_left_out(r->capture, i) > 0) {
            lum_capture_get_source(r->capture, i, &source);
            note(r->out,
                 "%s: it has more than %u comments; what the rest say of its "
                 "calibration and profile is ignored",
                 source.name, LUM_CAPTURE_COMMENTS_MAX);
            return;
        }
    }
}

static void take_texts(const struct reading *r)
{
    for (size_t i = 0; i < r->out->looked_at; i++) {
        const struct comment c = heard(r, i);
        const enum kind kind = kind_of(&c);
        if (kind == KIND_ORIGIN) {
            take_origin(r, &c);
        } else if (kind == KIND_UNKNOWN) {
            note_unknown(r, &c);
        }
    }
}

/* --- The whole --- */

void provenance_take(const lum_capture *capture, struct geometry *geometry,
                     struct provenance_source *out)
{
    const struct geometry before = *geometry;
    lum_capture_source speaker = {.struct_size = sizeof speaker};
    memset(out, 0, sizeof *out);
    out->speaker = find_speaker(capture);
    out->looked_at = lum_capture_comment_count(capture, out->speaker);
    out->takes_calibration = !geometry->has_calibration;
    out->takes_profile = !geometry->has_profile;
    lum_capture_get_source(capture, out->speaker, &speaker);
    const struct reading r = {capture, speaker.name, geometry, out};
    take_texts(&r);
    take_keys(&r, KIND_CALIBRATION, &geometry->has_calibration);
    take_keys(&r, KIND_PROFILE, &geometry->has_profile);
    check_both(&r, &before);
    note_others(&r);
    note_left_out(&r);
}

/* --- Sources of which some are streams --- */

static const char *name_of(const lum_capture *capture, size_t i)
{
    lum_capture_source source = {.struct_size = sizeof source};
    lum_capture_get_source(capture, i, &source);
    return source.name;
}

/* The names in sources stay when the capture is closed. */
static const char *find_path(const struct sources *sources, const char *name)
{
    size_t i = 0;
    while (i < sources->count && strcmp(sources->paths[i], name) != 0) {
        i++;
    }
    return i < sources->count ? sources->paths[i] : NULL;
}

static int open_files(const struct sources *sources, lum_capture **out)
{
    const char **paths = calloc(sources->count, sizeof *paths);
    size_t count = 0;
    for (size_t i = 0; paths != NULL && i < sources->count; i++) {
        if (sources_is_file(sources->paths[i])) {
            paths[count++] = sources->paths[i];
        }
    }
    const int result =
        count > 0 ? lum_capture_open_several(paths, count, out, NULL) : -1;
    free(paths);
    return result;
}

void provenance_ask(const char *program, const struct sources *sources,
                    bool is_quiet, struct geometry *geometry,
                    struct provenance_source *out)
{
    lum_capture *capture = NULL;
    memset(out, 0, sizeof *out);
    out->takes_calibration = !geometry->has_calibration;
    out->takes_profile = !geometry->has_profile;
    if (open_files(sources, &capture) != 0) {
        return;
    }
    provenance_take(capture, geometry, out);
    out->path = find_path(sources, name_of(capture, out->speaker));
    for (size_t i = 0; i < out->note_count && !is_quiet; i++) {
        (void)fprintf(stderr, "%s: warning: %s\n", program, out->notes[i].text);
    }
    lum_capture_close(capture);
}

bool provenance_find_other(const lum_capture *capture,
                           const struct provenance_source *asked,
                           struct provenance_other *out)
{
    const size_t count = lum_capture_source_count(capture);
    struct place first = {0, KIND_NONE};
    size_t speaker = 0;
    while (asked->path != NULL && speaker < count &&
           strcmp(name_of(capture, speaker), asked->path) != 0) {
        speaker++;
    }
    if (count_others(capture, asked, speaker, &first) == 0) {
        return false;
    }
    *out = (struct provenance_other){.source = name_of(capture, first.source),
                                     .speaker = asked->path,
                                     .what = kind_names[first.kind]};
    if (asked->path != NULL && first.source == speaker) {
        out->speaker = out->source;
    }
    return true;
}

bool provenance_has_changed(const lum_capture *capture,
                            const struct provenance_source *source)
{
    return count_others(capture, source, source->speaker, NULL) >
           source->others;
}
