/** @file
 * Results of all functions of the core. */
#ifndef LUM_RESULT_H
#define LUM_RESULT_H

#if defined(__GNUC__)
/** The caller has to look at the result. */
#define LUM_MUST_CHECK __attribute__((warn_unused_result))
#else
/** The caller has to look at the result. */
#define LUM_MUST_CHECK
#endif

#ifdef __cplusplus
/** A conversion of numbers, in C and in C++. */
#define LUM_CAST(type, value) static_cast<type>(value)
#else
/** A conversion of numbers, in C and in C++. */
#define LUM_CAST(type, value) ((type)(value))
#endif

/** Zero is success, positive values are events, negative ones say why nothing
 * was done. No output is written on a negative result. */
typedef enum lum_result {
    LUM_OK = 0,             /**< done */
    LUM_LINE_READY = 1,     /**< a line waits; take it, then call again */
    LUM_FRAME_READY = 2,    /**< a frame is complete; then call again */
    LUM_END = 3,            /**< nothing is left to iterate over */
    LUM_E_SHORT = -1,       /**< fewer bytes than the packet needs */
    LUM_E_SPACE = -2,       /**< the caller's buffer is too small */
    LUM_E_VALUE = -3,       /**< an argument is outside its range */
    LUM_E_FOREIGN = -4,     /**< no magic: not a packet of this sensor */
    LUM_E_TYPE = -5,        /**< a packet, but of another or unknown type */
    LUM_E_MALFORMED = -6,   /**< lengths or fields contradict each other */
    LUM_E_UNKNOWN_TAG = -7, /**< a data packet, neither angles nor ranges */
    LUM_E_STRAY = -8,       /**< dropped: its clock is far from the stream's */
    LUM_E_LATE = -9,        /**< dropped: its line has been handed out */
    LUM_E_DUPLICATE = -10,  /**< dropped: all its samples had come before */
    LUM_E_CONFLICT = -11,   /**< dropped: some of its samples had come before */
    LUM_E_NO_ROOM = -12,    /**< dropped: the line cannot hold its words */
    LUM_E_ORDER = -13       /**< refused: another call must come first */
} lum_result;

#endif
