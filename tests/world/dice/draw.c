/* Throws the dice: a session is a few scenes, with long idle times between
 * them. Faults come where they hurt: between a request and its answer, during a
 * move, while a file gets its name, when the laser goes on or off. */
#include "../kernel/random.h"
#include "script.h"

#include <inttypes.h>
#include <stdarg.h>
#include <string.h>

struct draw {
    struct script *script;
    world_random random;
    unsigned tools; /* numbers given */
    unsigned files;
    unsigned address; /* last byte of the sensor's, as the user knows it */
};

/* --- Dice --- */

static int64_t between(struct draw *d, int64_t low, int64_t high)
{
    return world_random_between(&d->random, low, high);
}

static bool one_in(struct draw *d, unsigned n)
{
    return world_random_below(&d->random, n) == 0;
}

#define PICK(d, list)                                                          \
    (list)[world_random_below(&(d)->random, sizeof(list) / sizeof((list)[0]))]

/* Short ones are as likely as long ones. */
static int64_t span(struct draw *d, int64_t low, int64_t high)
{
    int64_t top = low;
    while (top < high && !one_in(d, 3)) {
        top = top * 2 < high ? top * 2 : high;
    }
    return between(d, low, top > low ? top : low + 1);
}

/* --- Steps --- */

static script_step *add(struct draw *d, script_kind kind, int64_t at_ms)
{
    static script_step lost;
    struct script *s = d->script;
    if (s->count == SCRIPT_STEPS) {
        memset(&lost, 0, sizeof lost);
        return &lost;
    }
    script_step *step = &s->steps[s->count++];
    memset(step, 0, sizeof *step);
    step->kind = kind;
    step->at_ms = at_ms;
    return step;
}

/* The number of the tool. */
__attribute__((format(printf, 3, 4))) static unsigned run(struct draw *d,
                                                          int64_t at_ms,
                                                          const char *format,
                                                          ...)
{
    va_list arguments;
    script_step *step = add(d, SCRIPT_RUN, at_ms);
    step->tool = ++d->tools;
    va_start(arguments, format);
    (void)vsnprintf(step->text, sizeof step->text, format, arguments);
    va_end(arguments);
    return step->tool;
}

static void signal_to(struct draw *d, int64_t at_ms, unsigned tool, int number)
{
    script_step *step = add(d, SCRIPT_SIGNAL, at_ms);
    step->tool = tool;
    step->number = number;
}

static void stop(struct draw *d, int64_t at_ms, unsigned tool, int64_t lasts_ms)
{
    script_step *step = add(d, SCRIPT_STOP, at_ms);
    step->tool = tool;
    step->lasts_ms = lasts_ms;
}

static void type(struct draw *d, int64_t at_ms, unsigned tool, const char *text)
{
    script_step *step = add(d, SCRIPT_TYPE, at_ms);
    step->tool = tool;
    (void)snprintf(step->text, sizeof step->text, "%s", text);
}

/* --- Faults --- */

static void draw_wire(struct draw *d, int64_t at_ms, int64_t lasts_ms)
{
    script_step *step = add(d, SCRIPT_WIRE, at_ms);
    user_faults *f = &step->faults;
    step->lasts_ms = lasts_ms;
    step->way = (script_way)between(d, SCRIPT_BOTH, SCRIPT_IN);
    switch (between(d, 0, 5)) {
    case 0:
        f->lose = (double)between(d, 5, 95) / 100.0;
        break;
    case 1:
        f->repeat = (double)between(d, 5, 90) / 100.0;
        break;
    case 2:
        f->delay_ms = (double)span(d, 1, 1500);
        f->jitter_ms = (double)span(d, 1, 300);
        break;
    case 3:
        f->reorder = (double)between(d, 5, 60) / 100.0;
        f->reorder_ms = (double)span(d, 1, 400);
        break;
    case 4:
        f->corrupt = (double)between(d, 5, 60) / 100.0;
        break;
    default:
        f->lose = (double)between(d, 5, 50) / 100.0;
        f->repeat = (double)between(d, 5, 30) / 100.0;
        f->jitter_ms = (double)span(d, 1, 100);
        break;
    }
}

