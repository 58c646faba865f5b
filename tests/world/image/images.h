/* The tools, as they were built for the world: lumctl, lumdump, lumsim, and
 * lumview with a terminal in place of its page. */
#ifndef WORLD_IMAGES_H
#define WORLD_IMAGES_H

/* Makes them known to world_process_start(); once, before the first world. */
void world_images(void);

#endif
