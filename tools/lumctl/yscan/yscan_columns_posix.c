#define _DEFAULT_SOURCE
#include "yscan_draw.h"

#include <sys/ioctl.h>
#include <unistd.h>

unsigned yscan_columns(void)
{
    struct winsize size = {0, 0, 0, 0};
    const int result = ioctl(STDERR_FILENO, TIOCGWINSZ, &size);
    return result == 0 && size.ws_col > 0 ? size.ws_col : 80u;
}
