#include "comments.h"

#include "mcap_records.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

void lum_comments_clear(lum_comments *comments)
{
    for (size_t i = 0; i < comments->count; i++) {
        free(comments->list[i].text);
    }
    comments->count = 0;
}

void lum_comments_rewind(lum_comments *comments)
{
    comments->left_out = 0;
}

static bool has(const lum_comments *comments, const void *text, size_t len)
{
    for (size_t i = 0; i < comments->count; i++) {
        const lum_comment *c = &comments->list[i];
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
    comments->list[comments->count++] = (lum_comment){copy, len};
}

/* --- Those of an MCAP file of this project --- */

/* Between two documents. */
#define RULE       "\n---\n"
#define RULE_BYTES 5u

static bool begins_with_rule(lum_bytes_at text)
{
    return text.len >= RULE_BYTES && memcmp(text.at, RULE, RULE_BYTES) == 0;
}

/* The end of a line before a rule is the document's. */
static void split(lum_bytes_at text,
                  void (*take)(void *context, const uint8_t *text, size_t len),
                  void *context)
{
    lum_bytes_at left = text;
    const uint8_t *begin = text.at;
    while (left.len > 0) {
        if (begins_with_rule(left)) {
            take(context, begin, (size_t)(left.at + 1 - begin));
            left.at += RULE_BYTES - 1u;
            left.len -= RULE_BYTES - 1u;
            begin = left.at + 1;
        }
        left.at++;
        left.len--;
    }
    if (left.at > begin) {
        take(context, begin, (size_t)(left.at - begin));
    }
}

void lum_mcap_comments_read(const uint8_t *content, size_t len,
                            void (*take)(void *context, const uint8_t *text,
                                         size_t len),
                            void *context)
{
    lum_bytes_at record = {content, len};
    lum_bytes_at name;
    lum_bytes_at pairs;
    lum_bytes_at key;
    lum_bytes_at value;
    if (!lum_mcap_take_text(&record, &name) ||
        !lum_mcap_is_text(name, "lumsdk") ||
        !lum_mcap_take_text(&record, &pairs)) {
        return;
    }
    while (lum_mcap_take_text(&pairs, &key) &&
           lum_mcap_take_text(&pairs, &value)) {
        if (lum_mcap_is_text(key, "provenance")) {
            split(value, take, context);
        }
    }
}
