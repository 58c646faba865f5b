/* The text of a state file: a word and its values on each line, the last line
 * "end", so that a file that was cut short is known as such. */
#include "memory.h"

#include "../common/number.h"
#include "setting.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define HEAD "lumctl-state 1"

const char *const memory_standings[MEMORY_STANDINGS] = {
    [MEMORY_DONE] = "done", [MEMORY_UNSURE] = "unsure", [MEMORY_OLD] = "old"};

static const char *const scans[MEMORY_SCANS] = {[MEMORY_DEGREES] = "degrees",
                                                [MEMORY_SHAPE] = "shape",
                                                [MEMORY_TABLE] = "table"};

/* Text that grows. */
struct text {
    char *out;
    size_t len;
};

static void add(struct text *t, const char *what)
{
    const size_t len = strlen(what);
    const size_t room = MEMORY_TEXT_BYTES - 1u - t->len;
    const size_t taken = len < room ? len : room;
    memcpy(t->out + t->len, what, taken);
    t->len += taken;
    t->out[t->len] = '\0';
}

#define PUT(t, ...)                                                            \
    do {                                                                       \
        char line[MEMORY_FROM_BYTES + 64];                                     \
        (void)snprintf(line, sizeof line, __VA_ARGS__);                        \
        add((t), line);                                                        \
    } while (0)

/* The name of a setting as one word. */
static void put_word(struct text *t, const char *name)
{
    for (; *name != '\0'; name++) {
        PUT(t, "%c", *name == ' ' ? '-' : *name);
    }
}

static void put_table(struct text *t, const struct memory_table *table)
{
    const lum_yscan_shape *s = &table->shape;
    PUT(t, "scan %s\n", scans[table->scan]);
    if (table->from[0] != '\0') {
        PUT(t, "from %s\n", table->from);
    }
    if (table->scan != MEMORY_SHAPE) {
        return;
    }
    PUT(t, "shape %s %" PRId32 " %" PRId32 " %" PRId32 " %" PRId32 "\n",
        setting_shapes[s->kind], s->min_udeg, s->max_udeg, s->center_udeg,
        s->sigma_udeg);
    for (size_t i = 0; i < s->region_count; i++) {
        PUT(t, "region %" PRId32 " %" PRId32 " %" PRIu32 "\n",
            s->regions[i].min_udeg, s->regions[i].max_udeg,
            s->regions[i].weight);
    }
}

size_t memory_write(const struct memory_key *key, const struct memory *memory,
                    char out[MEMORY_TEXT_BYTES])
{
    struct text t = {out, 0};
    PUT(&t, HEAD "\nsensor %s %u\ninterface %s\n",
        number_address(key->address).text, (unsigned)key->port, key->interface);
    if (memory->clock.is_known) {
        PUT(&t, "clock %" PRId64 " %" PRIu32 " %" PRId64 "\n",
            memory->clock.utc_ns, memory->clock.clock_us,
            memory->clock.error_ns);
    }
    if (memory->restart_to_ns != 0) {
        PUT(&t, "restart %" PRId64 " %" PRId64 "\n", memory->restart_from_ns,
            memory->restart_to_ns);
    }
    for (size_t i = 0; i < LUM_COMMANDS; i++) {
        const struct memory_entry *e = &memory->entries[i];
        if (e->standing == MEMORY_NOTHING) {
            continue;
        }
        put_word(&t, setting_name((lum_command_id)i));
        PUT(&t, " %s %u %" PRId64 "\n", memory_standings[e->standing],
            (unsigned)e->value, e->utc_ns);
    }
    if (memory->entries[LUM_COMMAND_YSCAN].standing != MEMORY_NOTHING) {
        put_table(&t, &memory->table);
    }
    PUT(&t, "end\n");
    return t.len;
}

/* A state file that is being read. */
struct reading {
    const char *next;
    unsigned line;
    char text[MEMORY_FROM_BYTES + MEMORY_NAME_BYTES];
    char *rest; /* of the line, after the words that were taken */
    bool has_end;
};

