/* The status of the simulated sensor, and its answers to commands. */
#include "device_internal.h"

#include "lum/command.h"
#include "lum/host/command_text.h"
#include "lum/host/yscan.h"
#include "lum/laser.h"
#include "lum/wire.h"

#include <stdio.h>
#include <string.h>

/* Longest piece of a received text that an answer repeats. */
#define NAME_BYTES 40u

/* Longest debug text. */
#define TEXT_BYTES 160u

/* Reserved for the text that counts refusals without their own text. */
#define LAST_TEXT_BYTES 48u

/* --- Status --- */

bool lum_device_laser_is_up(const lum_device *device)
{
    return lum_laser_is_on(device->status);
}

void lum_device_set_status(lum_device *device, uint16_t status, int64_t now_ns)
{
    const bool was_up = lum_device_laser_is_up(device);
    device->status = status;
    if (!was_up && lum_device_laser_is_up(device)) {
        device->laser_ns = now_ns;
    }
}

void lum_device_note(lum_device_effects *fx, const char *text)
{
    const size_t len = strlen(fx->note);
    (void)snprintf(fx->note + len, sizeof fx->note - len, "%s%s",
                   len > 0 ? "; " : "", text);
}

void lum_device_put_status(const lum_device *device, uint32_t sequence,
                           lum_device_effects *fx, lum_tlv_writer *writer)
{
    const uint16_t type = device->layout.profile.tlv[LUM_TLV_STATUS];
    fx->has_reply = lum_tlv_begin(writer, fx->reply, sizeof fx->reply,
                                  sequence) == LUM_OK &&
                    lum_tlv_add_u16(writer, type, device->status) == LUM_OK;
}

/* --- Commands --- */

/* An answer that is being made. */
struct answer {
    lum_device *device;
    lum_device_effects *fx;
    lum_tlv_writer writer;
    int64_t now_ns;
    unsigned unnamed; /* refusals whose text had no room */
};

/* The received bytes for a text: printable, and not too long. */
static void make_name(char out[NAME_BYTES + 4], const char *text, size_t len)
{
    const size_t n = len < NAME_BYTES ? len : NAME_BYTES;
    for (size_t i = 0; i < n; i++) {
        out[i] = text[i] >= ' ' && text[i] <= '~' ? text[i] : '?';
    }
    memcpy(out + n, len > n ? "..." : "", len > n ? 4 : 1);
}

/* False when less than spare bytes would be left. */
static bool add_debug(struct answer *a, const char *text, size_t spare)
{
    const size_t len = strlen(text);
    const size_t room = a->writer.size - a->writer.len;
    const uint16_t type = a->device->layout.profile.tlv[LUM_TLV_DEBUG];
    return room >= LUM_TLV_HEAD_BYTES + len + spare &&
           lum_tlv_add(&a->writer, type, text, (uint16_t)len) == LUM_OK;
}

/* Names the refused command in the answer, and without the reason in the
 * note. */
static void refuse(struct answer *a, const char *what, const char *why)
{
    char text[TEXT_BYTES];
    (void)snprintf(text, sizeof text, "refused %s", what);
    lum_device_note(a->fx, text);
    (void)snprintf(text, sizeof text, "refused %s: %s", what, why);
    if (a->unnamed > 0 || !add_debug(a, text, LAST_TEXT_BYTES)) {
        a->unnamed++;
    }
}

static void count_unnamed(struct answer *a)
{
    if (a->unnamed > 0) {
        char text[LAST_TEXT_BYTES - LUM_TLV_HEAD_BYTES];
        (void)snprintf(text, sizeof text, "%u more refused", a->unnamed);
        (void)add_debug(a, text, 0);
    }
}

static void switch_laser(struct answer *a, bool on)
{
    const unsigned kept = a->device->status & ~((unsigned)LUM_LASER_TLV_CMD_ON |
                                                LUM_LASER_TLV_CMD_OFF);
    lum_device_set_status(
        a->device,
        (uint16_t)(kept | (on ? LUM_LASER_TLV_CMD_ON : LUM_LASER_TLV_CMD_OFF)),
        a->now_ns);
}

