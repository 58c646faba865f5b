/* Files, text and exit of the host by semihosting, as a debugger or an emulator
 * gives it. */
#include "board.h"
#include "port.h"

#include <stdbool.h>

#define HOST_OPEN    0x01
#define HOST_CLOSE   0x02
#define HOST_WRITE   0x05
#define HOST_READ    0x06
#define HOST_EXIT    0x20
#define OPEN_READ    1 /* "rb" */
#define OPEN_WRITE   4 /* "w" */
#define EXIT_ORDERLY 0x20026u
#define CONSOLE      ":tt"

static size_t length(const char *text)
{
    size_t n = 0;

    while (text[n] != '\0') {
        n++;
    }
    return n;
}

static int host_open(const char *path, uintptr_t mode)
{
    const uintptr_t block[3] = {(uintptr_t)path, mode, length(path)};

    return (int)board_call(HOST_OPEN, block);
}

int port_open(const char *path)
{
    static int input = -1;

    if (input != -1) {
        const uintptr_t block[1] = {(uintptr_t)input};
        (void)board_call(HOST_CLOSE, block);
    }
    input = host_open(path, OPEN_READ);
    return input;
}

/* The host answers how many bytes it did not read. */
long port_read(int file, void *out, size_t size)
{
    const uintptr_t block[3] = {(uintptr_t)file, (uintptr_t)out, size};
    const long left = board_call(HOST_READ, block);

    return left < 0 || (size_t)left > size ? -1 : (long)(size - (size_t)left);
}

int port_write(const char *text, size_t len)
{
    static int console;
    static bool open;

    if (!open) {
        console = host_open(CONSOLE, OPEN_WRITE);
        open = true;
    }
    const uintptr_t block[3] = {(uintptr_t)console, (uintptr_t)text, len};
    return board_call(HOST_WRITE, block) == 0 ? 0 : -1;
}

void port_exit(int status)
{
    const uintptr_t block[2] = {EXIT_ORDERLY, (uintptr_t)status};

    for (;;) {
        (void)board_call(HOST_EXIT, block);
    }
}
