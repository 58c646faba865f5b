/** @file
 * A frame: all points of one sweep of one sensor, as columns, with the lines
 * that they came from and what is missing (docs/reader.md).
 *
 * Frames are made by a lum_reader (lum/frame/reader.h) or a lum_framer
 * (lum/frame/framer.h). A frame that was handed out does not change any more,
 * so any number of threads can read it. Its references are counted: to use it
 * for longer than its maker promises, call lum_frame_keep(), and later
 * lum_frame_release(). Both are allowed in any thread, also after the maker has
 * been freed. The memory of released frames is used again for later ones. */
#ifndef LUM_FRAME_FRAME_H
#define LUM_FRAME_FRAME_H

#include "lum/capture/record.h"
#include "lum/points.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/** What is known of a point; each is one column. */
typedef enum lum_column {
    LUM_COLUMN_X,                 /**< float, metres, forward */
    LUM_COLUMN_Y,                 /**< float, metres, left */
    LUM_COLUMN_Z,                 /**< float, metres, up */
    LUM_COLUMN_RANGE,             /**< float, metres from the eye */
    LUM_COLUMN_AZIMUTH,           /**< float, degrees, of the eye */
    LUM_COLUMN_ELEVATION,         /**< float, degrees, of the eye */
    LUM_COLUMN_PULSE_WIDTH,       /**< float, nanoseconds; 0: not known */
    LUM_COLUMN_TIME,              /**< float, seconds from the frame's start */
    LUM_COLUMN_LINE,              /**< uint32_t, line number */
    LUM_COLUMN_PIXEL,             /**< uint16_t, 0..999 */
    LUM_COLUMN_RETURN_NUMBER,     /**< uint16_t, from 1 */
    LUM_COLUMN_NUMBER_OF_RETURNS, /**< uint16_t, of the pixel and edge */
    LUM_COLUMN_EYE,               /**< uint8_t, an ::lum_eye */
    LUM_COLUMN_EDGE,              /**< uint8_t, 1 rising, 0 falling */
    LUM_COLUMN_STRONGEST,         /**< uint8_t, 1: the widest pulse of its
                                       pixel and edge, the first among equals */
    LUM_COLUMN_COUNT              /**< how many there are */
} lum_column;

/** Some columns, a bit each. */
typedef uint32_t lum_columns;

/** The bit of one column. */
#define LUM_COLUMN_BIT(column) (UINT32_C(1) << (column))

/** x, y and z: what is computed fastest. */
#define LUM_COLUMNS_XYZ                                                        \
    (LUM_COLUMN_BIT(LUM_COLUMN_X) | LUM_COLUMN_BIT(LUM_COLUMN_Y) |             \
     LUM_COLUMN_BIT(LUM_COLUMN_Z))

/** Every column: 45 bytes a point. */
#define LUM_COLUMNS_ALL (LUM_COLUMN_BIT(LUM_COLUMN_COUNT) - UINT32_C(1))

/** What the numbers of a column are. */
typedef enum lum_column_type {
    LUM_TYPE_FLOAT,  /**< float */
    LUM_TYPE_UINT32, /**< uint32_t */
    LUM_TYPE_UINT16, /**< uint16_t */
    LUM_TYPE_UINT8   /**< uint8_t */
} lum_column_type;

/** The type of a column. */
lum_column_type lum_column_get_type(lum_column column);

/** The name of a column, as in CSV files: "x", "pulse_width"; NULL if there is
 * no such column. Static. */
const char *lum_column_name(lum_column column);

/** A frame. */
typedef struct lum_frame lum_frame;

/** Keep a frame; returns it. Any thread. */
lum_frame *lum_frame_keep(const lum_frame *frame);

/** Release a frame that was kept; NULL is allowed. Any thread. */
void lum_frame_release(lum_frame *frame);

/** How many points it has. Each column has this number of values. */
size_t lum_frame_count(const lum_frame *frame);

/** Which columns it has. */
lum_columns lum_frame_columns(const lum_frame *frame);

/** The numbers of a column, one a point, beginning at a multiple of 64 bytes;
 * they live as long as the frame.
 *
 * Points are in the order of their lines, as lum_frame_get_line() counts them,
 * and within a line by pixel, then in the order of the returns.
 * @return of the type of lum_column_get_type(); NULL if the frame has no such
 *         column; not NULL if it has the column and no points. */
