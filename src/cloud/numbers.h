/** @file
 * Types of numbers: how formats name them, and their values in memory as bytes
 * and as text of a file. Internal to cloud; lumdump reads the table. */
#ifndef LUM_CLOUD_NUMBERS_H
#define LUM_CLOUD_NUMBERS_H

#include "lum/cloud/writer.h"

#include <stddef.h>
#include <stdint.h>

/** How formats name a type. */
typedef struct lum_number_spec {
    const char *name;      /**< for people, such as "u8" */
    const char *ply;       /**< in PLY; NULL: PLY has none */
    const char *other_ply; /**< PLY's other name of it */
    char pcd;              /**< in PCD: F, I or U; 0: PCD has none */
    uint8_t bytes;         /**< its size */
    uint8_t ros;           /**< in sensor_msgs/msg/PointField; 0: none */
    uint8_t las;           /**< in extra bytes of LAS */
} lum_number_spec;

/** By ::lum_number_type. */
extern const lum_number_spec lum_number_types[LUM_NUMBER_TYPES];

/** Room that a number takes as text, its NUL included. */
#define LUM_NUMBER_ROOM 32u

/** Write the i-th of values as little-endian bytes.
 * @param values of the type, in the host's byte order, at any alignment.
 * @return the end of it. */
unsigned char *lum_number_put(unsigned char *p, lum_number_type type,
                              const void *values, size_t i);

/** Write it as text: the fewest digits that give the same number again.
 * @param p has LUM_NUMBER_ROOM bytes.
 * @return the end of it. */
char *lum_number_print(char *p, lum_number_type type, const void *values,
                       size_t i);

#endif