static void draw_cut(struct draw *d, int64_t at_ms, int64_t lasts_ms)
{
    static const script_kind kinds[] = {SCRIPT_CUT, SCRIPT_CUT, SCRIPT_CABLE,
                                        SCRIPT_ADDRESS};
    script_step *step = add(d, PICK(d, kinds), at_ms);
    step->lasts_ms = lasts_ms;
    step->way = (script_way)between(d, SCRIPT_BOTH, SCRIPT_IN);
}

static void draw_disk(struct draw *d, int64_t at_ms, int64_t lasts_ms)
{
    static const char *const how[] = {"stall", "slow", "full", "fail", "sync"};
    script_step *step = add(d, SCRIPT_DISK, at_ms);
    step->lasts_ms = lasts_ms;
    step->value = span(d, 1, 200000);
    (void)snprintf(step->text, sizeof step->text, "%s", PICK(d, how));
}

/* Of the sensor: a hazard, a restart, silence. */
static void draw_sensor(struct draw *d, int64_t at_ms, int64_t lasts_ms)
{
    static const char *const what[] = {"fan",     "interlock", "switch",
                                       "board",   "galvo-bx",  "silence",
                                       "silence", "reboot",    "reboot"};
    script_step *step = add(d, SCRIPT_SENSOR, at_ms);
    step->lasts_ms = lasts_ms;
    (void)snprintf(step->text, sizeof step->text, "%s", PICK(d, what));
}

static void draw_clock(struct draw *d, int64_t at_ms)
{
    static const int64_t steps_ms[] = {-86400000, -3600000, -1000,  -10,
                                       10,        1000,     3600000};
    script_step *step =
        add(d, one_in(d, 3) ? SCRIPT_DRIFT : SCRIPT_CLOCK, at_ms);
    step->value =
        step->kind == SCRIPT_DRIFT ? between(d, -200, 200) : PICK(d, steps_ms);
}

/* Something goes wrong, at a moment or a little later. */
static void draw_trouble(struct draw *d, int64_t at_ms)
{
    const int64_t lasts_ms = span(d, 50, 9000);
    switch (between(d, 0, 9)) {
    case 0:
    case 1:
    case 2:
        draw_wire(d, at_ms, lasts_ms);
        break;
    case 3:
    case 4:
        draw_cut(d, at_ms, lasts_ms);
        break;
    case 5:
    case 6:
        draw_sensor(d, at_ms, lasts_ms);
        break;
    case 7: {
        script_step *power = add(d, SCRIPT_POWER, at_ms);
        power->lasts_ms = lasts_ms;
        break;
    }
    case 8:
        draw_clock(d, at_ms);
        break;
    default: {
        script_step *slow = add(d, SCRIPT_SLOW, at_ms);
        slow->lasts_ms = lasts_ms;
        slow->value = between(d, 2, 60);
        break;
    }
    }
}

/* Files are made, synced and named a few times, and all else goes on as long as
 * the tool does. */
static bool is_rare(const char *call)
{
    static const char *const calls[] = {"rename", "fsync",  "fclose",
                                        "open",   "unlink", "ftruncate"};
    size_t i = 0;
    while (i < sizeof calls / sizeof *calls && strcmp(calls[i], call) != 0) {
        i++;
    }
    return i < sizeof calls / sizeof *calls;
}

/* The n-th of a tool's. */
static script_step *add_at_call(struct draw *d, script_kind kind, int64_t at_ms,
                                unsigned tool, const char *call)
{
    script_step *step = add(d, kind, at_ms);
    step->tool = tool;
    step->n = (unsigned)span(d, 1, is_rare(call) ? 6 : 60);
    (void)snprintf(step->call, sizeof step->call, "%s", call);
    return step;
}

/* Right before a call; it goes on later. */
static void stop_at_call(struct draw *d, int64_t at_ms, unsigned tool,
                         const char *call)
{
    script_step *step = add_at_call(d, SCRIPT_AT_CALL, at_ms, tool, call);
    step->number = SIGSTOP;
    step->value = span(d, 50, 9000);
}

