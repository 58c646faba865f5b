/* The counters of a run: their names, their meanings, and their sums over all
 * sensors, as the reports print them. */
#include "summary.h"

#include <stddef.h>
#include <string.h>

/* --- The counters by name --- */

/* Where a number is. */
#define IN_PACKETS(field)     NULL, false, offsetof(lum_demux_counters, field)
#define IN_FRAMES(field)      NULL, true, offsetof(lum_framer_counters, field)
#define PART_OF(whole, field) whole, true, offsetof(lum_framer_counters, field)

/* In the order of the reports. */
static const struct {
    enum summary_group group;
    const char *key;
    const char *meaning;
    const char *of;
    bool is_of_frames; /* else of packets */
    size_t at;
} counters[] = {
    {SUMMARY_PACKETS, "data", "data", IN_PACKETS(packets[LUM_PACKET_DATA])},
    {SUMMARY_PACKETS, "angle_packets", "angle packets",
     IN_PACKETS(angle_packets)},
    {SUMMARY_PACKETS, "range_packets", "range packets",
     IN_PACKETS(range_packets)},
    {SUMMARY_PACKETS, "heartbeat", "heartbeat",
     IN_PACKETS(packets[LUM_PACKET_HEARTBEAT])},
    {SUMMARY_PACKETS, "set_ip", "set IP",
     IN_PACKETS(packets[LUM_PACKET_SET_IP])},
    {SUMMARY_PACKETS, "timestamp", "timestamp",
     IN_PACKETS(packets[LUM_PACKET_TIMESTAMP])},
    {SUMMARY_PACKETS, "tlv", "TLV", IN_PACKETS(packets[LUM_PACKET_TLV])},
    {SUMMARY_PACKETS, "joined",
     "of all packets: came joined, and were taken apart", IN_PACKETS(joined)},
    {SUMMARY_CONTENT, "frames", "frames", IN_PACKETS(assembly.frames)},
    {SUMMARY_CONTENT, "frames_selected", "of them: --frames selects these",
     IN_FRAMES(frames)},
    {SUMMARY_CONTENT, "lines", "lines", IN_PACKETS(assembly.lines)},
    {SUMMARY_CONTENT, "lines_blue", "lines of the blue eye",
     IN_FRAMES(lines[LUM_EYE_BLUE])},
    {SUMMARY_CONTENT, "lines_green", "lines of the green eye",
     IN_FRAMES(lines[LUM_EYE_GREEN])},
    {SUMMARY_CONTENT, "words", "range words, of rising and falling edges",
     IN_PACKETS(assembly.words)},
    {SUMMARY_CONTENT, "points", "points", IN_FRAMES(points)},
    {SUMMARY_LOSSES, "lost_words", "range words lost on the way, at least",
     IN_PACKETS(assembly.lost_words)},
    {SUMMARY_LOSSES, "lines_missing_angles", "lines that lack angles",
     IN_PACKETS(assembly.lines_missing_angles)},
    {SUMMARY_LOSSES, "lines_skipped", "line numbers that never came",
     IN_PACKETS(assembly.lines_skipped)},
    {SUMMARY_LOSSES, "lines_missing",
     "lines that frames lack, as their numbers show", IN_FRAMES(lines_missing)},
    {SUMMARY_LOSSES, "lines_in_pauses",
     "lines missing in pauses, but for lines_skipped",
     IN_FRAMES(lines_in_pauses)},
    {SUMMARY_LOSSES, "pauses", "times that no lines came", IN_FRAMES(pauses)},
    {SUMMARY_LOSSES, "lines_cut", "lines beyond the most that a frame has",
     IN_FRAMES(lines_cut)},
    {SUMMARY_LOSSES, "no_angle", "words whose pixel has no angles",
     IN_FRAMES(losses.no_angle)},
    {SUMMARY_LOSSES, "no_range", "words without a range above zero",
     IN_FRAMES(losses.no_range)},
    {SUMMARY_LOSSES, "bad_words", "words with an impossible bit or pixel",
     IN_PACKETS(assembly.bad_words)},
    {SUMMARY_LOSSES, "late", "packets of lines already closed",
     IN_PACKETS(assembly.late)},
    {SUMMARY_LOSSES, "duplicate", "packets that came again",
     IN_PACKETS(assembly.duplicate)},
    {SUMMARY_LOSSES, "conflict", "packets that contradict others",
     IN_PACKETS(assembly.conflict)},
    {SUMMARY_LOSSES, "no_room", "packets with more words than a line holds",
     IN_PACKETS(assembly.no_room)},
    {SUMMARY_LOSSES, "stray", "packets far from the stream's clock",
     IN_PACKETS(assembly.stray)},
    {SUMMARY_LOSSES, "out_of_order",
     "packets too far out of order by their times", IN_PACKETS(out_of_order)},
    {SUMMARY_LOSSES, "malformed", "packets with impossible lengths or fields",
     IN_PACKETS(packets[LUM_PACKET_MALFORMED])},
    {SUMMARY_LOSSES, "unknown_tag", "data packets, neither angles nor ranges",
     IN_PACKETS(packets[LUM_PACKET_UNKNOWN_TAG])},
    {SUMMARY_LOSSES, "unknown_type", "packets of an unknown type",
     IN_PACKETS(packets[LUM_PACKET_UNKNOWN_TYPE])},
    {SUMMARY_LOSSES, "cut_short", "datagrams the capture holds in part",
     IN_PACKETS(cut_short)},
    {SUMMARY_LOSSES, "foreign",
     "datagrams on the sensor's port without our magic",
     IN_PACKETS(packets[LUM_PACKET_FOREIGN])},
    {SUMMARY_LOSSES, "other", "records that are not ours", IN_PACKETS(other)},
    {SUMMARY_UNDER_WAY, "lines_under_way",
     "of lines_missing_angles: cut by the stream's begin or end, not lost",
     PART_OF("lines_missing_angles", under_way.lines)},
    {SUMMARY_UNDER_WAY, "words_under_way", "of lost_words: the same",
     PART_OF("lost_words", under_way.words)},
    {SUMMARY_UNDER_WAY, "no_angle_under_way", "of no_angle: the same",
     PART_OF("no_angle", under_way.no_angle)},
    {SUMMARY_UNDER_WAY, "missing_under_way",
     "of lines_missing: of the frames that were cut so",
     PART_OF("lines_missing", missing_under_way)},
    {SUMMARY_LOSSES, "stray_at_breaks",
     "of stray: they began again after a pause",
     PART_OF("stray", stray_at_breaks)},
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

bool summary_shows(const struct summary *s, size_t sensor)
{
    return lum_demux_is_requested(lum_framer_demux(s->framer), sensor);
}

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
