#include "device.h"

#include "lum/command.h"
#include "lum/laser.h"
#include "lum/wire.h"

#include <stdio.h>
#include <string.h>

/* Bits that commands and heartbeats own; faults of the hardware have the rest.
 */
#define OWN_BITS                                                               \
    (LUM_LASER_HEARTBEAT_TIMEOUT | LUM_LASER_TLV_CMD_OFF | LUM_LASER_TLV_CMD_ON)

/* Strength of the returns at the moment the laser comes up. */
#define COLD_GAIN 0.1f

/* Longest piece of what was received that a text repeats. */
#define NAME_BYTES 40u

/* Longest debug text. */
#define TEXT_BYTES 160u

/* Kept free for the text that counts what was refused without a text. */
#define LAST_TEXT_BYTES 48u

#define UDEG 1000000

/* An answer that is being made. */
struct answer {
    lum_device *device;
    lum_device_effects *fx;
    lum_tlv_writer writer;
    int64_t now_ns;
    unsigned unnamed; /* refusals whose text had no room */
};

/* What can change, to tell what did. */
struct before {
    lum_device_settings settings;
    lum_device_peer client;
    uint16_t status;
    bool was_up;
    bool was_streaming;
};

void lum_device_init(lum_device *out, const lum_layout *layout, uint16_t lines,
                     uint32_t clock_us, int64_t now_ns)
{
    memset(out, 0, sizeof *out);
    out->layout = *layout;
    out->settings.power = 100;
    out->settings.holdoff = 200;
    out->settings.lines = lines;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        out->settings.threshold[eye] = 50;
    }
    out->status = LUM_LASER_HEARTBEAT_TIMEOUT | LUM_LASER_TLV_CMD_OFF;
    out->boot_ns = now_ns - (int64_t)clock_us * 1000;
}

uint32_t lum_device_clock_us(const lum_device *device, int64_t now_ns)
{
    return (uint32_t)((now_ns - device->boot_ns) / 1000);
}

bool lum_device_laser_is_up(const lum_device *device)
{
    return (device->status & LUM_LASER_TLV_CMD_ON) != 0 &&
           !lum_laser_is_down(device->status);
}

float lum_device_gain(const lum_device *device, int64_t now_ns)
{
    if (!lum_device_laser_is_up(device)) {
        return 0.0f;
    }
    const float power = (float)device->settings.power / 100.0f;
    const int64_t age_ns = now_ns - device->laser_ns;
    if (age_ns >= LUM_DEVICE_WARM_UP_NS) {
        return power;
    }
    const float warm = (float)age_ns / (float)LUM_DEVICE_WARM_UP_NS;
    return power * (COLD_GAIN + (1.0f - COLD_GAIN) * warm);
}

int64_t lum_device_next_ns(const lum_device *device)
{
    return (device->status & LUM_LASER_HEARTBEAT_TIMEOUT) != 0
               ? INT64_MAX
               : device->heartbeat_ns + LUM_DEVICE_TIMEOUT_NS;
}

/* --- what changed --- */

static void set_status(lum_device *device, uint16_t status, int64_t now_ns)
{
    const bool was_up = lum_device_laser_is_up(device);
    device->status = status;
    if (!was_up && lum_device_laser_is_up(device)) {
        device->laser_ns = now_ns;
    }
}

static struct before remember(const lum_device *device)
{
    const struct before before = {.settings = device->settings,
                                  .client = device->client,
                                  .status = device->status,
                                  .was_up = lum_device_laser_is_up(device),
                                  .was_streaming = device->is_streaming};
    return before;
}

static bool is_same_peer(lum_device_peer a, lum_device_peer b)
{
    return a.address == b.address && a.port == b.port;
}

static bool is_same_geometry(const lum_device_settings *a,
                             const lum_device_settings *b)
{
    return a->lines == b->lines && a->fov_deg == b->fov_deg &&
           a->yscan_count == b->yscan_count &&
           memcmp(a->yscan, b->yscan, a->yscan_count * sizeof a->yscan[0]) == 0;
}

static bool is_same_tuning(const lum_device_settings *a,
                           const lum_device_settings *b)
{
    return a->power == b->power && a->holdoff == b->holdoff &&
           memcmp(a->threshold, b->threshold, sizeof a->threshold) == 0 &&
           memcmp(a->offset, b->offset, sizeof a->offset) == 0;
}

