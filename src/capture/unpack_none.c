/* The compressions that a build lacks; CMake lists them as LUM_LACKING. */
#include "unpack.h"

#define LACKS(name) const lum_unpacker *const lum_unpack_##name = NULL;

LUM_LACKING
