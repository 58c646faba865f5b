/* Included before a file that lumtable --layout wrote: the functions get the
 * number of its layout, so that many and those of layout_any.c are one
 * program. */
#ifndef RENAMED_H
#define RENAMED_H

#define JOIN(name, number)   name##_##number
#define JOINED(name, number) JOIN(name, number)
#define NUMBERED(name)       JOINED(name, LAYOUT_NUMBER)

#define lum_layout_is_read     NUMBERED(lum_layout_is_read)
#define lum_group_decode       NUMBERED(lum_group_decode)
#define lum_clock_init         NUMBERED(lum_clock_init)
#define lum_clock_follow       NUMBERED(lum_clock_follow)
#define lum_layout_copy_angles NUMBERED(lum_layout_copy_angles)
#define lum_group_word         NUMBERED(lum_group_word)

#endif
