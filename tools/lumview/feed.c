#define _POSIX_C_SOURCE 200809L
#include "feed.h"

#include "../common/provenance.h"
#include "../common/rig_sensors.h"
#include "capture_player.h"
#include "sensor_link.h"
#include "stage.h"

#include <math.h>
#include <stdlib.h>

#define SPEED_MIN 0.01
#define SPEED_MAX 100.0
#define PI        3.14159265358979323846

/* How a sensor's packets become points. */
struct feed_sensor {
    lum_layout layout;
    lum_projector projector; /* of a rig, in the vehicle's frame */
};

struct feed {
    struct stage stage;
    struct feed_sensor sensors[LUM_RIG_SENSORS_MAX]; /* without a rig one */
    lum_rig_member members[LUM_RIG_SENSORS_MAX];
    bool has_second; /* another profile's */
    lum_layout second_layout;
    lum_projector second_projector;
    struct provenance_source said; /* of a capture's files */
    struct frame_pool *pool;
    struct player *player; /* of a capture */
    struct link *link;     /* of a sensor */
};

static double clamp_speed(double speed)
{
    return speed >= SPEED_MIN ? fmin(speed, SPEED_MAX) : SPEED_MIN;
}

static int start(struct feed *feed, const struct options *o, lum_error *error)
{
    struct decoder_options decoder = {.layout = &feed->sensors[0].layout,
                                      .projector = &feed->sensors[0].projector,
                                      .sensor = o->sensor,
                                      .stage = &feed->stage};
    if (o->rig != NULL) {
        decoder.members = feed->members;
        decoder.member_count = o->rig->rig.count;
        decoder.rig = o->sensor.is_given ? NULL : &o->rig->rig;
    }
    if (feed->has_second) {
        decoder.second_layout = &feed->second_layout;
        decoder.second_projector = &feed->second_projector;
    }
    if (!o->is_live) {
        const struct player_options options = {.sources = &o->sources,
                                               .said = &feed->said,
                                               .rig = o->rig_path,
                                               .is_quiet = o->quiet,
                                               .decoder = decoder};
        return player_start(&options, &feed->player, error);
    }
    decoder.sensor.is_given = true;
    decoder.sensor.address = o->live.address.address;
    const struct link_options options = {.live = o->live, .decoder = decoder};
    return link_start(&options, &feed->link, error);
}

static int make(const struct options *o, const struct geometry *from,
                lum_layout *layout, lum_projector *projector, lum_error *error)
{
    struct geometry geometry = *from;
    return geometry_set(&geometry, &o->set, error) == 0
               ? geometry_make(&geometry, layout, projector, error)
               : -1;
}

/* Each sensor of a rig has its own, and what captures say of themselves is not
 * taken. */
static int make_rig(struct feed *feed, const lum_rig_files *files, size_t shown,
                    lum_error *error)
{
    feed->said.takes_calibration = true;
    feed->said.takes_profile = true;
    for (size_t i = 0; i < files->rig.count; i++) {
        const lum_rig_sensor *s = &files->rig.sensor[i];
        const struct geometry geometry = {.calibration =
                                              files->sensor[i].calibration,
                                          .profile = files->sensor[i].profile};
        const lum_pose pose = rig_pose(s);
        struct feed_sensor *to = &feed->sensors[i];
        if (geometry_make(&geometry, &to->layout, &to->projector, error) != 0) {
            return -1;
        }
        lum_projector_place(&to->projector, &pose);
        feed->members[i] = (lum_rig_member){
            .address = s->address,
            .interface = s->interface[0] != '\0' ? s->interface : NULL,
            .layout = &to->layout,
            .projector = &to->projector,
            .is_left_out = i >= shown};
    }
    return 0;
}

/* What a stream says of itself comes too late, as the page is there before: the
 * player tells that. */
static int complete(struct feed *feed, const struct options *o,
                    const struct geometry *loaded, const lum_profile *second,
                    lum_error *error)
{
    struct geometry geometry = *loaded;
    if (o->rig != NULL) {
        return make_rig(feed, o->rig, o->shown, error);
    }
    if (!o->is_live) {
        provenance_ask("lumview", &o->sources, o->quiet, &geometry,
                       &feed->said);
    }
    if (make(o, &geometry, &feed->sensors[0].layout,
             &feed->sensors[0].projector, error) != 0) {
        return -1;
    }
    if (second == NULL) {
        return 0;
    }
    feed->has_second = true;
    geometry.profile = *second;
    return make(o, &geometry, &feed->second_layout, &feed->second_projector,
                error);
}

static void release(struct feed *feed)
{
    stage_end(&feed->stage);
    frame_pool_free(feed->pool);
    free(feed);
}

