#include "standing.h"

#include "../common/number.h"
#include "../common/option_table.h"
#include "base/text.h"
#include "sim/blocks.h"

#include <stdio.h>
#include <string.h>

#define POSE_NUMBERS 6
#define PLACE_MAX_M  1000.0
#define TURN_MAX_DEG 360.0
#define NOISE_MAX_M  1.0
#define TEXT_MAX     64
#define CAUSE_MAX    160

const struct option_word standing_scenes[] = {{"street", LUM_PLACE_STREET},
                                              {"room", LUM_PLACE_ROOM},
                                              {"yard", LUM_PLACE_YARD},
                                              {"town", LUM_PLACE_TOWN},
                                              {NULL, 0}};
const struct option_word standing_walls[] = {{"flat", LUM_WALLS_FLAT},
                                             {"mild", LUM_WALLS_MILD},
                                             {"rough", LUM_WALLS_ROUGH},
                                             {NULL, 0}};

static const char *word_of(const struct option_word *words, unsigned number)
{
    while (words->text != NULL && words->number != number) {
        words++;
    }
    return words->text;
}

const char *standing_scene(const struct options *o)
{
    return word_of(standing_scenes, (unsigned)o->render.place.kind);
}

/* The number before the next comma; NULL: it is none within the bounds, else
 * what follows it. */
static const char *take_number(const char *text, double low, double high,
                               double *out)
{
    char number[TEXT_MAX];
    const size_t len = strcspn(text, ",");
    if (len >= sizeof number) {
        return NULL;
    }
    (void)memcpy(number, text, len);
    number[len] = '\0';
    return number_parse_real(number, low, high, out) ? text + len : NULL;
}

bool standing_take_pose(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    static const char *const names[POSE_NUMBERS] = {"x",    "y",     "z",
                                                    "roll", "pitch", "yaw"};
    lum_stance *p = &o->render.place.pose;
    double *const values[POSE_NUMBERS] = {&p->at[0],     &p->at[1],
                                          &p->at[2],     &p->roll_deg,
                                          &p->pitch_deg, &p->yaw_deg};
    const char *at = text;
    for (int i = 0; i < POSE_NUMBERS; i++) {
        const double most = i < 3 ? PLACE_MAX_M : TURN_MAX_DEG;
        const char *rest = take_number(at, -most, most, values[i]);
        const char *end = i + 1 < POSE_NUMBERS ? "," : "";
        if (rest == NULL) {
            (void)lum_error_set(
                why, "'%.200s': %s is not a number from %g to %g; use %s", text,
                names[i], -most, most, STANDING_POSE);
            return false;
        }
        if (*rest != *end) {
            return false;
        }
        at = rest + (*end != '\0');
    }
    o->render.place.has_pose = true;
    return true;
}

/* The last number is that of all further returns. */
bool standing_take_noise(void *options, const char *text, lum_error *why)
{
    struct options *o = options;
    float *noise = o->render.noise_m;
    const char *at = text;
    unsigned n = 0;
    for (bool ends = false; !ends; n++) {
        double m = 0.0;
        const char *rest = n < LUM_RENDER_RETURNS_MAX
                               ? take_number(at, 0.0, NOISE_MAX_M, &m)
                               : NULL;
        if (rest == NULL) {
            (void)lum_error_set(why, "'%.200s' is not %s; at most %u", text,
                                STANDING_NOISE, LUM_RENDER_RETURNS_MAX);
            return false;
        }
        noise[n] = (float)m;
        ends = *rest == '\0';
        at = rest + 1;
    }
    for (; n < LUM_RENDER_RETURNS_MAX; n++) {
        noise[n] = noise[n - 1];
    }
    return true;
}

bool standing_check(const struct options *o)
{
    const lum_place_kind kind = o->render.place.kind;
    if (o->has_walls && (kind == LUM_PLACE_STREET || kind == LUM_PLACE_TOWN)) {
        return complain("--walls is about the faces of --scene room and "
                        "--scene yard; a %s has no flat faces",
                        standing_scene(o));
    }
    return true;
}

/* The first block is the place itself. */
static void name_bounds(lum_blocks blocks)
{
    const lum_block *b = &blocks.list[0];
    for (int i = 0; i < 3; i++) {
        const double middle = (double)b->middle[i];
        const double half = (double)b->size[i] / 2.0;
        (void)fprintf(stderr, "%s%c %sfrom %.4g to %.4g m", i == 0 ? "" : ", ",
                      "xyz"[i], i == 0 ? "goes " : "", middle - half,
                      middle + half);
    }
    (void)fputc('\n', stderr);
}

static const char *cause(const struct options *o, char text[CAUSE_MAX],
                         const double *time_s)
{
    text[0] = '\0';
    if (o->rig.name != NULL) {
        lum_text_add(text, CAUSE_MAX, "--rig: the sensor '%s', with ",
                     o->rig.name);
    }
    if (time_s != NULL) {
        lum_text_add(text, CAUSE_MAX, "--path, %.3f s after the beginning",
                     *time_s);
    } else {
        lum_text_add(text, CAUSE_MAX, "%s",
                     o->render.place.has_pose ? "--pose"
                     : o->rig.name != NULL
                         ? "its pose on a vehicle that stands at 0,0,0 "
                           "(or use --pose)"
                         : "the mount of an eye");
    }
    return text;
}

static bool refuse(const struct options *o, const char *eye,
                   const double *time_s)
{
    char text[CAUSE_MAX];
    (void)fprintf(stderr,
                  "lumsim: %s: the %s eye would be outside the %s or less than "
                  "%g m from something in it; ",
                  cause(o, text, time_s), eye, standing_scene(o),
                  (double)LUM_SHAPE_NEAREST);
    switch (o->render.place.kind) {
    case LUM_PLACE_ROOM:
        name_bounds(lum_blocks_of_room());
        break;
    case LUM_PLACE_YARD:
        name_bounds(lum_blocks_of_yard());
        break;
    case LUM_PLACE_TOWN:
        (void)fputs("it goes along streets, at least 0.5 m above the road, or "
                    "above 20.5 m\n",
                    stderr);
        break;
    case LUM_PLACE_STREET:
    default:
        (void)fputs("y goes from -7.5 to 11 m, z from 0.5 to 30 m above the "
                    "road\n",
                    stderr);
    }
    return false;
}

bool standing_see_eyes(const struct options *o, const lum_place *place,
                       const double *time_s)
{
    static const char *const names[LUM_EYES] = {
        [LUM_EYE_BLUE] = "blue", [LUM_EYE_GREEN] = "green"};
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        float mount[3];
        for (int i = 0; i < 3; i++) {
            mount[i] =
                (float)((double)o->render.calibration.eye[eye].mount_um[i] *
                        1e-6);
        }
        if (!(time_s != NULL ? lum_place_is_open_at(place, *time_s, mount)
                             : lum_place_is_open(place, mount))) {
            return refuse(o, names[eye], time_s);
        }
    }
    return true;
}

bool standing_is_open(const struct options *o)
{
    lum_place place;
    lum_place_init(&place, &o->render.place, o->render.seed);
    return standing_see_eyes(o, &place, NULL);
}
