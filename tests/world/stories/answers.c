/* lumctl's words, against a sensor whose answers are lost, late, repeated,
 * foreign or wrong. */
#include "help.h"
#include "made_up.h"

#include <string.h>

#define SENSOR "10.42.0.37"

STORY(no_answer, "no answer is exit status 3, after the tries asked for")
{
    const user_bench b = user_bench_new();
    const made_up *m = made_up_new(b.sensor, SENSOR, made_up_silent);
    user_tool *power =
        user_run(b.host, "lumctl power 50 --timeout 60 --retries 2");
    user_expect_status(power, NO_ANSWER);
    user_expect_has(user_err(power), "lumctl --host " SENSOR " doctor");
    user_expect_same(user_out(power), "");
    user_expect_same(made_up_texts(m), "50p,50p,50p,");
    user_expect_equal(made_up_sequences(m, MADE_UP_TLV), 1);
    power = user_run(b.host, "lumctl power 50 --timeout 60 --interface eth0");
    user_expect_status(power, NO_ANSWER);
    user_expect_has(user_err(power),
                    "lumctl --host " SENSOR " --interface eth0 doctor");
    user_tool *time = user_run(b.host, "lumctl time --timeout 60 --retries 2");
    user_expect_status(time, NO_ANSWER);
    user_expect_at_least(made_up_heard(m, MADE_UP_TIME), 3);
    user_expect_equal(made_up_sequences(m, MADE_UP_TIME), 3);
}

static void answer_third(made_up *self, const made_up_packet *packet)
{
    if (packet->before == 2) {
        made_up_plain(self, packet);
    }
}

STORY(a_lost_answer, "a lost answer is asked for again")
{
    const user_bench b = user_bench_new();
    (void)made_up_new(b.sensor, SENSOR, answer_third);
    user_tool *power = user_run(b.host, "lumctl power 50 --json");
    user_expect_status(power, DONE);
    expect_value(power, "tries", "3");
}

static void answer_others(made_up *self, const made_up_packet *packet)
{
    static const uint32_t away[] = {1, UINT32_MAX, 0x80000000u};
    for (size_t i = 0; i < sizeof away / sizeof *away; i++) {
        made_up_send(self, packet, packet->sequence + away[i], 0x0900, NULL);
    }
}

STORY(answers_of_other_numbers, "answers to others' sequences do not count")
{
    const user_bench b = user_bench_new();
    (void)made_up_new(b.sensor, SENSOR, answer_others);
    user_expect_status(
        user_run(b.host, "lumctl power 50 --timeout 60 --retries 1"),
        NO_ANSWER);
}

static void answer_as_if_its_own(made_up *self, const made_up_packet *packet)
{
    made_up_send(self, packet, 0xefbeadde, 0x0800, NULL);
    made_up_send(self, packet, 0, 0x0800, NULL);
}

STORY(answers_of_its_own_count,
      "a sensor that answers with sequences of its own answers nobody")
{
    const user_bench b = user_bench_new();
    (void)made_up_new(b.sensor, SENSOR, answer_as_if_its_own);
    user_expect_status(
        user_run(b.host, "lumctl --timeout 100 --retries 2 power 50"),
        NO_ANSWER);
}

static void answer_twice(made_up *self, const made_up_packet *packet)
{
    const uint32_t clock_us = 1000u * (uint32_t)packet->before;
    self->delay_ns = 20 * WORLD_MS;
    made_up_send_time(self, packet, clock_us);
    self->delay_ns = 40 * WORLD_MS; /* when the next question is under way */
    made_up_send_time(self, packet, clock_us);
}

STORY(an_answer_before_the_question,
      "a late answer to an earlier request is not believed")
{
    const user_bench b = user_bench_new();
    (void)made_up_new(b.sensor, SENSOR, answer_twice);
    user_tool *time = user_run(b.host, "lumctl time --json");
    user_expect_status(time, DONE);
    expect_value(time, "exchanges", "8");
    user_expect(user_number(user_out(time), "round_trip_min_ms") >= 20);
}

