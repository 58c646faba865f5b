#define _DEFAULT_SOURCE /* TIOCGWINSZ */
#include "say_system.h"

#include <errno.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#define COLUMNS_DEFAULT 80u

bool say_write(const char *bytes, size_t n, size_t *gone)
{
    const ssize_t written = write(STDERR_FILENO, bytes, n);
    if (written < 0 && (errno == EINTR || errno == EAGAIN)) {
        return false;
    }
    *gone = written < 0 ? n : (size_t)written;
    return true;
}

size_t say_columns(void)
{
    struct winsize size = {0};
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1
               ? size.ws_col
               : COLUMNS_DEFAULT;
}

void say_clock(char out[SAY_CLOCK_BYTES])
{
    const time_t now = time(NULL);
    struct tm local;
    out[0] = '\0';
    if (localtime_r(&now, &local) != NULL) {
        (void)strftime(out, SAY_CLOCK_BYTES, "%H:%M:%S", &local);
    }
}
