#include "command.h"

#include "../common/number.h"
#include "lum/smooth.h"

#include <string.h>

#define SPEED_MIN 0.01
#define SPEED_MAX 100.0
#define STEP_MAX  1000000

/* Beyond it numbers of a page are no whole ones any more. */
#define FRAME_MAX (INT64_C(1) << 53)

static bool take_nothing(char *text, struct command *out)
{
    (void)out;
    return text == NULL;
}

static bool take_view(char *text, struct command *out)
{
    static const char *const edges[] = {[LUM_EDGES_RISING] = "rising",
                                        [LUM_EDGES_FALLING] = "falling",
                                        [LUM_EDGES_BOTH] = "both"};
    char *window = text != NULL ? strchr(text, ' ') : NULL;
    int64_t smooth = 0;
    if (window == NULL) {
        return false;
    }
    *window++ = '\0';
    if (!number_parse_int(window, 0, LUM_SMOOTH_WINDOW_MAX, &smooth) ||
        (smooth != 0 && smooth % 2 == 0)) {
        return false;
    }
    out->view.smooth = (unsigned)smooth;
    for (unsigned i = 0; i < sizeof edges / sizeof edges[0]; i++) {
        if (edges[i] != NULL && strcmp(text, edges[i]) == 0) {
            out->view.edges = (lum_edges)i;
            return true;
        }
    }
    return false;
}

static bool take_frames(char *text, struct command *out)
{
    return text != NULL &&
           number_parse_int(text, 1, FEED_FRAMES_MAX, &out->number);
}

static bool take_past(char *text, struct command *out)
{
    char *which = text != NULL ? strchr(text, ' ') : NULL;
    int64_t past = 0;
    if (which == NULL) {
        return false;
    }
    *which++ = '\0';
    if (!number_parse_int(text, -FRAME_MAX, FRAME_MAX, &out->number) ||
        !number_parse_int(which, 0, FRAME_MAX, &past)) {
        return false;
    }
    out->past = (uint64_t)past;
    return true;
}

static bool take_step(char *text, struct command *out)
{
    return text != NULL &&
           number_parse_int(text, -STEP_MAX, STEP_MAX, &out->number);
}

static bool take_seek(char *text, struct command *out)
{
    return text != NULL &&
           number_parse_int(text, -FRAME_MAX, FRAME_MAX, &out->number);
}

static bool take_speed(char *text, struct command *out)
{
    return text != NULL &&
           number_parse_real(text, SPEED_MIN, SPEED_MAX, &out->speed);
}

static bool take_loop(char *text, struct command *out)
{
    out->loops = text != NULL && strcmp(text, "on") == 0;
    return out->loops || (text != NULL && strcmp(text, "off") == 0);
}

static const struct {
    const char *name;
    enum command_kind kind;
    bool (*take)(char *text, struct command *out); /* NULL: no text */
} table[] = {
    {"view", COMMAND_VIEW, take_view},
    {"frames", COMMAND_FRAMES, take_frames},
    {"past", COMMAND_PAST, take_past},
    {"play", COMMAND_PLAY, take_nothing},
    {"pause", COMMAND_PAUSE, take_nothing},
    {"step", COMMAND_STEP, take_step},
    {"seek", COMMAND_SEEK, take_seek},
    {"speed", COMMAND_SPEED, take_speed},
    {"loop", COMMAND_LOOP, take_loop},
};

bool command_parse(const char *text, size_t len, struct command *out)
{
    char copy[COMMAND_BYTES + 1u];
    if (len > COMMAND_BYTES || memchr(text, '\0', len) != NULL) {
        return false;
    }
    (void)memcpy(copy, text, len);
    copy[len] = '\0';
    char *space = strchr(copy, ' ');
    if (space != NULL) {
        *space++ = '\0';
    }
    *out = (struct command){.kind = COMMAND_PLAY};
    for (size_t i = 0; i < sizeof table / sizeof table[0]; i++) {
        if (strcmp(copy, table[i].name) == 0) {
            out->kind = table[i].kind;
            return table[i].take(space, out);
        }
    }
    return false;
}