/* While it switches the laser on, and longer than it may be held up. */
static void hold_up(struct draw *d, int64_t at_ms, unsigned tool)
{
    if (one_in(d, 2)) {
        script_step *step = add(d, SCRIPT_CUT, at_ms - 10);
        step->lasts_ms = span(d, 100, 8000);
        step->way = one_in(d, 2) ? SCRIPT_IN : SCRIPT_BOTH;
    }
    if (one_in(d, 2)) {
        const int64_t begins_ms = at_ms + span(d, 1, 600);
        stop(d, begins_ms, tool, span(d, 2400, 8000));
    } else {
        stop_at_call(d, at_ms, tool, "sendmmsg");
    }
}

/* What befalls one program. */
static void draw_fate(struct draw *d, int64_t at_ms, unsigned tool)
{
    static const int signals[] = {SIGINT, SIGINT,  SIGTERM,
                                  SIGHUP, SIGQUIT, SIGKILL};
    static const char *const calls[] = {
        "sendmmsg", "sendmmsg", "poll",  "recvmmsg", "write",  "rename",
        "fsync",    "fclose",   "close", "open",     "unlink", "clock_gettime",
        "fflush",   "fwrite",   "ppoll", "ftruncate"};
    if (one_in(d, 3)) {
        stop(d, at_ms, tool, span(d, 20, 6000));
    } else if (one_in(d, 3)) {
        stop_at_call(d, at_ms, tool, PICK(d, calls));
    } else if (one_in(d, 2)) {
        signal_to(d, at_ms, tool, PICK(d, signals));
    } else {
        script_step *step =
            add_at_call(d, SCRIPT_AT_CALL, at_ms, tool, PICK(d, calls));
        step->number = PICK(d, signals);
    }
}

/* --- Words of lumctl --- */

/* Those that make a request. */
static void draw_words(struct draw *d, char *out, size_t size)
{
    const int64_t percent = between(d, 0, 100);
    static const char *const goals[] = {"", " answers", " up", " down",
                                        " clear"};
    switch (between(d, 0, 13)) {
    case 0:
    case 1:
        (void)snprintf(out, size, "status --json");
        break;
    case 2:
        (void)snprintf(out, size, "power %" PRId64, percent);
        break;
    case 3:
        (void)snprintf(out, size, "threshold %s %" PRId64,
                       one_in(d, 2) ? "green" : "blue", percent);
        break;
    case 4:
        (void)snprintf(out, size, "send '%" PRId64 "p %" PRId64 "g'", percent,
                       between(d, 0, 100));
        break;
    case 5:
        (void)snprintf(out, size, "holdoff %" PRId64, between(d, 15, 25) * 10);
        break;
    case 6:
        (void)snprintf(out, size, "offset blue %" PRId64, between(d, 0, 30));
        break;
    case 7:
        (void)snprintf(out, size, "time --json");
        break;
    case 8:
        (void)snprintf(out, size, "show");
        break;
    case 9:
        (void)snprintf(out, size, "status --watch --duration 2");
        break;
    case 10:
        (void)snprintf(out, size, "yscan %" PRId64, between(d, 11, 30));
        break;
    case 11:
        (void)snprintf(out, size, "wait%s --for %" PRId64, PICK(d, goals),
                       between(d, 1, 9));
        break;
    case 12:
        (void)snprintf(out, size, "status --every 0.5 --duration 2");
        break;
    default:
        (void)snprintf(out, size, "laser off --json");
        break;
    }
}

static const char *draw_options(struct draw *d)
{
    static const char *const options[] = {"",
                                          "",
                                          "",
                                          "",
                                          " --timeout 60",
                                          " --timeout 150 --retries 1",
                                          " --retries 0",
                                          " --retries 12 --timeout 100"};
    return PICK(d, options);
}

static unsigned run_lumctl(struct draw *d, int64_t at_ms, const char *words)
{
    return run(d, at_ms, "lumctl --host 10.42.0.%u %s%s", d->address, words,
               draw_options(d));
}

static unsigned run_any(struct draw *d, int64_t at_ms)
{
    char words[80];
    draw_words(d, words, sizeof words);
    return run_lumctl(d, at_ms, words);
}

/* --- Scenes: each returns when it is over --- */

