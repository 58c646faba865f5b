#include "scene_feed.h"

#define USUAL_THRESHOLD 50.0f /* percent: the strength that is called 1 */

static void forget_line(struct scene *scene)
{
    scene->count = 0;
    scene->next = 0;
    scene->is_held = false;
}

void scene_load(struct scene *scene, lum_reel *reel, int64_t now_ns)
{
    const bool goes_on = scene->reel != NULL &&
                         lum_reel_lines(scene->reel) == lum_reel_lines(reel);
    lum_reel_free(scene->reel);
    scene->reel = reel;
    if (goes_on) {
        forget_line(scene);
        return;
    }
    scene->line_ns = 1e9 / scene->rate_hz / (double)lum_reel_lines(reel);
    scene_begin(scene, now_ns);
}

void scene_begin(struct scene *scene, int64_t now_ns)
{
    scene->begin_ns = now_ns;
    scene->current_ns = now_ns;
    scene->line = 0;
    scene->round = 0;
    forget_line(scene);
}

bool scene_hold(struct scene *scene, bool is_held)
{
    scene->is_held = is_held;
    return scene->next == scene->count;
}

static int64_t line_begins_ns(const struct scene *scene, int64_t line)
{
    return scene->begin_ns + (int64_t)((double)line * scene->line_ns);
}

static lum_reel_settings settings_of(const lum_device *device, int64_t now_ns)
{
    lum_reel_settings settings = {0};
    if (lum_device_laser_is_up(device)) {
        settings.gain = lum_device_gain(device, now_ns);
    }
    for (unsigned eye = 0; eye < LUM_EYES; eye++) {
        settings.threshold[eye] =
            (float)device->settings.threshold[eye] / USUAL_THRESHOLD;
    }
    return settings;
}

/* The datagrams of the line of that number, with that gain. */
static void make_line(struct scene *scene, const lum_device *device,
                      int64_t line)
{
    const int64_t lines = (int64_t)lum_reel_lines(scene->reel);
    const int64_t frames = (int64_t)lum_reel_frames(scene->reel);
    const lum_reel_settings settings = settings_of(device, scene->current_ns);
    scene->count = lum_reel_line(
        scene->reel, (unsigned)(line / lines % frames),
        (uint32_t)(line % lines), &settings,
        lum_device_since_boot_us(device, scene->current_ns), scene->packets);
}

/* When the next packet of the line under way leaves: evenly over its time. */
static int64_t packet_leaves_ns(const struct scene *scene)
{
    return scene->current_ns +
           (int64_t)(scene->line_ns * (double)(scene->next + 1) /
                     (double)scene->count);
}

static void skip_what_is_too_late(struct scene *scene, int64_t now_ns)
{
    const int64_t behind_ns = now_ns - line_begins_ns(scene, scene->line);
    if (behind_ns > FEED_LAG_MAX_NS) {
        const int64_t lines = (int64_t)((double)behind_ns / scene->line_ns);
        scene->line += lines;
        scene->lines_skipped += (uint64_t)lines;
    }
}

static void note_round(struct scene *scene)
{
    const int64_t round = scene->line / ((int64_t)lum_reel_lines(scene->reel) *
                                         (int64_t)lum_reel_frames(scene->reel));
    scene->rounds_again += round != scene->round ? 1 : 0;
    scene->round = round;
}

/* Whether there is a line under way with something left. */
static bool open_line(struct scene *scene, const lum_device *device,
                      int64_t now_ns)
{
    if (scene->next < scene->count) {
        return true;
    }
    if (scene->is_held) {
        return false;
    }
    skip_what_is_too_late(scene, now_ns);
    const int64_t begins_ns = line_begins_ns(scene, scene->line);
    if (begins_ns > now_ns) {
        return false;
    }
    note_round(scene);
    scene->current_ns = begins_ns;
    scene->next = 0;
    make_line(scene, device, scene->line);
    scene->line++;
    scene->lines_sent++;
    return scene->count > 0;
}

size_t scene_take(struct scene *scene, const lum_device *device, int64_t now_ns,
                  lum_outgoing *out, size_t max)
{
    size_t n = 0;
    if (scene->reel == NULL) {
        return 0;
    }
    while (n < max && open_line(scene, device, now_ns) &&
           packet_leaves_ns(scene) <= now_ns) {
        const lum_reel_packet *p = &scene->packets[scene->next++];
        out[n++] = (lum_outgoing){.bytes = p->bytes, .len = p->len};
    }
    return n;
}

int64_t scene_next_ns(const struct scene *scene)
{
    if (scene->reel == NULL) {
        return INT64_MAX;
    }
    if (scene->next < scene->count) {
        return packet_leaves_ns(scene);
    }
    return scene->is_held ? 0 : line_begins_ns(scene, scene->line);
}

void scene_darken(struct scene *scene, const lum_device *device)
{
    if (scene->next < scene->count) {
        make_line(scene, device, scene->line - 1);
    }
}
