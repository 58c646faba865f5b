#include "outputs.h"

#include "targets.h"

#include <errno.h>
#include <stdlib.h>

struct outputs {
    struct output *list[OUTPUTS_MAX]; /* NULL: left out */
    size_t count;
    size_t failed;               /* which has failed; count: none */
    struct outputs_notes *notes; /* NULL: a rehearsal */
};

/* --- Opening --- */

int outputs_open(const struct options *options, const struct outputs *rehearsal,
                 struct outputs_notes *notes, struct outputs **out,
                 lum_error *error)
{
    struct outputs *all = calloc(1, sizeof *all);
    if (all == NULL) {
        return lum_error_set(error, "out of memory");
    }
    all->count = options->output_count;
    all->failed = all->count;
    all->notes = notes;
    for (size_t i = 0; i < all->count; i++) {
        if ((notes != NULL || targets_needs_rehearsal(options, i)) &&
            output_open(options, i, notes == NULL,
                        rehearsal != NULL ? rehearsal->list[i] : NULL,
                        &all->list[i], error) != 0) {
            const int code = errno;
            outputs_abort(all);
            errno = code;
            return -1;
        }
    }
    *out = all;
    return 0;
}

void outputs_finish_by(struct outputs *outputs, struct closer *closer)
{
    for (size_t i = 0; i < outputs->count; i++) {
        output_finish_by(outputs->list[i], closer);
    }
}

bool outputs_any(const struct outputs *outputs, output_question *is_so)
{
    bool is_any = false;
    for (size_t i = 0; outputs != NULL && i < outputs->count; i++) {
        is_any |= outputs->list[i] != NULL && is_so(outputs->list[i]);
    }
    return is_any;
}

/* --- All at once --- */

static size_t count_others(const struct outputs *outputs, size_t i)
{
    size_t n = 0;
    for (size_t k = 0; k < outputs->count; k++) {
        n += k != i && k != outputs->failed && outputs->list[k] != NULL ? 1 : 0;
    }
    return n;
}

static void add_left(struct outputs_notes *notes, const char *name)
{
    (void)lum_error_set(&notes->list[notes->count++],
                        "the reader of %s has left: that output has ended, the "
                        "others go on",
                        output_title(name));
}

/* What has no reader any more is done with, where there are others. */
static bool leave_out(struct outputs *outputs, size_t i)
{
    if (outputs->notes == NULL || count_others(outputs, i) == 0) {
        return false;
    }
    add_left(outputs->notes, output_name(outputs->list[i]));
    output_abort(outputs->list[i]);
    outputs->list[i] = NULL;
    return true;
}

int outputs_act(struct outputs *outputs, const struct action *action,
                lum_error *error)
{
    for (size_t i = 0; i < outputs->count; i++) {
        if (outputs->list[i] != NULL &&
            output_act(outputs->list[i], action, error) != 0 &&
            (errno != EPIPE || !leave_out(outputs, i))) {
            outputs->failed = i;
            return -1;
        }
    }
    return 0;
}

int outputs_open_part(const struct outputs *outputs, lum_writer **out,
                      lum_error *error)
{
    return output_open_part(outputs->list[0], out, error);
}

bool outputs_find_lost(struct outputs *outputs, lum_error *out)
{
    bool is_found = false;
    for (size_t i = 0; i < outputs->count && !is_found; i++) {
        is_found =
            outputs->list[i] != NULL && output_find_lost(outputs->list[i], out);
    }
    return is_found;
}

/* --- The end --- */

void outputs_add_retention(struct retention_counts *sum,
                           const struct retention_counts *more)
{
    sum->is_used = sum->is_used || more->is_used;
    sum->removed += more->removed;
    sum->stuck += more->stuck;
}

static void add_end(struct outputs_notes *notes, const struct output_end *end)
{
    for (size_t i = 0; i < end->note_count; i++) {
        notes->list[notes->count++] = end->notes[i];
    }
    outputs_add_retention(&notes->retention, &end->retention);
}

/* Finishes one; a reader that has left before is no failure where there are
 * others. */
static int close_one(struct outputs *outputs, size_t i, bool has_others,
                     lum_error *error)
{
    struct output *output = outputs->list[i];
    const char *name = output_name(output);
    struct output_end end;
    const int result = output_close(output, &end, error);
    add_end(outputs->notes, &end); /* leaves errno as it is */
    if (result == 0) {
        return 0;
    }
    if (errno != EPIPE || !has_others) {
        return -1;
    }
    add_left(outputs->notes, name);
    outputs->list[i] = NULL;
    return 0;
}

/* Only the first failure is reported. */
int outputs_close(struct outputs *outputs, lum_error *error)
{
    lum_error others = {""};
    int code = 0;
    int result = 0;
    for (size_t i = 0; i < outputs->count; i++) {
        if (i == outputs->failed) {
            output_abort(outputs->list[i]);
        } else if (outputs->list[i] != NULL &&
                   close_one(outputs, i, count_others(outputs, i) > 0,
                             result == 0 ? error : &others) != 0) {
            code = result == 0 ? errno : code;
            result = -1;
        }
    }
    free(outputs);
    errno = code;
    return result;
}

void outputs_abort(struct outputs *outputs)
{
    if (outputs == NULL) {
        return;
    }
    for (size_t i = 0; i < outputs->count; i++) {
        output_abort(outputs->list[i]);
    }
    free(outputs);
}

/* --- What they lack --- */

static bool lacks_any(const struct left_out *l)
{
    return l->late > 0 || l->cut > 0 || l->no_place > 0;
}

size_t outputs_left_out(const struct outputs *outputs,
                        const struct left_out *of_frames,
                        struct left_out out[OUTPUTS_MAX])
{
    size_t n = 0;
    for (size_t i = 0; i < outputs->count; i++) {
        const struct output *o = outputs->list[i];
        if (o == NULL) {
            continue;
        }
        output_left_out(o, &out[n]);
        /* where nobody chose, they are of other frames or it is not whole */
        if (output_wants_frames(o) && !output_draws_one(o)) {
            out[n].late += of_frames->late;
            out[n].cut += of_frames->cut;
        }
        n += lacks_any(&out[n]) ? 1u : 0u;
    }
    return n;
}

size_t outputs_drawn(const struct outputs *outputs,
                     struct drawn out[OUTPUTS_MAX])
{
    size_t n = 0;
    for (size_t i = 0; i < outputs->count; i++) {
        const struct output *o = outputs->list[i];
        n += o != NULL && output_drawn(o, &out[n]) ? 1u : 0u;
    }
    return n;
}