/* A command, in trouble. */
static int64_t draw_command(struct draw *d, int64_t at_ms)
{
    const unsigned tool = run_any(d, at_ms);
    if (one_in(d, 2)) {
        draw_trouble(d, at_ms + between(d, -500, 600));
    }
    if (one_in(d, 3)) {
        draw_fate(d, at_ms + span(d, 1, 1500), tool);
    }
    if (one_in(d, 40)) {
        script_step *wrong = add(d, SCRIPT_RUN, at_ms + 700);
        wrong->tool = ++d->tools;
        wrong->is_wrong = true;
        (void)snprintf(wrong->text, sizeof wrong->text,
                       "lumctl --host 10.42.0.%u power 101", d->address);
    }
    return at_ms + 4000;
}

/* The laser goes on and off beside a session. */
static void draw_laser(struct draw *d, int64_t from_ms, int64_t to_ms)
{
    unsigned tool = 0;
    int64_t at_ms = from_ms + between(d, 200, 1500);
    while (at_ms < to_ms) {
        const bool is_on = one_in(d, 2);
        tool = run_lumctl(d, at_ms,
                          is_on ? (one_in(d, 2) ? "laser on" : "send u")
                                : "laser off");
        if (one_in(d, 4)) {
            draw_fate(d, at_ms + span(d, 1, 900), tool);
        } else if (one_in(d, 8)) {
            hold_up(d, at_ms, tool);
        }
        if (one_in(d, 3)) {
            draw_trouble(d, at_ms + between(d, -300, 700));
        }
        at_ms += span(d, 400, 8000);
    }
}

static const char *draw_output(struct draw *d, char *out, size_t size)
{
    static const char *const ends[] = {"pcap", "pcap", "pcapng", "csv",
                                       "ply",  "las",  "pcd",    "mcap"};
    const char *end = PICK(d, ends);
    const bool is_mcap = strcmp(end, "mcap") == 0;
    (void)snprintf(out, size, " -o f%u.%s%s", ++d->files, end,
                   is_mcap ? " --mcap packets --compression none" : "");
    return out;
}

/* What was last started. */
static script_step *last(struct draw *d)
{
    return &d->script->steps[d->script->count - 1];
}

/* Also on another computer, which nobody can tell. */
static void draw_second(struct draw *d, int64_t at_ms)
{
    const bool is_far = one_in(d, 4);
    if (one_in(d, 2)) {
        (void)run_lumctl(d, at_ms, "heartbeat --duration 2");
    } else {
        (void)run(d, at_ms, "lumdump udp://10.42.0.%u -q --duration 1 --json",
                  d->address);
    }
    last(d)->is_far = is_far;
}

/* What a session meets in its time. */
static void draw_session_life(struct draw *d, unsigned tool, int64_t from_ms,
                              int64_t to_ms, bool writes)
{
    for (int64_t n = between(d, 0, 3); n > 0; n--) {
        const int64_t at_ms = between(d, from_ms, to_ms + 300);
        switch (between(d, 0, 6)) {
        case 0:
        case 1:
            draw_trouble(d, at_ms);
            break;
        case 2:
            draw_fate(d, at_ms, tool);
            break;
        case 3:
            if (writes) {
                draw_disk(d, at_ms, span(d, 200, 20000));
            }
            break;
        case 4:
            draw_second(d, at_ms);
            break;
        case 5:
            (void)run_any(d, at_ms);
            break;
        default:
            draw_sensor(d, at_ms, span(d, 200, 6000));
            break;
        }
    }
}

static int64_t draw_recording(struct draw *d, int64_t at_ms)
{
    char one[80] = "";
    char two[80] = "";
    char lasts[32] = "";
    const int64_t length_ms = span(d, 1000, 24000);
    const bool is_told = one_in(d, 2);
    const bool has_laser = !one_in(d, 3);
    if (!is_told) {
        (void)snprintf(lasts, sizeof lasts, " --duration %.1f",
                       (double)length_ms / 1000.0);
    }
    if (!one_in(d, 4)) {
        (void)draw_output(d, one, sizeof one);
    }
    if (one_in(d, 3)) {
        (void)draw_output(d, two, sizeof two);
    }
    /* One after the other: compilers differ in the order of arguments. */
    const char *buffer = one_in(d, 2) ? " --buffer 128KiB" : "";
    const char *rotates = one[0] != '\0' && one_in(d, 8) ? " --rotate 3s" : "";
    const unsigned tool =
        run(d, at_ms, "lumdump udp://10.42.0.%u --json%s%s%s%s%s%s", d->address,
            has_laser ? " --laser" : "", lasts, one, two, buffer, rotates);
    last(d)->ignores_int = one_in(d, 8);
    const int64_t end_ms = at_ms + length_ms;
    if (one_in(d, 8)) {
        hold_up(d, at_ms, tool);
    }
    draw_session_life(d, tool, at_ms, end_ms, one[0] != '\0');
    if (one_in(d, 3)) {
        draw_laser(d, at_ms + 1000, end_ms);
    }
    if (is_told) {
        static const int signals[] = {SIGINT, SIGINT,  SIGTERM,
                                      SIGHUP, SIGQUIT, SIGKILL};
        signal_to(d, end_ms, tool, PICK(d, signals));
    }
    if (one_in(d, 4)) {
        draw_trouble(d, end_ms + between(d, -600, 600));
    }
    if (one_in(d, 8)) {
        script_step *cut = add(d, SCRIPT_BLACKOUT, end_ms - between(d, 0, 900));
        cut->value = between(d, 0, 100);
    }
    return end_ms + 3000;
}

