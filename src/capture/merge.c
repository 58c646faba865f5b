#include "merge.h"

#include "base/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* One of the files. */
struct part {
    char *name;
    const char *path; /* to open it by; NULL: it is open, or was */
    size_t place;     /* among those that were given */
    lum_input *input; /* NULL: not open */
    lum_comments *comments;
    char *empty;     /* why nothing can be read of it; NULL: it has a header */
    bool has_record; /* one is in hand */
    lum_pcap_record record;
    int64_t sort_ns;  /* its first record's; without any before all times */
    int64_t first_ns; /* of those handed out */
    int64_t last_ns;
    uint64_t records; /* handed out */
    uint64_t done;    /* bytes read before it was closed */
    uint64_t total;   /* bytes; 0: not known */
    uint64_t damaged; /* parts that were passed over before it was closed */
    lum_capture_end end;
};

struct lum_merge {
    struct part *parts;     /* by first record */
    lum_comments *comments; /* as they were given: inputs keep them */
    size_t count;
    size_t next;        /* the first that was not begun */
    size_t first_open;  /* none before it is being read */
    struct part *given; /* whose record was handed out last; or NULL */
    lum_go_on *go_on;
    size_t broken;
    lum_error error;            /* of the first that is */
    const struct part *damaged; /* the first closed file with such parts */
    lum_error damage;           /* and why its first part is one */
};

/* --- Opening --- */

static lum_merge *new_merge(size_t count, lum_go_on *go_on)
{
    lum_merge *m = calloc(1, sizeof *m);
    if (m == NULL) {
        return NULL;
    }
    m->go_on = go_on;
    m->parts = calloc(count, sizeof *m->parts);
    m->comments = calloc(count, sizeof *m->comments);
    if (m->parts == NULL || m->comments == NULL) {
        lum_merge_close(m);
        return NULL;
    }
    m->count = count;
    for (size_t i = 0; i < count; i++) {
        m->parts[i].comments = &m->comments[i];
    }
    return m;
}

static int refuse_for_memory(const char *name, lum_error *error)
{
    return lum_error_set(error, "%s: not enough memory to read it", name);
}

int lum_merge_one(lum_source *source, lum_go_on *go_on, lum_merge **out,
                  lum_error *error)
{
    lum_merge *m = new_merge(1, go_on);
    char *name = m != NULL ? lum_text_copy(source->name) : NULL;
    if (name == NULL) {
        (void)refuse_for_memory(source->name, error);
        lum_merge_close(m);
        lum_source_close(source);
        return -1;
    }
    m->parts[0].name = name;
    source->go_on = go_on;
    if (lum_input_open(source, m->parts[0].comments, &m->parts[0].input,
                       error) != 0) {
        lum_merge_close(m);
        return -1;
    }
    m->next = 1;
    m->given = &m->parts[0];
    *out = m;
    return 0;
}

/* As lum_input_open(). */
static int open_input(struct part *p, lum_go_on *go_on, lum_error *error)
{
    lum_source *source = NULL;
    if (lum_source_open(p->path, &source, error) != 0) {
        return -1;
    }
    source->go_on = go_on;
    return lum_input_open(source, p->comments, &p->input, error);
}

/* Beside others it is no more than a recording that was just begun. */
static int note_empty(struct part *p, const lum_error *why)
{
    const char *name = strcmp(p->path, "-") == 0 ? "standard input" : p->path;
    p->name = lum_text_copy(name);
    p->empty = lum_text_copy(why->text);
    p->sort_ns = INT64_MIN;
    return p->name != NULL && p->empty != NULL ? 0 : -1;
}

/* Read its first record. A file that can be opened again is closed until its
 * turn comes; what is wrong behind its header is told then. */
static int probe(struct part *p, lum_go_on *go_on, lum_error *error)
{
    uint64_t done = 0;
    lum_error later = {""};
    const int opened = open_input(p, go_on, &later);
    if (opened > 0) {
        return note_empty(p, &later) == 0 ? 0
                                          : refuse_for_memory(p->path, error);
    }
    if (opened < 0) {
        return lum_error_set(error, "%s", later.text);
    }
    const char *name = p->input->source->name;
    p->name = lum_text_copy(name);
    if (p->name == NULL) {
        return refuse_for_memory(name, error);
    }
    lum_source_progress(p->input->source, &done, &p->total);
    if (p->total == 0 || strcmp(p->path, "-") == 0) {
        p->path = NULL;
    }
    const int got = lum_input_next(p->input, &p->record, &later);
    p->has_record = got > 0;
    p->sort_ns = got > 0 ? p->record.time_ns : INT64_MIN;
    if (p->path != NULL) {
        p->path = p->name;
        p->has_record = false;
        lum_input_close(p->input);
        p->input = NULL;
    }
    return 0;
}

