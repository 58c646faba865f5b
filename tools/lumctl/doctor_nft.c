/* Rules as `nft list ruleset` prints them, one on a line. */
#include "doctor_rules.h"

#include <stdlib.h>
#include <string.h>

#define LINE_BYTES 4096u
#define WORDS_MAX  128u
#define BLANKS     " \t\r\n"

/* A set in braces is one word, without its blanks and quotes. */
static char *read_set(char *p)
{
    char *to = p;
    for (; *p != '\0' && *p != '}'; p++) {
        if (strchr(BLANKS "\"", *p) == NULL) {
            *to = *p;
            to++;
        }
    }
    char *end = *p == '}' ? p + 1 : p;
    *to = '\0';
    return end;
}

static char *read_until(char *p, const char *ends)
{
    p += strcspn(p, ends);
    if (*p != '\0') {
        *p = '\0';
        p++;
    }
    return p;
}

/* In place. */
static size_t split(char *line, char *out[WORDS_MAX])
{
    size_t n = 0;
    char *p = line;
    while (n < WORDS_MAX) {
        p += strspn(p, BLANKS ";");
        if (*p == '\0') {
            break;
        }
        const char first = *p;
        p += first == '"' || first == '{' ? 1 : 0;
        out[n] = p;
        n++;
        p = first == '{'   ? read_set(p)
            : first == '"' ? read_until(p, "\"")
                           : read_until(p, BLANKS ";");
    }
    return n;
}

static enum rule_match match_family(const struct rule_packet *p, const char *v)
{
    (void)p;
    return strcmp(v, "ipv4") == 0 ? RULE_YES : RULE_NO;
}

static enum rule_match match_kind(const struct rule_packet *p, const char *v)
{
    (void)p;
    return strstr(v, "unicast") != NULL || strstr(v, "host") != NULL ? RULE_YES
                                                                     : RULE_NO;
}

static enum rule_match match_in(const struct rule_packet *p, const char *v)
{
    return p->is_out ? RULE_NO : rules_match_device(v, p->device, '*');
}

static enum rule_match match_out(const struct rule_packet *p, const char *v)
{
    return p->is_out ? rules_match_device(v, p->device, '*') : RULE_NO;
}

static enum rule_match match_never(const struct rule_packet *p, const char *v)
{
    (void)p;
    (void)v;
    return RULE_NO;
}

/* What is compared: one word, or two (second NULL: any, "": none follows). */
static const struct selector {
    const char *first;
    const char *second;
    rule_matcher match;
} selectors[] = {
    {"ip", "saddr", rules_match_source},
    {"ip", "daddr", rules_match_destination},
    {"ip", "protocol", rules_match_protocol},
    {"udp", "sport", rules_match_source_port},
    {"udp", "dport", rules_match_destination_port},
    {"th", "sport", rules_match_source_port},
    {"th", "dport", rules_match_destination_port},
    {"meta", "l4proto", rules_match_protocol},
    {"meta", "nfproto", match_family},
    {"meta", "pkttype", match_kind},
    {"meta", "iifname", match_in},
    {"meta", "oifname", match_out},
    {"pkttype", "", match_kind},
    {"iif", "", match_in},
    {"iifname", "", match_in},
    {"oif", "", match_out},
    {"oifname", "", match_out},
    {"ct", "state", rules_match_state},
    {"tcp", NULL, match_never},
    {"sctp", NULL, match_never},
    {"icmp", NULL, match_never},
    {"icmpv6", NULL, match_never},
    {"igmp", NULL, match_never},
    {"esp", NULL, match_never},
    {"ah", NULL, match_never},
    {"ip6", NULL, match_never},
    {"arp", NULL, match_never},
};

#define SELECTORS (sizeof selectors / sizeof selectors[0])

/* Words of a rule, and where its reading stands. */
struct reader {
    const struct ruleset *set;
    struct rule *rule;
    char **words;
    size_t count;
    size_t at;
};

static const char *word(const struct reader *r, size_t ahead)
{
    return r->at + ahead < r->count ? r->words[r->at + ahead] : "";
}

static void narrow(struct rule *rule, enum rule_match match)
{
    rule->match = (uint8_t)rules_and((enum rule_match)rule->match, match);
}