/* Points to a program that takes them slowly, or not at all. */
static int64_t draw_pipe(struct draw *d, int64_t at_ms)
{
    char one[80] = "";
    const int64_t length_ms = span(d, 1500, 16000);
    if (one_in(d, 2)) {
        (void)draw_output(d, one, sizeof one);
    }
    const char *laser = one_in(d, 2) ? " --laser" : "";
    const char *buffer = one_in(d, 2) ? " --buffer 128KiB" : "";
    const unsigned tool =
        run(d, at_ms, "lumdump udp://10.42.0.%u -o - --format csv%s%s%s",
            d->address, laser, one, buffer);
    last(d)->is_stalled = true;
    last(d)->value = one_in(d, 2) ? 0 : span(d, 1, 2000000);
    last(d)->lasts_ms = one_in(d, 4) ? span(d, 500, length_ms) : 0;
    draw_session_life(d, tool, at_ms, at_ms + length_ms, false);
    signal_to(d, at_ms + length_ms, tool, one_in(d, 2) ? SIGINT : SIGTERM);
    if (one_in(d, 2)) {
        signal_to(d, at_ms + length_ms + span(d, 100, 9000), tool, SIGINT);
    }
    return at_ms + length_ms + 5000;
}

static int64_t draw_view(struct draw *d, int64_t at_ms)
{
    const int64_t length_ms = span(d, 1000, 15000);
    const unsigned tool =
        run(d, at_ms, "lumview --no-open -q udp://10.42.0.%u%s", d->address,
            one_in(d, 3) ? "" : " --laser");
    draw_session_life(d, tool, at_ms, at_ms + length_ms, false);
    if (one_in(d, 3)) {
        draw_laser(d, at_ms + 500, at_ms + length_ms);
    }
    signal_to(d, at_ms + length_ms, tool, one_in(d, 2) ? SIGINT : SIGTERM);
    return at_ms + length_ms + 4000;
}

/* What writes lines at times; into files or to standard output. */
static const char *draw_every(struct draw *d, char *out, size_t size)
{
    const int64_t tenths = span(d, 1, 60);
    char csv[32] = "";
    char page[40] = "";
    if (!one_in(d, 3)) {
        (void)snprintf(csv, sizeof csv, " --csv c%u.csv", ++d->files);
    }
    if (one_in(d, 2)) {
        (void)snprintf(page, sizeof page, " --prometheus p%u.prom", ++d->files);
    }
    (void)snprintf(out, size, " --every %" PRId64 ".%" PRId64 "%s%s",
                   tenths / 10, tenths % 10, csv, page);
    return out;
}

