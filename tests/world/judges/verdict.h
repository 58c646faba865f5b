/* What judges find. */
#ifndef WORLD_VERDICT_H
#define WORLD_VERDICT_H

#include "record.h"

#define VERDICT_FINDINGS 32
#define VERDICT_RULES    80
#define VERDICT_LEFT     16

typedef struct verdict_finding {
    const char *rule;
    int64_t t_ns;
    char text[240];
} verdict_finding;

struct verdict {
    unsigned count; /* of those that are held; more are only counted */
    unsigned more;
    verdict_finding findings[VERDICT_FINDINGS];
    const char *left[VERDICT_LEFT]; /* rules that are to be broken */
    unsigned left_count;
    bool is_full; /* of rules */
    unsigned rule_count;
    struct {
        const char *rule;
        uint64_t asked; /* how often it had something to say */
    } rules[VERDICT_RULES];
};

/* A rule found a case that it speaks of. rule: a constant. */
void verdict_asked(struct verdict *verdict, const char *rule);
__attribute__((format(printf, 4, 5))) void verdict_broken(
    struct verdict *verdict, const char *rule, int64_t t_ns, const char *format,
    ...);
/* The rule may be broken, and is to be. */
void verdict_leave(struct verdict *verdict, const char *rule);
bool verdict_is_left(const struct verdict *verdict, const char *rule);
bool verdict_has(const struct verdict *verdict, const char *rule);

#endif