const void *lum_frame_column(const lum_frame *frame, lum_column column);

/** A column of floats, as lum_frame_column().
 * @return NULL also for a column of another type. */
const float *lum_frame_floats(const lum_frame *frame, lum_column column);

/** A column of 32-bit integers, as lum_frame_floats(). */
const uint32_t *lum_frame_uint32s(const lum_frame *frame, lum_column column);

/** A column of 16-bit integers, as lum_frame_floats(). */
const uint16_t *lum_frame_uint16s(const lum_frame *frame, lum_column column);

/** A column of bytes, as lum_frame_floats(). */
const uint8_t *lum_frame_uint8s(const lum_frame *frame, lum_column column);

/** x, y and z as one array of three rows: x of point i is at [i], y at [spacing
 * + i], z at [2 * spacing + i]. They are the numbers of lum_frame_column(), and
 * each row begins at a multiple of 64 bytes. So code that takes rows at equal
 * distances needs no copy.
 * @param spacing gets the distance of two rows in numbers, at least
 *                lum_frame_count(); 0 if the frame has no points. Untouched on
 *                NULL.
 * @return lives as long as the frame; NULL if the frame lacks one of the three;
 *         not NULL if it has them and no points. */
const float *lum_frame_xyz(const lum_frame *frame, size_t *spacing);

/** The time of a frame, by each clock; all 0 if no line came. It never
 * grows. */
typedef struct lum_frame_times {
    int64_t begin_clock_us;   /**< sensor clock of the earliest line */
    int64_t end_clock_us;     /**< sensor clock of the latest line */
    int64_t begin_arrival_ns; /**< when the earliest line came, ns since 1970 */
    int64_t end_arrival_ns;   /**< when the latest line came */
    int64_t begin_utc_ns;     /**< time of begin_clock_us, ns since 1970 UTC, by
                                   lum_clock_fit_utc(); ::LUM_COLUMN_TIME counts
                                   from it. 0: the layout has no clock, or no line
                                   came */
    int64_t utc_error_ns;     /**< the estimated error of that time;
                                   ::LUM_CLOCK_ERROR_UNKNOWN: unknown, for
                                   example near a step of the host's clock */
} lum_frame_times;

/** Facts about a frame as a whole. */
typedef struct lum_frame_info {
    size_t struct_size;    /**< sizeof(lum_frame_info), set by the caller */
    int64_t number;        /**< frame number */
    uint32_t sensor;       /**< its address, host order */
    bool is_complete;      /**< nothing is known to be missing */
    bool is_first;         /**< first of its sensor: the stream may begin inside
                                it, so it may lack its start */
    bool is_last;          /**< the stream ended with it: it may lack its end */
    lum_frame_times times; /**< when it was */
    uint64_t points;       /**< as lum_frame_count() */
    uint32_t lines[LUM_EYES];         /**< lines that came, by ::lum_eye */
    uint32_t lines_missing[LUM_EYES]; /**< line numbers that did not come, up to
                                           the highest of this frame and of the
                                           one before */
    uint32_t lines_missing_angles;    /**< lines with fewer than 1000 */
    uint64_t lost_words;              /**< range words known to be lost */
    lum_point_losses losses;          /**< words that gave no point */
    uint64_t points_cut; /**< points beyond the frame's limit, or in lines
                              beyond its limit */
    uint64_t lines_cut;  /**< lines beyond ::LUM_FRAME_LINES_MAX */
    uint64_t lines_late; /**< lines that came since the frame before for frames
                              already handed out; they are in no frame */
    uint64_t lines_in_pauses; /**< lines missing by the clock, but not by line
                                   numbers: whole sweeps, and the end of a first
                                   one; as far as known */
    bool has_pause; /**< the sensor or one eye paused inside this frame, or the
                         frame has a part of another sweep; then it is not
                         complete */
    char sensor_interface[LUM_INTERFACE_BYTES]; /**< the sensor's interface, if
                                                     another sensor with its
                                                     address came before; else
                                                     empty */
    uint64_t lines_dark; /**< lines before the first one with a word: if the
                              frame before had no word either, the laser may
                              have come on inside */
    uint32_t member; /**< of a rig: 1 + its place in lum_framer_options.members;
                          0: there is no rig */
} lum_frame_info;