static int compare(const void *a, const void *b)
{
    const struct part *p = a;
    const struct part *q = b;
    if (p->sort_ns != q->sort_ns) {
        return p->sort_ns < q->sort_ns ? -1 : 1;
    }
    return p->place < q->place ? -1 : 1;
}

/* Of none that is not empty, the first one says why. */
static int check_any(const lum_merge *m, lum_error *error)
{
    for (size_t i = 0; i < m->count; i++) {
        if (m->parts[i].empty == NULL) {
            return 0;
        }
    }
    return lum_error_set(error, "%s", m->parts[0].empty);
}

static int probe_all(lum_merge *m, const char *const *paths, lum_error *error)
{
    for (size_t i = 0; i < m->count; i++) {
        m->parts[i].path = paths[i];
        m->parts[i].place = i;
        if (probe(&m->parts[i], m->go_on, error) != 0) {
            return -1;
        }
    }
    qsort(m->parts, m->count, sizeof *m->parts, compare);
    return check_any(m, error);
}

static int open_several(const char *const *paths, size_t count,
                        lum_go_on *go_on, lum_merge **out, lum_error *error)
{
    lum_merge *m = new_merge(count, go_on);
    if (m == NULL) {
        return refuse_for_memory(paths[0], error);
    }
    if (probe_all(m, paths, error) != 0) {
        lum_merge_close(m);
        return -1;
    }
    *out = m;
    return 0;
}

int lum_merge_open(const char *const *paths, size_t count, lum_go_on *go_on,
                   lum_merge **out, lum_error *error)
{
    lum_source *source = NULL;
    if (count == 0) {
        return lum_error_set(error, "no capture is named");
    }
    if (count > 1) {
        return open_several(paths, count, go_on, out, error);
    }
    return lum_source_open(paths[0], &source, error) == 0
               ? lum_merge_one(source, go_on, out, error)
               : -1;
}

void lum_merge_close(lum_merge *merge)
{
    if (merge == NULL) {
        return;
    }
    for (size_t i = 0; i < merge->count; i++) {
        lum_input_close(merge->parts[i].input);
        lum_comments_clear(merge->parts[i].comments);
        free(merge->parts[i].name);
        free(merge->parts[i].empty);
    }
    free(merge->parts);
    free(merge->comments);
    free(merge);
}

/* --- The place of one file --- */

/* Then it stays open at its end. */
bool lum_merge_can_seek(const lum_merge *merge)
{
    return merge->count == 1 && merge->parts[0].input != NULL &&
           lum_pcap_can_seek(merge->parts[0].input->reader);
}

int lum_merge_pack(lum_merge *merge, lum_pack *pack, lum_error *error)
{
    struct part *p = &merge->parts[0];
    lum_pack_u64(pack, &p->records);
    lum_pack_i64(pack, &p->first_ns);
    lum_pack_i64(pack, &p->last_ns);
    if (lum_pack_is_reading(pack)) {
        p->has_record = false;
        p->end = LUM_CAPTURE_UNDER_WAY;
        merge->first_open = 0;
        merge->given = p;
        merge->broken = 0;
    }
    return lum_input_pack(p->input, pack, error);
}

/* --- Reading --- */

static void note_broken(lum_merge *m, const lum_error *error)
{
    if (m->broken == 0) {
        m->error = *error;
    }
    m->broken++;
}

static void note_damage(lum_merge *m, struct part *p)
{
    const char *first = "";
    p->damaged = lum_pcap_damaged(p->input->reader, &first);
    if (p->damaged != 0 && m->damaged == NULL) {
        m->damaged = p;
        (void)lum_error_set(&m->damage, "%s", first);
    }
}

static void end_part(lum_merge *m, struct part *p, lum_capture_end end)
{
    if (p->input != NULL) {
        lum_source_progress(p->input->source, &p->done, &p->total);
    }
    if (p->input != NULL && !lum_merge_can_seek(m)) {
        note_damage(m, p);
        lum_input_close(p->input);
        p->input = NULL;
    }
    p->has_record = false;
    p->end = end;
    while (m->first_open < m->next &&
           m->parts[m->first_open].end != LUM_CAPTURE_UNDER_WAY) {
        m->first_open++;
    }
}

static void read_part(lum_merge *m, struct part *p)
{
    lum_error error;
    error.text[0] = '\0';
    const int got = lum_input_next(p->input, &p->record, &error);
    p->has_record = got > 0;
    if (got < 0) {
        note_broken(m, &error);
    }
    if (got == 0) {
        end_part(m, p, LUM_CAPTURE_WHOLE);
    } else if (got < 0) {
        end_part(m, p,
                 lum_input_is_unread(p->input) ? LUM_CAPTURE_UNREAD
                                               : LUM_CAPTURE_BROKEN);
    }
}