static bool next_line(struct reading *r)
{
    const size_t len = strcspn(r->next, "\n");
    if (r->next[len] != '\n' || len >= sizeof r->text) {
        return false;
    }
    memcpy(r->text, r->next, len);
    r->text[len] = '\0';
    r->next += len + 1;
    r->rest = r->text;
    r->line++;
    return true;
}

/* The next word of the line; empty: there is none. */
static const char *take_word(struct reading *r)
{
    char *word = r->rest;
    const size_t len = strcspn(word, " ");
    r->rest += len;
    if (*r->rest == ' ') {
        *r->rest++ = '\0';
    }
    return word;
}

static bool take_number(struct reading *r, int64_t min, int64_t max,
                        int64_t *out)
{
    return number_parse_int(take_word(r), min, max, out);
}

/* The index of a word among names; count: it is none. */
static size_t take_name(struct reading *r, const char *const *names,
                        size_t count)
{
    const char *word = take_word(r);
    size_t i = 0;
    while (i < count && (names[i] == NULL || strcmp(names[i], word) != 0)) {
        i++;
    }
    return i;
}

static bool read_clock(struct reading *r, struct memory *m)
{
    int64_t clock_us = 0;
    m->clock.is_known =
        take_number(r, 0, INT64_MAX / 4, &m->clock.utc_ns) &&
        take_number(r, 0, UINT32_MAX, &clock_us) &&
        take_number(r, 0, INT64_C(3600000000000) / 4, &m->clock.error_ns);
    m->clock.clock_us = (uint32_t)clock_us;
    return m->clock.is_known;
}

static bool read_restart(struct reading *r, struct memory *m)
{
    return take_number(r, 0, INT64_MAX / 4, &m->restart_from_ns) &&
           take_number(r, 1, INT64_MAX / 4, &m->restart_to_ns);
}

static bool read_scan(struct reading *r, struct memory *m)
{
    const size_t i = take_name(r, scans, MEMORY_SCANS);
    m->table.scan = i < MEMORY_SCANS ? (enum memory_scan)i : MEMORY_DEGREES;
    return i < MEMORY_SCANS;
}

static bool read_from(struct reading *r, struct memory *m)
{
    (void)snprintf(m->table.from, sizeof m->table.from, "%s", r->rest);
    r->rest += strlen(r->rest);
    return true;
}

static bool take_udeg(struct reading *r, int32_t *out)
{
    int64_t udeg = 0;
    const bool good = take_number(r, INT32_MIN, INT32_MAX, &udeg);
    *out = (int32_t)udeg;
    return good;
}

static bool read_shape(struct reading *r, struct memory *m)
{
    lum_yscan_shape *s = &m->table.shape;
    const size_t i = take_name(r, setting_shapes, SETTING_SHAPES);
    s->kind = i < SETTING_SHAPES ? (lum_yscan_kind)i : LUM_YSCAN_UNIFORM;
    return i < SETTING_SHAPES && take_udeg(r, &s->min_udeg) &&
           take_udeg(r, &s->max_udeg) && take_udeg(r, &s->center_udeg) &&
           take_udeg(r, &s->sigma_udeg);
}

static bool read_region(struct reading *r, struct memory *m)
{
    lum_yscan_shape *s = &m->table.shape;
    int64_t weight = 0;
    if (s->region_count == LUM_YSCAN_REGIONS_MAX) {
        return false;
    }
    lum_yscan_region *region = &s->regions[s->region_count++];
    const bool good = take_udeg(r, &region->min_udeg) &&
                      take_udeg(r, &region->max_udeg) &&
                      take_number(r, 1, 1000000, &weight);
    region->weight = (uint32_t)weight;
    return good;
}

static bool read_end(struct reading *r, struct memory *m)
{
    (void)m;
    r->has_end = true;
    return true;
}

static const struct word {
    const char *name;
    bool (*read)(struct reading *r, struct memory *m);
} words[] = {
    {"clock", read_clock}, {"restart", read_restart}, {"scan", read_scan},
    {"from", read_from},   {"shape", read_shape},     {"region", read_region},
    {"end", read_end},
};

