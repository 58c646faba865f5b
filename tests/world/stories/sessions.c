/* A session with a sensor that answers as it should not. */
#include "bench.h"
#include "made_up.h"

#include <stdlib.h>
#include <string.h>

#define LINE_US 2500

/* Of a data packet: angles, and words. */
enum {
    TAG_ANGLES = 2,
    TAG_WORDS = 3
};

static void put(uint8_t *to, uint32_t value, unsigned bytes)
{
    for (unsigned i = 0; i < bytes; i++) {
        to[i] = (uint8_t)(value >> 8 * i);
    }
}

/* samples: 4 bytes each, with what is in them. */
static void send_group(made_up *self, const made_up_packet *packet,
                       unsigned tag, unsigned line, uint32_t clock_us,
                       unsigned first, unsigned samples, uint32_t sample)
{
    static const uint8_t magic[8] = {0xed, 0xfe, 0xf3, 0xa1,
                                     0xef, 0xbe, 0x34, 0x12};
    uint8_t bytes[24 + 4 * 334] = {0};
    memcpy(bytes, magic, sizeof magic);
    bytes[8] = MADE_UP_HEARTBEAT; /* data has the type of heartbeats */
    bytes[12] = (uint8_t)tag;
    put(bytes + 14, line, 2);
    put(bytes + 16, samples, 2);
    put(bytes + 18, first, 2);
    put(bytes + 20, clock_us, 4);
    for (unsigned i = 0; i < samples; i++) {
        put(bytes + 24 + (size_t)4 * i, sample, 4);
    }
    made_up_send_bytes(self, packet, bytes, 24 + (size_t)4 * samples);
}

/* A line that looks straight ahead, with a return in pixel 5. */
static void send_line(made_up *self, const made_up_packet *packet,
                      unsigned line, uint32_t clock_us)
{
    const uint32_t word = 1000u << 12 | 1024u | 5u;
    send_group(self, packet, TAG_ANGLES, line, clock_us, 0, 334, 0);
    send_group(self, packet, TAG_ANGLES, line, clock_us, 334, 334, 0);
    send_group(self, packet, TAG_ANGLES, line, clock_us, 668, 332, 0);
    send_group(self, packet, TAG_WORDS, line, clock_us, 0, 1, word);
}

/* What a story wants of it. */
typedef struct wishes {
    unsigned refusals;  /* of laser on, for want of a heartbeat */
    char mute;          /* no answer to this command; 0: to all */
    bool has_no_status; /* in answers */
    bool has_no_data;
    bool has_a_lost_line;  /* a line whose number is damaged, with each */
    bool keeps_its_status; /* whatever it is told */
} wishes;

static void obey(made_up *self, const made_up_packet *packet, wishes *w)
{
    for (const made_up_packet *p = self->packets; p < packet; p++) {
        if (p->kind == MADE_UP_TLV && p->sequence == packet->sequence) {
            return; /* it was sent again */
        }
    }
    if (w->keeps_its_status) {
        return;
    }
    if (packet->text[0] == 'd') {
        self->status = MADE_UP_OFF;
    } else if (w->refusals > 0) {
        w->refusals--;
        self->status = MADE_UP_ON | MADE_UP_TIMEOUT;
    } else {
        self->status = MADE_UP_ON;
    }
}

/* A line for each heartbeat. The clock is `state`. */
static void send_data(made_up *self, const made_up_packet *packet)
{
    const wishes *w = self->facts;
    if (w->has_no_data) {
        return;
    }
    self->state += LINE_US;
    const uint32_t clock_us = (uint32_t)self->state;
    send_line(self, packet, clock_us / LINE_US % 64, clock_us);
    if (w->has_a_lost_line) {
        send_line(self, packet, 60000, clock_us + 1000);
    }
}

static void answer(made_up *self, const made_up_packet *packet)
{
    wishes *w = (wishes *)self->facts;
    if (packet->kind == MADE_UP_TLV && packet->text[0] != '\0') {
        obey(self, packet, w);
    }
    if (packet->kind == MADE_UP_TLV &&
        (w->mute == 0 || packet->text[0] != w->mute)) {
        made_up_say(self, packet, w->has_no_status ? NO_STATUS : self->status,
                    "a\033bc\n\377");
    }
}

