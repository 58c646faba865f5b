#include "verdict.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

void verdict_asked(struct verdict *verdict, const char *rule)
{
    unsigned i = 0;
    while (i < verdict->rule_count &&
           strcmp(verdict->rules[i].rule, rule) != 0) {
        i++;
    }
    if (i == VERDICT_RULES) {
        verdict->is_full = true;
        return;
    }
    if (i == verdict->rule_count) {
        verdict->rules[verdict->rule_count++].rule = rule;
    }
    verdict->rules[i].asked++;
}

void verdict_broken(struct verdict *verdict, const char *rule, int64_t t_ns,
                    const char *format, ...)
{
    va_list arguments;
    if (verdict->count == VERDICT_FINDINGS) {
        verdict->more++;
        return;
    }
    verdict_finding *f = &verdict->findings[verdict->count++];
    f->rule = rule;
    f->t_ns = t_ns;
    va_start(arguments, format);
    (void)vsnprintf(f->text, sizeof f->text, format, arguments);
    va_end(arguments);
}

void verdict_leave(struct verdict *verdict, const char *rule)
{
    if (verdict->left_count == VERDICT_LEFT) {
        verdict->is_full = true;
        return;
    }
    verdict->left[verdict->left_count++] = rule;
}

bool verdict_is_left(const struct verdict *verdict, const char *rule)
{
    for (unsigned i = 0; i < verdict->left_count; i++) {
        if (strcmp(verdict->left[i], rule) == 0) {
            return true;
        }
    }
    return false;
}

bool verdict_has(const struct verdict *verdict, const char *rule)
{
    for (unsigned i = 0; i < verdict->count; i++) {
        if (strcmp(verdict->findings[i].rule, rule) == 0) {
            return true;
        }
    }
    return false;
}
