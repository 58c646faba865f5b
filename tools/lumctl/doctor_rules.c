#include "doctor_rules.h"

#include "../common/number.h"

#include <stdlib.h>
#include <string.h>

struct ruleset *rules_new(const struct rule_packet *packet, bool is_nft)
{
    struct ruleset *set = calloc(1, sizeof *set);
    if (set != NULL) {
        set->packet = *packet;
        set->is_nft = is_nft;
    }
    return set;
}

struct rule_chain *rules_chain(struct ruleset *set, const char *family,
                               const char *table, const char *name)
{
    for (size_t i = 0; i < set->chain_count; i++) {
        struct rule_chain *c = &set->chains[i];
        if (strcmp(c->name, name) == 0 && strcmp(c->table, table) == 0 &&
            strcmp(c->family, family) == 0) {
            return c;
        }
    }
    if (set->chain_count == RULE_CHAINS_MAX) {
        set->is_cut = true;
        return NULL;
    }
    struct rule_chain *c = &set->chains[set->chain_count];
    set->chain_count++;
    (void)snprintf(c->family, sizeof c->family, "%s", family);
    (void)snprintf(c->table, sizeof c->table, "%s", table);
    (void)snprintf(c->name, sizeof c->name, "%s", name);
    return c;
}

struct rule *rules_add(struct ruleset *set, const struct rule_chain *chain,
                       const char *text)
{
    if (set->rule_count == RULES_MAX) {
        set->is_cut = true;
        return NULL;
    }
    struct rule *r = &set->rules[set->rule_count];
    set->rule_count++;
    r->chain = (uint16_t)(chain - set->chains);
    r->match = RULE_YES;
    (void)snprintf(r->text, sizeof r->text, "%s", text);
    return r;
}

enum rule_match rules_not(enum rule_match match)
{
    return match == RULE_MAYBE ? RULE_MAYBE
           : match == RULE_YES ? RULE_NO
                               : RULE_YES;
}

enum rule_match rules_and(enum rule_match a, enum rule_match b)
{
    return a < b ? a : b;
}

static enum rule_match either(enum rule_match a, enum rule_match b)
{
    return a > b ? a : b;
}

#define VALUE_BYTES 64u

/* The next of several values at commas; false at the end. */
static bool next_value(const char **list, char out[VALUE_BYTES])
{
    const char *p = *list + strspn(*list, ", ");
    const size_t n = strcspn(p, ", ");
    *list = p + n;
    if (n == 0) {
        return false;
    }
    (void)snprintf(out, VALUE_BYTES, "%.*s", (int)(n < 63u ? n : 63u), p);
    return true;
}

static enum rule_match match_range(const char *first, const char *last,
                                   uint32_t address)
{
    uint32_t low = 0;
    uint32_t high = 0;
    if (!number_parse_address(first, &low) ||
        !number_parse_address(last, &high)) {
        return RULE_MAYBE;
    }
    return address >= low && address <= high ? RULE_YES : RULE_NO;
}

/* BITS, or a mask written as an address. */
static bool parse_mask(const char *text, uint32_t *out)
{
    int64_t bits = 0;
    if (!number_parse_int(text, 0, 32, &bits)) {
        return number_parse_address(text, out);
    }
    *out = bits == 0 ? 0 : UINT32_MAX << (32 - bits);
    return true;
}

/* ADDRESS, ADDRESS/BITS or /MASK, ADDRESS-ADDRESS. */
static enum rule_match match_one_address(char *value, uint32_t address)
{
    char *mark = value + strcspn(value, "-/");
    const char kind = *mark;
    uint32_t base = 0;
    uint32_t mask = UINT32_MAX;
    *mark = '\0';
    if (kind == '-') {
        return match_range(value, mark + 1, address);
    }
    if ((kind == '/' && !parse_mask(mark + 1, &mask)) ||
        !number_parse_address(value, &base)) {
        return RULE_MAYBE;
    }
    return (address & mask) == (base & mask) ? RULE_YES : RULE_NO;
}

