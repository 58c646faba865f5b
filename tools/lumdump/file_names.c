/* Names an output's files: picks the next name, claims names against other
 * runs, and opens the list that --keep uses. */
#define _POSIX_C_SOURCE 200809L
#include "file_names.h"

#include "base/system.h"
#include "numbered.h"
#include "targets.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

struct file_names file_names_of(const struct options *options, size_t i)
{
    const struct output_options *output = &options->outputs[i];
    struct file_names names = {
        .options = options, .name = output->name, .claim = LUM_CLAIM_NONE};
    if (output->is_folder) {
        names.kind = FILE_NAMES_IN_FOLDER;
    } else if (options_rotates(options, i)) {
        names.kind = FILE_NAMES_NUMBERED;
    } else if (options_pattern(output->name) == 1) {
        names.kind = FILE_NAMES_OF_FRAMES;
    }
    return names;
}

/* Without the right to the name another run may be writing the files. */
static int open_retention(struct file_names *n, lum_error *error)
{
    if (n->claim.mark == NULL || n->claim.fd < 0) {
        (void)lum_error_set(
            error, "%s: --keep needs a folder that this user may write to",
            n->name);
        errno = EACCES;
        return -1;
    }
    return retention_open(n->name, &n->options->files.keep, &n->retention,
                          error);
}

static bool has_folder_for_each(const struct file_names *n)
{
    const char *percent = strchr(n->name, '%');
    return percent != NULL && percent < lum_system_base(n->name);
}

/* A run that makes several files of a name owns that name until its end. Other
 * errors of the name are reported by its first file, unless --keep was given:
 * then nothing is done without the right. */
int file_names_take(struct file_names *n, lum_error *error)
{
    const bool keeps = n->kind == FILE_NAMES_NUMBERED &&
                       options_is_rotation(&n->options->files.keep);
    if (n->kind == FILE_NAMES_IN_FOLDER) {
        n->folder = bag_folder_new(n->name, error);
        return n->folder != NULL ? 0 : -1;
    }
    if (n->kind != FILE_NAMES_ONE && !has_folder_for_each(n) &&
        lum_claim_take(n->name, n->name, &n->claim, error) != 0 &&
        (keeps || errno == EBUSY || errno == EEXIST)) {
        return -1;
    }
    return keeps ? open_retention(n, error) : 0;
}

static int make_next(struct file_names *n, int64_t frame,
                     char out[FILE_NAME_BYTES], lum_error *error)
{
    if (n->kind == FILE_NAMES_OF_FRAMES) {
        return numbered_name(n->name, frame, out, FILE_NAME_BYTES, error);
    }
    n->number++;
    if (n->kind == FILE_NAMES_IN_FOLDER) {
        return bag_folder_next_name(n->folder, out, FILE_NAME_BYTES)
                   ? 0
                   : lum_error_set(error, "%s: the name is too long", n->name);
    }
    return n->retention == NULL ||
                   retention_begin(n->retention, &n->number, error) == 0
               ? numbered_name(n->name, n->number, out, FILE_NAME_BYTES, error)
               : -1;
}

const char *file_names_next(struct file_names *names, int64_t frame,
                            char room[FILE_NAME_BYTES], lum_error *error)
{
    if (names->kind == FILE_NAMES_ONE) {
        return names->name;
    }
    return make_next(names, frame, room, error) == 0 &&
                   targets_check_inputs(names->options, room, error) == 0
               ? room
               : NULL;
}

static bool is_there(const struct file_names *n, unsigned number,
                     char name[FILE_NAME_BYTES])
{
    return numbered_name(n->name, number, name, FILE_NAME_BYTES, NULL) == 0 &&
           access(name, F_OK) == 0;
}

bool file_names_find_stale(const struct file_names *n, lum_error *out)
{
    char first[FILE_NAME_BYTES];
    char second[FILE_NAME_BYTES];
    if (n->kind != FILE_NAMES_NUMBERED || n->retention != NULL ||
        !is_there(n, n->number + 1u, first)) {
        return false;
    }
    const bool has_more = is_there(n, n->number + 2u, second);
    (void)lum_error_set(out,
                        "%s%s of an earlier run: this one ended with number "
                        "%u; remove what you do not need",
                        first, has_more ? " and what follows are" : " is",
                        n->number);
    return true;
}

void file_names_give_back(struct file_names *names)
{
    const int code = errno;
    retention_close(names->retention);
    lum_claim_drop(&names->claim);
    bag_folder_free(names->folder);
    errno = code;
}
