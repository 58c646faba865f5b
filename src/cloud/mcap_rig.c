#include "mcap_rig.h"

#include "ros_messages.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#define FRAME_ID "luminar"

/* From the rig's frame to the sensor's, and on to those of its eyes. */
#define TRANSFORMS_EACH (1u + LUM_EYES)

static int take_frame_id(char out[LUM_MCAP_FRAME_ID_MAX + 1u], const char *name,
                         const char *id, lum_error *error)
{
    const size_t n = strlen(id);
    if (n == 0 || n > LUM_MCAP_FRAME_ID_MAX) {
        errno = EINVAL;
        return lum_error_set(error, "%s: a frame_id of %zu bytes; 1 to %u",
                             name, n, LUM_MCAP_FRAME_ID_MAX);
    }
    memcpy(out, id, n + 1u);
    return 0;
}

static int take_sensor(lum_mcap_rig_sensor *out, const char *name,
                       const lum_mcap_sensor *from, lum_error *error)
{
    out->topic = from->topic;
    out->has_pose = from->pose != NULL;
    out->has_mounts = from->calibration != NULL;
    if (out->has_pose) {
        out->pose = *from->pose;
    }
    if (out->has_mounts) {
        out->calibration = *from->calibration;
    }
    return take_frame_id(out->frame_id, name, from->frame_id, error);
}

int lum_mcap_rig_take(lum_mcap_rig *out, const char *name,
                      const lum_mcap_options *o, lum_error *error)
{
    const char *id = o->frame_id != NULL ? o->frame_id : FRAME_ID;
    const lum_mcap_sensor only = {.topic = lum_ros_topics[LUM_ROS_POINTS].name,
                                  .frame_id = id,
                                  .calibration = o->calibration};
    out->count = o->sensors != NULL ? o->sensor_count : 1u;
    if (out->count == 0 || out->count > LUM_MCAP_SENSORS_MAX) {
        errno = EINVAL;
        return lum_error_set(error, "%s: %zu sensors; 1 to %u", name,
                             out->count, LUM_MCAP_SENSORS_MAX);
    }
    for (size_t i = 0; i < out->count; i++) {
        if (take_sensor(&out->sensors[i], name,
                        o->sensors != NULL ? &o->sensors[i] : &only,
                        error) != 0) {
            return -1;
        }
    }
    return take_frame_id(out->frame_id, name, id, error);
}

static int attach(lum_mcap_file *file, const char *name, const char *text,
                  lum_error *error)
{
    return text == NULL || text[0] == '\0'
               ? 0
               : lum_mcap_add_attachment(file, name, "application/yaml", text,
                                         error);
}

int lum_mcap_rig_attach(lum_mcap_file *file, const lum_mcap_options *o,
                        lum_error *error)
{
    int result = attach(file, "calibration.yaml", o->calibration_yaml, error);
    if (result == 0) {
        result = attach(file, "profile.yaml", o->profile_yaml, error);
    }
    for (size_t i = 0; o->sensors != NULL && i < o->sensor_count && result == 0;
         i++) {
        const lum_mcap_sensor *of = &o->sensors[i];
        char name[LUM_MCAP_FRAME_ID_MAX + 32u];
        (void)snprintf(name, sizeof name, "calibration-%s.yaml", of->frame_id);
        result = attach(file, name, of->calibration_yaml, error);
        if (result == 0) {
            (void)snprintf(name, sizeof name, "profile-%s.yaml", of->frame_id);
            result = attach(file, name, of->profile_yaml, error);
        }
    }
    return result;
}

bool lum_mcap_rig_has_transforms(const lum_mcap_rig *rig)
{
    bool has = false;
    for (size_t i = 0; i < rig->count; i++) {
        has |= rig->sensors[i].has_pose || rig->sensors[i].has_mounts;
    }
    return has;
}

void lum_mcap_rig_put_transforms(const lum_mcap_rig *rig, int64_t stamp_ns,
                                 lum_bytes *out)
{
    lum_ros_transform all[LUM_MCAP_SENSORS_MAX * TRANSFORMS_EACH];
    char children[LUM_MCAP_SENSORS_MAX][LUM_EYES][LUM_ROS_CHILD_BYTES];
    size_t n = 0;
    for (size_t i = 0; i < rig->count; i++) {
        const lum_mcap_rig_sensor *of = &rig->sensors[i];
        if (of->has_pose) {
            all[n++] =
                (lum_ros_transform){rig->frame_id, of->frame_id, of->pose};
        }
        if (of->has_mounts) {
            lum_ros_find_mounts(of->frame_id, &of->calibration, children[i],
                                &all[n]);
            n += LUM_EYES;
        }
    }
    lum_ros_put_transforms(out, stamp_ns, all, n);
}