static int64_t draw_heartbeat(struct draw *d, int64_t at_ms)
{
    char every[96] = "";
    const int64_t length_ms = span(d, 1500, 20000);
    const bool is_told = one_in(d, 2);
    if (one_in(d, 4)) {
        (void)draw_every(d, every, sizeof every);
    }
    const char *rate = one_in(d, 3) ? " --rate 20" : "";
    const char *laser = one_in(d, 3) ? " --laser" : "";
    char lasts[32] = "";
    if (!is_told) {
        (void)snprintf(lasts, sizeof lasts, " --duration %.1f",
                       (double)length_ms / 1000.0);
    }
    const unsigned tool =
        run(d, at_ms, "lumctl --host 10.42.0.%u heartbeat --json%s%s%s%s",
            d->address, lasts, rate, laser, every);
    if (*laser != '\0' && one_in(d, 8)) {
        hold_up(d, at_ms, tool);
    }
    if (*laser == '\0' || one_in(d, 3)) {
        draw_laser(d, at_ms, at_ms + length_ms);
    }
    draw_session_life(d, tool, at_ms, at_ms + length_ms, *every != '\0');
    if (is_told) {
        signal_to(d, at_ms + length_ms, tool, one_in(d, 2) ? SIGINT : SIGKILL);
    }
    return at_ms + length_ms + 3500;
}

/* Looks at a sensor for a while, beside an owner or not. */
static int64_t draw_watch(struct draw *d, int64_t at_ms)
{
    static const char *const untils[] = {"", "", " --until hazard",
                                         " --until up", " --until down"};
    char every[96] = "";
    const int64_t length_ms = span(d, 1500, 20000);
    const char *until = PICK(d, untils);
    (void)draw_every(d, every, sizeof every);
    const unsigned tool =
        run(d, at_ms, "lumctl --host 10.42.0.%u status%s%s%s", d->address,
            every, until, one_in(d, 2) ? " --json" : "");
    if (one_in(d, 2)) {
        (void)run(d, at_ms + between(d, 0, 1000),
                  "lumctl --host 10.42.0.%u heartbeat --laser --duration %.1f",
                  d->address, (double)span(d, 1000, length_ms) / 1000.0);
    }
    if (one_in(d, 2)) {
        (void)run(d, at_ms + between(d, -500, 3000),
                  "lumctl --host 10.42.0.%u wait %s", d->address,
                  one_in(d, 2) ? "up" : "clear");
        signal_to(d, at_ms + length_ms, d->tools, SIGINT);
    }
    draw_session_life(d, tool, at_ms, at_ms + length_ms, true);
    signal_to(d, at_ms + length_ms, tool, one_in(d, 3) ? SIGKILL : SIGINT);
    return at_ms + length_ms + 8000;
}

/* A few steps, each on a line or two. */
static void draw_plan(struct draw *d, int64_t at_ms, unsigned number)
{
    static const char *const items[] = {"  - power: 30\n", "  - holdoff: 200\n",
                                        "  - yscan: 15\n",
                                        "  - threshold: {blue: 40}\n"};
    static const char *const records[] = {
        "", "    record: 0.5\n", "    record: 2\n", "    record: {frames: 1}\n",
        "    settle: 1.5\n"};
    script_step *step = add(d, SCRIPT_PLAN, at_ms);
    size_t used = 0;
    step->n = number;
    for (int64_t n = between(d, 1, 4); n > 0; n--) {
        const char *item = PICK(d, items);
        const char *record = PICK(d, records);
        used += (size_t)snprintf(step->text + used, sizeof step->text - used,
                                 "%s%s", item, record);
    }
}

static unsigned run_sweep(struct draw *d, int64_t at_ms, unsigned number,
                          const char *laser, const char *again)
{
    return run(d, at_ms,
               "lumctl --host 10.42.0.%u sweep plan%u.yaml -o f%u%s%s",
               d->address, number, number, laser, again);
}

static int64_t draw_sweep(struct draw *d, int64_t at_ms)
{
    const unsigned number = ++d->files;
    const char *laser = one_in(d, 3) ? "" : " --laser";
    draw_plan(d, at_ms - 1, number);
    for (int64_t n = between(d, 1, 3); n > 0; n--) {
        const int64_t length_ms = span(d, 1000, 30000);
        const unsigned tool = run_sweep(d, at_ms, number, laser, " --continue");
        if (one_in(d, 8)) {
            hold_up(d, at_ms, tool);
        }
        draw_session_life(d, tool, at_ms, at_ms + length_ms, true);
        if (one_in(d, 2)) {
            draw_fate(d, at_ms + span(d, 1, length_ms), tool);
        }
        signal_to(d, at_ms + length_ms, tool, one_in(d, 2) ? SIGINT : SIGKILL);
        at_ms += length_ms + between(d, 100, 20000);
    }
    return at_ms + 8000;
}

