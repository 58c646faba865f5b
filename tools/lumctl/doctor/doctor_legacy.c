#include "doctor_legacy.h"

#include <stdlib.h>
#include <string.h>

#define LINE_BYTES 1024u

/* Up to a blank; returns what follows. */
static const char *take_word(const char *p, char out[LEGACY_NAME_BYTES])
{
    const size_t len = strcspn(p, " \n");
    (void)snprintf(out, LEGACY_NAME_BYTES, "%.*s", (int)len, p);
    return p + len + strspn(p + len, " ");
}

static void add(struct legacy_rules *out, const struct legacy_rule *rule)
{
    if (out->count < LEGACY_MAX) {
        out->all[out->count] = *rule;
        out->count++;
    }
}

/* ":INPUT DROP [12:340]" */
static void read_policy(const char *line, struct legacy_rule *rule,
                        struct legacy_rules *out)
{
    char policy[LEGACY_NAME_BYTES];
    const char *p = take_word(line + 1, rule->chain);
    p = take_word(p, policy);
    if (strcmp(policy, "DROP") == 0 && *p == '[') {
        rule->packets = strtoull(p + 1, NULL, 10);
        rule->text[0] = '\0';
        add(out, rule);
    }
}

/* "[3:144] -A INPUT -s 10.42.0.37/32 -j DROP" */
static void read_rule(const char *line, struct legacy_rule *rule,
                      struct legacy_rules *out)
{
    const char *p = strstr(line, "] -A ");
    if (p == NULL ||
        (strstr(p, " -j DROP") == NULL && strstr(p, " -j REJECT") == NULL)) {
        return;
    }
    rule->packets = strtoull(line + 1, NULL, 10);
    (void)take_word(p + strlen("] -A "), rule->chain);
    p += strlen("] ");
    (void)snprintf(rule->text, sizeof rule->text, "%.*s", (int)strcspn(p, "\n"),
                   p);
    add(out, rule);
}

void legacy_read(FILE *in, struct legacy_rules *out)
{
    struct legacy_rule rule = {0, "", "", ""};
    char line[LINE_BYTES];
    out->count = 0;
    while (fgets(line, sizeof line, in) != NULL) {
        if (line[0] == '*') {
            (void)take_word(line + 1, rule.table);
        } else if (line[0] == ':') {
            read_policy(line, &rule, out);
        } else if (line[0] == '[') {
            read_rule(line, &rule, out);
        }
    }
}

static const struct legacy_rule *find(const struct legacy_rules *in,
                                      const struct legacy_rule *like)
{
    for (size_t i = 0; i < in->count; i++) {
        if (strcmp(in->all[i].table, like->table) == 0 &&
            strcmp(in->all[i].chain, like->chain) == 0 &&
            strcmp(in->all[i].text, like->text) == 0) {
            return &in->all[i];
        }
    }
    return NULL;
}

const struct legacy_rule *legacy_grown(const struct legacy_rules *before,
                                       const struct legacy_rules *after,
                                       uint64_t packets)
{
    const struct legacy_rule *best = NULL;
    uint64_t least = UINT64_MAX;
    for (size_t i = 0; i < after->count; i++) {
        const struct legacy_rule *rule = &after->all[i];
        const struct legacy_rule *was = find(before, rule);
        const uint64_t grown = was != NULL && rule->packets > was->packets
                                   ? rule->packets - was->packets
                                   : 0;
        if (grown >= packets && grown < least) {
            best = rule;
            least = grown;
        }
    }
    return best;
}
