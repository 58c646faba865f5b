/** @file
 * The places that a simulated sensor looks at, and where it stands in them.
 *
 * It stands, or moves along a path; in a street it drives if nothing else is
 * said. A room and a yard are of flat faces, whose planes are known exactly.
 * All faces are those of the same blocks with any seed; the seed gives their
 * waves. */
#ifndef LUM_SIM_PLACE_H
#define LUM_SIM_PLACE_H

#include "face.h"
#include "lum/pose.h"
#include "path.h"
#include "shape.h"
#include "street.h"

#include <stdbool.h>
#include <stdint.h>

/** Which place. */
typedef enum lum_place_kind {
    LUM_PLACE_STREET, /**< houses, vehicles, people, trees */
    LUM_PLACE_ROOM,   /**< 8 x 6 x 3 m, with things in it */
    LUM_PLACE_YARD,   /**< 30 x 20 m between houses, without a roof */
    LUM_PLACE_TOWN    /**< streets around blocks of houses */
} lum_place_kind;

/** How flat the faces of a room or yard are, and how exact the sensor is. */
typedef enum lum_walls {
    LUM_WALLS_FLAT, /**< planes */
    LUM_WALLS_MILD, /**< as usual walls: ::LUM_WALLS_RMS_M and the others */
    LUM_WALLS_ROUGH /**< twice that */
} lum_walls;

/** Waves of mild walls, root mean square; metres. */
#define LUM_WALLS_RMS_M 0.0014

/** Standard deviation of the bias of ranges to a face of mild walls; metres. */
#define LUM_WALLS_BIAS_M 0.002

/** Height of the sine by which encoders are wrong where walls are mild;
 * degrees. */
#define LUM_WALLS_ENCODER_DEG 0.003

/** Where the sensor stands, in the frame of the place: x forward, y left, z up.
 * The origin of a room and a yard lies on the floor, near its middle; that of a
 * street on the road below the sensor at the beginning of the drive. */
typedef struct lum_stance {
    double at[3]; /**< metres */
    double roll_deg;
    double pitch_deg;
    double yaw_deg;
} lum_stance;

/** What to lay out. All 0: the drive along the street. */
typedef struct lum_place_options {
    lum_place_kind kind;
    lum_walls walls;    /**< of a street ::LUM_WALLS_FLAT */
    bool has_pose;      /**< else a room and a yard have lum_place_usual_pose(),
                             and the street is driven along */
    lum_stance pose;    /**< where has_pose */
    lum_path path;      /**< but LUM_PATH_NONE: it moves, all the time; then
                             has_pose is false, and course is set by
                             lum_place_init() */
    bool is_on_vehicle; /**< pose and path are those of a vehicle, and the
                             sensor is on it; a street has one of both */
    lum_pose on_vehicle; /**< where it is on it */
} lum_place_options;

/** Most faces of a place. */
#define LUM_PLACE_FACES_MAX 96u

/** A place. Private except its size; shapes that it laid out point into it. */
typedef struct lum_place {
    lum_place_options options;               /**< private: pose is the
                                                  sensor's */
    lum_stance vehicle;                      /**< private: of one that stands */
    uint64_t seed;                           /**< private */
    float rotation[9];                       /**< private: sensor to place */
    float middle[LUM_PLACE_FACES_MAX][3];    /**< private: of each face */
    float reflectivity[LUM_PLACE_FACES_MAX]; /**< private */
    uint8_t block[LUM_PLACE_FACES_MAX];      /**< private: that it is of */
    lum_face faces[LUM_PLACE_FACES_MAX];     /**< private */
    unsigned face_count;                     /**< private */
} lum_place;

/** Where the sensor stands if nothing else is said: in the middle of a room or
 * yard, and at the beginning of the drive. A vehicle's frame stands below, at
 * z = 0. */
lum_stance lum_place_usual_pose(lum_place_kind kind);

/** Begin. Cannot fail. */
void lum_place_init(lum_place *out, const lum_place_options *options,
                    uint64_t seed);

/** Whether a path of this kind is one of the place. */
bool lum_place_has_path(lum_place_kind kind, lum_path_kind path);

/** Whether the sensor moves during a frame, and all that can move there. */
bool lum_place_moves(const lum_place *place);

/** Where the sensor is, in the frame of the place.
 * @param time_s since the beginning of the drive; of a street without a path,
 *               that of a frame. */
lum_pose lum_place_pose(const lum_place *place, double time_s);

/** Where its vehicle is; the sensor, if it is on none. */
lum_pose lum_place_vehicle_pose(const lum_place *place, double time_s);

/** Whether the place and the sensor stand still: every moment is the same. */
bool lum_place_is_still(const lum_place *place);

/** By how much the encoders are wrong: height of a sine, degrees. */
double lum_place_encoder_deg(const lum_place *place);

/** The seed of noise: of a still place another one for each pose, so that no
 * noise is common to two recordings of a room. */
uint64_t lum_place_noise_seed(const lum_place *place);

/** A direction of the sensor's frame in that of the place. */
void lum_place_turn(const lum_place *place, const float sensor[3],
                    float out[3]);

/** Whether an eye is in the open: inside the place and at least
 * ::LUM_SHAPE_NEAREST away from everything, as nothing nearer is seen. Of a
 * street only its width and a height are checked.
 * @param mount where the eye is in the frame of the sensor, metres. */
bool lum_place_is_open(const lum_place *place, const float mount[3]);

/** As lum_place_is_open(), of a sensor that moves, at a time. */
bool lum_place_is_open_at(const lum_place *place, double time_s,
                          const float mount[3]);

/** Lay out the shapes around a point of a place where all moves.
 * @param time_s since the beginning of the drive.
 * @param view   in the frame of the place; what is outside may be left out.
 * @param out    as lum_place_lay_out(). */
void lum_place_lay_out_around(const lum_place *place, double time_s,
                              const lum_sight_view *view, lum_shape_list *out,
                              lum_ground *ground);

/** Lay out the shapes around an eye, with the axes of the place.
 * @param time_s since the beginning of the drive; only for a street.
 * @param mount  as lum_place_is_open().
 * @param out    emptied, then filled; failed is set when there is no memory.
 * @param ground gets the ground of the street. */
void lum_place_lay_out(const lum_place *place, double time_s,
                       const float mount[3], lum_shape_list *out,
                       lum_ground *ground);

#endif