static made_up *begin(const user_bench *b, wishes *w)
{
    made_up *m = made_up_new(b->sensor, "10.42.0.37", answer);
    m->facts = w;
    m->beat = send_data;
    m->status = MADE_UP_OFF | MADE_UP_TIMEOUT;
    return m;
}

/* By then what it answered before has been heard. */
static void until_polls(const made_up *m)
{
    const size_t enough = made_up_heard(m, MADE_UP_TLV) + 3;
    user_until(made_up_heard(m, MADE_UP_TLV) >= enough);
}

/* After a hazard its first answer to "off" has no status, and the laser is up
 * again until the second. */
static void forget_the_first_off(made_up *self, const made_up_packet *packet)
{
    const bool is_off = strcmp(packet->text, "d") == 0;
    if (packet->kind != MADE_UP_TLV) {
        return;
    }
    if (strcmp(packet->text, "u") == 0) {
        self->status = MADE_UP_ON;
    } else if (is_off && self->status == (MADE_UP_ON | MADE_UP_FAN)) {
        self->status = MADE_UP_ON;
        made_up_say(self, packet, NO_STATUS, NULL);
        return;
    } else if (is_off) {
        self->status = MADE_UP_OFF;
    }
    made_up_say(self, packet, self->status, NULL);
}

STORY(an_off_that_is_forgotten,
      "every program repeats a laser off that a later status belies")
{
    static const char *const programs[] = {
        "lumdump udp://10.42.0.37 --laser -o a.pcap",
        "lumview --no-open udp://10.42.0.37 --laser",
        "lumctl shell --heartbeat"};
    for (size_t i = 0; i < sizeof programs / sizeof programs[0]; i++) {
        const user_bench b = user_bench_new();
        wishes w = {0};
        made_up *m = made_up_new(b.sensor, "10.42.0.37", forget_the_first_off);
        m->facts = &w;
        m->beat = send_data;
        m->status = MADE_UP_OFF;
        world_file *end = NULL;
        world_writer *input = world_writer_new(&end);
        user_tool *tool = user_start_with(b.host, (user_with){.input = end},
                                          "%s", programs[i]);
        user_type(tool, input, "laser on\n");
        user_until(m->status == MADE_UP_ON);
        until_polls(m);
        m->status = MADE_UP_ON | MADE_UP_FAN;
        user_until(m->status == MADE_UP_OFF);
        user_expect_same(made_up_commands(m), "u,d,d,");
        world_writer_close(input);
        user_signal(tool, SIGINT);
        (void)user_wait(tool);
    }
}

STORY(a_laser_refused_for_want_of_a_heartbeat,
      "a laser that is refused before the first heartbeat is asked for again")
{
    const user_bench b = user_bench_new();
    wishes w = {.refusals = 3};
    made_up *m = begin(&b, &w);
    user_tool *dump = user_start(b.host, RECORD);
    user_until(m->status == MADE_UP_ON);
    until_polls(m);
    user_expect_end(dump, SIGINT, 0);
    user_expect_same(made_up_commands(m), "u,u,u,u,d,");
    user_expect_lacks(user_err(dump), "hazard");
}

STORY(a_laser_that_is_given_up, "a laser that is given up is switched off")
{
    const user_bench b = user_bench_new();
    wishes w = {.mute = 'u'};
    made_up *m = begin(&b, &w);
    user_tool *dump = user_run(b.host, RECORD " --duration 8");
    user_expect_status(dump, 0);
    user_expect_has(user_err(dump), "did not answer to laser on in 15 "
                                    "tries: it is being switched off");
    user_expect_like(made_up_texts(m), "^(u,)+(d,)+$");
    user_expect_like(made_up_commands(m), "d,d,$"); /* at once, at the end */
}

STORY(a_laser_that_cannot_be_seen,
      "a laser that cannot be seen is switched off")
{
    const user_bench b = user_bench_new();
    wishes w = {.has_no_status = true};
    made_up *m = begin(&b, &w);
    user_tool *dump = user_start(b.host, RECORD);
    user_until(made_up_tries(m, "d") > 0 && m->state > 0);
    user_expect_end(dump, SIGINT, 1);
    user_expect_has(user_err(dump), "without a status: whether it is on is not "
                                    "known, so it is being switched off");
    user_expect_like(made_up_commands(m), "^u,(d,)+$");
}