static int64_t draw_shell(struct draw *d, int64_t at_ms)
{
    static const char *const lines[] = {"laser on",  "laser on", "u",
                                        "laser off", "d",        "power 50",
                                        "50p 20g",   "status",   "time"};
    const unsigned tool = run(d, at_ms, "lumctl --host 10.42.0.%u shell%s",
                              d->address, one_in(d, 4) ? "" : " --heartbeat");
    int64_t t_ms = at_ms + between(d, 300, 2000);
    for (int64_t n = between(d, 1, 6); n > 0; n--) {
        type(d, t_ms, tool, PICK(d, lines));
        if (one_in(d, 4)) {
            draw_trouble(d, t_ms + between(d, -300, 600));
        }
        if (one_in(d, 8)) {
            draw_fate(d, t_ms + span(d, 1, 500), tool);
        }
        t_ms += span(d, 300, 6000);
    }
    if (one_in(d, 3)) {
        signal_to(d, t_ms, tool, SIGTERM);
    } else if (one_in(d, 2)) {
        type(d, t_ms, tool, "quit");
    } else {
        type(d, t_ms, tool, "");
    }
    return t_ms + 4000;
}

/* The sensor gets another address, in trouble; then it is asked there. */
static int64_t draw_move(struct draw *d, int64_t at_ms)
{
    char words[40];
    const unsigned address = (unsigned)between(d, 38, 60);
    (void)snprintf(words, sizeof words, "set-ip 10.42.0.%u --json", address);
    const unsigned tool = run_lumctl(d, at_ms, words);
    if (one_in(d, 2)) {
        draw_trouble(d, at_ms + between(d, -200, 900));
    }
    if (one_in(d, 3)) {
        draw_fate(d, at_ms + span(d, 1, 2500), tool);
    }
    if (!one_in(d, 3)) {
        d->address = address;
    }
    (void)run_any(d, at_ms + 9000);
    return at_ms + 13000;
}

static int64_t draw_find(struct draw *d, int64_t at_ms)
{
    const unsigned tool =
        run(d, at_ms, "lumctl find --subnet 10.42.0.32/27 --json");
    if (one_in(d, 2)) {
        draw_trouble(d, at_ms + between(d, -200, 900));
    }
    if (one_in(d, 4)) {
        draw_fate(d, at_ms + span(d, 1, 1500), tool);
    }
    return at_ms + 6000;
}

static int64_t draw_doctor(struct draw *d, int64_t at_ms)
{
    const unsigned tool = run_lumctl(d, at_ms, "doctor --json");
    if (one_in(d, 2)) {
        draw_trouble(d, at_ms + between(d, -200, 2000));
    }
    if (one_in(d, 4)) {
        draw_fate(d, at_ms + span(d, 1, 2500), tool);
    }
    return at_ms + 8000;
}

/* --- What waits for a call --- */

/* While a file is made, written, synced, and gets its name. */
static const char *draw_file_call(struct draw *d)
{
    static const char *const calls[] = {"open",   "write",  "write", "fwrite",
                                        "fflush", "fsync",  "fsync", "close",
                                        "fclose", "rename", "rename"};
    return PICK(d, calls);
}

static void aim_at_file(struct draw *d, const script_step *at)
{
    static const char *const how[] = {"stall", "stall", "slow",   "full",
                                      "fail",  "sync",  "rename", "open"};
    const char *call = draw_file_call(d);
    script_step *step = NULL;
    if (one_in(d, 4)) {
        step = add_at_call(d, SCRIPT_BLACKOUT, at->at_ms, at->tool, call);
        step->value = between(d, 0, 100);
        return;
    }
    step = add_at_call(d, SCRIPT_DISK, at->at_ms, at->tool, call);
    step->lasts_ms = span(d, 200, 20000);
    step->value = span(d, 1, 20000);
    (void)snprintf(step->text, sizeof step->text, "%s", PICK(d, how));
}