static void refuse_a_field(made_up *self, const made_up_packet *packet)
{
    made_up_say(self, packet, MADE_UP_OFF, "cannot: 15y");
}

STORY(a_command_that_is_named, "a command that the answer names is refused")
{
    const user_bench b = user_bench_new();
    (void)made_up_new(b.sensor, SENSOR, refuse_a_field);
    user_tool *plain = user_run(b.host, "lumctl send '50p 15y'");
    user_expect_status(plain, FAILED);
    user_expect_has(user_err(plain), "'15y'");
    user_expect_has(user_out(plain), "cannot: 15y");
    user_tool *json = user_run(b.host, "lumctl send '50p 15y' --json");
    user_expect_status(json, FAILED);
    expect_value(json, "done", "false");
    expect_value(json, "refused", "15y");
    user_tool *others = user_run(b.host, "lumctl send '50p 5g'");
    user_expect_status(others, FAILED);
    user_expect_has(user_err(others), "cannot: 15y");
}

/* What a sensor says, in up to two texts, and what is made of it. */
typedef struct saying {
    const char *said, *said_too;
    int status;
    const char *refused, *told;
} saying;

static void say_it(made_up *self, const made_up_packet *packet)
{
    const saying *s = self->facts;
    uint8_t bytes[200] = {0};
    memcpy(bytes, packet->bytes, 16);
    memcpy(bytes + 16, "\2\0\2\0\0\2", 6);
    size_t size = 22;
    const char *const texts[] = {s->said, s->said_too};
    for (size_t i = 0; i < 2 && texts[i] != NULL; i++) {
        bytes[size] = 3;
        bytes[size + 2] = (uint8_t)strlen(texts[i]);
        memcpy(bytes + size + 4, texts[i], strlen(texts[i]));
        size += 4 + strlen(texts[i]);
    }
    made_up_send_bytes(self, packet, bytes, size);
}

STORY(a_refusal_need_not_name_anything,
      "a refusal is told from a confirmation, whatever it names")
{
    static const saying sayings[] = {
        {"3 more refused", NULL, FAILED, "", "3 more refused"},
        {"Invalid command", NULL, FAILED, "", "Invalid command"},
        {"50p", NULL, FAILED, "50p", "refused '50p'; the others are done"},
        {"50p: limit is 40", NULL, FAILED, "50p", "limit is 40"},
        {"50p not set", NULL, FAILED, "50p", "50p not set"},
        {"refused 50p: hot", "2 more refused", FAILED, "50p", "'50p' and more"},
        {"50p set to the limit, 40", NULL, FAILED, "50p", "the limit, 40"},
        {"50p: setpoint is 40", NULL, FAILED, "50p", "setpoint is 40"},
        {"50p set", NULL, DONE, "", ""},
        {"50p ok", "5g refused", FAILED, "5g", "'5g'; the others"},
        {"a cool day", NULL, DONE, "", ""},
    };
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, SENSOR, say_it);
    for (size_t i = 0; i < sizeof sayings / sizeof *sayings; i++) {
        m->facts = &sayings[i];
        user_tool *send = user_run(b.host, "lumctl send '50p 5g' --json");
        user_expect_status(send, sayings[i].status);
        expect_value(send, "done",
                     sayings[i].status == DONE ? "true" : "false");
        expect_value(send, "refused", sayings[i].refused);
        user_expect_has(user_err(send), sayings[i].told);
    }
}

STORY(raw_text_for_the_laser,
      "raw text for the laser is done when the answer shows it")
{
    static const struct {
        const char *text;
        int status, end;
    } cases[] = {
        {"u", MADE_UP_ON | MADE_UP_FAN, HAZARD},
        {"u", MADE_UP_OFF, FAILED},
        {"u", NO_STATUS, FAILED},
        {"50p u", MADE_UP_ON, DONE},
        {"d", MADE_UP_ON, FAILED},
        {"d", NO_STATUS, FAILED},
        {"u d", MADE_UP_OFF, DONE},
        {"50p", MADE_UP_ON | MADE_UP_FAN, DONE},
    };
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        m->status = cases[i].status;
        user_tool *send =
            user_run(b.host, "lumctl send '%s' --json", cases[i].text);
        user_expect_status(send, cases[i].end);
        expect_value(send, "done", cases[i].end == DONE ? "true" : "false");
    }
}

