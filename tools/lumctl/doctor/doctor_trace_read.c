#include "doctor_trace.h"

#include <stdio.h>
#include <string.h>

#define LINE_WORDS "trace id "

/* The next word, cut to what fits. */
static const char *take_word(const char *p, char *out, size_t room)
{
    const size_t len = strcspn(p, " \n");
    (void)snprintf(out, room, "%.*s", (int)len, p);
    p += len;
    return p + strspn(p, " ");
}

static struct trace_way *find(struct trace_reader *reader, const char *id)
{
    for (size_t i = 0; i < reader->count; i++) {
        if (strcmp(reader->ways[i].id, id) == 0) {
            return &reader->ways[i];
        }
    }
    if (reader->count == TRACE_IDS_MAX) {
        return NULL;
    }
    struct trace_way *way = &reader->ways[reader->count];
    reader->count++;
    *way = (struct trace_way){.is_out = false};
    (void)snprintf(way->id, sizeof way->id, "%s", id);
    return way;
}

/* The last one in a line, because the text of a rule may contain the same
 * words. */
static const char *find_verdict(const char *rest)
{
    const char *found = NULL;
    for (const char *p = strstr(rest, "(verdict "); p != NULL;
         p = strstr(p + 1, "(verdict ")) {
        found = p;
    }
    return found;
}

static bool begins(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

/* "rule TEXT (verdict drop)" or "policy drop". */
static void take_end(struct trace_way *way, const char *kind, const char *rest)
{
    const bool is_rule = strcmp(kind, "rule") == 0;
    const char *verdict = is_rule ? find_verdict(rest) : NULL;
    way->is_dropped = is_rule
                          ? verdict != NULL && begins(verdict, "(verdict drop)")
                          : strcmp(kind, "policy") == 0 && begins(rest, "drop");
    way->rule[0] = '\0';
    if (way->is_dropped && is_rule) {
        size_t len = (size_t)(verdict - rest);
        while (len > 0 && rest[len - 1u] == ' ') {
            len--;
        }
        (void)snprintf(way->rule, sizeof way->rule, "%.*s", (int)len, rest);
    }
}

/* Another table, or the same one from another hook, whose chain is then the
 * first after a new "packet:" line. */
static void take_place(struct trace_way *way, const char *family,
                       const char *table, const char *chain, const char *kind)
{
    if (strcmp(kind, "packet:") == 0 || strcmp(way->table, table) != 0 ||
        strcmp(way->family, family) != 0) {
        (void)snprintf(way->base, sizeof way->base, "%s", chain);
    }
    (void)snprintf(way->family, sizeof way->family, "%s", family);
    (void)snprintf(way->table, sizeof way->table, "%s", table);
    (void)snprintf(way->chain, sizeof way->chain, "%s", chain);
    way->has_ufw = way->has_ufw || strncmp(chain, "ufw", strlen("ufw")) == 0;
}

void trace_read(struct trace_reader *reader, const char *line)
{
    char id[16];
    char family[16];
    char table[TRACE_NAME_BYTES];
    char chain[TRACE_NAME_BYTES];
    char kind[16];
    if (strncmp(line, LINE_WORDS, strlen(LINE_WORDS)) != 0) {
        return;
    }
    const char *p = take_word(line + strlen(LINE_WORDS), id, sizeof id);
    p = take_word(p, family, sizeof family);
    p = take_word(p, table, sizeof table);
    p = take_word(p, chain, sizeof chain);
    p = take_word(p, kind, sizeof kind);
    struct trace_way *way = find(reader, id);
    if (way == NULL) {
        return;
    }
    if (strcmp(table, reader->table) == 0) {
        way->is_out = strcmp(chain, "leaves") == 0;
        return;
    }
    if (!way->is_dropped) {
        take_place(way, family, table, chain, kind);
        take_end(way, kind, p);
    }
}

const struct trace_way *trace_dropped(const struct trace_reader *reader)
{
    const struct trace_way *found = NULL;
    for (size_t i = 0; i < reader->count; i++) {
        const struct trace_way *way = &reader->ways[i];
        if (way->is_dropped &&
            (found == NULL || (found->is_out && !way->is_out))) {
            found = way;
        }
    }
    return found;
}

bool trace_saw(const struct trace_reader *reader, bool is_out)
{
    for (size_t i = 0; i < reader->count; i++) {
        if (reader->ways[i].is_out == is_out) {
            return true;
        }
    }
    return false;
}
