/* Which program has a process number or a UDP port, on Windows. */
#include "net/winsock.h"

#include "net/program.h"

#include <iphlpapi.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A process's program without its directories; empty: not known. */
static void read_name(long process, char *out, size_t room)
{
    char path[MAX_PATH];
    DWORD len = sizeof path;
    const HANDLE handle =
        OpenProcess(PROCESS_QUERY_LIMITED_INFORMATION, FALSE, (DWORD)process);
    out[0] = '\0';
    if (handle == NULL) {
        return;
    }
    if (QueryFullProcessImageNameA(handle, 0, path, &len)) {
        const char *last = strrchr(path, '\\');
        (void)snprintf(out, room, "%.40s", last != NULL ? last + 1 : path);
    }
    (void)CloseHandle(handle);
}

lum_program_text lum_program_show(long process)
{
    lum_program_text out = {"another program"};
    char name[41];
    if (process > 0) {
        read_name(process, name, sizeof name);
        (void)snprintf(out.text, sizeof out.text, "%s (process %ld)",
                       name[0] != '\0' ? name : "another program", process);
    }
    return out;
}

static bool is_of(const MIB_UDPROW_OWNER_PID *row, lum_endpoint local)
{
    const uint32_t theirs = ntohl(row->dwLocalAddr);
    return ntohs((uint16_t)row->dwLocalPort) == local.port &&
           (theirs == local.address || theirs == 0 || local.address == 0);
}

static long find_in(const MIB_UDPTABLE_OWNER_PID *table, lum_endpoint local)
{
    for (DWORD i = 0; i < table->dwNumEntries; i++) {
        if (is_of(&table->table[i], local)) {
            return (long)table->table[i].dwOwningPid;
        }
    }
    return 0;
}

long lum_program_of_port(lum_endpoint local)
{
    DWORD bytes = 0;
    long process = 0;
    (void)GetExtendedUdpTable(NULL, &bytes, FALSE, AF_INET, UDP_TABLE_OWNER_PID,
                              0);
    MIB_UDPTABLE_OWNER_PID *table = malloc(bytes);
    if (table == NULL) {
        return 0;
    }
    if (GetExtendedUdpTable(table, &bytes, FALSE, AF_INET, UDP_TABLE_OWNER_PID,
                            0) == NO_ERROR) {
        process = find_in(table, local);
    }
    free(table);
    return process;
}

long lum_program_of_tcp_port(lum_endpoint local)
{
    (void)local;
    return 0;
}