static void hide_off_under_a_hazard(made_up *self, const made_up_packet *packet)
{
    if (strcmp(packet->text, "d") != 0) {
        made_up_say(self, packet, MADE_UP_ON | MADE_UP_FAN, NULL);
    }
}

STORY(a_laser_on_that_cannot_be_taken_back,
      "a laser on that cannot be taken back is told")
{
    static const char *const commands[] = {"lumctl laser on", "lumctl send u"};
    const user_bench b = user_bench_new();
    for (size_t i = 0; i < 2; i++) {
        made_up *m = made_up_new(b.sensor, SENSOR, hide_off_under_a_hazard);
        user_tool *on = user_run(b.host, "%s", commands[i]);
        user_expect_status(on, HAZARD);
        user_expect_has(user_err(on), "NOT cancelled");
        user_expect_has(user_err(on), "MAY BE ON or come on by itself");
        user_expect_lacks(user_err(on), "it will not come up");
        user_expect_like(made_up_texts(m), "^u,(d,)+$");
        user_peer_leave(m->peer);
        user_pause_ms(1);
    }
}

STORY(a_d_that_changes_nothing, "a d that changes nothing takes nothing back")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    m->status = MADE_UP_ON | MADE_UP_FAN;
    user_tool *on = user_run(b.host, "lumctl laser on");
    user_expect_status(on, HAZARD);
    user_expect_has(user_err(on), "IS STILL IN EFFECT");
    user_tool *raw = user_run(b.host, "lumctl send u --json");
    user_expect_status(raw, HAZARD);
    expect_value(raw, "taken_back", "false");
}

static void keep_u_to_itself(made_up *self, const made_up_packet *packet)
{
    if (strcmp(packet->text, "u") == 0) {
        self->status = MADE_UP_ON;
        return;
    }
    self->status = strcmp(packet->text, "d") == 0 ? MADE_UP_OFF : self->status;
    made_up_plain(self, packet);
}

STORY(a_laser_on_without_an_answer,
      "a laser on that the sensor got, and whose answers were lost, is taken "
      "back")
{
    const user_bench b = user_bench_new();
    const made_up *m = made_up_new(b.sensor, SENSOR, keep_u_to_itself);
    user_tool *on =
        user_run(b.host, "lumctl laser on --timeout 60 --retries 1");
    user_expect_status(on, NO_ANSWER);
    user_expect_has(user_err(on), "cancelled: it will not come up by itself");
    user_expect_like(made_up_texts(m), "^u,u,d,");
    user_expect_same(made_up_commands(m), "u,d,");
    user_expect_equal(m->status, MADE_UP_OFF);
}

STORY(a_signal_during_laser_on,
      "a signal does not keep a laser on from being taken back")
{
    const user_bench b = user_bench_new();
    const made_up *m = made_up_new(b.sensor, SENSOR, keep_u_to_itself);
    user_tool *on = user_start(b.host, "lumctl laser on --timeout 20000");
    user_until(made_up_tries(m, "u") > 0);
    user_expect_end(on, SIGINT, -SIGINT);
    user_expect_same(made_up_commands(m), "u,d,");
    user_expect_has(user_err(on), "cancelled");
    user_expect_equal(m->status, MADE_UP_OFF);
}

static void refuse_what_is_on(made_up *self, const made_up_packet *packet)
{
    made_up_say(self, packet, MADE_UP_ON, "refused u");
}

STORY(a_laser_that_is_on_is_called_on,
      "a laser that is on is called on, whatever was refused")
{
    const user_bench b = user_bench_new();
    (void)made_up_new(b.sensor, SENSOR, refuse_what_is_on);
    user_tool *on = user_run(b.host, "lumctl laser on");
    user_expect_status(on, FAILED);
    user_expect_has(user_out(on), "laser on sent; laser up");
}

