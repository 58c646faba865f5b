/** @file
 * Version of the library. The build reads it from here. */
#ifndef LUM_VERSION_H
#define LUM_VERSION_H

#define LUM_VERSION_MAJOR 0 /**< changes when source compatibility breaks */
#define LUM_VERSION_MINOR 1 /**< changes when something is added */
#define LUM_VERSION_PATCH 0 /**< changes when something is fixed */

/** Used by LUM_VERSION. */
#define LUM_VERSION_TEXT(major, minor, patch) #major "." #minor "." #patch
/** Used by LUM_VERSION. */
#define LUM_VERSION_EXPAND(major, minor, patch)                                \
    LUM_VERSION_TEXT(major, minor, patch)

/** The version as text, such as "0.1.0". */
#define LUM_VERSION                                                            \
    LUM_VERSION_EXPAND(LUM_VERSION_MAJOR, LUM_VERSION_MINOR, LUM_VERSION_PATCH)

#endif