static void tell_changes(const lum_device *device, const struct before *before,
                         lum_device_effects *out)
{
    const lum_device_settings *s = &device->settings;
    out->geometry_changed = !is_same_geometry(&before->settings, s);
    out->settings_changed =
        out->geometry_changed || !is_same_tuning(&before->settings, s);
    out->status_changed = device->status != before->status;
    out->laser_changed = lum_device_laser_is_up(device) != before->was_up;
    out->streaming_changed =
        device->is_streaming != before->was_streaming ||
        (device->is_streaming && !is_same_peer(device->client, before->client));
}

/* One more piece of the note, cut where it has to be. */
static void add_note(lum_device_effects *fx, const char *text)
{
    const size_t len = strlen(fx->note);
    (void)snprintf(fx->note + len, sizeof fx->note - len, "%s%s",
                   len > 0 ? "; " : "", text);
}

/* What was received, fit for a text: printable, and not too long. */
static void make_name(char out[NAME_BYTES + 4], const char *text, size_t len)
{
    const size_t n = len < NAME_BYTES ? len : NAME_BYTES;
    for (size_t i = 0; i < n; i++) {
        out[i] = text[i] >= ' ' && text[i] <= '~' ? text[i] : '?';
    }
    memcpy(out + n, len > n ? "..." : "", len > n ? 4 : 1);
}

/* --- time and hazards --- */

static void let_time_pass(lum_device *device, int64_t now_ns,
                          lum_device_effects *out)
{
    if (now_ns < lum_device_next_ns(device)) {
        return;
    }
    const unsigned kept = device->status & ~(unsigned)LUM_LASER_TLV_CMD_ON;
    device->is_streaming = false;
    set_status(
        device,
        (uint16_t)(kept | LUM_LASER_HEARTBEAT_TIMEOUT | LUM_LASER_TLV_CMD_OFF),
        now_ns);
    add_note(out, "heartbeat timeout");
}

/* Also writes the head of an answer that has more again. */
static void put_status(const lum_device *device, uint32_t sequence,
                       lum_device_effects *fx, lum_tlv_writer *writer)
{
    const uint16_t type = device->layout.profile.tlv[LUM_TLV_STATUS];
    fx->has_reply = lum_tlv_begin(writer, fx->reply, sizeof fx->reply,
                                  sequence) == LUM_OK &&
                    lum_tlv_add_u16(writer, type, device->status) == LUM_OK;
}

/* An alert, when there is someone to hear it. */
static void alert(const lum_device *device, lum_device_effects *out)
{
    if (out->status_changed && device->has_client) {
        lum_tlv_writer writer;
        put_status(device, 0, out, &writer);
        out->reply_len = writer.len;
    }
}

void lum_device_tick(lum_device *device, int64_t now_ns,
                     lum_device_effects *out)
{
    const struct before before = remember(device);
    memset(out, 0, sizeof *out);
    let_time_pass(device, now_ns, out);
    tell_changes(device, &before, out);
    alert(device, out);
}

static void note_bits(lum_device_effects *fx, unsigned bits, const char *what)
{
    for (unsigned bit = 0; bit < LUM_LASER_BITS; bit++) {
        if ((bits >> bit & 1u) != 0) {
            char text[48];
            (void)snprintf(text, sizeof text, "%s %s", lum_laser_bit_name(bit),
                           what);
            add_note(fx, text);
        }
    }
}

void lum_device_set_hazards(lum_device *device, uint16_t set, uint16_t clear,
                            int64_t now_ns, lum_device_effects *out)
{
    const struct before before = remember(device);
    memset(out, 0, sizeof *out);
    let_time_pass(device, now_ns, out);
    const unsigned status = (device->status & ~(clear & ~(unsigned)OWN_BITS)) |
                            (set & ~(unsigned)OWN_BITS);
    note_bits(out, status & ~(unsigned)device->status, "set");
    note_bits(out, device->status & ~status, "cleared");
    set_status(device, (uint16_t)status, now_ns);
    tell_changes(device, &before, out);
    alert(device, out);
}

/* --- TLV packets --- */

/* False when less than spare bytes would be left. */
static bool add_debug(struct answer *a, const char *text, size_t spare)
{
    const size_t len = strlen(text);
    const size_t room = a->writer.size - a->writer.len;
    const uint16_t type = a->device->layout.profile.tlv[LUM_TLV_DEBUG];
    return room >= LUM_TLV_HEAD_BYTES + len + spare &&
           lum_tlv_add(&a->writer, type, text, (uint16_t)len) == LUM_OK;
}

