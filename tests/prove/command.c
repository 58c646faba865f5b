/* Command texts: any characters, every length up to 8 (no command has more than
 * 4, and the space behind it), ending where their memory ends. Writing: any id
 * and value, those within the table's limits one by one. */
#include "lum/command.h"
#include "lum/host/command_text.h"
#include "unknown.h"

#define MOST 8u

static char memory[MOST];

static void parse(uint32_t len)
{
    const char *text = memory + (MOST - len);
    size_t left = len;
    lum_command command;
    if (lum_command_parse(&text, &left, &command) == LUM_OK) {
        //@ assert 0 <= command.id < LUM_COMMANDS;
        //@ assert left < len;
    }
}

static void format(uint32_t id, uint32_t value)
{
    char out[LUM_COMMAND_TEXT_BYTES];
    size_t len;
    const lum_command command = {(lum_command_id)id, (uint16_t)value};
    if (lum_command_format(&command, out, &len) == LUM_OK) {
        //@ assert 1 <= len <= LUM_COMMAND_TEXT_BYTES;
    }
}

static void format_values(uint32_t id)
{
    const lum_command_spec *spec = &lum_command_specs[id];
    const uint32_t value = any_u32(0, 65535);
    if (value < spec->min || value > spec->max) {
        format(id, value);
    } else {
        //@ split value;
        format(id, value);
        //@ merge value;
    }
}

void main(void)
{
    const uint32_t id = any_u32(0, LUM_COMMANDS - 1);
    format(LUM_COMMANDS, any_u32(0, 65535));
    //@ split id;
    format_values(id);
    //@ merge id;
    any_bytes(memory, MOST);
    const uint32_t len = any_u32(0, MOST);
    //@ split len;
    parse(len);
}
