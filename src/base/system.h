/** @file
 * Small facts of the system. Internal. */
#ifndef LUM_BASE_SYSTEM_H
#define LUM_BASE_SYSTEM_H

/** The last part of a path, by this system's separators. */
const char *lum_system_base(const char *path);

/** This process's number. */
long lum_system_process(void);

#endif