/* Between a request and its answer. */
static void aim_at_way(struct draw *d, const script_step *at)
{
    static const char *const calls[] = {"sendmmsg", "sendmmsg", "poll",
                                        "ppoll",    "recvmmsg", "close"};
    static const script_kind kinds[] = {SCRIPT_CUT,   SCRIPT_CUT,
                                        SCRIPT_CABLE, SCRIPT_ADDRESS,
                                        SCRIPT_POWER, SCRIPT_SLOW};
    const char *call = PICK(d, calls);
    script_step *step =
        add_at_call(d, PICK(d, kinds), at->at_ms, at->tool, call);
    step->lasts_ms = span(d, 50, 9000);
    step->way = (script_way)between(d, SCRIPT_BOTH, SCRIPT_IN);
    step->value = step->kind == SCRIPT_SLOW ? between(d, 2, 60) : 0;
}

/* From a stream of their own, so that the scenes stay what they are. */
static void draw_aims(struct script *script)
{
    struct draw d = {.script = script,
                     .random = world_stream_under(script->seed, "aims", 0)};
    const unsigned count = script->count;
    for (unsigned i = 0; i < count; i++) {
        const script_step at = script->steps[i];
        if (at.kind != SCRIPT_RUN || at.is_wrong) {
            continue;
        }
        if (one_in(&d, strstr(at.text, " -o f") != NULL ? 3 : 24)) {
            aim_at_file(&d, &at);
        }
        if (one_in(&d, 10)) {
            aim_at_way(&d, &at);
        }
    }
}

/* --- A session --- */

static void draw_lumsim(struct draw *d)
{
    static const char *const clocks[] = {"", "", " --clock 4294967295",
                                         " --clock 4290000000",
                                         " --clock 4200000000"};
    static const char *const answers[] = {"",
                                          "",
                                          "",
                                          " --answer-loss 0.3",
                                          " --answer-delay 30",
                                          " --answer-delay 300"};
    static const char *const data[] = {
        "", "", "", " --loss 0.05", " --jitter 5", " --duplicate 0.1"};
    const char *scene = one_in(d, 24) ? "--frames 1 --lines 64 --rate 0.2"
                                      : "--replay small.pcap --loop";
    const char *clock = PICK(d, clocks);
    const char *answer = PICK(d, answers);
    (void)snprintf(d->script->sensor, sizeof d->script->sensor, "%s%s%s%s",
                   scene, clock, answer, PICK(d, data));
}

/* Its power goes off and on, which brings it back to its first address. */
static void come_home(struct draw *d, int64_t at_ms)
{
    if (d->address != 37 && one_in(d, 2)) {
        add(d, SCRIPT_POWER, at_ms)->lasts_ms = 300;
        d->address = 37;
    }
}

static void sort(struct script *s)
{
    for (unsigned i = 1; i < s->count; i++) {
        const script_step step = s->steps[i];
        unsigned k = i;
        for (; k > 0 && s->steps[k - 1].at_ms > step.at_ms; k--) {
            s->steps[k] = s->steps[k - 1];
        }
        s->steps[k] = step;
    }
}

void script_keep(struct script *script, const bool has[SCRIPT_STEPS + 1])
{
    unsigned count = 0;
    for (unsigned i = 0; i < script->count; i++) {
        if (has[script->steps[i].place]) {
            script->steps[count++] = script->steps[i];
        }
    }
    script->count = count;
}

void script_draw(struct script *out, uint64_t seed)
{
    static int64_t (*const scenes[])(struct draw * d, int64_t at_ms) = {
        draw_command,   draw_command,   draw_command,   draw_recording,
        draw_recording, draw_recording, draw_heartbeat, draw_heartbeat,
        draw_shell,     draw_pipe,      draw_view,      draw_move,
        draw_move,      draw_find,      draw_doctor,    draw_watch,
        draw_sweep};
    struct draw d = {.script = out,
                     .random = world_stream_under(seed, "dice", 0),
                     .address = 37};
    memset(out, 0, sizeof *out);
    out->seed = seed;
    draw_lumsim(&d);
    int64_t at_ms = between(&d, 600, 3000);
    for (int64_t n = between(&d, 2, 5); n > 0; n--) {
        come_home(&d, at_ms - 600);
        at_ms = PICK(&d, scenes)(&d, at_ms);
        at_ms += span(&d, 20000, 500000);
    }
    out->ends_ms = at_ms + between(&d, 0, 170000);
    draw_aims(out);
    sort(out);
    for (unsigned i = 0; i < out->count; i++) {
        out->steps[i].place = i + 1;
    }
}