STORY(laser_off_until_it_is_answered,
      "laser off that a hazard calls for is said until it is answered")
{
    const user_bench b = user_bench_new();
    wishes w = {.mute = 'd'};
    made_up *m = begin(&b, &w);
    user_tool *dump = user_start(b.host, RECORD);
    user_until(made_up_tries(m, "u") > 0);
    until_polls(m);
    w.keeps_its_status = true;
    m->status = MADE_UP_ON | MADE_UP_FAN;
    user_until(made_up_tries(m, "d") > 7);
    w.mute = 0;
    w.keeps_its_status = false;
    user_expect_end(dump, SIGINT, 0);
    user_expect_like(made_up_texts(m), "^(u,)+(d,)+$");
    user_expect_equal(
        user_count(user_err(dump), "does not answer to laser off"), 1);
}

STORY(answers_and_no_data, "a sensor that answers and sends no data is told "
                           "from one that is not there")
{
    const user_bench b = user_bench_new();
    wishes w = {.has_no_data = true};
    made_up *m = begin(&b, &w);
    user_tool *dump = user_run(b.host, RECORD " -o c.csv");
    user_expect_status(dump, 3);
    user_expect_has(user_err(dump), "though it answers");
    user_expect_same(made_up_commands(m), "u,d,");
    user_expect_same(user_names(b.host), "");
}

STORY(points_left_out, "points that are left out are told of each output")
{
    const user_bench b = user_bench_new();
    wishes w = {.has_a_lost_line = true};
    made_up *m = begin(&b, &w);
    user_tool *dump = user_start(
        b.host, LIVE " --organized --return first --json -o raw.pcap "
                     "-o whole.csv -o f-%%d.pcd");
    user_until(m->state > 5 * LINE_US);
    user_expect_end(dump, SIGINT, 0);
    const char *got = user_out(dump);
    const double count = user_number(got, "left_out.0.no_place");
    user_expect(count > 1);
    user_expect_equal(user_length(got, "left_out"), 1);
    user_expect_same(user_value(got, "left_out.0.output"), "f-%d.pcd");
    user_expect_equal(user_count(user_err(dump), "left out"), 1);
    user_expect_has(user_err(dump),
                    user_format("warning: f-%%d.pcd: %.0f points left out, "
                                "which have no place in an organised cloud",
                                count));
}

STORY(answers_alone, "answers alone replace no recording")
{
    const user_bench b = user_bench_new();
    wishes w = {.has_no_data = true};
    made_up *m = begin(&b, &w);
    user_write_file(b.host, "keep.pcap", "old");
    for (int i = 0; i < 2; i++) {
        user_tool *dump = user_start(b.host, LIVE " -o keep.pcap");
        if (i == 0) {
            until_polls(m);
            user_signal(dump, SIGINT);
        }
        user_expect_status(dump, 3);
        user_expect_like(user_err(dump), "no data from [^ ]+ within [^ ]+ s, "
                                         "though it answers");
        user_expect_same(user_file(b.host, "keep.pcap"), "old");
        user_expect_same(user_names(b.host), "keep.pcap ");
    }
}

/* How many signals it takes, after so many before laser off is repeated. */
static void tell_long_off(unsigned before, const char *told)
{
    const user_bench b = user_bench_new();
    wishes w = {.mute = 'd'};
    made_up *m = begin(&b, &w);
    user_tool *dump =
        user_start(b.host, RECORD " -q %s", before > 0 ? "" : "--duration 0.5");
    user_until(made_up_tries(m, "u") > 0 &&
               made_up_heard(m, MADE_UP_HEARTBEAT) > 2);
    for (unsigned sent = 0; sent < before; sent++) {
        user_signal(dump, SIGINT);
        user_until(made_up_tries(m, "d") > 0);
    }
    if (told != NULL) {
        user_until(user_has(user_err(dump), "laser off is repeated"));
        user_expect_has(user_err(dump), told);
    }
    for (unsigned sent = before; sent < 2; sent++) {
        user_signal(dump, SIGINT);
        user_pause_ms(5);
    }
    user_expect_status(dump, 1);
    user_expect(user_has(user_err(dump), "laser off is repeated") ==
                (told != NULL));
    user_expect_has(user_err(dump), "laser off was not answered");
}

STORY(a_long_off_after_no_signal, "two signals end a long laser off")
{
    tell_long_off(0, "for 7 s more; Ctrl-C twice gives up\n");
}