static enum rule_match match_address(const char *value, uint32_t address)
{
    char one[VALUE_BYTES];
    enum rule_match match = RULE_NO;
    while (next_value(&value, one)) {
        match = either(match, match_one_address(one, address));
    }
    return match;
}

/* PORT, PORT-PORT, PORT:PORT. Any port lies in a range of all of them. */
static enum rule_match match_one_port(char *value, uint16_t port)
{
    char *dash = value + strcspn(value, "-:");
    int64_t low = 0;
    int64_t high = 65535;
    if (*dash != '\0') {
        *dash = '\0';
        if ((dash > value && !number_parse_int(value, 0, 65535, &low)) ||
            (dash[1] != '\0' && !number_parse_int(dash + 1, 0, 65535, &high))) {
            return RULE_MAYBE;
        }
    } else if (number_parse_int(value, 0, 65535, &low)) {
        high = low;
    } else {
        return RULE_MAYBE;
    }
    if (port == 0) {
        return low <= 1024 && high == 65535 ? RULE_YES : RULE_MAYBE;
    }
    return port >= low && port <= high ? RULE_YES : RULE_NO;
}

static enum rule_match match_port(const char *value, uint16_t port)
{
    char one[VALUE_BYTES];
    enum rule_match match = RULE_NO;
    while (next_value(&value, one)) {
        match = either(match, match_one_port(one, port));
    }
    return match;
}

enum rule_match rules_match_source(const struct rule_packet *packet,
                                   const char *value)
{
    return match_address(value, packet->source);
}

enum rule_match rules_match_destination(const struct rule_packet *packet,
                                        const char *value)
{
    return match_address(value, packet->destination);
}

enum rule_match rules_match_source_port(const struct rule_packet *packet,
                                        const char *value)
{
    return match_port(value, packet->source_port);
}

enum rule_match rules_match_destination_port(const struct rule_packet *packet,
                                             const char *value)
{
    return match_port(value, packet->destination_port);
}

static enum rule_match match_one_device(const char *value, const char *device,
                                        char wildcard)
{
    const size_t n = strlen(value);
    if (*device == '\0' || *value == '@') {
        return RULE_MAYBE;
    }
    if (n > 0 && value[n - 1u] == wildcard) {
        return strncmp(value, device, n - 1u) == 0 ? RULE_YES : RULE_NO;
    }
    return strcmp(value, device) == 0 ? RULE_YES : RULE_NO;
}

enum rule_match rules_match_device(const char *value, const char *device,
                                   char wildcard)
{
    char one[VALUE_BYTES];
    enum rule_match match = RULE_NO;
    while (next_value(&value, one)) {
        match = either(match, match_one_device(one, device, wildcard));
    }
    return match;
}

static enum rule_match match_word(const char *value, const char *const *words)
{
    char one[VALUE_BYTES];
    enum rule_match match = RULE_NO;
    while (next_value(&value, one)) {
        match = either(match, *one == '@' ? RULE_MAYBE : RULE_NO);
        for (size_t i = 0; words[i] != NULL; i++) {
            match =
                either(match, strcmp(one, words[i]) == 0 ? RULE_YES : RULE_NO);
        }
    }
    return match;
}

enum rule_match rules_match_protocol(const struct rule_packet *packet,
                                     const char *value)
{
    (void)packet;
    static const char *const words[] = {"udp", "17", "all", "0", NULL};
    return match_word(value, words);
}

enum rule_match rules_match_state(const struct rule_packet *packet,
                                  const char *value)
{
    static const char *const out[] = {"new", "NEW", NULL};
    static const char *const in[] = {"established", "ESTABLISHED", NULL};
    return match_word(value, packet->is_out ? out : in);
}

/* The kernel takes no rules that jump in circles; a text might hold some. */
#define JUMPS_MAX 5000u

/* A walk of one packet along the chains. */
struct walk {
    const struct ruleset *set;
    const struct rule *drops;    /* for certain */
    const struct rule *may_drop; /* the first of them */
    bool may_accept;             /* a rule before may have let it through */
    unsigned jumps;              /* taken so far */
};

enum step {
    STEP_ON,
    STEP_ACCEPT,
    STEP_DROP
};

