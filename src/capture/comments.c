#include "comments.h"

#include "lum/capture/capture.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* A NUL follows it. */
struct comment {
    char *text;
    size_t len;
};

struct lum_comments {
    struct comment list[LUM_CAPTURE_COMMENTS_MAX];
    size_t count;
    uint64_t left_out;
};

lum_comments *lum_comments_new(void)
{
    return calloc(1, sizeof(lum_comments));
}

void lum_comments_free(lum_comments *comments)
{
    if (comments != NULL) {
        for (size_t i = 0; i < comments->count; i++) {
            free(comments->list[i].text);
        }
        free(comments);
    }
}

void lum_comments_rewind(lum_comments *comments)
{
    comments->left_out = 0;
}

static bool has(const lum_comments *comments, const void *text, size_t len)
{
    for (size_t i = 0; i < comments->count; i++) {
        const struct comment *c = &comments->list[i];
        if (c->len == len && memcmp(c->text, text, len) == 0) {
            return true;
        }
    }
    return false;
}

void lum_comments_add(lum_comments *comments, const void *text, size_t len)
{
    if (has(comments, text, len)) {
        return;
    }
    char *copy =
        comments->count < LUM_CAPTURE_COMMENTS_MAX ? malloc(len + 1u) : NULL;
    if (copy == NULL) {
        comments->left_out++;
        return;
    }
    memcpy(copy, text, len);
    copy[len] = '\0';
    comments->list[comments->count++] = (struct comment){copy, len};
}

size_t lum_comments_count(const lum_comments *comments)
{
    return comments->count;
}

const char *lum_comments_get(const lum_comments *comments, size_t i,
                             size_t *len)
{
    *len = comments->list[i].len;
    return comments->list[i].text;
}

uint64_t lum_comments_left_out(const lum_comments *comments)
{
    return comments->left_out;
}
