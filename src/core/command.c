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

/* By sums: some small targets have no instruction that divides. */
static bool is_allowed(const lum_command_spec *spec, unsigned value)
{
    unsigned allowed = spec->min;
    while (allowed < value && allowed < spec->max) {
        allowed += spec->step;
    }
    return allowed == value;
}

/* No value of the table has more than three digits. */
static size_t put_decimal(char *out, unsigned value)
{
    static const uint8_t powers[3] = {100, 10, 1};
    size_t n = 0;
    for (size_t i = 0; i < sizeof powers; i++) {
        char digit = '0';
        while (value >= powers[i]) {
            value -= powers[i];
            digit++;
        }
        if (n > 0 || digit > '0' || powers[i] == 1) {
            out[n++] = digit;
        }
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
