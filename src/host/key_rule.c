#include "key_rule.h"

#include <string.h>

#define QUOTED_MAX   55 /* bytes after which a quotation is cut */
#define DIGITS_MAX   20 /* of 64 bits */
#define DECIMALS_MAX 12

/* --- Text --- */

lum_key_text lum_key_text_begin(char *out, size_t size)
{
    const lum_key_text text = {out, size, 0};
    if (size > 0) {
        out[0] = '\0';
    }
    return text;
}

static void add_char(lum_key_text *text, char c)
{
    if (text->len + 1 < text->size) {
        text->out[text->len] = c;
        text->out[text->len + 1] = '\0';
    }
    text->len++;
}

void lum_key_text_add(lum_key_text *text, const char *string)
{
    for (; *string != '\0'; string++) {
        add_char(text, *string);
    }
}

void lum_key_text_add_bytes(lum_key_text *text, const char *bytes, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        add_char(text, bytes[i]);
    }
}

void lum_key_text_add_number(lum_key_text *text, int64_t number, int decimals)
{
    uint64_t rest =
        number < 0 ? UINT64_C(0) - (uint64_t)number : (uint64_t)number;
    char digits[DIGITS_MAX + DECIMALS_MAX]; /* the last one first */
    int count = 0;
    int end = 0;
    while (count <= decimals || rest > 0) {
        digits[count++] = (char)('0' + (char)(rest % 10));
        rest /= 10;
    }
    while (end < decimals && digits[end] == '0') {
        end++;
    }
    lum_key_text_add(text, number < 0 ? "-" : "");
    for (int i = count - 1; i >= end; i--) {
        lum_key_text_add(text, i == decimals - 1 ? "." : "");
        add_char(text, digits[i]);
    }
}

void lum_key_text_add_quoted(lum_key_text *text, const char *bytes, size_t len)
{
    static const char hex[] = "0123456789abcdef";
    const size_t start = text->len;
    for (size_t i = 0; i < len; i++) {
        const unsigned char c = (unsigned char)bytes[i];
        if (text->len - start > QUOTED_MAX) {
            lum_key_text_add(text, "...");
            return;
        }
        if (c >= 0x20 && c < 0x7f) {
            add_char(text, (char)c);
        } else {
            lum_key_text_add(text, "\\x");
            add_char(text, hex[c >> 4]);
            add_char(text, hex[c & 15u]);
        }
    }
}

size_t lum_key_text_length(const char *string)
{
    const char *end = string;
    while (*end != '\0') {
        end++;
    }
    return (size_t)(end - string);
}

/* --- Rules --- */

static const lum_key_word *find_word(const lum_key_rule *rule,
                                     lum_key_given given)
{
    const lum_key_word *word = rule->words;
    while (word != NULL && word->text != NULL) {
        if (lum_key_text_length(word->text) == given.len &&
            memcmp(word->text, given.text, given.len) == 0) {
            return word;
        }
        word++;
    }
    return NULL;
}

bool lum_key_rule_takes_numbers(const lum_key_rule *rule)
{
    return rule->min <= rule->max;
}

/* Where the character stands first, or NULL. */
static const char *find(lum_key_given given, char wanted)
{
    for (size_t i = 0; i < given.len; i++) {
        if (given.text[i] == wanted) {
            return given.text + i;
        }
    }
    return NULL;
}

/* Takes a number, blanks before it, and the character that ends it. */
static bool take_part(lum_key_given *left, char end, int64_t *out)
{
    const char *from = left->text;
    const char *const at = find(*left, end);
    if (at == NULL) {
        return false;
    }
    left->len -= (size_t)(at + 1 - from);
    left->text = at + 1;
    while (*from == ' ') {
        from++;
    }
    return lum_key_number_parse(from, (size_t)(at - from), 0, true, out) ==
           LUM_KEY_NUMBER_FINE;
}

