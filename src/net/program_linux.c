/* Which program has a process number or a port, on Linux. */
#define _POSIX_C_SOURCE 200809L
#include "net/program.h"

#include <ctype.h>
#include <dirent.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* A table of the kernel is read again until so many readings in a row had the
 * same number of lines, and at most so often in all. */
#define SAME_LOOKS 8
#define LOOKS_MAX  50

/* A program can have any name; only printable characters go into a message. */
static void read_name(long process, char *out, size_t room)
{
    char path[64];
    (void)snprintf(path, sizeof path, "/proc/%ld/comm", process);
    FILE *file = fopen(path, "r");
    size_t n = 0;
    if (file != NULL) {
        n = fread(out, 1, room - 1u, file);
        (void)fclose(file);
    }
    out[n] = '\0';
    out[strcspn(out, "\n")] = '\0';
    for (char *c = out; *c != '\0'; c++) {
        *c = (char)(isprint((unsigned char)*c) ? *c : '?');
    }
}

lum_program_text lum_program_show(long process)
{
    lum_program_text out = {"another program"};
    char name[20];
    if (process > 0) {
        read_name(process, name, sizeof name);
        (void)snprintf(out.text, sizeof out.text, "%s (process %ld)",
                       name[0] != '\0' ? name : "another program", process);
    }
    return out;
}

/* The text of a line's n-th word. */
static const char *word(const char *line, int n)
{
    const char *at = line + strspn(line, " ");
    for (; n > 0; n--) {
        at += strcspn(at, " ");
        at += strspn(at, " ");
    }
    return at;
}

/* A line of /proc/net/udp or tcp: "12: 2500007F:158D ...", the inode its tenth
 * word; 0 where no program has the socket any more.
 * The address is in network order, shown as a number of the host's. */
static bool line_is_of(const char *line, lum_endpoint local,
                       unsigned long *inode)
{
    char *colon = NULL;
    const unsigned long address = strtoul(word(line, 1), &colon, 16);
    const uint32_t theirs = ntohl((uint32_t)address);
    if (*colon != ':' || strtoul(colon + 1, NULL, 16) != local.port) {
        return false;
    }
    *inode = strtoul(word(line, 9), NULL, 10);
    return *inode != 0 &&
           (theirs == local.address || theirs == 0 || local.address == 0);
}

/* count: lines that were read. */
static bool find_in_table(const char *table, lum_endpoint local,
                          unsigned long *inode, size_t *count)
{
    char line[512];
    bool found = false;
    FILE *file = fopen(table, "r");
    *count = 0;
    if (file == NULL) {
        return false;
    }
    while (!found && fgets(line, sizeof line, file) != NULL) {
        found = line_is_of(line, local, inode);
        ++*count;
    }
    (void)fclose(file);
    return found;
}

/* The kernel gives the table by parts: when a socket of an earlier part is
 * closed, the next part begins a line too late. So a socket that is missing is
 * looked for again, as long as sockets come and go. */
static bool find_inode(const char *table, lum_endpoint local,
                       unsigned long *inode)
{
    size_t before = 0;
    int same = 0;
    for (int i = 0; i < LOOKS_MAX && same < SAME_LOOKS; i++) {
        size_t count = 0;
        if (find_in_table(table, local, inode, &count)) {
            return true;
        }
        same = count == before ? same + 1 : 1;
        before = count;
    }
    return false;
}

static bool is_link_to(DIR *directory, const char *name, const char *target)
{
    char found[64];
    const ssize_t n =
        readlinkat(dirfd(directory), name, found, sizeof found - 1u);
    if (n <= 0) {
        return false;
    }
    found[n] = '\0';
    return strcmp(found, target) == 0;
}

static bool has_open(long process, const char *target)
{
    char path[64];
    bool found = false;
    (void)snprintf(path, sizeof path, "/proc/%ld/fd", process);
    DIR *directory = opendir(path);
    if (directory == NULL) {
        return false;
    }
    for (struct dirent *entry = readdir(directory); !found && entry != NULL;
         entry = readdir(directory)) {
        found = is_link_to(directory, entry->d_name, target);
    }
    (void)closedir(directory);
    return found;
}

static long find_holder(const char *target)
{
    long holder = 0;
    DIR *directory = opendir("/proc");
    if (directory == NULL) {
        return 0;
    }
    for (struct dirent *entry = readdir(directory);
         holder == 0 && entry != NULL; entry = readdir(directory)) {
        const long process = strtol(entry->d_name, NULL, 10);
        if (process > 0 && has_open(process, target)) {
            holder = process;
        }
    }
    (void)closedir(directory);
    return holder;
}

static long find_program(const char *table, lum_endpoint local)
{
    unsigned long inode = 0;
    char target[64];
    if (!find_inode(table, local, &inode)) {
        return 0;
    }
    (void)snprintf(target, sizeof target, "socket:[%lu]", inode);
    return find_holder(target);
}

long lum_program_of_port(lum_endpoint local)
{
    return find_program("/proc/net/udp", local);
}

long lum_program_of_tcp_port(lum_endpoint local)
{
    return find_program("/proc/net/tcp", local);
}
