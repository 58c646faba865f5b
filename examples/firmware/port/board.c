#include "board.h"

#include "port.h"

#include <string.h>

#ifndef BOARD_COMMAND_MAX
#define BOARD_COMMAND_MAX 256 /* bytes of a command line */
#endif
#ifndef BOARD_WORDS_MAX
#define BOARD_WORDS_MAX 4 /* its words */
#endif
#define FAULT_STATUS 70
#define GET_COMMAND  0x15

/* Of the linker script. */
extern uint32_t board_data[], board_data_end[], board_data_load[];
extern uint32_t board_bss[], board_bss_end[];

int main(int argc, char **argv);

static void fill_variables(void)
{
    memcpy(board_data, board_data_load,
           (size_t)((uintptr_t)board_data_end - (uintptr_t)board_data));
    memset(board_bss, 0,
           (size_t)((uintptr_t)board_bss_end - (uintptr_t)board_bss));
}

/* Cuts a line into words, in place. */
static int split(char *line, char **words)
{
    int n = 0;

    while (*line != '\0' && n < BOARD_WORDS_MAX) {
        if (*line == ' ') {
            *line++ = '\0';
            continue;
        }
        words[n++] = line;
        while (*line != '\0' && *line != ' ') {
            line++;
        }
    }
    if (*line == ' ') {
        *line = '\0';
    }
    return n;
}

static int get_command(char *line, char **words)
{
    const uintptr_t block[2] = {(uintptr_t)line, BOARD_COMMAND_MAX};

    if (board_call(GET_COMMAND, block) != 0) {
        return 0;
    }
    return split(line, words);
}

void board_run(void)
{
    static char line[BOARD_COMMAND_MAX];
    static char *words[BOARD_WORDS_MAX + 1];

    fill_variables();
    port_exit(main(get_command(line, words), words));
}

void board_fault(void)
{
    static const char text[] = "fault: an exception that nobody expects\n";

    (void)port_write(text, sizeof text - 1u);
    port_exit(FAULT_STATUS);
}