static bool is_setting(const char *word, const char *name)
{
    for (; *word != '\0' && *name != '\0'; word++, name++) {
        if (*word != (*name == ' ' ? '-' : *name)) {
            return false;
        }
    }
    return *word == *name;
}

/* Values beyond those of a command are a table's lines. */
static bool read_entry(struct reading *r, struct memory *m, lum_command_id id)
{
    const lum_command_spec *spec = &lum_command_specs[id];
    const int64_t most = id == LUM_COMMAND_YSCAN ? UINT16_MAX : spec->max;
    const int64_t least = id == LUM_COMMAND_YSCAN ? 1 : spec->min;
    struct memory_entry *e = &m->entries[id];
    const size_t standing = take_name(r, memory_standings, MEMORY_STANDINGS);
    int64_t value = 0;
    if (standing == MEMORY_STANDINGS || e->standing != MEMORY_NOTHING ||
        !take_number(r, least, most, &value) ||
        !take_number(r, 0, INT64_MAX / 4, &e->utc_ns)) {
        return false;
    }
    e->standing = (enum memory_standing)standing;
    e->value = (uint16_t)value;
    return true;
}

static bool read_line(struct reading *r, struct memory *m)
{
    const char *word = take_word(r);
    bool good = false;
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (strcmp(word, words[i].name) == 0) {
            good = words[i].read(r, m);
        }
    }
    for (size_t i = 0; i < LUM_COMMANDS; i++) {
        const char *name = setting_name((lum_command_id)i);
        if (name != NULL && is_setting(word, name)) {
            good = read_entry(r, m, (lum_command_id)i);
        }
    }
    return good && *r->rest == '\0';
}

/* The lines that say whose file it is. */
static bool is_for(struct reading *r, const struct memory_key *key)
{
    uint32_t address = 0;
    int64_t port = 0;
    if (!next_line(r) || strcmp(take_word(r), "sensor") != 0 ||
        !number_parse_address(take_word(r), &address) ||
        !take_number(r, 1, UINT16_MAX, &port) || *r->rest != '\0' ||
        !next_line(r) || strcmp(take_word(r), "interface") != 0) {
        return false;
    }
    return address == key->address && (uint16_t)port == key->port &&
           strcmp(r->rest, key->interface) == 0;
}

/* What the parts have to be together. */
static bool is_sound(const struct memory *m)
{
    const struct memory_entry *yscan = &m->entries[LUM_COMMAND_YSCAN];
    const lum_command_spec *spec = &lum_command_specs[LUM_COMMAND_YSCAN];
    const bool has_shape = m->table.scan == MEMORY_SHAPE;
    int32_t udeg[64];
    if (yscan->standing == MEMORY_NOTHING) {
        return m->table.scan == MEMORY_DEGREES;
    }
    if (m->table.scan == MEMORY_DEGREES &&
        (yscan->value < spec->min || yscan->value > spec->max)) {
        return false;
    }
    return !has_shape || lum_yscan_make(&m->table.shape, -90000000, 90000000,
                                        udeg, 64) == LUM_OK;
}

int memory_read(const char *text, const struct memory_key *key,
                struct memory *out, lum_error *error)
{
    struct reading r = {.next = text};
    memset(out, 0, sizeof *out);
    if (!next_line(&r) || strcmp(r.text, HEAD) != 0) {
        return lum_error_set(error, "is not a state file of this lumctl");
    }
    if (!is_for(&r, key)) {
        return lum_error_set(error, "is of another sensor");
    }
    while (!r.has_end) {
        if (!next_line(&r)) {
            return lum_error_set(error, "is cut short after line %u", r.line);
        }
        if (!read_line(&r, out)) {
            return lum_error_set(error, "line %u makes no sense", r.line);
        }
    }
    return *r.next == '\0' && is_sound(out)
               ? 0
               : lum_error_set(error, "its lines contradict each other");
}