static void answer_each_second(made_up *self, const made_up_packet *packet)
{
    if (packet->before % 2 == 1) {
        made_up_plain(self, packet);
    }
}

STORY(a_round_trip_of_two_tries,
      "a round trip is not known when the request was sent twice")
{
    static const char *const commands[] = {"status", "power 50"};
    const user_bench b = user_bench_new();
    (void)made_up_new(b.sensor, SENSOR, answer_each_second);
    for (size_t i = 0; i < 2; i++) {
        user_tool *tool = user_run(b.host, "lumctl %s --json", commands[i]);
        user_expect_status(tool, DONE);
        expect_value(tool, "tries", "2");
        expect_value(tool, "round_trip_ms", "null");
    }
    user_tool *plain = user_run(b.host, "lumctl status");
    user_expect_status(plain, DONE);
    user_expect_lacks(user_out(plain), "round trip");
}

STORY(a_second_signal_during_laser_off,
      "a second signal does not cut a laser off short whose answer comes")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    m->delay_ns = 100 * WORLD_MS;
    user_tool *off = user_start(b.host, "lumctl laser off");
    user_until(made_up_tries(m, "d") > 0);
    user_signal(off, SIGINT);
    user_pause_between_ms(0, 90);
    user_signal(off, SIGTERM);
    user_expect_status(off, DONE);
}

static void answer_in_the_ninth_second(made_up *self,
                                       const made_up_packet *packet)
{
    if (packet->t_ns - self->packets[0].t_ns > 8 * WORLD_S) {
        made_up_plain(self, packet);
    }
}

STORY(
    laser_off_goes_on_for_ten_seconds,
    "laser off is repeated often and for ten seconds: what comes in the ninth "
    "does it")
{
    const user_bench b = user_bench_new();
    const made_up *m =
        made_up_new(b.sensor, SENSOR, answer_in_the_ninth_second);
    user_expect_status(
        user_run(b.host, "lumctl laser off --timeout 60 --retries 0"), DONE);
    user_expect_at_least(made_up_tries(m, "d"), 21);
    user_expect_like(made_up_texts(m), "^(d,)+$");
}

STORY(a_laser_off_that_is_given_up,
      "a second signal ends a laser off that goes on, and it says so")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, SENSOR, made_up_silent);
    const int64_t begin = world_now();
    user_tool *full = user_run(b.host, "lumctl laser off");
    user_expect_status(full, NO_ANSWER);
    user_expect_has(user_err(full), "MAY BE ON");
    const int64_t whole = world_now() - begin;
    user_expect_at_least(whole, 10 * WORLD_S);
    const size_t tries = made_up_tries(m, "d");
    const int64_t second = world_now();
    user_tool *cut = user_start(b.host, "lumctl laser off");
    user_until(user_has(user_err(cut), "laser off is repeated"));
    user_signal(cut, SIGINT);
    user_signal(cut, SIGTERM);
    user_expect_status(cut, NO_ANSWER);
    user_expect_has(user_err(cut), "MAY BE ON");
    user_expect_at_most(world_now() - second, 4 * WORLD_S);
    user_expect_at_most(4 * (made_up_tries(m, "d") - tries), 3 * tries);
}

static void answer_after_four(made_up *self, const made_up_packet *packet)
{
    if (packet->before > 3) {
        made_up_plain(self, packet);
    }
}

STORY(raw_text_that_switches_off,
      "raw text that switches off is not left to one try")
{
    const user_bench b = user_bench_new();
    const made_up *m = made_up_new(b.sensor, SENSOR, answer_after_four);
    user_tool *raw =
        user_run(b.host, "lumctl send '50p d' --timeout 60 --retries 0");
    user_expect_status(raw, NO_ANSWER);
    user_expect_has(user_err(raw), "the laser is off; whether the rest");
    user_expect_like(made_up_texts(m), "^50p d,d,");
}

