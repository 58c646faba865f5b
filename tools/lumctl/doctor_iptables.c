/* Rules as iptables-save prints them. */
#include "doctor_rules.h"

#include <stdlib.h>
#include <string.h>

#define LINE_BYTES 1024u
#define WORDS_MAX  96u

/* Behind a word, which ends there. Quotes inside quotes are escaped. */
static char *end_word(char *p, bool is_quoted)
{
    const char *ends = is_quoted ? "\"" : " \t\r\n";
    while (*p != '\0' && strchr(ends, *p) == NULL) {
        p += is_quoted && p[0] == '\\' && p[1] != '\0' ? 2 : 1;
    }
    if (*p != '\0') {
        *p = '\0';
        p++;
    }
    return p;
}

/* Splits at blanks, in place; what stands in quotes is one word. */
static size_t split(char *line, char *out[WORDS_MAX])
{
    size_t n = 0;
    char *p = line + strspn(line, " \t\r\n");
    while (n < WORDS_MAX && *p != '\0') {
        const bool is_quoted = *p == '"';
        p += is_quoted ? 1 : 0;
        out[n] = p;
        n++;
        p = end_word(p, is_quoted);
        p += strspn(p, " \t\r\n");
    }
    return n;
}

static enum rule_match match_in(const struct rule_packet *p, const char *v)
{
    return p->is_out ? RULE_NO : rules_match_device(v, p->device, '+');
}

static enum rule_match match_out(const struct rule_packet *p, const char *v)
{
    return p->is_out ? rules_match_device(v, p->device, '+') : RULE_NO;
}

static enum rule_match match_always(const struct rule_packet *p, const char *v)
{
    (void)p;
    (void)v;
    return RULE_YES;
}

/* Options with one value. Others may match or not. */
static const struct {
    const char *name;
    rule_matcher match;
} options[] = {
    {"-s", rules_match_source},
    {"-d", rules_match_destination},
    {"-p", rules_match_protocol},
    {"-i", match_in},
    {"-o", match_out},
    {"--sport", rules_match_source_port},
    {"--sports", rules_match_source_port},
    {"--dport", rules_match_destination_port},
    {"--dports", rules_match_destination_port},
    {"--ctstate", rules_match_state},
    {"--state", rules_match_state},
    {"-m", match_always},
    {"--comment", match_always},
    {"--reject-with", match_always},
    {"--log-prefix", match_always},
    {"--log-level", match_always},
};

#define OPTIONS (sizeof options / sizeof options[0])

static void take_target(struct rule *r, const char *target, bool is_goto)
{
    static const struct {
        const char *name;
        enum rule_verdict verdict;
    } known[] = {
        {"ACCEPT", RULE_ACCEPT}, {"DROP", RULE_DROP}, {"REJECT", RULE_DROP},
        {"RETURN", RULE_RETURN}, {"LOG", RULE_NONE},  {"NFLOG", RULE_NONE},
        {"MARK", RULE_NONE},     {"CT", RULE_NONE},   {"NOTRACK", RULE_NONE},
        {"CONNMARK", RULE_NONE}, {"TRACE", RULE_NONE}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (strcmp(target, known[i].name) == 0) {
            r->verdict = (uint8_t)known[i].verdict;
            return;
        }
    }
    r->verdict = is_goto ? RULE_GOTO : RULE_JUMP;
    (void)snprintf(r->target, sizeof r->target, "%s", target);
}

static enum rule_match match_option(const struct rule_packet *p,
                                    const char *name, const char *value)
{
    for (size_t i = 0; i < OPTIONS; i++) {
        if (strcmp(name, options[i].name) == 0) {
            return options[i].match(p, value);
        }
    }
    return RULE_MAYBE;
}

/* An option and its value, if it has one. Returns how many words. */
static size_t take_option(const struct ruleset *set, struct rule *r,
                          const char *name, const char *value, bool negate)
{
    if (strcmp(name, "-j") == 0 || strcmp(name, "-g") == 0) {
        take_target(r, value, name[1] == 'g');
        return 2;
    }
    const enum rule_match m = match_option(&set->packet, name, value);
    r->match = (uint8_t)rules_and((enum rule_match)r->match,
                                  negate ? rules_not(m) : m);
    return *value == '-' || *value == '!' ? 1 : 2;
}

static void take_words(const struct ruleset *set, struct rule *r, char **words,
                       size_t n)
{
    size_t i = 0;
    bool negate = false;
    while (i < n) {
        const char *value = i + 1u < n ? words[i + 1u] : "";
        if (words[i][0] == '-') {
            i += take_option(set, r, words[i], value, negate);
            negate = false;
        } else {
            negate = strcmp(words[i], "!") == 0;
            i++;
        }
    }
}

static enum rule_hook hook_of(const char *chain)
{
    static const struct {
        const char *name;
        enum rule_hook hook;
    } known[] = {{"INPUT", RULE_IN},
                 {"PREROUTING", RULE_IN},
                 {"OUTPUT", RULE_OUT},
                 {"POSTROUTING", RULE_OUT}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (strcmp(chain, known[i].name) == 0) {
            return known[i].hook;
        }
    }
    return RULE_NO_HOOK;
}

/* ":INPUT DROP [0:0]" */
static void take_chain(struct ruleset *set, const char *table, char **words,
                       size_t n)
{
    struct rule_chain *c = rules_chain(set, "ip", table, words[0] + 1);
    if (c != NULL && n > 1u) {
        c->hook = (uint8_t)hook_of(c->name);
        c->drops = strcmp(words[1], "DROP") == 0;
    }
}

static void take_rule(struct ruleset *set, const char *table, const char *text,
                      char **words, size_t n)
{
    const struct rule_chain *c = rules_chain(set, "ip", table, words[1]);
    struct rule *r = c == NULL ? NULL : rules_add(set, c, text);
    if (r != NULL) {
        take_words(set, r, words + 2, n - 2u);
    }
}

void rules_read_iptables(struct ruleset *set, FILE *in)
{
    char line[LINE_BYTES];
    char text[LINE_BYTES];
    char table[RULE_NAME_BYTES] = "";
    char *words[WORDS_MAX];
    while (fgets(line, sizeof line, in) != NULL) {
        line[strcspn(line, "\r\n")] = '\0';
        (void)snprintf(text, sizeof text, "%s", line);
        const size_t n = split(line, words);
        if (n == 0 || words[0][0] == '#') {
            continue;
        }
        if (words[0][0] == '*') {
            (void)snprintf(table, sizeof table, "%.63s", words[0] + 1);
        } else if (strcmp(table, "nat") == 0) {
            continue; /* rewrites, does not drop */
        } else if (words[0][0] == ':') {
            take_chain(set, table, words, n);
        } else if (n > 2u && strcmp(words[0], "-A") == 0) {
            take_rule(set, table, text, words, n);
        }
    }
}
