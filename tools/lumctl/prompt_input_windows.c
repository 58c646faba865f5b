/* Standard input without a wait, on Windows. */
#include "prompt_input.h"

#include <stdbool.h>
#include <windows.h>

/* A console hands a line over when it is whole: from the first key on the read
 * waits for its end. */
static bool is_ready(HANDLE input)
{
    DWORD bytes = 0;
    switch (GetFileType(input)) {
    case FILE_TYPE_PIPE:
        return !PeekNamedPipe(input, NULL, 0, NULL, &bytes, NULL) || bytes > 0;
    case FILE_TYPE_CHAR:
        return WaitForSingleObject(input, 0) == WAIT_OBJECT_0;
    default:
        return true;
    }
}

int prompt_input_read(char *out, size_t room)
{
    const HANDLE input = GetStdHandle(STD_INPUT_HANDLE);
    DWORD n = 0;
    if (!is_ready(input)) {
        return 0;
    }
    return ReadFile(input, out, (DWORD)room, &n, NULL) && n > 0 ? (int)n : -1;
}

int prompt_descriptor(void)
{
    return -1;
}
