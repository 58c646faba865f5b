/* What kind of file a name is, on Windows. */
#include "file_look.h"

#include <string.h>
#include <windows.h>

/* Windows counts 100 ns since 1601. */
static int64_t seconds_of(const FILETIME *time)
{
    const uint64_t ticks =
        ((uint64_t)time->dwHighDateTime << 32) | time->dwLowDateTime;
    return (int64_t)(ticks / 10000000u) - INT64_C(11644473600);
}

static bool ask(HANDLE file, struct file_look *out)
{
    BY_HANDLE_FILE_INFORMATION facts;
    *out = (struct file_look){.kind = FILE_DEVICE};
    switch (GetFileType(file)) {
    case FILE_TYPE_DISK:
        break;
    case FILE_TYPE_PIPE:
        out->kind = FILE_PIPE;
        return true;
    case FILE_TYPE_CHAR:
        return true;
    default:
        return false;
    }
    if (!GetFileInformationByHandle(file, &facts)) {
        return false;
    }
    out->kind = (facts.dwFileAttributes & FILE_ATTRIBUTE_DIRECTORY) != 0
                    ? FILE_DIRECTORY
                    : FILE_REGULAR;
    out->bytes = ((uint64_t)facts.nFileSizeHigh << 32) | facts.nFileSizeLow;
    out->modified_s = seconds_of(&facts.ftLastWriteTime);
    out->volume = facts.dwVolumeSerialNumber;
    out->number = ((uint64_t)facts.nFileIndexHigh << 32) | facts.nFileIndexLow;
    return true;
}

/* A handle to ask, of directories too, which keeps nobody away. */
static bool look_at(const char *name, DWORD flags, struct file_look *out)
{
    const HANDLE file = CreateFileA(
        name, 0, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, NULL,
        OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS | flags, NULL);
    if (file == INVALID_HANDLE_VALUE) {
        return false;
    }
    const bool is_known = ask(file, out);
    (void)CloseHandle(file);
    return is_known;
}

static bool look(const char *name, DWORD standard, struct file_look *out)
{
    return strcmp(name, "-") == 0 ? ask(GetStdHandle(standard), out)
                                  : look_at(name, 0, out);
}

bool file_look_itself(const char *name, struct file_look *out)
{
    const DWORD attributes = GetFileAttributesA(name);
    if (!look_at(name, FILE_FLAG_OPEN_REPARSE_POINT, out)) {
        return false;
    }
    if ((attributes & FILE_ATTRIBUTE_REPARSE_POINT) != 0) {
        out->kind = FILE_DEVICE;
    }
    return true;
}

bool file_look(const char *name, struct file_look *out)
{
    return look(name, STD_OUTPUT_HANDLE, out);
}

bool file_look_input(const char *name, struct file_look *out)
{
    return look(name, STD_INPUT_HANDLE, out);
}

/* Pipes and devices have no numbers: the callers compare their names. */
bool file_look_is_same(const struct file_look *a, const struct file_look *b)
{
    return a->kind != FILE_PIPE && b->kind != FILE_PIPE &&
           a->volume == b->volume && a->number == b->number;
}

/* There has to be somebody at a pipe's other end, or opening it fails. */
bool file_look_opens_late(const char *name)
{
    (void)name;
    return false;
}

bool file_look_is_dangling(const char *name)
{
    struct file_look l;
    return strcmp(name, "-") != 0 &&
           GetFileAttributesA(name) != INVALID_FILE_ATTRIBUTES &&
           !file_look(name, &l);
}