STORY(silence_of_an_owner, "silence of an owner is a hazard")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    m->status = MADE_UP_TIMEOUT | MADE_UP_OFF;
    user_tool *idle = user_run(b.host, "lumctl status --json");
    user_expect_status(idle, DONE);
    expect_value(idle, "idle", "true");
    user_tool *owner = user_start(b.host, "lumctl heartbeat");
    user_until(user_has(user_err(owner), "this is now the session"));
    user_signal(owner, SIGSTOP);
    user_tool *json = user_run(b.host, "lumctl status --json");
    user_expect_status(json, HAZARD);
    expect_value(json, "idle", "false");
    expect_value(json, "laser", "down");
    user_tool *plain = user_run(b.host, "lumctl status");
    user_expect_status(plain, HAZARD);
    user_expect_has(user_out(plain), "its owner's heartbeats are missing");
    user_expect_has(user_out(plain), user_format("%ld", owner->process->pid));
    user_expect_has(user_out(plain), "HAZARD");
    user_tool *watch = user_start(b.host, "lumctl status --watch");
    user_until(user_has(user_out(watch), "its owner's heartbeats are missing"));
    user_expect_end(watch, SIGINT, HAZARD);
    user_signal(owner, SIGKILL);
    user_expect_status(owner, -SIGKILL);
    user_expect_status(user_run(b.host, "lumctl status"), DONE);
}

static void say_before_the_answer(made_up *self, const made_up_packet *packet)
{
    made_up_send(self, packet, 0, 0x0840, "fan \033[2J slow");
    self->delay_ns = 50 * WORLD_MS;
    made_up_say(self, packet, 0x0840, NULL);
    self->delay_ns = 0;
}

STORY(what_comes_unasked, "what comes unasked is told and is no answer")
{
    const user_bench b = user_bench_new();
    (void)made_up_new(b.sensor, SENSOR, say_before_the_answer);
    user_tool *power = user_run(b.host, "lumctl power 50");
    user_expect_status(power, DONE);
    user_expect_has(user_err(power), "says: fan ?[2J slow");
    user_expect_has(user_err(power), "FAN_PWM_BAD");
}

static void answer_malformed(made_up *self, const made_up_packet *packet)
{
    uint8_t bytes[21] = {0};
    memcpy(bytes, packet->bytes, 16);
    memcpy(bytes + 16, "\2\0\377\377\0", 5);
    made_up_send_bytes(self, packet, bytes, sizeof bytes);
    made_up_send_bytes(self, packet, bytes, 5);
    made_up_send_bytes(self, packet, bytes, 0);
    made_up_send_bytes(self, packet, bytes, 11);
}

STORY(malformed_answers, "malformed answers are no answers")
{
    const user_bench b = user_bench_new();
    (void)made_up_new(b.sensor, SENSOR, answer_malformed);
    user_expect_status(
        user_run(b.host, "lumctl power 50 --timeout 60 --retries 1"),
        NO_ANSWER);
}

STORY(an_answer_without_status, "an answer without a status is no status")
{
    static const struct {
        const char *words, *told;
    } cases[] = {
        {"laser on", "the profile (tlv.status)"},
        {"laser off", "answered without a status TLV"},
        {"send d", "the profile (tlv.status)"},
    };
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    m->status = NO_STATUS;
    user_tool *status = user_run(b.host, "lumctl status");
    user_expect_status(status, FAILED);
    user_expect_has(user_err(status), "no status");
    user_tool *power = user_run(b.host, "lumctl power 50");
    user_expect_status(power, DONE);
    user_expect_has(user_out(power), "no status");
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        user_tool *tool = user_run(b.host, "lumctl %s", cases[i].words);
        user_expect_status(tool, FAILED);
        user_expect_has(user_err(tool), cases[i].told);
        user_expect_has(user_err(tool), "tlv.status");
    }
}

STORY(bits_without_a_name, "bits without a name are shown")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    m->status = 0xffff;
    user_tool *json = user_run(b.host, "lumctl status --json");
    user_expect_status(json, HAZARD);
    user_expect_equal(user_length(user_out(json), "bits"), 16);
    user_expect_has(user_value(user_out(json), "bits"), "BIT_10");
    user_tool *plain = user_run(b.host, "lumctl status");
    user_expect_status(plain, HAZARD);
    user_expect_has(user_out(plain), "BIT_15");
}