static void clear_table(lum_device_settings *s)
{
    s->yscan_count = 0;
    memset(s->yscan, 0, sizeof s->yscan);
}

static void set_lines(lum_device_settings *s, uint16_t value)
{
    s->lines = value == 0 ? 640 : 64;
    clear_table(s);
}

static void set_fov(lum_device_settings *s, uint16_t value)
{
    s->fov_deg = value;
    clear_table(s);
}

static void set_value(lum_device_settings *s, const lum_command *command)
{
    const uint16_t value = command->value;
    switch (command->id) {
    case LUM_COMMAND_POWER:
        s->power = value;
        break;
    case LUM_COMMAND_THRESHOLD_GREEN:
        s->threshold[LUM_EYE_GREEN] = value;
        break;
    case LUM_COMMAND_THRESHOLD_BLUE:
        s->threshold[LUM_EYE_BLUE] = value;
        break;
    case LUM_COMMAND_LINE_MODE:
        set_lines(s, value);
        break;
    case LUM_COMMAND_YSCAN:
        set_fov(s, value);
        break;
    case LUM_COMMAND_HOLDOFF:
        s->holdoff = value;
        break;
    case LUM_COMMAND_OFFSET_GREEN:
        s->offset[LUM_EYE_GREEN] = value;
        break;
    case LUM_COMMAND_OFFSET_BLUE:
        s->offset[LUM_EYE_BLUE] = value;
        break;
    case LUM_COMMAND_LASER_ON:
    case LUM_COMMAND_LASER_OFF:
    case LUM_COMMANDS:
    default: /* no setting */
        break;
    }
}

static void refuse_unheard(struct answer *a, const char *text)
{
    char why[80];
    (void)snprintf(why, sizeof why,
                   "no heartbeat; send one first, and then %.3g a second",
                   1000.0 / LUM_HEARTBEAT_MS);
    refuse(a, text, why);
}

static void carry_out(struct answer *a, const lum_command *command)
{
    char text[LUM_COMMAND_TEXT_BYTES + 1];
    size_t len = 0;
    const lum_result result = lum_command_format(command, text, &len);
    text[result == LUM_OK ? len : 0] = '\0';
    const bool on = command->id == LUM_COMMAND_LASER_ON;
    if (on && !a->device->is_streaming) {
        refuse_unheard(a, text);
        return;
    }
    if (on || command->id == LUM_COMMAND_LASER_OFF) {
        switch_laser(a, on);
    } else {
        set_value(&a->device->settings, command);
    }
    lum_device_note(a->fx, text);
}

/* The command that ends in a letter and takes values. */
static const lum_command_spec *find_spec(char letter)
{
    for (unsigned i = 0; i < LUM_COMMANDS; i++) {
        if (lum_command_specs[i].letter == letter) {
            return &lum_command_specs[i];
        }
    }
    return NULL;
}

static void refuse_command(struct answer *a, const char *text, size_t len,
                           lum_result result)
{
    char name[NAME_BYTES + 4];
    char why[64] = "not a command";
    const lum_command_spec *spec = find_spec(text[len - 1]);
    make_name(name, text, len);
    if (result == LUM_E_VALUE && spec != NULL) {
        const int n =
            snprintf(why, sizeof why, "%c takes %u to %u", spec->letter,
                     (unsigned)spec->min, (unsigned)spec->max);
        if (spec->step > 1 && n > 0) {
            (void)snprintf(why + n, sizeof why - (size_t)n, " in steps of %u",
                           (unsigned)spec->step);
        }
    }
    refuse(a, name, why);
}

static void refuse_rest(struct answer *a, const char *text, size_t len)
{
    char name[NAME_BYTES + 4];
    char what[NAME_BYTES + 6];
    make_name(name, text, len);
    (void)snprintf(what, sizeof what, "\"%s\"", name);
    refuse(a, what, "separate commands by one space, with none at the ends");
}

/* Each command of a text is handled separately, as long as the text can be
 * split into commands. */
