#include "lum/host/command_text.h"

#include <stdbool.h>

/* Digits at the beginning of a text. A value above 16 bits saturates; no
 * command allows that value. */
static size_t read_digits(const char *text, size_t len, uint32_t *value)
{
    size_t n = 0;
    uint32_t v = 0;
    while (n < len && text[n] >= '0' && text[n] <= '9') {
        v = v * 10u + (uint32_t)(text[n] - '0');
        v = v > 0xffffu ? 0xffffu : v;
        n++;
    }
    *value = v;
    return n;
}

static const lum_command_spec *find_spec(char letter, bool has_value)
{
    for (unsigned i = 0; i < LUM_COMMANDS; i++) {
        const lum_command_spec *spec = &lum_command_specs[i];
        if (spec->letter == letter && spec->has_value == has_value) {
            return spec;
        }
    }
    return NULL;
}

/* Skips one space between commands. After a space at the end or a second one,
 * *used does not point to a command, and the next parse refuses it. */
static bool is_separated(const char *text, size_t len, size_t *used)
{
    if (*used == len) {
        return true;
    }
    if (text[*used] != ' ' || *used + 1 == len) {
        return false;
    }
    (*used)++;
    return true;
}

/* What can be written may be read. */
static bool is_allowed(const lum_command *command)
{
    char text[LUM_COMMAND_TEXT_BYTES];
    size_t len = 0;
    return lum_command_format(command, text, &len) == LUM_OK;
}

lum_result lum_command_parse(const char **text, size_t *len, lum_command *out)
{
    const char *t = *text;
    uint32_t value = 0;
    if (*len == 0) {
        return LUM_END;
    }
    const size_t digits = read_digits(t, *len, &value);
    if (digits == *len || (digits > 1 && t[0] == '0')) {
        return LUM_E_MALFORMED;
    }
    const lum_command_spec *spec = find_spec(t[digits], digits > 0);
    size_t used = digits + 1;
    if (spec == NULL || !is_separated(t, *len, &used)) {
        return LUM_E_MALFORMED;
    }
    const lum_command command = {(lum_command_id)(spec - lum_command_specs),
                                 (uint16_t)value};
    if (!is_allowed(&command)) {
        return LUM_E_VALUE;
    }
    *out = command;
    *text = t + used;
    *len -= used;
    return LUM_OK;
}
