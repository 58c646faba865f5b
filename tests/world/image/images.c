#include "images.h"

#include "kernel/process.h"

/* What make_image and the linker give each image. */
#define DECLARE(name)                                                          \
    extern int name##_main(int argc, char **argv);                             \
    extern char __start_##name##_data[];                                       \
    extern char __stop_##name##_data[];

#define IMAGE(name)                                                            \
    {                                                                          \
#name, name##_main, __start_##name##_data, __stop_##name##_data        \
    }

DECLARE(lumctl)
DECLARE(lumdump)
DECLARE(lumsim)
DECLARE(lumview)

void world_images(void)
{
    static const world_image images[] = {IMAGE(lumctl), IMAGE(lumdump),
                                         IMAGE(lumsim), IMAGE(lumview)};
    world_process_images(images, sizeof images / sizeof images[0]);
}