STORY(a_long_off_after_a_signal,
      "one more ends that of a run that a signal ended")
{
    tell_long_off(1, "for 7 s more; Ctrl-C gives up\n");
}

STORY(no_long_off_after_two, "and none is begun after two")
{
    tell_long_off(2, NULL);
}

STORY(what_the_sensor_says, "what the sensor says cannot upset a terminal")
{
    const user_bench b = user_bench_new();
    wishes w = {0};
    (void)begin(&b, &w);
    user_tool *dump = user_run(b.host, LIVE " --duration 1");
    user_expect_has(user_err(dump), "says: a?bc??\n");
}

/* --- before the first data --- */

static made_up *deaf(const user_bench *b)
{
    return made_up_new(b->sensor, "10.42.0.37", made_up_silent);
}

STORY(a_signal_before_the_first_data,
      "a signal before the first data leaves all as it was")
{
    static const char *const extras[] = {"", "-q", "--json"};
    static const char *const keep[] = {"keep.csv", "keep.pcap", "keep.pcapng",
                                       "keep.ply"};
    const user_bench b = user_bench_new();
    const made_up *m = deaf(&b);
    for (size_t i = 0; i < 4; i++) {
        user_write_file(b.host, keep[i], "old");
    }
    for (size_t i = 0; i < 6; i++) {
        const size_t before = m->count;
        user_tool *dump = user_start(
            b.host,
            LIVE " -o keep.ply -o keep.csv -o keep.pcap -o keep.pcapng "
                 "-o new.pcap %s",
            extras[i % 3]);
        user_until(m->count > before);
        user_expect_equal(user_files(b.host, "", ".part"), 5);
        user_pause_between_ms(0, 1000);
        user_expect_end(dump, i < 3 ? SIGINT : SIGTERM, 3);
        user_expect_same(user_out(dump), "");
        user_expect_like(user_err(dump), "no data from 10.42.0.37 within "
                                         "[0-9.]+ s, nor any answer");
        user_expect_lacks(user_err(dump), "5517");
        user_expect_equal(user_count(user_err(dump), "\n"), 1);
        for (size_t k = 0; k < 4; k++) {
            user_expect_same(user_file(b.host, keep[k]), "old");
        }
        user_expect_same(user_names(b.host),
                         "keep.csv keep.pcap keep.pcapng keep.ply ");
    }
}

STORY(a_whole_header, "a reader gets a whole header though a signal comes "
                      "before the first data")
{
    const user_bench b = user_bench_new();
    const made_up *m = deaf(&b);
    user_tool *dump = user_start(b.host, LIVE " -o - --format pcap");
    user_until(m->count > 0);
    user_expect_end(dump, SIGINT, 3);
    user_expect_equal(user_size_out(dump), 24);
    user_expect_has(user_err(dump), "no data from 10.42.0.37");
}

STORY(a_reader_that_leaves_before_data,
      "a reader that leaves before the first data is no failure")
{
    const user_bench b = user_bench_new();
    user_with with = {0};
    world_reader *reader = world_reader_new("reader", &with.output);
    user_tool *dump = user_start_with(b.host, with, LIVE " -o - --format csv");
    user_until(user_has(user_taken(reader), "\n"));
    world_reader_close(reader);
    user_expect_status(dump, 0);
    user_expect_same(user_err(dump), "");
}

STORY(why_before_the_laser, "why no data came is told before the laser is "
                            "switched off")
{
    const user_bench b = user_bench_new();
    user_tool *dump = user_start(b.host, RECORD " -o c.csv");
    user_until(user_has(user_err(dump), "repeated for 7 s more"));
    user_expect_like(user_err(dump),
                     "^[^\n]*no data from 10.42.0.37 within 5 s, nor any "
                     "answer[^\n]*\n[^\n]*laser off is repeated for 7 s more; "
                     "Ctrl-C twice gives up\n$");
    user_signal(dump, SIGINT);
    user_pause_ms(5);
    user_signal(dump, SIGINT);
    user_expect_status(dump, 3);
    user_expect_equal(user_count(user_err(dump), "no data from"), 1);
}

/* --- strangers --- */