int feed_open(const struct options *options, const struct geometry *geometry,
              const lum_profile *second, void (*wake)(void *context),
              void *context, struct feed **out, lum_error *error)
{
    struct feed *feed = calloc(1, sizeof *feed);
    if (feed == NULL) {
        return lum_error_set(error, "out of memory");
    }
    if (!stage_init(&feed->stage, wake, context)) {
        free(feed);
        return lum_error_set(error, "out of memory");
    }
    feed->stage.orders.plays = !options->play.paused;
    feed->stage.orders.loops = options->play.loops;
    feed->stage.orders.speed = clamp_speed(options->play.speed);
    feed->stage.orders.frames = 1;
    feed->stage.status.is_live = options->is_live;
    feed->pool = frame_pool_new();
    feed->stage.pool = feed->pool;
    if (feed->pool == NULL ||
        complete(feed, options, geometry, second, error) != 0 ||
        start(feed, options, error) != 0) {
        release(feed);
        return -1;
    }
    *out = feed;
    return 0;
}

int feed_close(struct feed *feed, lum_error *error)
{
    stage_begin_order(&feed->stage)->closing = true;
    stage_end_order(&feed->stage);
    player_end(feed->player);
    const int result = link_end(feed->link, error);
    release(feed);
    return result;
}

int64_t feed_work(struct feed *feed)
{
    return player_work(feed->player);
}

void feed_want(struct feed *feed, const struct feed_view *views, size_t count)
{
    struct orders *orders = stage_begin_order(&feed->stage);
    struct feed_views *wanted = &feed->stage.views;
    orders->is_wanted = count > 0;
    wanted->count = count < FEED_VIEWS_MAX ? count : FEED_VIEWS_MAX;
    for (size_t i = 0; i < wanted->count; i++) {
        wanted->at[i] = views[i];
    }
    stage_end_order(&feed->stage);
}

void feed_keep(struct feed *feed, unsigned frames)
{
    stage_begin_order(&feed->stage)->frames = frames;
    stage_end_order(&feed->stage);
}

static struct frame *keep(struct frame *frame)
{
    return frame != NULL ? frame_keep(frame) : NULL;
}

struct frame *feed_newest(struct feed *feed, const struct feed_view *view)
{
    (void)stage_begin_look(&feed->stage);
    struct frame *frame = keep(picture_find(&feed->stage.shown, view));
    stage_end_look(&feed->stage);
    return frame;
}

struct frame *feed_past(struct feed *feed, const struct feed_view *view,
                        int64_t number)
{
    (void)stage_begin_look(&feed->stage);
    const struct picture *picture = trail_find(&feed->stage.trail, number);
    struct frame *frame =
        picture != NULL ? keep(picture_find(picture, view)) : NULL;
    stage_end_look(&feed->stage);
    return frame;
}

void feed_look(struct feed *feed, struct feed_status *out)
{
    *out = *stage_begin_look(&feed->stage);
    out->speed = feed->stage.orders.speed;
    out->loops = feed->stage.orders.loops;
    stage_end_look(&feed->stage);
}

void feed_look_marks(struct feed *feed, struct feed_marks *out)
{
    (void)stage_begin_look(&feed->stage);
    *out = feed->stage.marks;
    stage_end_look(&feed->stage);
}

/* The projector's rotation has the azimuth's centre in it, about which a scan
 * is computed; it is taken out. */
void feed_geometry(const struct feed *feed, unsigned eye, float mount[3],
                   float rotation[9])
{
    const lum_eye_projector *e =
        &feed->sensors[eye / LUM_EYES].projector.eye[eye % LUM_EYES];
    const double center = e->azimuth_center * (PI / 180.0);
    const double ca = cos(center);
    const double sa = sin(center);
    for (unsigned row = 0; row < 3; row++) {
        const float *r = &e->rotation[3u * row];
        mount[row] = e->mount[row];
        rotation[3u * row] = (float)((double)r[0] * ca - (double)r[1] * sa);
        rotation[3u * row + 1u] =
            (float)((double)r[0] * sa + (double)r[1] * ca);
        rotation[3u * row + 2u] = r[2];
    }
}

const lum_profile *feed_profile(const struct feed *feed, bool is_second)
{
    if (is_second && !feed->has_second) {
        return NULL;
    }
    return is_second ? &feed->second_layout.profile
                     : &feed->sensors[0].layout.profile;
}

/* At the end, play starts again. */
void feed_play(struct feed *feed, bool plays)
{
    struct orders *orders = stage_begin_order(&feed->stage);
    if (plays && feed->stage.status.state == FEED_ENDED) {
        orders->has_seek = true;
        orders->seek = INT64_MIN;
        orders->steps = 0;
    }
    orders->plays = plays;
    stage_end_order(&feed->stage);
}

void feed_step(struct feed *feed, int64_t frames)
{
    struct orders *orders = stage_begin_order(&feed->stage);
    orders->plays = false;
    orders->steps = add_clamped(orders->steps, frames);
    stage_end_order(&feed->stage);
}

void feed_seek(struct feed *feed, int64_t frame)
{
    struct orders *orders = stage_begin_order(&feed->stage);
    orders->has_seek = true;
    orders->seek = frame;
    orders->steps = 0;
    stage_end_order(&feed->stage);
}

void feed_speed(struct feed *feed, double speed)
{
    stage_begin_order(&feed->stage)->speed = clamp_speed(speed);
    stage_end_order(&feed->stage);
}

void feed_loop(struct feed *feed, bool loops)
{
    stage_begin_order(&feed->stage)->loops = loops;
    stage_end_order(&feed->stage);
}