static void take_text(struct answer *a, const char *text, size_t len)
{
    if (len == 0) {
        lum_device_note(a->fx, "empty command text");
    }
    while (len > 0) {
        lum_command command;
        const lum_result result = lum_command_parse(&text, &len, &command);
        if (result == LUM_OK) {
            carry_out(a, &command);
            continue;
        }
        const char *space = memchr(text, ' ', len);
        const size_t n = space != NULL ? (size_t)(space - text) : len;
        if (n == 0 || n + 1 == len) {
            refuse_rest(a, text, len);
            return;
        }
        refuse_command(a, text, n, result);
        const size_t step = n < len ? n + 1 : n;
        text += step;
        len -= step;
    }
}

/* --- Tables --- */

static bool turns(const int16_t *v, size_t n)
{
    bool falls = false;
    bool rises = false;
    for (size_t i = 1; i < n; i++) {
        falls = falls || v[i] < v[i - 1];
        rises = rises || v[i] > v[i - 1];
    }
    return falls && rises;
}

static void take_table(struct answer *a, const lum_tlv *tlv)
{
    lum_device_settings *s = &a->device->settings;
    int16_t table[LUM_DEVICE_YSCAN_MAX];
    char text[TEXT_BYTES];
    size_t n = tlv->length / 2u;
    const lum_result result =
        lum_yscan_decode(tlv, table, LUM_DEVICE_YSCAN_MAX, &n);
    if (result == LUM_E_MALFORMED) {
        refuse(a, "Y-scan table", "odd length, an elevation has 2 bytes");
    } else if (result != LUM_OK || n != s->lines) {
        (void)snprintf(text, sizeof text,
                       "%u elevations, %u lines need one each", (unsigned)n,
                       (unsigned)s->lines);
        refuse(a, "Y-scan table", text);
    } else if (turns(table, n)) {
        refuse(a, "Y-scan table", "it turns; elevations must fall or rise");
    } else {
        memcpy(s->yscan, table, n * sizeof table[0]);
        s->yscan_count = n;
        (void)snprintf(text, sizeof text, "Y-scan table of %u", (unsigned)n);
        lum_device_note(a->fx, text);
    }
}

static void take_tlv(struct answer *a, const lum_tlv *tlv)
{
    const uint16_t *types = a->device->layout.profile.tlv;
    if (tlv->type == types[LUM_TLV_COMMAND]) {
        take_text(a, (const char *)tlv->value, tlv->length);
    } else if (tlv->type == types[LUM_TLV_YSCAN]) {
        take_table(a, tlv);
    } else {
        char text[48];
        (void)snprintf(text, sizeof text, "passed over TLV %u",
                       (unsigned)tlv->type);
        lum_device_note(a->fx, text);
    }
}

static void take_tlvs(struct answer *a, lum_tlv_reader *reader, size_t len)
{
    lum_tlv tlv;
    lum_result result = LUM_OK;
    if (reader->left == 0) {
        lum_device_note(a->fx, "status poll");
    }
    size_t at = len - reader->left;
    while ((result = lum_tlv_next(reader, &tlv)) == LUM_OK) {
        take_tlv(a, &tlv);
        at = len - reader->left;
    }
    if (result == LUM_E_MALFORMED) {
        char text[TEXT_BYTES];
        a->device->malformed++;
        (void)snprintf(
            text, sizeof text,
            "the %u bytes from byte %u on do not hold the TLV that they begin",
            (unsigned)(len - at), (unsigned)at);
        refuse(a, "malformed TLV", text);
    }
}

void lum_device_answer(lum_device *device, int64_t now_ns, const void *bytes,
                       size_t len, lum_device_effects *out)
{
    struct answer a = {.device = device, .fx = out, .now_ns = now_ns};
    lum_tlv_writer again;
    lum_tlv_reader reader;
    uint32_t sequence = 0;
    if (lum_tlv_open(bytes, len, &sequence, &reader) != LUM_OK) {
        device->malformed++;
        lum_device_note(out, "malformed TLV packet");
        return;
    }
    lum_device_put_status(device, sequence, out, &a.writer);
    take_tlvs(&a, &reader, len);
    count_unnamed(&a);
    out->reply_len = a.writer.len;
    lum_device_put_status(device, sequence, out, &again);
}