static void begin_part(lum_merge *m)
{
    lum_error error = {""};
    struct part *p = &m->parts[m->next++];
    if (p->empty != NULL) {
        (void)lum_error_set(&error, "%s", p->empty);
        note_broken(m, &error);
        end_part(m, p, LUM_CAPTURE_BROKEN);
        return;
    }
    if (p->input == NULL && open_input(p, m->go_on, &error) != 0) {
        note_broken(m, &error);
        end_part(m, p, LUM_CAPTURE_UNREAD);
    } else if (!p->has_record) {
        read_part(m, p);
    }
}

static struct part *find_lowest(const lum_merge *m)
{
    struct part *lowest = NULL;
    for (size_t i = m->first_open; i < m->next; i++) {
        struct part *p = &m->parts[i];
        if (p->has_record &&
            (lowest == NULL || p->record.time_ns < lowest->record.time_ns)) {
            lowest = p;
        }
    }
    return lowest;
}

static int end(const lum_merge *m, lum_error *error)
{
    if (m->broken == 0) {
        return 0;
    }
    return m->broken == 1
               ? lum_error_set(error, "%s", m->error.text)
               : lum_error_set(error,
                               "%s; %zu more of the captures could not "
                               "be read to their end",
                               m->error.text, m->broken - 1u);
}

static void count(struct part *p)
{
    const int64_t time_ns = p->record.time_ns;
    if (p->records == 0) {
        p->first_ns = time_ns;
        p->last_ns = time_ns;
    }
    p->last_ns = time_ns > p->last_ns ? time_ns : p->last_ns;
    p->records++;
}

int lum_merge_next(lum_merge *merge, lum_pcap_record *out, lum_error *error)
{
    if (merge->given != NULL && merge->given->input != NULL) {
        read_part(merge, merge->given);
    }
    struct part *lowest = find_lowest(merge);
    while (merge->next < merge->count &&
           (lowest == NULL ||
            merge->parts[merge->next].sort_ns <= lowest->record.time_ns)) {
        begin_part(merge);
        lowest = find_lowest(merge);
    }
    merge->given = lowest;
    if (lowest == NULL) {
        return end(merge, error);
    }
    count(lowest);
    *out = lowest->record;
    return 1;
}

/* --- What is known --- */

size_t lum_merge_count(const lum_merge *merge)
{
    return merge->count;
}

static uint64_t damaged_of(const struct part *p, const char **first)
{
    return p->input != NULL ? lum_pcap_damaged(p->input->reader, first)
                            : p->damaged;
}

void lum_merge_get(const lum_merge *merge, size_t i, lum_capture_source *out)
{
    const struct part *p = &merge->parts[i];
    const char *first = "";
    *out = (lum_capture_source){.struct_size = sizeof *out,
                                .name = p->name,
                                .records = p->records,
                                .first_ns = p->first_ns,
                                .last_ns = p->last_ns,
                                .end = p->end,
                                .damaged = damaged_of(p, &first)};
}

/* The file that tells why, and the reason. */
static const struct part *find_damaged(const lum_merge *m, const char **first)
{
    if (m->damaged != NULL) {
        *first = m->damage.text;
        return m->damaged;
    }
    for (size_t i = 0; i < m->count; i++) {
        if (damaged_of(&m->parts[i], first) != 0) {
            return &m->parts[i];
        }
    }
    return NULL;
}

uint64_t lum_merge_damaged(const lum_merge *merge, lum_error *error)
{
    const char *first = "";
    uint64_t total = 0;
    for (size_t i = 0; i < merge->count; i++) {
        total += damaged_of(&merge->parts[i], &first);
    }
    const struct part *p = find_damaged(merge, &first);
    if (p != NULL) {
        const char *ignored = NULL;
        const uint64_t n = damaged_of(p, &ignored);
        lum_pcap_tell_damage(p->name, n, total - n, first, error);
    }
    return total;
}

const lum_comments *lum_merge_comments(const lum_merge *merge, size_t i)
{
    return merge->parts[i].comments;
}

void lum_merge_progress(const lum_merge *merge, uint64_t *done, uint64_t *total)
{
    bool is_known = true;
    *done = 0;
    *total = 0;
    for (size_t i = 0; i < merge->count; i++) {
        const struct part *p = &merge->parts[i];
        uint64_t read = p->done;
        uint64_t bytes = p->total;
        if (p->input != NULL) {
            lum_source_progress(p->input->source, &read, &bytes);
        }
        *done += read;
        *total += bytes;
        is_known = is_known && bytes != 0;
    }
    *total = is_known ? *total : 0;
}
