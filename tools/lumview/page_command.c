#include "page_command.h"

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
    bool (*take)(char *text, struct command *out); /* NULL: one number, */
    int64_t min;                                   /* from this */
    int64_t max;                                   /* to this */
} table[] = {
    {"view", COMMAND_VIEW, take_view, 0, 0},
    {"frames", COMMAND_FRAMES, NULL, 1, FEED_FRAMES_MAX},
    {"past", COMMAND_PAST, take_past, 0, 0},
    {"play", COMMAND_PLAY, take_nothing, 0, 0},
    {"pause", COMMAND_PAUSE, take_nothing, 0, 0},
    {"step", COMMAND_STEP, NULL, -STEP_MAX, STEP_MAX},
    {"seek", COMMAND_SEEK, NULL, -FRAME_MAX, FRAME_MAX},
    {"speed", COMMAND_SPEED, take_speed, 0, 0},
    {"loop", COMMAND_LOOP, take_loop, 0, 0},
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
            return table[i].take != NULL
                       ? table[i].take(space, out)
                       : space != NULL &&
                             number_parse_int(space, table[i].min, table[i].max,
                                              &out->number);
        }
    }
    return false;
}