static void show_one_after_another(made_up *self, const made_up_packet *packet)
{
    static const int statuses[] = {
        MADE_UP_OFF,         0x1000,    0, MADE_UP_TIMEOUT | MADE_UP_ON,
        MADE_UP_ON | 0x0400, MADE_UP_ON};
    const bool is_on = strcmp(packet->text, "u") == 0;
    made_up_say(self, packet, is_on ? statuses[self->state] : MADE_UP_OFF,
                NULL);
    self->state += is_on && self->state < 5;
}

STORY(laser_on_needs_a_status, "laser on needs a status that shows it")
{
    const user_bench b = user_bench_new();
    const made_up *m = made_up_new(b.sensor, SENSOR, show_one_after_another);
    user_expect_status(user_run(b.host, "lumctl laser on"), FAILED);
    user_tool *unclear = user_run(b.host, "lumctl laser on --json");
    user_expect_status(unclear, FAILED);
    expect_value(unclear, "laser", "may be up");
    user_tool *bare = user_run(b.host, "lumctl laser on");
    user_expect_status(bare, FAILED);
    user_expect_has(user_err(bare),
                    "the laser did not come up: laser may be up: no bit set");
    user_tool *lonely = user_run(b.host, "lumctl laser on");
    user_expect_status(lonely, FAILED);
    user_expect_has(user_err(lonely), "nobody sends heartbeats");
    user_tool *odd = user_run(b.host, "lumctl laser on");
    user_expect_status(odd, FAILED);
    user_expect_has(user_err(odd), "BIT_10");
    user_expect_status(user_run(b.host, "lumctl laser on"), DONE);
    user_expect_same(made_up_commands(m), "u,d,u,d,u,d,u,d,u,d,u,");
}

STORY(laser_off_ends_in_one_of_three_ways,
      "laser off is done, is seen not to be, or is not known to be")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    m->status = MADE_UP_ON;
    user_tool *on =
        user_run(b.host, "lumctl laser off --timeout 60 --retries 1");
    user_expect_status(on, FAILED);
    user_expect_has(user_err(on), "THE LASER IS STILL ON");
    m->answer = made_up_silent;
    user_tool *unknown =
        user_run(b.host, "lumctl laser off --timeout 60 --retries 1");
    user_expect_status(unknown, NO_ANSWER);
    user_expect_has(user_err(unknown), "MAY BE ON");
    user_tool *json =
        user_run(b.host, "lumctl laser off --timeout 60 --retries 1 --json");
    user_expect_status(json, NO_ANSWER);
    expect_value(json, "done", "false");
    m->answer = made_up_plain;
    m->status = MADE_UP_OFF;
    m->count = 0;
    user_expect_status(user_run(b.host, "lumctl laser off"), DONE);
    user_expect_same(made_up_commands(m), "d,");
}

STORY(a_host_may_have_a_name, "a host may have a name, as the environment's")
{
    static const char *const environment[] = {"LUM_HOST=localhost", NULL};
    const user_bench b = user_bench_new();
    (void)made_up_new(b.host, "127.0.0.1", NULL);
    user_tool *json = user_run(b.host, "lumctl --host localhost status --json");
    user_expect_status(json, DONE);
    expect_value(json, "sensor", "127.0.0.1");
    user_expect_status(user_start_with(b.host,
                                       (user_with){.environment = environment},
                                       "lumctl status"),
                       DONE);
}

STORY(heartbeats_that_bring_no_data,
      "heartbeats that bring no data are told, and those that nobody answers")
{
    const user_bench b = user_bench_new();
    const made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    user_tool *beat = user_start(b.host, "lumctl heartbeat");
    user_until(user_has(user_err(beat), "no data from " SENSOR
                                        " within 3 s, though it answers"));
    user_expect_end(beat, SIGINT, DONE);
    user_peer_leave(m->peer);
    user_tool *lonely = user_run(b.host, "lumctl heartbeat --duration 0.5");
    user_expect_status(lonely, NO_ANSWER);
    user_expect_has(user_err(lonely), "does not answer (waited for 0.5 s)");
    user_expect_has(user_err(lonely), "heartbeats go to " SENSOR);
    user_expect_lacks(user_err(lonely), "this is now the session");
}

