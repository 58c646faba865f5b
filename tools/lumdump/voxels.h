/* Frames as voxels: in the world, all of them in one map, or each on its own.
 */
#ifndef LUMDUMP_VOXELS_H
#define LUMDUMP_VOXELS_H

#include "outputs.h"
#include "pose_motion.h"
#include "summary.h"

struct voxels;

/* As options say. */
int voxels_new(const struct options *options, struct voxels **out,
               lum_error *error);

/* NULL is allowed. */
void voxels_free(struct voxels *voxels);

/* Take a frame, which has the columns FRAME_LINES_OF_MESSAGES. moved: where its
 * points are instead, or NULL. sensor: as of an action. Its voxels go to the
 * outputs, if they are of no map. -1: errno is as of outputs_act(). */
int voxels_take(struct voxels *voxels, const lum_frame *frame,
                const struct moved *moved, unsigned sensor,
                struct outputs *outputs, lum_error *error);

/* Once all frames came: -1 with the reason in error if points came, and the map
 * has none of them, because they are too far from 0. */
int voxels_check(struct voxels *voxels, lum_error *error);

/* After that: some voxels of the map go to the outputs. The first
 * call refuses a map that does not fit on the disk. is_done: there are no more.
 */
int voxels_write(struct voxels *voxels, struct outputs *outputs, bool *is_done,
                 lum_error *error);

void voxels_count(const struct voxels *voxels, struct voxel_counts *out);

#endif
