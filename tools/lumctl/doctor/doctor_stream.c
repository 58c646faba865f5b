/* Judges the data that comes while the doctor has the session. */
#include "doctor.h"

#include "lum/capture/demux.h"
#include "lum/frame/framer.h"
#include "lum/wire.h"

#include "core/bytes.h"

#include <inttypes.h>
#include <stdio.h>

#define FEW 16u /* datagrams, or lines */

/* Lines of an eye that may be under way at once. */
static unsigned open_lines(void)
{
    lum_assembler_config config;
    lum_assembler_config_default(&config);
    return config.open_lines;
}

/* Only lines, without points. */
bool doctor_stream_open(struct doctor *d)
{
    const lum_framer_options options = {.struct_size = sizeof options,
                                        .layout = &d->ctl->layout,
                                        .wants = LUM_WANT_LINES};
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        d->stream.pass_over[eye] = open_lines();
    }
    return lum_framer_new(&options, &d->stream.framer, NULL) == 0 &&
           lum_framer_set_views(d->stream.framer, NULL, 0, NULL) == 0;
}

/* What was under way when the doctor began to listen is incomplete, and does
 * not prove a loss. */
static void take_line(struct doctor_stream *s, const lum_line *line)
{
    if (s->pass_over[line->eye] > 0) {
        s->pass_over[line->eye]--;
        return;
    }
    s->lines++;
    s->lines_missing_angles += line->angle_count < LUM_LINE_PIXELS ? 1u : 0u;
    s->lost_words += line->lost_words;
}

/* On the sensor's side, the port is the one that all sensors have, whatever
 * port a relay uses. */
static void take_data(struct doctor *d, const lum_received *datagram,
                      int64_t arrived_ns, unsigned eye)
{
    const uint64_t stray = d->stream.assembly.stray;
    const lum_record record = {.time_ns = arrived_ns,
                               .payload = datagram->bytes,
                               .len = datagram->len,
                               .source = d->sensor.address,
                               .source_port = LUM_PORT,
                               .kind = LUM_RECORD_DATAGRAM};
    lum_framer_event event = LUM_FRAMER_NONE;
    do {
        event = lum_framer_push(d->stream.framer, &record, NULL);
        if (event == LUM_FRAMER_LINE) {
            take_line(&d->stream, lum_framer_line(d->stream.framer));
        }
    } while (event != LUM_FRAMER_NONE && event != LUM_FRAMER_FAILED);
    d->stream.lacks_memory |= event == LUM_FRAMER_FAILED;
    lum_demux_counters counters = {.struct_size = sizeof counters};
    lum_demux_total(lum_framer_demux(d->stream.framer), &counters);
    d->stream.assembly = counters.assembly;
    if (counters.assembly.stray > stray) {
        /* If the clock jumps, the first packet is dropped here and was not lost
         * on the way. Its own line follows the open lines. */
        d->stream.pass_over[eye] = 2u * open_lines();
    }
}

/* Whether data has the clock that answers have: 32 bits of microseconds. */
static bool is_clock_of_answers(const lum_profile *profile)
{
    const lum_field *clock = &profile->group[LUM_FIELD_TIMESTAMP];
    const unsigned bits = clock->bits > 0 ? clock->bits : 8u * clock->bytes;
    return bits == 32u && profile->clock_unit_ns == 1000u;
}

void doctor_stream_take(struct doctor *d, const lum_received *datagram,
                        int64_t arrived_ns)
{
    struct doctor_stream *s = &d->stream;
    const lum_layout *layout = &d->ctl->layout;
    lum_group group;
    const lum_packet_kind kind =
        lum_packet_decode(layout, datagram->bytes, datagram->len, &group);
    s->kinds[kind]++;
    if (kind == LUM_PACKET_DATA) {
        s->has_clock = is_clock_of_answers(&layout->profile);
        s->clock_us = (uint32_t)group.clock_raw;
        s->clock_ns = arrived_ns;
        take_data(d, datagram, arrived_ns, group.eye);
    } else if (kind >= LUM_PACKET_UNKNOWN_TYPE) {
        s->odd_type = load_u32(datagram->bytes + 8);
        s->odd_len = datagram->len;
    }
}

