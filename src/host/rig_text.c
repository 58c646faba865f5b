#include "rig_text.h"

#include "lum/host/rig.h"

#include <stdbool.h>

/* The first addresses beyond those of hosts: multicast. */
#define ADDRESS_END UINT32_C(0xe0000000)

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static bool is_one_of(char c, const char *others)
{
    while (*others != '\0' && *others != c) {
        others++;
    }
    return *others != '\0';
}

/* Letters, digits and some others, a letter first. */
static const char *check_word(const char *text, size_t len, size_t size,
                              const char *others)
{
    if (len == 0 || !is_letter(text[0])) {
        return "does not begin with a letter";
    }
    for (size_t i = 0; i < len; i++) {
        if (!is_letter(text[i]) && !is_digit(text[i]) &&
            !is_one_of(text[i], others)) {
            return "has another character";
        }
    }
    return len < size ? NULL : "is too long";
}

const char *lum_rig_check_frame(const char *text, size_t len)
{
    return check_word(text, len, LUM_RIG_FRAME_BYTES, "_-./");
}

const char *lum_rig_check_name(const char *text, size_t len)
{
    return check_word(text, len, LUM_RIG_NAME_BYTES, "_");
}

static const char *check_length(size_t len, size_t size)
{
    if (len == 0) {
        return "is empty";
    }
    return len < size ? NULL : "is too long";
}

/* Those of a capture are of these alone. */
const char *lum_rig_check_interface(const char *text, size_t len)
{
    for (size_t i = 0; i < len; i++) {
        if (text[i] <= ' ' || text[i] > '~') {
            return "has another character";
        }
    }
    return check_length(len, LUM_RIG_INTERFACE_BYTES);
}

const char *lum_rig_check_path(const char *text, size_t len)
{
    if (len == 1 && text[0] == '-') {
        return "is standard input, which is no file";
    }
    for (size_t i = 0; i < len; i++) {
        const unsigned char c = (unsigned char)text[i];
        if (c < 0x20 || c == 0x7f) {
            return "has a control character";
        }
    }
    return check_length(len, LUM_RIG_PATH_BYTES);
}

const char *lum_rig_check_list(const char *text, size_t len)
{
    (void)text;
    (void)len;
    return "is no list";
}

/* Takes a number of 0 to 255, without zeros before it. */
static bool take_byte(const char **p, const char *end, uint32_t *address)
{
    const char *const from = *p;
    uint32_t value = 0;
    while (*p < end && is_digit(**p) && value < 256u) {
        value = value * 10u + (uint32_t)(**p - '0');
        (*p)++;
    }
    *address = *address << 8 | value;
    return *p > from && value < 256u && (*p == from + 1 || *from != '0');
}

static bool take_dot(const char **p, const char *end)
{
    if (*p < end && **p == '.') {
        (*p)++;
        return true;
    }
    return false;
}

/* Returns where the address ends; NULL: it is none. */
static const char *take_address(const char *text, size_t len, uint32_t *out)
{
    const char *p = text;
    const char *const end = text + len;
    *out = 0;
    bool is_fine = take_byte(&p, end, out);
    for (unsigned i = 1; i < 4u && is_fine; i++) {
        is_fine = take_dot(&p, end) && take_byte(&p, end, out);
    }
    return is_fine ? p : NULL;
}

const char *lum_rig_check_address(const char *text, size_t len)
{
    uint32_t address = 0;
    const char *const end = text + len;
    const char *const at = take_address(text, len, &address);
    if (at == NULL || (at < end && *at != '%')) {
        return "is not an IPv4 address";
    }
    if (address == 0 || address >= ADDRESS_END) {
        return "is no sensor's address";
    }
    if (at < end &&
        lum_rig_check_interface(at + 1, (size_t)(end - at - 1)) != NULL) {
        return "has no interface behind its '%'";
    }
    return NULL;
}

const char *lum_rig_take_address(const char *text, size_t len, uint32_t *out)
{
    const char *const at = take_address(text, len, out);
    return at < text + len ? at + 1 : at;
}
