/* The counters of a run, in one table for text and JSON: names, meanings, and
 * sums over all sensors. A new counter goes here. */
#include "summary.h"

#include <stddef.h>
#include <string.h>

/* --- The counters by name --- */

/* Where a number is: in the counters of packets, of lines, or of frames. */
#define PACKETS(field) NULL, false, offsetof(lum_demux_counters, field)
#define LINES(field)   PACKETS(assembly.field)
#define FRAMES(field)  NULL, true, offsetof(lum_framer_counters, field)

#define PART(loss, field) loss, true, offsetof(lum_framer_counters, field)

/* The groups. */
#define KIND      SUMMARY_PACKETS
#define CONTENT   SUMMARY_CONTENT
#define LOSS      SUMMARY_LOSSES
#define UNDER_WAY SUMMARY_UNDER_WAY

/* In the order of the reports. */
static const struct {
    enum summary_group group;
    const char *key;
    const char *meaning;
    const char *of;
    bool is_of_frames; /* else of packets */
    size_t at;
} counters[] = {
    {KIND, "data", "data", PACKETS(packets[LUM_PACKET_DATA])},
    {KIND, "angle_packets", "angle packets", PACKETS(angle_packets)},
    {KIND, "range_packets", "range packets", PACKETS(range_packets)},
    {KIND, "heartbeat", "heartbeat", PACKETS(packets[LUM_PACKET_HEARTBEAT])},
    {KIND, "set_ip", "set IP", PACKETS(packets[LUM_PACKET_SET_IP])},
    {KIND, "timestamp", "timestamp", PACKETS(packets[LUM_PACKET_TIMESTAMP])},
    {KIND, "tlv", "TLV", PACKETS(packets[LUM_PACKET_TLV])},
    {KIND, "joined", "of all packets: came joined, and were split",
     PACKETS(joined)},
    {CONTENT, "frames", "frames", LINES(frames)},
    {CONTENT, "frames_selected", "of them: --frames selects these",
     FRAMES(frames)},
    {CONTENT, "lines", "lines", LINES(lines)},
    {CONTENT, "lines_blue", "lines of the blue eye",
     FRAMES(lines[LUM_EYE_BLUE])},
    {CONTENT, "lines_green", "lines of the green eye",
     FRAMES(lines[LUM_EYE_GREEN])},
    {CONTENT, "words", "range words, of rising and falling edges",
     LINES(words)},
    {CONTENT, "points", "points", FRAMES(points)},
    {LOSS, "lost_words", "range words lost on the way, at least",
     LINES(lost_words)},
    {LOSS, "lines_missing_angles", "lines that lack angles",
     LINES(lines_missing_angles)},
    {LOSS, "lines_skipped", "line numbers that never came",
     LINES(lines_skipped)},
    {LOSS, "lines_missing", "lines that frames lack, as their numbers show",
     FRAMES(lines_missing)},
    {LOSS, "lines_in_pauses", "lines missing in pauses, without lines_skipped",
     FRAMES(lines_in_pauses)},
    {LOSS, "pauses", "times that no lines came", FRAMES(pauses)},
    {LOSS, "lines_cut", "lines beyond the most that a frame has",
     FRAMES(lines_cut)},
    {LOSS, "no_angle", "words whose pixel has no angles",
     FRAMES(losses.no_angle)},
    {LOSS, "no_range", "words without a range above zero",
     FRAMES(losses.no_range)},
    {LOSS, "bad_words", "words with an impossible bit or pixel",
     LINES(bad_words)},
    {LOSS, "late", "packets of lines already closed", LINES(late)},
    {LOSS, "duplicate", "packets that came again", LINES(duplicate)},
    {LOSS, "conflict", "packets that contradict others", LINES(conflict)},
    {LOSS, "no_room", "packets with more words than a line holds",
     LINES(no_room)},
    {LOSS, "stray", "packets far from the stream's clock", LINES(stray)},
    {LOSS, "out_of_order", "packets too far out of order by their times",
     PACKETS(out_of_order)},
    {LOSS, "malformed", "packets with impossible lengths or fields",
     PACKETS(packets[LUM_PACKET_MALFORMED])},
    {LOSS, "unknown_tag", "data packets, neither angles nor ranges",
     PACKETS(packets[LUM_PACKET_UNKNOWN_TAG])},
    {LOSS, "unknown_type", "packets of an unknown type",
     PACKETS(packets[LUM_PACKET_UNKNOWN_TYPE])},
    {LOSS, "cut_short", "datagrams the capture holds in part",
     PACKETS(cut_short)},
    {LOSS, "foreign", "datagrams on the sensor's port without our magic",
     PACKETS(packets[LUM_PACKET_FOREIGN])},
    {LOSS, "other", "records that are not ours", PACKETS(other)},
    {UNDER_WAY, "lines_under_way",
     "of lines_missing_angles: cut by the stream's start or end, not lost",
     PART("lines_missing_angles", under_way.lines)},
    {UNDER_WAY, "words_under_way", "of lost_words: the same",
     PART("lost_words", under_way.words)},
    {UNDER_WAY, "no_angle_under_way", "of no_angle: the same",
     PART("no_angle", under_way.no_angle)},
    {UNDER_WAY, "missing_under_way",
     "of lines_missing: of the frames that were cut so",
     PART("lines_missing", missing_under_way)},
    {LOSS, "stray_at_breaks", "of stray: they began again after a pause",
     PART("stray", stray_at_breaks)},
};

