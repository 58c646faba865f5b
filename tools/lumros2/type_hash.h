/* What ROS 2 from Iron on compares of a type beside its name (REP 2016). */
#ifndef LUMROS2_TYPE_HASH_H
#define LUMROS2_TYPE_HASH_H

/* RIHS01_ and 64 digits, of a type such as sensor_msgs/msg/PointCloud2; NULL:
 * not known, and then none is told. */
const char *type_hash(const char *type);

#endif