static const char *read_pair(const lum_key_rule *rule, lum_key_given given,
                             int64_t *out)
{
    static const char none[] = "is not [LOW, HIGH], two whole numbers";
    int64_t low = 0;
    int64_t high = 0;
    if (given.is_quoted) {
        return "is text; write [LOW, HIGH], without quotes";
    }
    if (given.len == 0 || given.text[0] != '[') {
        return none;
    }
    lum_key_given left = {given.text + 1, given.len - 1, false};
    if (!take_part(&left, ',', &low) || !take_part(&left, ']', &high) ||
        left.len != 0) {
        return none;
    }
    if (low < rule->min || low > rule->max || high < rule->min ||
        high > rule->max) {
        return "is out of range";
    }
    if (high < low) {
        return "has the higher number first";
    }
    *out = LUM_KEY_PAIR(low, high);
    return NULL;
}

static const char *read_number(const lum_key_rule *rule, lum_key_given given,
                               int64_t *out)
{
    static const char *const why[] = {
        [LUM_KEY_NUMBER_NONE] = "is not a decimal number",
        [LUM_KEY_NUMBER_NOT_WHOLE] = "is not a whole number in digits",
        [LUM_KEY_NUMBER_LEADING_ZERO] =
            "begins with 0, which some read as octal; leave the 0 out",
        [LUM_KEY_NUMBER_TOO_LARGE] = "is out of range",
    };
    int64_t number = 0;
    if (!lum_key_rule_takes_numbers(rule)) {
        return "is not known";
    }
    if (given.is_quoted) {
        return "is text; write a number, without quotes";
    }
    const lum_key_number kind = lum_key_number_parse(
        given.text, given.len, rule->decimals, rule->whole, &number);
    if (kind != LUM_KEY_NUMBER_FINE) {
        return why[kind];
    }
    if (number < rule->min || number > rule->max) {
        return "is out of range";
    }
    *out = number;
    return NULL;
}

const char *lum_key_rule_read(const lum_key_rule *rule, lum_key_given given,
                              int64_t *out)
{
    if (rule->check != NULL) {
        const char *why = rule->check(given.text, given.len);
        *out = why == NULL ? 0 : *out;
        return why;
    }
    const lum_key_word *word = find_word(rule, given);
    if (word == NULL) {
        return rule->pair ? read_pair(rule, given, out)
                          : read_number(rule, given, out);
    }
    *out = word->number;
    return NULL;
}

static const char *word_of(const lum_key_rule *rule, int64_t number)
{
    const lum_key_word *word = rule->words;
    while (word != NULL && word->text != NULL) {
        if (word->number == number) {
            return word->text;
        }
        word++;
    }
    return NULL;
}

bool lum_key_rule_is_word(const lum_key_rule *rule, int64_t number)
{
    return word_of(rule, number) != NULL;
}

void lum_key_rule_add_value(const lum_key_rule *rule, int64_t number,
                            lum_key_text *text)
{
    const char *word = word_of(rule, number);
    if (word != NULL) {
        lum_key_text_add(text, word);
    } else if (rule->pair) {
        lum_key_text_add(text, "[");
        lum_key_text_add_number(text, LUM_KEY_PAIR_LOW(number), 0);
        lum_key_text_add(text, ", ");
        lum_key_text_add_number(text, LUM_KEY_PAIR_HIGH(number), 0);
        lum_key_text_add(text, "]");
    } else {
        lum_key_text_add_number(text, number, rule->decimals);
    }
}

static void add_unit(const lum_key_rule *rule, lum_key_text *text)
{
    if (rule->unit != NULL) {
        lum_key_text_add(text, " ");
        lum_key_text_add(text, rule->unit);
    }
}

static void add_numbers(const lum_key_rule *rule, lum_key_text *text)
{
    if (rule->allowed != NULL) {
        lum_key_text_add(text, rule->allowed);
        return;
    }
    if (rule->min == 1 && !rule->whole) {
        lum_key_text_add(text, "above 0, at most ");
    } else {
        lum_key_text_add_number(text, rule->min, rule->decimals);
        lum_key_text_add(text, " to ");
    }
    lum_key_text_add_number(text, rule->max, rule->decimals);
    add_unit(rule, text);
}

void lum_key_rule_add_allowed(const lum_key_rule *rule, lum_key_text *text)
{
    for (const lum_key_word *w = rule->words; w != NULL && w->text != NULL;
         w++) {
        lum_key_text_add(text, w != rule->words ? " or " : "");
        lum_key_text_add(text, w->text);
    }
    if (lum_key_rule_takes_numbers(rule)) {
        lum_key_text_add(text, rule->words != NULL ? ", or " : "");
        add_numbers(rule, text);
    }
}