static const struct selector *find_selector(const struct reader *r)
{
    for (size_t i = 0; i < SELECTORS; i++) {
        const struct selector *s = &selectors[i];
        if (strcmp(s->first, word(r, 0)) == 0 &&
            (s->second == NULL || *s->second == '\0' ||
             strcmp(s->second, word(r, 1)) == 0)) {
            return s;
        }
    }
    return NULL;
}

static bool set_verdict(struct rule *rule, const char *name, const char *target)
{
    static const struct {
        const char *name;
        enum rule_verdict verdict;
    } known[] = {{"accept", RULE_ACCEPT}, {"drop", RULE_DROP},
                 {"reject", RULE_DROP},   {"jump", RULE_JUMP},
                 {"goto", RULE_GOTO},     {"return", RULE_RETURN},
                 {"continue", RULE_NONE}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (strcmp(name, known[i].name) == 0) {
            rule->verdict = (uint8_t)known[i].verdict;
            (void)snprintf(rule->target, sizeof rule->target, "%.63s", target);
            return true;
        }
    }
    return false;
}

/* "accept", or "jumpNAME" as a set without blanks has it. */
static void set_mapped_verdict(struct rule *rule, const char *text)
{
    const bool jumps =
        strncmp(text, "jump", 4) == 0 || strncmp(text, "goto", 4) == 0;
    char name[16];
    (void)snprintf(name, sizeof name, "%.*s", jumps ? 4 : 15, text);
    if (!set_verdict(rule, name, jumps ? text + 4 : "")) {
        narrow(rule, RULE_MAYBE);
        rule->verdict = RULE_ACCEPT;
    }
}

/* KEY:VERDICT,KEY:VERDICT; the one whose key matches holds. */
static void take_map(struct reader *r, rule_matcher match, char *map)
{
    enum rule_match best = RULE_NO;
    char *p = map;
    while (*p != '\0' && best != RULE_YES) {
        char *end = p + strcspn(p, ",");
        char *next = *end == '\0' ? end : end + 1;
        *end = '\0';
        char *colon = strchr(p, ':');
        if (colon == NULL) {
            best = RULE_MAYBE;
            break;
        }
        *colon = '\0';
        const enum rule_match m = match(&r->set->packet, p);
        best = m > best ? m : best;
        if (m == RULE_YES) {
            set_mapped_verdict(r->rule, colon + 1);
        }
        p = next;
    }
    if (best == RULE_MAYBE) {
        r->rule->verdict = RULE_ACCEPT; /* perhaps; it weakens what follows */
    }
    narrow(r->rule, best);
}

static void take_selector(struct reader *r, const struct selector *s)
{
    bool negate = false;
    r->at += s->second != NULL && *s->second == '\0' ? 1u : 2u;
    if (strcmp(word(r, 0), "!=") == 0 || strcmp(word(r, 0), "!") == 0) {
        negate = true;
        r->at++;
    } else if (strcmp(word(r, 0), "==") == 0) {
        r->at++;
    } else if (strcmp(word(r, 0), "vmap") == 0 && r->at + 1u < r->count) {
        take_map(r, s->match, r->words[r->at + 1u]);
        r->at += 2u;
        return;
    }
    const enum rule_match m = s->match == match_never
                                  ? RULE_NO
                                  : s->match(&r->set->packet, word(r, 0));
    narrow(r->rule, negate && s->match != match_never ? rules_not(m) : m);
    r->at++;
}

/* Statements that neither match nor decide, with their words. */
static bool skip_statement(struct reader *r)
{
    static const struct {
        const char *first;
        size_t words;
    } known[] = {{"comment", 2}, {"log", 1},   {"prefix", 2}, {"level", 2},
                 {"flags", 2},   {"group", 2}, {"notrack", 1}};
    if (strcmp(word(r, 0), "counter") == 0) {
        r->at += strcmp(word(r, 1), "packets") == 0 ? 5u
                 : strcmp(word(r, 1), "name") == 0  ? 3u
                                                    : 1u;
        return true;
    }
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (strcmp(word(r, 0), known[i].first) == 0) {
            r->at += known[i].words;
            return true;
        }
    }
    return false;
}

/* It may match or not; where it decides by itself, it may let the packet pass.
 */
static void take_unknown(struct reader *r)
{
    if (strcmp(word(r, 0), "vmap") == 0 || strcmp(word(r, 0), "queue") == 0) {
        r->rule->verdict = RULE_ACCEPT;
    }
    narrow(r->rule, RULE_MAYBE);
    r->at++;
}

