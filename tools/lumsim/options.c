#define _POSIX_C_SOURCE 200809L /* strcasecmp */
#include "options.h"

#include "../common/host.h"
#include "../common/number.h"
#include "../common/option_table.h"
#include "lum/laser.h"
#include "lum/wire.h"
#include "moving.h"
#include "named_files.h"
#include "rig_capture.h"
#include "sim/device.h"
#include "standing.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define FRAMES_MAX   10000000
#define LOOP_MAX     1000        /* frames that are held in memory */
#define CLIENT       0x0a2a0001u /* 10.42.0.1 */
#define LOOPBACK     0x7f000001u /* 127.0.0.1 */
#define CLIENT_PORT  50000
#define EXIT_USAGE   2
#define RATE_MIN_HZ  0.2
#define RATE_MAX_HZ  100.0
#define DELAY_MAX_MS 10000.0
#define SPEED_MIN    0.001
#define SPEED_MAX    1000.0
#define DURATION_MAX 1e9
#define DRIFT_MAX    1000.0
#define BATCH_MAX_MS 1000.0
#define VELOCITY_MIN 0.001
#define VELOCITY_MAX 100.0

static const struct option_word clocks[] = {
    {"sensor", 0}, {"utc", 1}, {NULL, 0}};

/* --- Values --- */

static bool take_lines(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    const bool is_64 = strcmp(text, "64") == 0;
    (void)why;
    o->render.lines = is_64 ? 64 : 640;
    return is_64 || strcmp(text, "640") == 0;
}

/* An address that a host may have. */
static bool is_host(uint32_t address)
{
    return address >> 24 != 0 && address >> 28 < 0xeu;
}

static bool parse_host(const char *text, uint32_t *out, lum_error *why)
{
    return host_parse(text, out, why) && is_host(*out);
}

static bool take_address(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    return parse_host(text, &o->sensor, why);
}

static bool take_sensor(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    return host_parse_sensor(text, &o->replay.sensor.address,
                             o->replay.sensor.interface, why) &&
           is_host(o->replay.sensor.address);
}

/* The true calibration and the exact points are told apart by the name. */
static bool take_truth(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    const char *ending = strrchr(text, '.');
    const bool is_yaml = ending != NULL && (strcasecmp(ending, ".yaml") == 0 ||
                                            strcasecmp(ending, ".yml") == 0);
    const char **path = is_yaml ? &o->truth.calibration : &o->truth.points;
    if (*path != NULL) {
        (void)lum_error_set(why,
                            "'%.200s': '%.200s' is the %s already; one file "
                            "ends in .yaml, and one does not",
                            text, *path,
                            is_yaml ? "true calibration" : "exact points");
        return false;
    }
    *path = text;
    return text[0] != '\0';
}

static bool take_interface(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    o->live.interface = text;
    return host_has_interface(text, why);
}

static bool refuse_text(const char *text, const char *right, lum_error *why)
{
    (void)lum_error_set(why, "'%.200s' is not %s", text, right);
    return false;
}

static bool take_client(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    char address[256];
    const size_t len = strcspn(text, ":");
    int64_t port = CLIENT_PORT;
    if (len >= sizeof address) {
        return refuse_text(text, "HOST or HOST:PORT", why);
    }
    (void)memcpy(address, text, len);
    address[len] = '\0';
    if (text[len] == ':' &&
        !number_parse_int(text + len + 1, 1, UINT16_MAX, &port)) {
        return refuse_text(
            text, "HOST or HOST:PORT with a port from 1 to 65535", why);
    }
    o->capture.client_port = (uint16_t)port;
    return parse_host(address, &o->capture.client, why);
}

/* With TLV_CMD_ON it would boot with its laser on. */
static bool take_boot_status(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    char *end = NULL;
    const size_t digits = strspn(text, "0x123456789abcdefABCDEF");
    const unsigned long bits = strtoul(text, &end, 0);
    (void)why;
    o->live.boot_status = (uint16_t)bits;
    return digits > 0 && *end == '\0' && bits <= UINT16_MAX &&
           (bits & LUM_LASER_TLV_CMD_ON) == 0;
}

static bool take_fault(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    const char *right = "";
    return timeline_add(&o->timeline, text, &right) ||
           refuse_text(text, right, why);
}

#define ALL   (MODE_FILE | MODE_SCENE | MODE_REPLAY)
#define LIVE  (MODE_SCENE | MODE_REPLAY)
#define DRIVE (MODE_FILE | MODE_SCENE)
#define ALONE 8u /* not with --rig */
#define HOST  "an address of a host, such as 10.42.0.37"

#define INTO(field)  OPTION_INTO(struct options, field)
#define FLAG(field)  .kind = OPTION_FLAG, INTO(field)
#define TEXT(field)  .kind = OPTION_TEXT, INTO(field)
#define HAS(field)   .has = offsetof(struct options, field)
#define CALL(called) .kind = OPTION_CALL, .call = (called)
#define WHOLE(field, from, to)                                                 \
    .kind = OPTION_WHOLE, INTO(field), .min = (from), .max = (to)
