#include "device_internal.h"

#include "lum/host/laser_name.h"
#include "lum/laser.h"
#include "lum/wire.h"

#include <stdio.h>
#include <string.h>

/* Bits that commands and heartbeats set; hardware faults set the others. */
#define OWN_BITS                                                               \
    (LUM_LASER_HEARTBEAT_TIMEOUT | LUM_LASER_TLV_CMD_OFF | LUM_LASER_TLV_CMD_ON)

/* Strength of the returns at the moment the laser comes up. */
#define COLD_GAIN 0.1f

#define UDEG 1000000

/* What can change, to tell what did. */
struct before {
    lum_device_settings settings;
    lum_device_peer client;
    uint16_t status;
    bool was_up;
    bool was_streaming;
};

void lum_device_init(lum_device *out, const lum_layout *layout, uint16_t lines,
                     uint16_t status, uint32_t clock_us, int64_t now_ns)
{
    memset(out, 0, sizeof *out);
    out->layout = *layout;
    out->settings.power = 100;
    out->settings.holdoff = 200;
    out->settings.lines = lines;
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        out->settings.threshold[eye] = 50;
    }
    out->status = (uint16_t)(status & ~(unsigned)LUM_LASER_TLV_CMD_ON);
    out->heartbeat_ns = now_ns;
    out->boot_ns = now_ns - (int64_t)clock_us * 1000;
}

uint32_t lum_device_clock_us(const lum_device *device, int64_t now_ns)
{
    return (uint32_t)lum_device_since_boot_us(device, now_ns);
}

int64_t lum_device_since_boot_us(const lum_device *device, int64_t now_ns)
{
    return (now_ns - device->boot_ns) / 1000;
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

static void let_time_pass(lum_device *device, int64_t now_ns,
                          lum_device_effects *out)
{
    if (now_ns < lum_device_next_ns(device)) {
        return;
    }
    const bool was_on = (device->status & LUM_LASER_TLV_CMD_ON) != 0;
    const unsigned kept = device->status & ~(unsigned)LUM_LASER_TLV_CMD_ON;
    device->is_streaming = false;
    lum_device_set_status(
        device,
        (uint16_t)(kept | LUM_LASER_HEARTBEAT_TIMEOUT |
                   (was_on ? (unsigned)LUM_LASER_TLV_CMD_OFF : 0)),
        now_ns);
    lum_device_note(out, "heartbeat timeout");
}

/* An alert, when there is someone to hear it. */
static void alert(const lum_device *device, lum_device_effects *out)
{
    if (out->status_changed && device->has_client) {
        lum_tlv_writer writer;
        lum_device_put_status(device, 0, out, &writer);
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
            lum_device_note(fx, text);
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
    lum_device_set_status(device, (uint16_t)status, now_ns);
    tell_changes(device, &before, out);
    alert(device, out);
}

static void receive_set_ip(lum_device *device, const void *bytes, size_t len,
                           lum_device_effects *out)
{
    char text[48];
    uint32_t address = 0;
    if (lum_set_ip_decode(&device->layout, bytes, len, &address) != LUM_OK) {
        device->malformed++;
        lum_device_note(out, "malformed set IP packet");
        return;
    }
    const bool is_fine = lum_address_is_host(address);
    (void)snprintf(
        text, sizeof text, "%sset IP %u.%u.%u.%u", is_fine ? "" : "refused ",
        (unsigned)(address >> 24), (unsigned)(address >> 16 & 0xffu),
        (unsigned)(address >> 8 & 0xffu), (unsigned)(address & 0xffu));
    lum_device_note(out, text);
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
        lum_device_note(out, "malformed timestamp packet");
        return;
    }
    t.clock_us = lum_device_clock_us(device, now_ns);
    lum_timestamp_encode(out->reply, &t);
    out->reply_len = LUM_TIMESTAMP_BYTES;
    out->has_reply = true;
    lum_device_note(out, "timestamp");
}

static void receive_heartbeat(lum_device *device, int64_t now_ns,
                              lum_device_peer from, lum_device_effects *out)
{
    device->client = from;
    device->has_client = true;
    device->is_streaming = true;
    device->heartbeat_ns = now_ns;
    lum_device_set_status(
        device,
        (uint16_t)(device->status & ~(unsigned)LUM_LASER_HEARTBEAT_TIMEOUT),
        now_ns);
    lum_device_note(out, "heartbeat");
}

static void ignore(lum_device *device, const char *what,
                   lum_device_effects *out)
{
    device->ignored++;
    lum_device_note(out, what);
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
        lum_device_answer(device, now_ns, bytes, len, out);
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

/* --- Where its lines point --- */

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
