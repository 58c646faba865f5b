/* The fields of a point that a cloud's header names. */
#ifndef LUMDUMP_CLOUD_FIELDS_H
#define LUMDUMP_CLOUD_FIELDS_H

#include "cloud/presets.h"
#include "lum/base/error.h"

#include <stdbool.h>
#include <stdint.h>

#define CLOUD_FIELDS_MAX 64u

struct cloud_field {
    char name[64];
    unsigned type; /* a lum_number_type, or LUM_NUMBER_TYPES: another */
    char word[16]; /* the type as the file has it */
    uint64_t offset;
};

struct cloud_fields {
    unsigned count;
    bool has_types;  /* CSV has none */
    bool has_places; /* a point has all fields one behind the other */
    struct cloud_field at[CLOUD_FIELDS_MAX];
};

/* Those of a .pcd, .ply, .csv or .mcap; of an MCAP file of its first
 * sensor_msgs/msg/PointCloud2. -1 with the reason in error. */
int cloud_fields_read(const char *path, struct cloud_fields *out,
                      lum_error *error);

/* Those of messages that have no preset. */
void cloud_fields_of_messages(struct cloud_fields *out);

#endif