#define REAL(field, from, to)                                                  \
    .kind = OPTION_REAL, INTO(field), .low = (from), .high = (to)
#define PROBABILITY(field)                                                     \
    REAL(field, 0.0, 1.0), .allowed = "a probability from 0 to 1"

/* --- The table --- */

static const struct option_spec specs[] = {
    {"output", .letter = 'o', .group = ALL, TEXT(capture.output)},
    {"frames", .letter = 'n', .group = DRIVE, WHOLE(frames, 1, FRAMES_MAX)},
    {"quiet", .letter = 'q', .group = ALL, FLAG(quiet)},
    {"truth", .group = MODE_FILE, CALL(take_truth),
     .allowed = "the name of a file"},
    {"time", .group = MODE_FILE, .kind = OPTION_WORD, INTO(truth.is_utc),
     .words = clocks},
    {"drift", .group = MODE_FILE,
     REAL(capture.drift_ppm, -DRIFT_MAX, DRIFT_MAX)},
    {"batch", .group = MODE_FILE, REAL(capture.batch_ms, 0.0, BATCH_MAX_MS)},
    {"scene", .group = DRIVE, .kind = OPTION_WORD, INTO(render.place.kind),
     .words = standing_scenes},
    {"walls", .group = DRIVE, .kind = OPTION_WORD, INTO(render.place.walls),
     .words = standing_walls, HAS(has_walls)},
    {"pose", .group = DRIVE, CALL(standing_take_pose),
     .allowed = STANDING_POSE},
    {"path", .group = DRIVE, CALL(moving_take_path), .allowed = MOVING_PATH},
    {"velocity", .group = DRIVE,
     REAL(render.place.path.velocity_m_s, VELOCITY_MIN, VELOCITY_MAX),
     HAS(moving.has_velocity)},
    {"poses", .group = MODE_FILE, TEXT(moving.poses)},
    {"labels", .group = MODE_FILE, CALL(moving_take_labels),
     .allowed = "the name of a file that ends in .npy"},
    {"noise", .group = DRIVE, CALL(standing_take_noise),
     .allowed = STANDING_NOISE},
    {"lines", .group = DRIVE, CALL(take_lines), .allowed = "64 or 640"},
    {"rate", .group = DRIVE, REAL(render.rate_hz, RATE_MIN_HZ, RATE_MAX_HZ)},
    {"seed", .group = ALL, WHOLE(render.seed, 0, INT64_MAX)},
    {"returns-max", .group = DRIVE,
     WHOLE(render.returns_max, 1, LUM_RENDER_RETURNS_MAX)},
    {"loss", .group = ALL, PROBABILITY(delivery.faults[LUM_FAULT_LOSS])},
    {"duplicate", .group = ALL,
     PROBABILITY(delivery.faults[LUM_FAULT_DUPLICATE])},
    {"reorder", .group = ALL, PROBABILITY(delivery.faults[LUM_FAULT_REORDER])},
    {"corrupt", .group = ALL, PROBABILITY(delivery.faults[LUM_FAULT_CORRUPT])},
    {"jitter", .group = LIVE, REAL(delivery.jitter_ms, 0.0, DELAY_MAX_MS)},
    {"answer-delay", .group = LIVE, REAL(answers.delay_ms, 0.0, DELAY_MAX_MS)},
    {"answer-loss", .group = LIVE, PROBABILITY(answers.loss)},
    {"joined", .group = ALL, FLAG(delivery.joined)},
    {"fault", .group = LIVE, CALL(take_fault), .allowed = "KIND@TIME"},
    {"rig", .group = ALL, TEXT(rig.path)},
    {"calibration", .group = DRIVE | ALONE, TEXT(calibration)},
    {"profile", .group = ALL | ALONE, TEXT(profile)},
    {"set", .group = ALL | ALONE, CALL(set_keys_add), INTO(set),
     .allowed = SET_KEYS_ALLOWED},
    {"address", .group = ALL | ALONE, CALL(take_address), .allowed = HOST},
    {"port", .group = LIVE, WHOLE(live.port, 1, UINT16_MAX)},
    {"interface", .group = LIVE, CALL(take_interface),
     .allowed = "the name of an interface"},
    {"clock", .group = LIVE, WHOLE(live.clock_us, 0, UINT32_MAX)},
    {"boot-status", .group = LIVE, CALL(take_boot_status),
     .allowed =
         "a number from 0 to 0xffff without the bit 0x0800, such as 0x0200"},
    {"duration", .group = LIVE, REAL(live.duration_s, 0.001, DURATION_MAX)},
    {"log", .group = LIVE, TEXT(live.log)},
    {"client", .group = MODE_FILE, CALL(take_client), .allowed = HOST},
    {"replay", .group = ALL, TEXT(replay.path)},
    {"speed", .group = MODE_REPLAY, REAL(replay.speed, SPEED_MIN, SPEED_MAX)},
    {"loop", .group = MODE_REPLAY, FLAG(replay.loops)},
    {"sensor", .group = MODE_REPLAY, CALL(take_sensor),
     .allowed = HOST ", or 10.42.0.37%eth1"},
    {"sensor-port", .group = MODE_REPLAY,
     WHOLE(replay.sensor.port, 1, UINT16_MAX)},
    OPTION_HELP,
    OPTION_VERSION("lumsim"),
};

