#define _POSIX_C_SOURCE 200809L
#include "redirect.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *const page =
    "<!doctype html>\n"
    "<html lang=\"en\">\n"
    "<meta charset=\"utf-8\">\n"
    "<meta name=\"referrer\" content=\"no-referrer\">\n"
    "<meta http-equiv=\"refresh\" content=\"0; url=%s\">\n"
    "<title>lumview</title>\n"
    "<p><a href=\"%s\">To lumview</a></p>\n";

/* 0, or -1: a folder cannot be made in this place. */
static int make_folder(struct redirect *redirect, const char *place)
{
    const int n = place == NULL || place[0] != '/'
                      ? -1
                      : snprintf(redirect->folder, sizeof redirect->folder,
                                 "%s/lumview-XXXXXX", place);
    if (n < 0 || (size_t)n >= sizeof redirect->folder ||
        mkdtemp(redirect->folder) == NULL) {
        redirect->folder[0] = '\0';
        return -1;
    }
    (void)snprintf(redirect->file, sizeof redirect->file, "%s/open.html",
                   redirect->folder);
    return 0;
}

static void write_url(struct redirect *redirect)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyz"
                                "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789/-._~";
    char *out = redirect->url + sprintf(redirect->url, "file://");
    for (const char *at = redirect->file; *at != '\0'; at++) {
        const unsigned c = (unsigned char)*at;
        out += sprintf(out, strchr(plain, *at) != NULL ? "%c" : "%%%02X", c);
    }
}

static int write_page(const char *name, const char *to)
{
    const int fd = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    FILE *out = fd >= 0 ? fdopen(fd, "w") : NULL;
    if (out == NULL) {
        if (fd >= 0) {
            (void)close(fd);
        }
        return -1;
    }
    const int n = fprintf(out, page, to, to);
    return fclose(out) == 0 && n > 0 ? 0 : -1;
}

int redirect_write(struct redirect *redirect, const char *to)
{
    if (make_folder(redirect, getenv("XDG_RUNTIME_DIR")) != 0 &&
        make_folder(redirect, getenv("TMPDIR")) != 0 &&
        make_folder(redirect, "/tmp") != 0) {
        return -1;
    }
    write_url(redirect);
    if (write_page(redirect->file, to) != 0) {
        redirect_remove(redirect);
        return -1;
    }
    return 0;
}

void redirect_remove(struct redirect *redirect)
{
    if (redirect->folder[0] != '\0') {
        (void)unlink(redirect->file);
        (void)rmdir(redirect->folder);
        redirect->folder[0] = '\0';
    }
}