uint64_t doctor_stream_odd(const struct doctor_stream *s)
{
    return s->kinds[LUM_PACKET_UNKNOWN_TYPE] + s->kinds[LUM_PACKET_MALFORMED] +
           s->kinds[LUM_PACKET_UNKNOWN_TAG];
}

static void fix_layout(const struct doctor *d, struct doctor_finding *out)
{
    doctor_fix(out,
               "lumdump udp://%s --laser --duration 3 -o look.pcap; lumdump "
               "look.pcap --infer -o profile.yaml    # records 3 s with the "
               "laser on, and finds the layout for --profile profile.yaml",
               session_name(d->sensor).text);
}

static void say_odd(const struct doctor *d, uint64_t odd, uint64_t good,
                    struct doctor_finding *out)
{
    const struct doctor_stream *s = &d->stream;
    doctor_wrong(out,
                 "%" PRIu64 " of %" PRIu64 " datagrams do not fit the wire "
                 "profile (%" PRIu64 " of unknown type, %" PRIu64
                 " malformed, %" PRIu64 " neither angles nor ranges; the last "
                 "is of type %" PRIu32 ", %zu bytes)",
                 odd, odd + good, s->kinds[LUM_PACKET_UNKNOWN_TYPE],
                 s->kinds[LUM_PACKET_MALFORMED],
                 s->kinds[LUM_PACKET_UNKNOWN_TAG], s->odd_type, s->odd_len);
    fix_layout(d, out);
}

void doctor_check_layout(struct doctor *d, struct doctor_finding *out)
{
    const struct doctor_stream *s = &d->stream;
    const uint64_t good = s->kinds[LUM_PACKET_DATA];
    const uint64_t odd = doctor_stream_odd(s);
    if (odd * 100u > good) {
        say_odd(d, odd, good, out);
    } else if (s->assembly.bad_words > s->assembly.words / 10u) {
        doctor_wrong(out,
                     "%" PRIu64 " range words are impossible, against %" PRIu64
                     " good ones: group.samples of the wire profile may be "
                     "another offset",
                     s->assembly.bad_words, s->assembly.words);
        fix_layout(d, out);
    } else if (s->assembly.stray > good / 2u) {
        doctor_wrong(out,
                     "the clocks of %" PRIu64 " of %" PRIu64
                     " packets jump: group.timestamp of the wire profile may "
                     "be another offset",
                     s->assembly.stray, good);
        fix_layout(d, out);
    } else if (odd > 0 || s->assembly.bad_words > 0) {
        doctor_note(out,
                    "the packets fit the wire profile, except %" PRIu64
                    " packets and %" PRIu64 " words, corrupted on their way",
                    odd, s->assembly.bad_words);
    } else {
        doctor_fine(out, "all %" PRIu64 " data packets fit the wire profile",
                    good);
    }
    if (out->result == DOCTOR_WRONG) {
        doctor_lack(d, DOCTOR_NEEDS_DATA,
                    good == 0 ? "no packet could be decoded"
                              : "the data does not fit the wire profile");
    }
}

static void say_kernel_loss(const struct doctor_stream *s,
                            struct doctor_finding *out)
{
    doctor_wrong(out,
                 "this host's kernel dropped %" PRIu64
                 " datagrams: its receive buffer was full, this program was "
                 "too slow, or they came damaged",
                 s->session.kernel_drops);
    doctor_fix_buffer(out);
}

/* A few may be under way while it is counted. */
uint64_t doctor_stream_filtered(const struct doctor *d)
{
    const struct doctor_stream *s = &d->stream;
    const uint64_t arrived = s->session.datagrams + s->session.kernel_drops;
    return s->came_in > arrived + FEW + s->came_in / 100u ? s->came_in - arrived
                                                          : 0;
}