/* Where there is no room for all, and for five more that a report adds, this
 * does not compile. */
#define COUNTERS (sizeof counters / sizeof counters[0])
#define ROOM                                                                   \
    (sizeof((struct summary_rows *)NULL)->list / sizeof(struct summary_row))
typedef char every_counter_has_room[COUNTERS + 5u <= ROOM ? 1 : -1];

void summary_list(const lum_demux_counters *packets,
                  const lum_framer_counters *frames, struct summary_rows *out)
{
    for (size_t i = 0; i < COUNTERS; i++) {
        struct summary_row *row = &out->list[i];
        const char *from = counters[i].is_of_frames ? (const char *)frames
                                                    : (const char *)packets;
        *row = (struct summary_row){counters[i].group, counters[i].key,
                                    counters[i].meaning, counters[i].of, 0};
        memcpy(&row->value, from + counters[i].at, sizeof row->value);
    }
    out->count = COUNTERS;
}

/* --- Sums over the sensors --- */

lum_framer_counters summary_count_sensor(const struct summary *s, size_t i)
{
    lum_framer_counters c = {.struct_size = sizeof c};
    (void)lum_framer_count(s->framer, i, &c);
    if (s->whole.asked != 0) {
        c.frames = i == s->whole.sensor ? s->whole.frames : 0;
        c.points = i == s->whole.sensor ? s->whole.points : 0;
    }
    return c;
}

/* Whole numbers stand from the lines on, and the rate alone among them. Else
 * this does not compile, and a counter would be in no total. */
#define NUMBERS_AT offsetof(lum_framer_counters, lines)
#define RATE_AT    offsetof(lum_framer_counters, frames_per_second)
typedef char every_number_is_added
    [(sizeof(lum_framer_counters) - NUMBERS_AT) % sizeof(uint64_t) == 0 &&
             (RATE_AT - NUMBERS_AT) % sizeof(uint64_t) == 0 &&
             sizeof(double) == sizeof(uint64_t)
         ? 1
         : -1];

static void add_numbers(lum_framer_counters *to,
                        const lum_framer_counters *more)
{
    for (size_t at = NUMBERS_AT; at < sizeof *to; at += sizeof(uint64_t)) {
        uint64_t sum = 0;
        uint64_t number = 0;
        if (at == RATE_AT) {
            continue;
        }
        memcpy(&sum, (const char *)to + at, sizeof sum);
        memcpy(&number, (const char *)more + at, sizeof number);
        sum += number;
        memcpy((char *)to + at, &sum, sizeof sum);
    }
}

lum_framer_counters summary_count(const struct summary *s)
{
    lum_framer_counters total = {.struct_size = sizeof total};
    for (size_t i = 0; i < LUM_DEMUX_SENSORS_MAX; i++) {
        const lum_framer_counters c = summary_count_sensor(s, i);
        add_numbers(&total, &c);
        total.frames_per_second += c.frames_per_second;
    }
    return total;
}

lum_demux_counters summary_count_packets(const struct summary *s)
{
    lum_demux_counters total = {.struct_size = sizeof total};
    lum_demux_total(lum_framer_demux(s->framer), &total);
    return total;
}

bool summary_find_clock(const struct summary *s, size_t sensor,
                        lum_clock_fit_info *out)
{
    const lum_clock_fit *clock = lum_framer_clock(s->framer, sensor);
    out->struct_size = sizeof *out;
    return clock != NULL && lum_clock_fit_get_info(clock, out) == LUM_OK;
}

lum_clock_fit_info summary_count_clocks(const struct summary *s)
{
    const size_t n = lum_demux_sensor_count(lum_framer_demux(s->framer));
    lum_clock_fit_info total = {.struct_size = sizeof total};
    for (size_t i = 0; i < n; i++) {
        lum_clock_fit_info clock;
        if (summary_find_clock(s, i, &clock)) {
            total.sensor_breaks += clock.sensor_breaks;
            total.host_steps += clock.host_steps;
            total.still += clock.still;
        }
    }
    return total;
}

/* --- The rest of a report's numbers --- */

uint64_t summary_damaged(const struct summary *s, lum_error *why)
{
    return s->capture != NULL ? lum_capture_damaged(s->capture, why) : 0;
}

double summary_seconds(const struct summary *s)
{
    return s->span.is_known
               ? (double)(s->span.last_ns - s->span.first_ns) * 1e-9
               : 0.0;
}
