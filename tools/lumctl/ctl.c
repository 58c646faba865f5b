#include "ctl.h"

#include "ctl_session.h"
#include "remember.h"

#include "lum/base/time.h"
#include "lum/laser.h"

#include <stdio.h>
#include <string.h>

static void put_packet(struct ctl *ctl, const char *hex)
{
    if (!ctl->has_packets) {
        ctl->has_packets = true;
        json_begin_line(&ctl->packets, stdout);
        json_open_array(&ctl->packets, "packets");
    }
    json_text(&ctl->packets, NULL, hex);
}

enum exit_status ctl_print_packet(struct ctl *ctl, const void *bytes,
                                  size_t len)
{
    char hex[2u * LUM_SENSOR_REQUEST_BYTES + 1u];
    const unsigned char *p = bytes;
    hex[0] = '\0';
    for (size_t i = 0; i < len && i < LUM_SENSOR_REQUEST_BYTES; i++) {
        (void)snprintf(hex + 2u * i, 3, "%02x", p[i]);
    }
    if (ctl->options.json) {
        put_packet(ctl, hex);
    } else {
        (void)puts(hex);
    }
    return EXIT_DONE;
}

void ctl_end_packets(struct ctl *ctl)
{
    if (ctl->has_packets) {
        ctl->has_packets = false;
        json_close_array(&ctl->packets);
        json_end_line(&ctl->packets);
    }
}

static enum exit_status complain_length(size_t len)
{
    return ctl_complain(
        EXIT_BAD, "%u bytes do not fit one packet, which holds %u",
        (unsigned)len,
        (unsigned)(LUM_SENSOR_REQUEST_BYTES - LUM_TLV_PACKET_BYTES));
}

static enum exit_status print_request(struct ctl *ctl, const void *tlvs,
                                      size_t len)
{
    uint8_t packet[LUM_SENSOR_REQUEST_BYTES];
    lum_tlv_writer writer;
    if (len > sizeof packet - LUM_TLV_PACKET_BYTES ||
        lum_tlv_begin(&writer, packet, sizeof packet,
                      ctl->options.requests.sequence) != LUM_OK) {
        return complain_length(len);
    }
    if (len > 0) {
        (void)memcpy(packet + writer.len, tlvs, len);
    }
    return ctl_print_packet(ctl, packet, writer.len + len);
}

enum exit_status ctl_request(struct ctl *ctl, const void *tlvs, size_t len,
                             struct ctl_answer *out, bool *was_sent)
{
    return ctl_request_text(ctl, NULL, tlvs, len, out, was_sent);
}

enum exit_status ctl_request_text(struct ctl *ctl, const char *text,
                                  const void *tlvs, size_t len,
                                  struct ctl_answer *out, bool *was_sent)
{
    lum_sensor_event event;
    *was_sent = !ctl->options.dry_run;
    if (ctl->options.dry_run) {
        return print_request(ctl, tlvs, len);
    }
    enum exit_status status = ctl_open(ctl, false);
    if (status != EXIT_DONE) {
        return status;
    }
    if (ctl->changes.begun_ns == 0) {
        ctl->changes.begun_ns = lum_time_utc_ns();
    }
    if ((text != NULL ? session_command(ctl, text)
                      : session_request(ctl, tlvs, len)) != LUM_OK) {
        return complain_length(len);
    }
    status = session_finish(ctl, &event);
    if (status == EXIT_DONE) {
        session_read_answer(ctl, &event, out);
    }
    remember_request(ctl, tlvs, len, status == EXIT_DONE ? out : NULL);
    return status;
}