static void answer_without_status(made_up *self, const made_up_packet *packet)
{
    made_up_say(self, packet, NO_STATUS, NULL);
}

STORY(heartbeats_without_a_status,
      "heartbeats tell of a sensor that shows no status")
{
    const user_bench b = user_bench_new();
    (void)made_up_new(b.sensor, SENSOR, answer_without_status);
    user_tool *beat = user_start(b.host, "lumctl heartbeat --timeout 100");
    user_until(user_has(user_err(beat), "answers without a status"));
    user_expect_end(beat, SIGINT, DONE);
}

STORY(a_watch_that_hears_nothing, "a watch that hears nothing says so")
{
    static const char *const words[] = {"status", "time"};
    const user_bench b = user_bench_new();
    for (size_t i = 0; i < 2; i++) {
        user_tool *watch =
            user_run(b.host, "lumctl %s --watch --duration 0.3", words[i]);
        user_expect_status(watch, NO_ANSWER);
        user_expect_has(user_err(watch), "(waited for 0.3 s)");
        user_expect_lacks(user_err(watch), "tried");
    }
    user_tool *json =
        user_run(b.host, "lumctl status --watch --duration 0.3 --json");
    user_expect_status(json, NO_ANSWER);
    user_expect_equal(user_count(user_out(json), "\n"), 1);
    expect_value(json, "answers", "false");
}

STORY(a_watch_tells_silence, "a watch tells silence, and goes on")
{
    const user_bench b = user_bench_new();
    made_up *m = made_up_new(b.sensor, SENSOR, NULL);
    user_tool *watch =
        user_start(b.host, "lumctl status --watch --timeout 50 --retries 1");
    user_until(user_has(user_out(watch), "laser down"));
    m->answer = made_up_silent;
    user_until(user_has(user_out(watch), "does not answer"));
    m->answer = made_up_plain;
    user_until(user_count(user_out(watch), "laser down") == 2);
    user_expect_end(watch, SIGINT, DONE);
}

STORY(a_signal_ends_a_request, "a signal ends a request by that signal")
{
    const user_bench b = user_bench_new();
    const made_up *m = made_up_new(b.sensor, SENSOR, made_up_silent);
    user_tool *status = user_start(b.host, "lumctl status --timeout 20000");
    user_until(m->count > 0);
    user_expect_end(status, SIGINT, -SIGINT);
    user_expect_has(user_err(status), "interrupted");
}

STORY(a_host_of_the_environment,
      "a host in the environment is used, and an option is stronger")
{
    static const char *const environment[] = {"LUM_HOST=10.42.0.51", NULL};
    static const char *const wrong[] = {"LUM_HOST=here.invalid", NULL};
    const user_bench b = user_bench_new();
    user_leave("status-2", "the environment is wrong on purpose");
    (void)user_interface(user_host_new("other"), "eth0", b.wire,
                         "10.42.0.51/24");
    const user_with with = {.environment = environment};
    user_tool *plain =
        user_start_with(b.host, with, "lumctl status --retries 0 --timeout 50");
    user_expect_status(plain, NO_ANSWER);
    user_expect_has(user_err(plain), "10.42.0.51");
    user_tool *option = user_start_with(
        b.host, with,
        "lumctl --host 10.42.0.52 status --retries 0 --timeout 50");
    user_expect_status(option, NO_ANSWER);
    user_expect_has(user_err(option), "10.42.0.52");
    user_tool *bad = user_start_with(b.host, (user_with){.environment = wrong},
                                     "lumctl status");
    user_expect_status(bad, BAD);
    user_expect_has(user_err(bad), "LUM_HOST");
    user_expect_has(user_err(bad), "'here.invalid'");
    user_expect_equal(user_count(user_err(bad), "\n"), 1);
}
