/* The feed of lumview and the one who looks at it, in one thread: what the
 * server does for a browser, for a page that holds the captures itself. */
#include "../feed.h"
#include "../setting_files.h"
#include "../true_points.h"
#include "../viewer.h"
#include "inputs.h"

#include "lum/base/time.h"

#include <string.h>

#define TICK_NS INT64_C(500000000)

/* What engine_next() gives. */
enum next {
    NEXT_TEXT = 1,
    NEXT_PIECE = 2 /* of a frame, as lum/frame/packed.h has it */
};

static struct engine {
    struct options options;
    struct files files;
    struct feed *feed;
    struct viewers viewers;
    struct viewer viewer;
    struct viewer_message message;
    bool is_awake;
    int64_t tick_ns;
} engine;

static void wake(void *context)
{
    struct engine *e = context;
    e->is_awake = true;
}

static int take_inputs(struct options *o, lum_error *error)
{
    const struct inputs *in = inputs_look();
    o->calibration = in->names[INPUT_CALIBRATION];
    o->profile = in->names[INPUT_PROFILE];
    o->second = in->names[INPUT_SECOND];
    o->rig_path = in->names[INPUT_RIG];
    o->beside.poses_path = in->names[INPUT_POSES];
    if (sources_init(&o->sources, (const char *const *)in->captures,
                     in->capture_count, error) != 0) {
        return -1;
    }
    o->source = in->capture_count == 1 ? in->captures[0] : o->sources.name;
    return 0;
}

static int start(struct engine *e, lum_error *error)
{
    struct options *o = &e->options;
    if (take_inputs(o, error) != 0 || files_load(o, &e->files, error) != 0 ||
        feed_open(o, &e->files.geometry,
                  o->second != NULL ? &e->files.second : NULL, wake, e,
                  &e->feed, error) != 0) {
        return -1;
    }
    if (viewers_init(&e->viewers, o, 0) != 0) {
        return lum_error_set(error, "out of memory");
    }
    e->viewers.feed = e->feed;
    viewers_add(&e->viewers, &e->viewer);
    return 0;
}

/* Begin, once, with what was handed over. 0, or -1 with an error. */
EXPORTED(engine_open) int engine_open(unsigned is_paused);
int engine_open(unsigned is_paused)
{
    engine.options.play =
        (struct play_options){.paused = is_paused != 0, .speed = 1.0};
    engine.options.quiet = true;
    return start(&engine, inputs_error());
}

/* The text is a command of the page. 0; -1: it is none. */
EXPORTED(engine_command) int engine_command(void);
int engine_command(void)
{
    const char *text = inputs_text();
    return viewer_take(&engine.viewers, &engine.viewer, text, strlen(text))
               ? 0
               : lum_error_set(inputs_error(), "no such command: %s", text);
}

/* Work for some milliseconds. Returns the nanoseconds until there is more to
 * do. */
EXPORTED(engine_work) double engine_work(void);
double engine_work(void)
{
    struct engine *e = &engine;
    const int64_t wait_ns = feed_work(e->feed);
    const int64_t now_ns = lum_time_monotonic_ns();
    if (e->is_awake) {
        e->is_awake = false;
        viewers_wake(&e->viewers);
    }
    if (now_ns >= e->tick_ns) {
        e->tick_ns = now_ns + TICK_NS;
        viewers_tick(&e->viewers);
    }
    const int64_t left_ns = e->tick_ns - now_ns;
    return (double)(wait_ns < left_ns ? wait_ns : left_ns);
}

/* The next message for the page: ::next, 0: there is none, or -1 with an error.
 */
EXPORTED(engine_next) int engine_next(void);
int engine_next(void)
{
    struct viewer_message *m = &engine.message;
    const int found = viewer_next(&engine.viewers, &engine.viewer, m);
    if (found <= 0) {
        return found == 0 ? 0 : lum_error_set(inputs_error(), "out of memory");
    }
    return m->is_text ? (int)NEXT_TEXT : (int)NEXT_PIECE;
}

/* Reads the captures to their end, in place of engine_open(), as points that
 * are true: engine_bytes() are an array then. 0, or -1 with an error. */
EXPORTED(engine_truth) int engine_truth(void);
int engine_truth(void)
{
    struct options *o = &engine.options;
    struct truth truth;
    o->quiet = true;
    if (take_inputs(o, inputs_error()) != 0 ||
        files_load(o, &engine.files, inputs_error()) != 0 ||
        truth_read(o, &engine.files.geometry, o->sources.paths,
                   o->sources.count, &truth, inputs_error()) != 0) {
        return -1;
    }
    engine.message.bytes = (unsigned char *)truth.bytes;
    engine.message.len = truth.len;
    return 0;
}

EXPORTED(engine_bytes) const unsigned char *engine_bytes(void);
const unsigned char *engine_bytes(void)
{
    return engine.message.bytes;
}

EXPORTED(engine_length) size_t engine_length(void);
size_t engine_length(void)
{
    return engine.message.len;
}