static enum step walk_chain(struct walk *w, size_t chain, bool is_sure,
                            unsigned depth);

static bool find_target(const struct ruleset *set, const struct rule *rule,
                        size_t *out)
{
    const struct rule_chain *from = &set->chains[rule->chain];
    for (size_t i = 0; i < set->chain_count; i++) {
        const struct rule_chain *c = &set->chains[i];
        if (strcmp(c->name, rule->target) == 0 &&
            strcmp(c->table, from->table) == 0 &&
            strcmp(c->family, from->family) == 0) {
            *out = i;
            return true;
        }
    }
    return false;
}

static enum step walk_jump(struct walk *w, const struct rule *rule,
                           bool is_sure, unsigned depth)
{
    size_t target = 0;
    w->jumps++;
    if (depth == RULE_DEPTH_MAX || w->jumps > JUMPS_MAX ||
        !find_target(w->set, rule, &target)) {
        w->may_accept = true;
        return STEP_ON;
    }
    return walk_chain(w, target, is_sure, depth + 1u);
}

static enum step take_drop(struct walk *w, const struct rule *rule,
                           bool is_sure)
{
    if (is_sure && !w->may_accept) {
        w->drops = rule;
        return STEP_DROP;
    }
    if (w->may_drop == NULL) {
        w->may_drop = rule;
    }
    return is_sure ? STEP_DROP : STEP_ON;
}

static enum step take_accept(struct walk *w, bool is_sure)
{
    w->may_accept = w->may_accept || !is_sure;
    return is_sure ? STEP_ACCEPT : STEP_ON;
}

static enum step take_rule(struct walk *w, const struct rule *rule,
                           bool is_sure, unsigned depth)
{
    switch ((enum rule_verdict)rule->verdict) {
    case RULE_ACCEPT:
        return take_accept(w, is_sure);
    case RULE_DROP:
        return take_drop(w, rule, is_sure);
    case RULE_JUMP:
    case RULE_GOTO:
        return walk_jump(w, rule, is_sure, depth);
    default:
        return STEP_ON;
    }
}

static bool leaves_chain(const struct rule *rule)
{
    return rule->verdict == RULE_RETURN || rule->verdict == RULE_GOTO;
}

static enum step walk_chain(struct walk *w, size_t chain, bool is_sure,
                            unsigned depth)
{
    for (size_t i = 0; i < w->set->rule_count; i++) {
        const struct rule *r = &w->set->rules[i];
        if (r->chain != chain || r->match == RULE_NO) {
            continue;
        }
        const bool sure = is_sure && r->match == RULE_YES;
        const enum step step = take_rule(w, r, sure, depth);
        if (step != STEP_ON) {
            return step;
        }
        if (leaves_chain(r)) {
            if (r->match == RULE_YES) {
                return STEP_ON;
            }
            is_sure = false;
        }
    }
    return STEP_ON;
}

static void judge_base(const struct ruleset *set, size_t chain,
                       struct rule_finding *out)
{
    struct walk w = {set, NULL, NULL, false, 0};
    const struct rule_chain *base = &set->chains[chain];
    const enum step step = walk_chain(&w, chain, true, 0);
    const bool by_policy = step == STEP_ON && base->drops;
    enum rule_fate fate = RULE_PASSES;
    if (w.drops != NULL || (by_policy && !w.may_accept)) {
        fate = RULE_IS_DROPPED;
    } else if (w.may_drop != NULL || by_policy) {
        fate = RULE_MAY_BE_DROPPED;
    }
    if (fate > out->fate) {
        *out = (struct rule_finding){fate, base,
                                     w.drops != NULL ? w.drops
                                     : by_policy     ? NULL
                                                     : w.may_drop};
    }
}

void rules_judge(const struct ruleset *set, struct rule_finding *out)
{
    const enum rule_hook hook = set->packet.is_out ? RULE_OUT : RULE_IN;
    *out = (struct rule_finding){RULE_PASSES, NULL, NULL};
    for (size_t i = 0; i < set->chain_count; i++) {
        if (set->chains[i].hook == hook) {
            judge_base(set, i, out);
        }
    }
}