STORY(what_others_send, "what others send is not taken")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_host *stranger = user_host_new("stranger");
    (void)user_interface(stranger, "eth0", b.wire, "10.42.0.66/24");
    user_tool *dump = user_start(b.host, LIVE " --json -o raw.pcap");
    until_data(&b, "raw.pcap", 100000);
    const char *to = user_value(user_last(s, "heartbeat")->line, "from");
    const char *port = strchr(to, ':');
    user_expect(port != NULL);
    user_peer *other = user_peer_new(stranger, "10.42.0.66", 5517, NULL, NULL);
    for (int i = 0; i < 5; i++) {
        user_send(other, user_ip(to), (uint16_t)strtoul(port + 1, NULL, 10),
                  "junk", 4);
    }
    user_pause_ms(200);
    user_expect_end(dump, SIGINT, 0);
    const char *got = user_out(dump);
    user_expect_equal(user_number(got, "foreign_source"), 5);
    user_expect_equal(user_number(got, "stray"), 0);
    user_expect_equal(user_number(got, "foreign"), 0);
}

STORY(a_recording_grows, "a recording grows as it comes, and no further data "
                         "has to bring it to the file")
{
    const user_bench b = user_bench_new();
    wishes w = {0};
    made_up *m = begin(&b, &w);
    user_tool *dump = user_start(b.host, LIVE " -o raw.pcap");
    user_until(m->state >= (size_t)3 * LINE_US);
    w.has_no_data = true; /* 3 lines of 4 kB, and then no more */
    until_data(&b, "raw.pcap", 10000);
    (void)user_end(dump, SIGKILL);
    user_expect(user_number(summary_of(&b, "raw.pcap"), "data") > 5);
}

/* --- strangers in numbers --- */

/* Noise, only our magic, a type that no sensor has, data that contradicts
 * itself, and a full-sized packet of zeros. */
static size_t make_foreign(unsigned number, uint8_t out[1472])
{
    static const uint8_t magic[8] = {0xed, 0xfe, 0xf3, 0xa1,
                                     0xef, 0xbe, 0x34, 0x12};
    static const size_t sizes[5] = {64, 8, 200, 100, 1472};
    memset(out, 0, 1472);
    memcpy(out, magic, sizeof magic);
    if (number % 5 == 0 || number % 5 == 4) {
        memset(out, (int)(number & 0xffu), 64);
    }
    out[8] = number % 5 == 2 ? (uint8_t)(number | 0x80u) : 8;
    out[12] = 3;
    out[16] = 0xff;
    return sizes[number % 5];
}

STORY(a_flood_of_others, "a flood of others leaves good lines unharmed, and "
                         "each of them is counted")
{
    const user_bench b = user_bench_new();
    user_sensor *s = user_sensor_start(b.sensor, "--rate 4");
    world_host *stranger = user_host_new("stranger");
    (void)user_interface(stranger, "eth0", b.wire, "10.42.0.66/24");
    user_tool *dump = user_start(b.host, LIVE " --json -o a.pcap");
    until_data(&b, "a.pcap", 1000);
    user_expect_status(user_run(b.host, "lumctl laser on"), 0);
    const char *to = user_value(user_last(s, "heartbeat")->line, "from");
    const char *port = strchr(to, ':');
    user_expect(port != NULL);
    unsigned sent = 0;
    for (unsigned ms = 0; ms < 1000; ms++) {
        user_peer *from = user_peer_new(stranger, "10.42.0.66", 0, NULL, NULL);
        for (unsigned i = 0; i < 20; i++) {
            uint8_t bytes[1472];
            const size_t size = make_foreign(sent++, bytes);
            user_send(from, user_ip(to), (uint16_t)strtoul(port + 1, NULL, 10),
                      bytes, size);
        }
        user_pause_ms(1);
        user_peer_leave(from);
    }
    (void)user_end(s->tool, SIGTERM);
    user_pause_ms(300);
    user_expect_end(dump, SIGINT, 0);
    static const char *const harm[] = {
        "lost_words", "lines_skipped", "malformed", "foreign",
        "late",       "stray",         "conflict",  "kernel_drops"};
    const char *got = user_out(dump);
    user_expect_equal(user_number(got, "foreign_source"), sent);
    for (size_t i = 0; i < sizeof harm / sizeof *harm; i++) {
        user_expect_equal(user_number(got, harm[i]), 0);
    }
    user_expect(user_number(got, "words") > 10000);
    /* The sensor may have ended in the midst of a line of each eye. */
    user_expect(user_number(got, "lines_missing_angles") <= 2);
}