#define SPECS (sizeof specs / sizeof specs[0])

/* --- What fits together --- */

static int see_help(void)
{
    (void)fputs("Try 'lumsim --help'.\n", stderr);
    return EXIT_USAGE;
}

static int end_output(void)
{
    if (fflush(stdout) != 0 || ferror(stdout) != 0) {
        perror("lumsim: standard output");
        return 1;
    }
    return 0;
}

/* Why an option does not go with the mode. */
static const char *reason(unsigned modes)
{
    switch (modes) {
    case MODE_FILE:
        return "works only with -o FILE, not with a sensor on the network";
    case MODE_REPLAY:
        return "works only with --replay FILE";
    case DRIVE:
        return "does not go with --replay: the capture decides that";
    default:
        return "is for a sensor on the network; it does not go with -o";
    }
}

static bool check_modes(const struct options *o,
                        const struct option_result *result)
{
    for (size_t i = 0; i < SPECS; i++) {
        const unsigned group = specs[i].group;
        const bool is_alone = (group & ALONE) != 0 && o->rig.path != NULL;
        if (option_table_has(result, i) &&
            (is_alone || (group & (unsigned)o->mode) == 0)) {
            return complain("--%s %s", specs[i].name,
                            is_alone ? "does not go with --rig, whose file "
                                       "says that of each sensor"
                                     : reason(group & ~ALONE));
        }
    }
    return true;
}

/* As --calibration. */
static bool check_set(const struct options *o)
{
    const char *first = set_keys_first(&o->set, false);
    return o->mode != MODE_REPLAY || first == NULL ||
           complain("--set %s: a key of a calibration %s", first,
                    reason(DRIVE));
}

/* Whether the options can be combined in one run. */
static bool check_choice(const struct options *o)
{
    if (o->mode == MODE_SCENE && o->frames > LOOP_MAX) {
        return complain("--frames: on the network frames are held in memory "
                        "and played in a loop; at most %d",
                        LOOP_MAX);
    }
    if (o->truth.is_utc && o->truth.points == NULL && o->moving.poses == NULL) {
        return complain("--time utc is about the times of the exact points in "
                        "--truth FILE, and of --poses FILE; name one");
    }
    return o->capture.output == NULL || o->replay.path == NULL ||
           complain(
               "-o and --replay: one writes a capture, the other sends one "
               "over the network; choose");
}

static void choose_mode(struct options *o)
{
    o->mode = o->capture.output != NULL ? MODE_FILE
              : o->replay.path != NULL  ? MODE_REPLAY
                                        : MODE_SCENE;
    if (o->sensor == 0) {
        o->sensor = o->mode == MODE_FILE ? LUM_BOOT_ADDRESS : LOOPBACK;
    }
}

static void set_defaults(struct options *out)
{
    *out = (struct options){.capture.client = CLIENT,
                            .capture.client_port = CLIENT_PORT,
                            .live.port = LUM_PORT,
                            .live.boot_status = LUM_DEVICE_BOOT_STATUS,
                            .replay.speed = 1.0};
    lum_render_options_default(&out->render);
    out->render.seed = 1;
}

static bool is_open(const struct options *o)
{
    return o->moving.path != NULL ? moving_is_open(o) : standing_is_open(o);
}

static bool load(struct options *o)
{
    if (o->rig.path == NULL) {
        return files_load(o) && moving_load(o) && is_open(o);
    }
    bool is_fine = rig_load(o) && moving_load(o) && rig_spread(o);
    for (size_t i = 0; i < o->rig.count && is_fine; i++) {
        is_fine = is_open(&o->rig.sensors[i]);
    }
    return is_fine;
}

int options_parse(int argc, char **argv, struct options *out)
{
    static const struct option_table table = {"lumsim", "lumsim --help", specs,
                                              SPECS, false};
    struct option_result result;
    set_defaults(out);
    const enum option_end end =
        option_table_read(&table, argc, argv, out, &result);
    if (end == OPTIONS_SHOWN) {
        return end_output();
    }
    if (end == OPTIONS_REFUSED) {
        return EXIT_USAGE;
    }
    if (result.count > 0) {
        (void)complain("'%s': no argument is expected beside the options; -o "
                       "FILE names an output",
                       argv[1]);
        return see_help();
    }
    choose_mode(out);
    if (!check_choice(out) || !check_modes(out, &result) || !check_set(out) ||
        !standing_check(out) || !rig_check(out) || !moving_check(out) ||
        !files_check(out)) {
        return see_help();
    }
    return load(out) ? -1 : EXIT_USAGE;
}