static void take_rule(const struct ruleset *set, struct rule *rule,
                      char **words, size_t count)
{
    struct reader r = {set, rule, words, count, 0};
    while (r.at < r.count && rule->match != RULE_NO) {
        const struct selector *s = find_selector(&r);
        if (s != NULL) {
            take_selector(&r, s);
        } else if (set_verdict(rule, word(&r, 0), word(&r, 1))) {
            return;
        } else if (!skip_statement(&r)) {
            take_unknown(&r);
        }
    }
}

static enum rule_hook hook_of(const char *name)
{
    static const struct {
        const char *name;
        enum rule_hook hook;
    } known[] = {{"ingress", RULE_IN}, {"prerouting", RULE_IN},
                 {"input", RULE_IN},   {"output", RULE_OUT},
                 {"egress", RULE_OUT}, {"postrouting", RULE_OUT}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (strcmp(name, known[i].name) == 0) {
            return known[i].hook;
        }
    }
    return RULE_NO_HOOK;
}

/* type T hook H [device D] priority P; policy V; */
static void take_hook(const struct ruleset *set, struct rule_chain *chain,
                      char **words, size_t n)
{
    const bool is_nat = n > 1u && strcmp(words[1], "nat") == 0;
    for (size_t i = 2; i + 1u < n && !is_nat; i++) {
        const char *value = words[i + 1u];
        if (strcmp(words[i], "hook") == 0) {
            chain->hook = (uint8_t)hook_of(value);
        } else if (strcmp(words[i], "policy") == 0) {
            chain->drops = strcmp(value, "drop") == 0;
        } else if (strcmp(words[i], "device") == 0 &&
                   rules_match_device(value, set->packet.device, '*') ==
                       RULE_NO) {
            chain->hook = RULE_NO_HOOK;
        }
    }
}

/* Where the reading stands among braces. */
struct place {
    char family[16];
    char table[RULE_NAME_BYTES];
    struct rule_chain *chain; /* NULL: in none */
    unsigned depth;
};

static bool is_of_ip(const char *family)
{
    return strcmp(family, "ip") == 0 || strcmp(family, "inet") == 0 ||
           strcmp(family, "netdev") == 0;
}

static void open_block(struct ruleset *set, struct place *at, char **words,
                       size_t n)
{
    if (at->depth == 0 && n > 2u && strcmp(words[0], "table") == 0) {
        (void)snprintf(at->family, sizeof at->family, "%.15s", words[1]);
        (void)snprintf(at->table, sizeof at->table, "%.63s", words[2]);
    } else if (at->depth == 1 && n > 1u && strcmp(words[0], "chain") == 0 &&
               is_of_ip(at->family)) {
        at->chain = rules_chain(set, at->family, at->table, words[1]);
    }
    at->depth++;
}

static void take_line(struct ruleset *set, struct place *at, char *line,
                      const char *text)
{
    char *words[WORDS_MAX];
    const size_t len = strlen(text);
    const size_t n = split(line, words);
    if (n == 0 || words[0][0] == '#') {
        return;
    }
    if (text[len - 1u] == '{') {
        open_block(set, at, words, n);
    } else if (strcmp(words[0], "}") == 0) {
        at->depth -= at->depth > 0 ? 1u : 0u;
        at->chain = at->depth < 2u ? NULL : at->chain;
    } else if (at->chain != NULL && strcmp(words[0], "type") == 0) {
        take_hook(set, at->chain, words, n);
    } else if (at->chain != NULL && at->depth == 2u) {
        struct rule *rule = rules_add(set, at->chain, text);
        if (rule != NULL) {
            take_rule(set, rule, words, n);
        }
    }
}

void rules_read_nft(struct ruleset *set, FILE *in)
{
    char line[LINE_BYTES];
    char text[LINE_BYTES];
    struct place at = {"", "", NULL, 0};
    while (fgets(line, sizeof line, in) != NULL) {
        size_t len = strlen(line);
        while (len > 0 && strchr(BLANKS, line[len - 1u]) != NULL) {
            len--;
        }
        line[len] = '\0';
        (void)snprintf(text, sizeof text, "%s", line + strspn(line, BLANKS));
        if (*text != '\0') {
            take_line(set, &at, line, text);
        }
    }
}
