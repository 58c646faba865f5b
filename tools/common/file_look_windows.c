#include "file_look.h"

#include <string.h>
#include <windows.h>

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
    out->volume = facts.dwVolumeSerialNumber;
    out->number = ((uint64_t)facts.nFileIndexHigh << 32) | facts.nFileIndexLow;
    return true;
}

/* A handle to ask, of directories too, which keeps nobody away. */
static bool look(const char *name, DWORD standard, struct file_look *out)
{
    if (strcmp(name, "-") == 0) {
        return ask(GetStdHandle(standard), out);
    }
    const HANDLE file = CreateFileA(
        name, 0, FILE_SHARE_READ | FILE_SHARE_WRITE | FILE_SHARE_DELETE, NULL,
        OPEN_EXISTING, FILE_FLAG_BACKUP_SEMANTICS, NULL);
    if (file == INVALID_HANDLE_VALUE) {
        return false;
    }
    const bool is_known = ask(file, out);
    (void)CloseHandle(file);
    return is_known;
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
