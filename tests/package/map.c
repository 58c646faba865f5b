/* Links the map of an installed copy. */
#include <lum/map/map.h>

#include <stdio.h>

int main(void)
{
    const lum_map_options options = {.struct_size = sizeof options,
                                     .voxel = 0.1};
    lum_map_voxel voxel;
    lum_map *map = NULL;
    lum_error error;
    size_t count = 1;

    if (lum_map_new(&options, &map, &error) != 0) {
        return 1;
    }
    const int result = lum_map_next(map, &voxel, 1, &count, &error);
    lum_map_free(map);
    (void)puts("map");
    return result == 0 && count == 0 ? 0 : 1;
}
