#define _GNU_SOURCE /* POSIX_SPAWN_SETSID, environ */
#include "browser.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#if defined(__APPLE__)
#define DESKTOP_OPENER "open"
extern char **environ;
#else
#define DESKTOP_OPENER "xdg-open"
#endif

#define NAME_BYTES 4096u

/* --- Starting it --- */

/* A separate session, so that Ctrl-C here does not end it; signals have their
 * defaults. */
static int set_attributes(posix_spawnattr_t *attributes)
{
    sigset_t none;
    sigset_t all;
    (void)sigemptyset(&none);
    (void)sigfillset(&all);
    return posix_spawnattr_setsigmask(attributes, &none) == 0 &&
                   posix_spawnattr_setsigdefault(attributes, &all) == 0 &&
                   posix_spawnattr_setflags(
                       attributes, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK |
                                       POSIX_SPAWN_SETSIGDEF) == 0
               ? 0
               : -1;
}

static int set_files(posix_spawn_file_actions_t *files)
{
    int failed = 0;
    for (int fd = 0; fd < 3; fd++) {
        failed |= posix_spawn_file_actions_addopen(
            files, fd, "/dev/null", fd == 0 ? O_RDONLY : O_WRONLY, 0);
    }
    return failed;
}

static bool start_with(char *program, char *url,
                       const posix_spawn_file_actions_t *files)
{
    posix_spawnattr_t attributes;
    pid_t child = 0;
    char *const arguments[] = {program, url, NULL};
    if (posix_spawnattr_init(&attributes) != 0) {
        return false;
    }
    const bool is_started = set_attributes(&attributes) == 0 &&
                            posix_spawnp(&child, program, files, &attributes,
                                         arguments, environ) == 0;
    (void)posix_spawnattr_destroy(&attributes);
    return is_started;
}

static bool start(char *program, char *url)
{
    posix_spawn_file_actions_t files;
    if (posix_spawn_file_actions_init(&files) != 0) {
        return false;
    }
    const bool is_started =
        set_files(&files) == 0 && start_with(program, url, &files);
    (void)posix_spawn_file_actions_destroy(&files);
    return is_started;
}

/* The first of a list, separated by colons, that can be started. */
static bool start_any(const char *list, char *url)
{
    char name[NAME_BYTES];
    while (*list != '\0') {
        const size_t len = strcspn(list, ":");
        if (len > 0 && len < sizeof name) {
            (void)memcpy(name, list, len);
            name[len] = '\0';
            if (start(name, url)) {
                return true;
            }
        }
        list += len + (list[len] == ':' ? 1u : 0u);
    }
    return false;
}

static bool has_screen(void)
{
#if defined(__APPLE__)
    return true;
#else
    return getenv("DISPLAY") != NULL || getenv("WAYLAND_DISPLAY") != NULL;
#endif
}

/* Nobody asks how the browser ended. */
static void forget_children(void)
{
    struct sigaction action = {.sa_handler = SIG_IGN};
    (void)sigemptyset(&action.sa_mask);
    (void)sigaction(SIGCHLD, &action, NULL);
}

static bool open_url(char *url)
{
    char opener[] = DESKTOP_OPENER;
    const char *chosen = getenv("BROWSER");
    forget_children();
    if (chosen != NULL && start_any(chosen, url)) {
        return true;
    }
    return has_screen() && start(opener, url);
}

/* --- A file that leads on to a URL --- */

static const char *const page =
    "<!doctype html>\n"
    "<html lang=\"en\">\n"
    "<meta charset=\"utf-8\">\n"
    "<meta name=\"referrer\" content=\"no-referrer\">\n"
    "<meta http-equiv=\"refresh\" content=\"0; url=%s\">\n"
    "<title>lumview</title>\n"
    "<p><a href=\"%s\">To lumview</a></p>\n";

/* 0, or -1: a folder cannot be made in this place. */
static int make_folder(struct browser *browser, const char *place)
{
    const int n = place == NULL || place[0] != '/'
                      ? -1
                      : snprintf(browser->folder, sizeof browser->folder,
                                 "%s/lumview-XXXXXX", place);
    if (n < 0 || (size_t)n >= sizeof browser->folder ||
        mkdtemp(browser->folder) == NULL) {
        browser->folder[0] = '\0';
        return -1;
    }
    (void)snprintf(browser->file, sizeof browser->file, "%s/open.html",
                   browser->folder);
    return 0;
}

static void write_url(struct browser *browser)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyz"
                                "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789/-._~";
    char *out = browser->url + sprintf(browser->url, "file://");
    for (const char *at = browser->file; *at != '\0'; at++) {
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

static int write_redirect(struct browser *browser, const char *to)
{
    if (make_folder(browser, getenv("XDG_RUNTIME_DIR")) != 0 &&
        make_folder(browser, getenv("TMPDIR")) != 0 &&
        make_folder(browser, "/tmp") != 0) {
        return -1;
    }
    write_url(browser);
    if (write_page(browser->file, to) != 0) {
        browser_forget(browser);
        return -1;
    }
    return 0;
}

void browser_forget(struct browser *browser)
{
    if (browser->folder[0] != '\0') {
        (void)unlink(browser->file);
        (void)rmdir(browser->folder);
        browser->folder[0] = '\0';
    }
}

bool browser_open(struct browser *browser, char *url, bool is_secret)
{
    if (!is_secret) {
        return open_url(url);
    }
    return write_redirect(browser, url) == 0 && open_url(browser->url);
}