/* Names what was refused in the answer, and in the note without the reason. */
static void refuse(struct answer *a, const char *what, const char *why)
{
    char text[TEXT_BYTES];
    (void)snprintf(text, sizeof text, "refused %s", what);
    add_note(a->fx, text);
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
    set_status(
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
    uint16_t *const plain[LUM_COMMANDS] = {
        [LUM_COMMAND_POWER] = &s->power,
        [LUM_COMMAND_THRESHOLD_GREEN] = &s->threshold[LUM_EYE_GREEN],
        [LUM_COMMAND_THRESHOLD_BLUE] = &s->threshold[LUM_EYE_BLUE],
        [LUM_COMMAND_HOLDOFF] = &s->holdoff,
        [LUM_COMMAND_OFFSET_GREEN] = &s->offset[LUM_EYE_GREEN],
        [LUM_COMMAND_OFFSET_BLUE] = &s->offset[LUM_EYE_BLUE],
    };
    if (command->id == LUM_COMMAND_LINE_MODE) {
        set_lines(s, command->value);
    } else if (command->id == LUM_COMMAND_YSCAN) {
        set_fov(s, command->value);
    } else if (plain[command->id] != NULL) {
        *plain[command->id] = command->value;
    }
}

static void carry_out(struct answer *a, const lum_command *command)
{
    char text[LUM_COMMAND_TEXT_BYTES + 1];
    size_t len = 0;
    const lum_result result = lum_command_format(command, text, &len);
    text[result == LUM_OK ? len : 0] = '\0';
    const bool on = command->id == LUM_COMMAND_LASER_ON;
    if (on && (a->device->status & LUM_LASER_HEARTBEAT_TIMEOUT) != 0) {
        refuse(a, text, "no heartbeat; send one first, and then 5 a second");
        return;
    }
    if (on || command->id == LUM_COMMAND_LASER_OFF) {
        switch_laser(a, on);
    } else {
        set_value(&a->device->settings, command);
    }
    add_note(a->fx, text);
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
    refuse(a, what, "one space parts commands, none stands at the ends");
}

/* Every command of a text stands for itself, as long as the text can be cut
 * into commands. */
static void take_text(struct answer *a, const char *text, size_t len)
{
    if (len == 0) {
        add_note(a->fx, "empty command text");
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
        add_note(a->fx, text);
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
        add_note(a->fx, text);
    }
}

static void take_tlvs(struct answer *a, lum_tlv_reader *reader, size_t len)
{
    lum_tlv tlv;
    lum_result result = LUM_OK;
    if (reader->left == 0) {
        add_note(a->fx, "status poll");
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

static void receive_tlv(lum_device *device, int64_t now_ns, const void *bytes,
                        size_t len, lum_device_effects *out)
{
    struct answer a = {.device = device, .fx = out, .now_ns = now_ns};
    lum_tlv_writer again;
    lum_tlv_reader reader;
    uint32_t sequence = 0;
    if (lum_tlv_open(bytes, len, &sequence, &reader) != LUM_OK) {
        device->malformed++;
        add_note(out, "malformed TLV packet");
        return;
    }
    put_status(device, sequence, out, &a.writer);
    take_tlvs(&a, &reader, len);
    count_unnamed(&a);
    out->reply_len = a.writer.len;
    put_status(device, sequence, out, &again);
}

/* --- the other packets --- */

static void receive_set_ip(lum_device *device, const void *bytes, size_t len,
                           lum_device_effects *out)
{
    uint8_t packet[LUM_SET_IP_BYTES];
    char text[48];
    uint32_t address = 0;
    if (lum_set_ip_decode(&device->layout, bytes, len, &address) != LUM_OK) {
        device->malformed++;
        add_note(out, "malformed set IP packet");
        return;
    }
    const bool is_fine =
        lum_set_ip_encode(packet, &device->layout, address) == LUM_OK;
    (void)snprintf(
        text, sizeof text, "%sset IP %u.%u.%u.%u", is_fine ? "" : "refused ",
        (unsigned)(address >> 24), (unsigned)(address >> 16 & 0xffu),
        (unsigned)(address >> 8 & 0xffu), (unsigned)(address & 0xffu));
    add_note(out, text);
    device->malformed += is_fine ? 0 : 1;
    out->has_address = is_fine;
    out->address = is_fine ? address : 0;
}

static void receive_timestamp(lum_device *device, int64_t now_ns,
                              const void *bytes, size_t len,
                              lum_device_effects *out)
{
    lum_timestamp t;
    if (lum_timestamp_decode(bytes, len, &t) != LUM_OK) {
        device->malformed++;
        add_note(out, "malformed timestamp packet");
        return;
    }
    t.clock_us = lum_device_clock_us(device, now_ns);
    lum_timestamp_encode(out->reply, &t);
    out->reply_len = LUM_TIMESTAMP_BYTES;
    out->has_reply = true;
    add_note(out, "timestamp");
}

static void receive_heartbeat(lum_device *device, int64_t now_ns,
                              lum_device_peer from, lum_device_effects *out)
{
    device->client = from;
    device->has_client = true;
    device->is_streaming = true;
    device->heartbeat_ns = now_ns;
    set_status(
        device,
        (uint16_t)(device->status & ~(unsigned)LUM_LASER_HEARTBEAT_TIMEOUT),
        now_ns);
    add_note(out, "heartbeat");
}

static void ignore(lum_device *device, const char *what,
                   lum_device_effects *out)
{
    device->ignored++;
    add_note(out, what);
}

static void receive(lum_device *device, int64_t now_ns, lum_device_peer from,
                    const void *bytes, size_t len, lum_device_effects *out)
{
    uint8_t type = 0;
    const lum_result result = lum_header_decode(bytes, len, &type);
    if (result == LUM_E_FOREIGN) {
        ignore(device, "ignored: no magic", out);
    } else if (result != LUM_OK) {
        ignore(device, "ignored: reserved bytes set", out);
    } else if (type == LUM_TYPE_SET_IP) {
        receive_set_ip(device, bytes, len, out);
    } else if (type == LUM_TYPE_TIMESTAMP) {
        receive_timestamp(device, now_ns, bytes, len, out);
    } else if (type == LUM_TYPE_TLV) {
        receive_tlv(device, now_ns, bytes, len, out);
    } else if (type == LUM_TYPE_HEARTBEAT && len == LUM_HEARTBEAT_BYTES) {
        receive_heartbeat(device, now_ns, from, out);
    } else {
        ignore(device,
               type == LUM_TYPE_HEARTBEAT ? "ignored: data"
                                          : "ignored: unknown type",
               out);
    }
}

void lum_device_receive(lum_device *device, int64_t now_ns,
                        lum_device_peer from, const void *bytes, size_t len,
                        lum_device_effects *out)
{
    const struct before before = remember(device);
    memset(out, 0, sizeof *out);
    let_time_pass(device, now_ns, out);
    receive(device, now_ns, from, bytes, len, out);
    tell_changes(device, &before, out);
}

/* --- where the lines lie --- */

/* Of a line of the uniform scan, in the middle of its share. */
static int64_t uniform_udeg(const lum_device_settings *s, size_t line)
{
    const int64_t fov = (int64_t)s->fov_deg * UDEG;
    return fov / 2 - fov * (2 * (int64_t)line + 1) / (2 * (int64_t)s->lines);
}

static int64_t raw_udeg(const lum_layout *layout,
                        const lum_eye_calibration *eye, int16_t raw)
{
    const int64_t low = eye->elevation_min_udeg;
    const int64_t high = eye->elevation_max_udeg;
    const int64_t lsb = (int64_t)layout->profile.angle_lsb_pdeg;
    const int64_t center = (low + high) / 2;
    return lsb > 0 ? center + raw * lsb / UDEG
                   : center + raw * (high - low) / 65536;
}

bool lum_device_elevations(const lum_device_settings *settings,
                           const lum_layout *layout,
                           const lum_eye_calibration *eye, int32_t *out_udeg)
{
    const bool has_table = settings->yscan_count > 0;
    if (!has_table && settings->fov_deg == 0) {
        return false;
    }
    for (size_t i = 0; i < settings->lines; i++) {
        int64_t udeg = has_table ? raw_udeg(layout, eye, settings->yscan[i])
                                 : uniform_udeg(settings, i);
        udeg = udeg < eye->elevation_min_udeg ? eye->elevation_min_udeg : udeg;
        udeg = udeg > eye->elevation_max_udeg ? eye->elevation_max_udeg : udeg;
        out_udeg[i] = (int32_t)udeg;
    }
    return true;
}
