#include "mcap_comments.h"

#include "byte_order.h"

#include <stdbool.h>
#include <string.h>

/* Between two documents. */
#define RULE       "\n---\n"
#define RULE_BYTES 5u

struct text {
    const uint8_t *at;
    size_t len;
};

/* A text with its length before it. */
static bool take_text(struct text *from, struct text *out)
{
    if (from->len < 4u) {
        return false;
    }
    out->at = from->at + 4;
    out->len = load_le32(from->at);
    if (out->len > from->len - 4u) {
        return false;
    }
    from->at += 4u + out->len;
    from->len -= 4u + out->len;
    return true;
}

static bool is(struct text text, const char *wanted)
{
    return text.len == strlen(wanted) && memcmp(text.at, wanted, text.len) == 0;
}

static bool begins_with_rule(struct text text)
{
    return text.len >= RULE_BYTES && memcmp(text.at, RULE, RULE_BYTES) == 0;
}

/* The end of a line before a rule is the document's. */
static void split(struct text text,
                  void (*take)(void *context, const uint8_t *text, size_t len),
                  void *context)
{
    struct text left = text;
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
    struct text record = {content, len};
    struct text name;
    struct text pairs;
    struct text key;
    struct text value;
    if (!take_text(&record, &name) || !is(name, "lumsdk") ||
        !take_text(&record, &pairs)) {
        return;
    }
    while (take_text(&pairs, &key) && take_text(&pairs, &value)) {
        if (is(key, "provenance")) {
            split(value, take, context);
        }
    }
}