static void say_filtered(const struct doctor *d, struct doctor_finding *out)
{
    doctor_wrong(
        out,
        "of %" PRIu64 " datagrams that came in by %s this host dropped %" PRIu64
        ", though its buffer had room: a rule of its firewall limits them",
        d->stream.came_in, d->route.interface, doctor_stream_filtered(d));
    doctor_fix_rules(d, out);
}

static void fix_wire(const struct doctor *d, struct doctor_finding *out)
{
    if (d->is_local) {
        doctor_fix(out,
                   "lumsim --address %s &    # anew, without --loss, "
                   "--reorder, --corrupt and --jitter; where it cannot keep "
                   "up, with a lower --rate",
                   doctor_place(d->sensor).text);
    } else if (d->route.interface[0] != '\0') {
        doctor_fix(out,
                   "ethtool -S %s | grep -iE 'err|drop|miss|fifo'    # "
                   "rising: sudo ethtool -G %s rx 4096, or another cable",
                   d->route.interface, d->route.interface);
    }
}

static void say_wire_loss(const struct doctor *d, struct doctor_finding *out)
{
    const struct doctor_stream *s = &d->stream;
    doctor_wrong(
        out,
        "lost %s: of %" PRIu64 " lines %" PRIu64 " without all angles, %" PRIu64
        " more whole, and %" PRIu64 " range words or more; %s: %s",
        d->is_local ? "by the simulator" : "on the wire", s->lines,
        s->lines_missing_angles, s->assembly.lines_skipped, s->lost_words,
        s->counts_drops ? "the kernel dropped none"
                        : "this system does not report what it drops",
        d->is_local ? "it was told to, or cannot keep up"
                    : "cable, switch, or the network card");
    fix_wire(d, out);
}

void doctor_check_loss(struct doctor *d, struct doctor_finding *out)
{
    const struct doctor_stream *s = &d->stream;
    const uint64_t wire =
        s->lines_missing_angles + s->lost_words + s->assembly.lines_skipped;
    if (s->session.kernel_drops > 0) {
        say_kernel_loss(s, out);
    } else if (doctor_stream_filtered(d) > 0) {
        say_filtered(d, out);
    } else if (s->lines == 0) {
        doctor_note(out, "no whole line came: too little to judge");
    } else if (s->lines >= FEW && s->lines_missing_angles == s->lines) {
        doctor_wrong(out,
                     "none of %" PRIu64
                     " lines has all its angles: nearly all packets are lost, "
                     "or group.line or group.first_sample_index of the wire "
                     "profile is another offset",
                     s->lines);
        fix_layout(d, out);
    } else if (wire > 0) {
        say_wire_loss(d, out);
    } else {
        doctor_fine(out, "%" PRIu64 " lines without a gap; the kernel %s",
                    s->lines,
                    s->counts_drops ? "dropped nothing"
                                    : "does not tell what it drops");
    }
}

void doctor_check_strangers(struct doctor *d, struct doctor_finding *out)
{
    const lum_sensor_counters *c = &d->stream.session;
    char filter[48];
    const uint64_t others = c->foreign_source - c->other_port;
    if (c->other_port > 0) {
        doctor_note(out,
                    "%" PRIu64 " datagrams came from %s, but from another port "
                    "than %u: they are dropped",
                    c->other_port, d->address, (unsigned)d->sensor.port);
    } else if (others > 0) {
        doctor_note(out,
                    "%" PRIu64 " datagrams of other senders came to this "
                    "session's port: they are dropped",
                    others);
        (void)snprintf(filter, sizeof filter, "udp and not host %s",
                       d->address);
        doctor_fix_watch(d, out, filter, "who sends them?");
    } else {
        doctor_fine(out, "only the sensor sent to this session");
    }
}