/** Read the info of a frame.
 * @param out the caller sets struct_size; the members within that size are
 *            overwritten.
 * @return LUM_OK; LUM_E_VALUE if struct_size is not set: then nothing is
 *         written.
 *
 * @code
 * lum_frame_info info = {.struct_size = sizeof info};
 * (void)lum_frame_get_info(frame, &info);
 * @endcode */
lum_result lum_frame_get_info(const lum_frame *frame, lum_frame_info *out);

/** Where its sensor is on the vehicle: the pose of its member of a rig
 * (lum_framer_options.members); x y z are in the vehicle's frame. Without one,
 * the identity: x y z are in the sensor's frame. */
lum_pose lum_frame_pose(const lum_frame *frame);

/** Most lines of a frame, both eyes together; further lines are cut off. */
#define LUM_FRAME_LINES_MAX 65536u

/** One line of a frame. */
typedef struct lum_frame_line {
    size_t struct_size;   /**< sizeof(lum_frame_line), set by the caller */
    int64_t clock_us;     /**< sensor clock of its first packet */
    int64_t arrival_ns;   /**< when that came, ns since 1970 UTC */
    uint32_t number;      /**< line number */
    uint32_t first_point; /**< its first point's index */
    uint32_t point_count; /**< its points, from there on; may be 0 */
    uint32_t lost_words;  /**< range words known to be lost */
    uint16_t angle_count; /**< pixels that have angles, 0..1000 */
    uint8_t eye;          /**< an ::lum_eye */
} lum_frame_line;

/** How many lines it has. */
size_t lum_frame_line_count(const lum_frame *frame);

/** The i-th line, in order of completion. The numbers of one eye rise, except
 * if a line was late; lines of the two eyes alternate.
 * @param i   below lum_frame_line_count().
 * @param out as for lum_frame_get_info().
 * @return false if i is too large or struct_size is not set; then out is
 *         untouched. */
bool lum_frame_get_line(const lum_frame *frame, size_t i, lum_frame_line *out);

/** Most rows of an eye that lum_frame_rows() gives. */
#define LUM_FRAME_ROWS_MAX 8192u

/** Rows of an eye: its highest plausible line number, plus 1; 0 if there is
 * none.
 *
 * A damaged packet can claim any number. These rows are at most
 * ::LUM_FRAME_ROWS_MAX, so a grid of them can be allocated. A line with all
 * angles is plausible. Another line with points is plausible if its number is
 * below twice the rows of lines with all angles, in this frame and the one
 * before, plus 64; without such lines, if it is below 4096. Points of other
 * lines are in the frame, but in no row. */
uint32_t lum_frame_rows(const lum_frame *frame, unsigned eye);

/** Marks a cell of a grid that has no point. */
#define LUM_FRAME_MISSING UINT32_MAX

/** A frame of one eye as a grid of lines x 1000 pixels x returns.
 *
 * Cell ((row x 1000) + pixel) x returns + k is the k-th point, from 0, of that
 * line and pixel among those of the frame. If a line number came twice, the
 * first line counts; line numbers from rows on, and points beyond returns, are
 * left out.
 * @param eye     an ::lum_eye.
 * @param rows    lines to be written: lum_frame_rows(), or as many as the
 *                sensor has.
 * @param returns cells of a pixel, at least 1.
 * @param out     rows x 1000 x returns indices of points, or LUM_FRAME_MISSING.
 * @return false if the frame lacks ::LUM_COLUMN_PIXEL or there is no such eye;
 *         then out is untouched. Linear. */
bool lum_frame_grid_index(const lum_frame *frame, unsigned eye, uint32_t rows,
                          uint32_t returns, uint32_t *out);

/** The numbers of a column as such a grid: a range image is one call. Cells
 * without a point are NaN. Integers become floats; exact below 2^24.
 * @return false as lum_frame_grid_index(), or if the frame lacks the column. */
bool lum_frame_grid_floats(const lum_frame *frame, lum_column column,
                           unsigned eye, uint32_t rows, uint32_t returns,
                           float *out);

#ifdef __cplusplus
}
#endif

#endif
