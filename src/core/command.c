#include "lum/command.h"

const lum_command_spec lum_command_specs[LUM_COMMANDS] = {
    [LUM_COMMAND_LASER_ON] = {'u', false, 0, 0, 1},
    [LUM_COMMAND_LASER_OFF] = {'d', false, 0, 0, 1},
    [LUM_COMMAND_POWER] = {'p', true, 0, 100, 1},
    [LUM_COMMAND_THRESHOLD_GREEN] = {'g', true, 0, 100, 1},
    [LUM_COMMAND_THRESHOLD_BLUE] = {'b', true, 0, 100, 1},
    [LUM_COMMAND_LINE_MODE] = {'f', true, 0, 1, 1},
    [LUM_COMMAND_YSCAN] = {'y', true, 11, 30, 1},
    [LUM_COMMAND_HOLDOFF] = {'h', true, 150, 250, 10},
    [LUM_COMMAND_OFFSET_GREEN] = {'G', true, 0, 30, 1},
    [LUM_COMMAND_OFFSET_BLUE] = {'B', true, 0, 30, 1},
};

static bool is_allowed(const lum_command_spec *spec, uint32_t value)
{
    return value >= spec->min && value <= spec->max &&
           (value - spec->min) % spec->step == 0;
}

static size_t put_decimal(char *out, uint16_t value)
{
    char reversed[5];
    size_t n = 0;
    do {
        reversed[n] = (char)('0' + value % 10u);
        value = (uint16_t)(value / 10u);
        n++;
    } while (value != 0);
    for (size_t i = 0; i < n; i++) {
        out[i] = reversed[n - 1 - i];
    }
    return n;
}

lum_result lum_command_format(const lum_command *command,
                              char out[LUM_COMMAND_TEXT_BYTES], size_t *len)
{
    if ((unsigned)command->id >= LUM_COMMANDS) {
        return LUM_E_VALUE;
    }
    const lum_command_spec *spec = &lum_command_specs[command->id];
    if (!is_allowed(spec, command->value)) {
        return LUM_E_VALUE;
    }
    size_t n = spec->has_value ? put_decimal(out, command->value) : 0;
    out[n] = spec->letter;
    *len = n + 1;
    return LUM_OK;
}

/* Digits at the beginning of a text; a value past 16 bits saturates, which no
 * command allows. */
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

/* Steps over one space between commands; a space at the end or a second one
 * leaves *used short of a command, which the next parse refuses. */
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
    if (!is_allowed(spec, value)) {
        return LUM_E_VALUE;
    }
    out->id = (lum_command_id)(spec - lum_command_specs);
    out->value = (uint16_t)value;
    *text = t + used;
    *len -= used;
    return LUM_OK;
}
